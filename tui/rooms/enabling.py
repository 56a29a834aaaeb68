"""Which of the console's own actions would do something now. The map, the log and whatever else has keys of its own
decides about those in its ``check_action``.

Textual asks before it does an action, and every hint asks before it names a key (``Stage.acting``), so that the two
agree. An action that is not listed here always does something.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from tui.keys.keys import IN_ONE_LINE, KEYS
from tui.keys.speeds import limit_beside
from tui.screens.pages import Copied, Paged
from tui.shown.offers import FollowUp, offered
from tui.shown.readiness import deaf

if TYPE_CHECKING:
    from tui.rooms.drawing import Drawing
    from tui.rooms.emergency import EmergencyStop
    from tui.rooms.leaving import Leaving
    from tui.stage import Stage

_IN_PANES: Final = ("map", "zoom", "border", "scroll_line", "newest", "next_pane", "add", "speed")
"""The actions that do nothing while a page is open."""
_WHILE_ASKED: Final = frozenset({"interrupt", "estop", "release", "leave_now"})
"""The actions whose keys act while the map asks something; every other key is its answer."""
_NEEDING_ROOM: Final = (
    "pane", "next_pane", "palette", "recall", "settings", "zoom", "border", "map", "camera", "by_hand",
)  # fmt: skip
"""The actions that do nothing on a terminal that is too small."""


class Enabling:
    """Asks the other rooms. In the UI thread."""

    def __init__(
        self, stage: Stage, drawing: Drawing, leaving: Leaving, emergency: EmergencyStop, *, one_line: bool
    ) -> None:
        """``one_line``: all stands on one line, so that actions have neither panes nor pages."""
        self._stage = stage
        self._drawing = drawing
        self._leaving = leaving
        wanting = {key.action.partition("(")[0] for key in KEYS if key.id not in IN_ONE_LINE}
        self.without_room = frozenset(wanting if one_line else ())
        """The actions for which there is no room on one line."""
        self._uses: Mapping[str, Callable[..., bool]] = {
            "back": self._is_away,
            "wake": lambda: self._hears and deaf(drawing.parts) is None,
            "end_task": lambda: self._hears,
            "type": lambda: self._takes_requests and not self._in_line,
            "add": lambda: self._in_line and stage.main.line.sends,
            "release": lambda: emergency.can_be_released,
            "by_hand": lambda: self._hears and self._has_robot and not emergency.is_pressed,
            "speed": self._has_other_speed,
            "resume": lambda: self._offers("resume"),
            "undo": lambda: self._offers("undo"),
            "again": lambda: self._offers("again"),
            "log": lambda: not self._on_main or stage.main.can_toggle("log"),
            "timeline": lambda: not self._on_main or stage.main.can_toggle("turns"),
            "turn_back": lambda: drawing.can_browse(-1),
            "turn_on": lambda: drawing.can_browse(1),
            "recall": lambda: bool(stage.main.line.history),
            "border": lambda steps: stage.main.can_shift(steps),
            "copy": lambda: not isinstance(stage.screen, Copied) or bool(stage.screen.plain()),
            "older": lambda: self._has_more(-1),
            "newer": lambda: self._has_more(1),
            "newest": lambda name=None: stage.main.can_follow(name) or self._looks_back_at_turns(name),
            "scroll_line": lambda lines: stage.main.can_scroll(lines),
        }

    def check(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """As Textual's ``check_action``. None: it would do nothing now, and its key says why, where there is a
        reason."""
        stage = self._stage
        if action in self.without_room:
            return None
        if self._on_main and stage.main.asks and action not in _WHILE_ASKED:
            return None
        if action in _IN_PANES and not self._on_main:
            return None
        if action in _NEEDING_ROOM and stage.main.is_hidden:
            return None
        use = self._uses.get(action)
        return True if use is None or use(*parameters) else None

    def answers(self, key: str) -> bool:
        """Whether this key answers what the map asks, so that it does nothing else."""
        if not (self._on_main and self._stage.main.asks):
            return False
        bound = self._stage.screen.active_bindings.get(key)
        return bound is None or bound.binding.action not in _WHILE_ASKED

    def idle_borders(self) -> frozenset[str]:
        """The keys of borders where none is in sight: a pane has the whole width."""
        moves = any(self._stage.main.can_shift(step) for step in (-1, 1))
        return frozenset(() if moves else ("border_left", "border_right"))

    def possible(self, action: str) -> bool:
        """Whether there is anything here by which it could ever act: nobody is heard without a microphone."""
        return action != "wake" or deaf(self._drawing.parts) is None

    @property
    def _on_main(self) -> bool:
        return self._stage.screen is self._stage.main

    @property
    def _in_line(self) -> bool:
        return self._on_main and self._stage.main.line is self._stage.focused

    @property
    def _hears(self) -> bool:
        """The engine is there to be told."""
        return self._stage.handle is not None and self._drawing.model.ended is None

    @property
    def _takes_requests(self) -> bool:
        """What is typed is done, or will be when the engine is there."""
        return not self._drawing.failed and self._drawing.model.ended is None

    @property
    def _has_robot(self) -> bool:
        """The robot is there: it neither starts nor is gone."""
        return self._stage.handle is not None and self._stage.handle.robot_state() is not None

    def _is_away(self) -> bool:
        """There is a step back."""
        return self._leaving.asked or not self._on_main or self._stage.main.is_away

    def _has_other_speed(self, step: int) -> bool:
        robot = self._stage.handle.robot_state() if self._stage.handle is not None else None
        return robot is not None and limit_beside(robot.speed_limit, step) != robot.speed_limit

    def _offers(self, kind: FollowUp) -> bool:
        return self._stage.handle is not None and kind in offered(self._drawing.model)

    def _has_more(self, direction: int) -> bool:
        page: Any = self._stage.screen if isinstance(self._stage.screen, Paged) else self._stage.main
        return bool(page.can_scroll(direction))

    def _looks_back_at_turns(self, name: str | None) -> bool:
        return (name or self._stage.main.pane) == "turns" and self._drawing.browsed is not None
