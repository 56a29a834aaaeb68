"""What the console shows at one moment, as one value: the screens and their panes draw it and know nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from msgspec import Struct, field

from tui.words import strings

if TYPE_CHECKING:
    from config.schema import Place
    from engine.handle import PartStatus
    from engine.perception.memory import World
    from engine.robot.floor_map import FloorMap
    from engine.robot.robot import RobotState, Scan
    from tui.shown.facts import Ended, Line, Problem
    from tui.shown.model import ConsoleModel
    from tui.shown.turn import Turn
    from tui.terminal.link import LinkFigures


class Hint(Struct, frozen=True):
    """A key and its word in the status line."""

    action: str
    key: str
    word: str
    matters: bool

    @property
    def text(self) -> str:
        return f" {self.key} {self.word} "

    @property
    def urgent(self) -> bool:
        """The key to reach for: set off by its colour when it matters."""
        return self.action == "interrupt"


RELEASE: Final = "release"
"""The action that releases the emergency stop."""


class View(Struct, frozen=True):
    """Everything the screen shows at one moment."""

    model: ConsoleModel
    now: float = 0.0  # s, event time
    started: bool = False  # the engine is there
    failed: bool = False  # it did not start, and will not
    session: str = ""  # the engine's, by its id, as the event log is named
    notice: str = ""  # stands in the status line
    notice_does: str = ""  # the action that a click on it does
    release: str = ""  # the same in the fewest words, where it is why nothing can move the robot
    remark: str = ""  # the notice that has no place there, as the emergency stop has it
    ends: tuple[Ended, ...] = ()  # how requests ended that were not done, alike, where there is one line for all
    outdated: Sequence[Line | Problem] = ()  # what the model still has and is not true any more
    newest: str = ""  # the key that leads to the newest line of a pane, where one does so now
    hints: tuple[Hint, ...] = ()
    parts: tuple[PartStatus, ...] = ()
    robot: RobotState | None = None
    floor_map: FloorMap | None = None
    places: Mapping[str, Place] = field(default_factory=dict)
    world: World | None = None
    scan: Scan | None = None
    turn: Turn | None = None  # that somebody browsed to; None: the newest
    fresh: int = 0  # turns that have begun since then
    bare: bool = False  # the line bears no more than what one has to know
    touring: bool = False  # somebody sits here for the first time
    link: LinkFigures | None = None  # how good the line is; None: nobody wants to know

    @property
    def moving(self) -> bool:
        """The robot is."""
        return self.model.moving or (self.robot is not None and self.robot.moving)

    @property
    def pressed(self) -> bool:
        """The emergency stop is."""
        return self.model.pressed or (self.robot is not None and self.robot.estop)

    @property
    def standstill(self) -> str:
        """Why nothing can move the robot, and what changes that; empty where it can be moved."""
        return self.notice if self.notice_does == RELEASE else ""

    def is_true(self, told: Line | Problem) -> bool:
        """What the model has is still true."""
        return not any(told is old for old in self.outdated)

    @property
    def no_way(self) -> str:
        """Why the robot cannot be sent anywhere on the map; empty where it can be."""
        at = self.robot.pose if self.robot is not None else None
        known = at is not None and math.isfinite(at.x) and math.isfinite(at.y)
        return self.standstill or ("" if known else strings.NOWHERE)
