"""The robot in figures: where it stands, how fast it is, what holds it back; and whether all parts are well."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from textual.content import Content

from tui import strings
from tui.widgets.lines import Drawn, Lines

if TYPE_CHECKING:
    from engine.handle import PartStatus
    from engine.perception.memory import Thing
    from engine.robot.robot import RobotState

_PART_SIGNS: Final = {
    "ready": ("✓", "$text-success"),
    "loading": ("◌", "$text-primary"),
    "missing": ("–", "$text-warning"),
    "failed": ("✗", "$text-error"),
}
_WIDE: Final = 50
"""Columns from which all figures fit in two lines, and all parts in one."""

Piece = tuple[str, str]
"""Text and style."""


class Figures(Lines[tuple[Piece, ...]]):
    """Pose, speed and gripper, rounded to what can be read, and one line about the parts."""

    def update_from(self, robot: RobotState | None, parts: Sequence[PartStatus], held: Thing | None = None) -> None:
        """``held`` is what the gripper holds."""
        wide = self.size.width >= _WIDE
        lines = [((strings.NO_ROBOT, "$foreground 60%"),)] if robot is None else figure_lines(robot, wide, held)
        self.show([*lines, part_line(parts, wide)], matters=0)

    def drawn(self, item: tuple[Piece, ...]) -> Drawn:
        return Drawn(Content(""), Content.assemble(*item), nowrap=True)


def figure_lines(robot: RobotState, wide: bool, held: Thing | None = None) -> list[tuple[Piece, ...]]:
    """Where the robot is and what it does, in two lines or three."""
    pose, twist = robot.pose, robot.twist
    x, y = _figure("x", f"{_plain(pose.x, 2):>6} m"), _figure("y", f"{_plain(pose.y, 2):>6} m")
    heading = _figure(strings.HEADING, f"{round(math.degrees(pose.yaw), 0) % 360:>3.0f}°")
    speed = _figure(strings.SPEED, f"{math.hypot(twist.vx, twist.vy):.2f} m/s")
    turning = _figure(strings.TURNING, f"{_plain(math.degrees(twist.wz), 0):>4}°/s")
    grip = strings.OPEN if robot.gripper > 0.8 else strings.CLOSED if robot.gripper < 0.1 else strings.HALF_OPEN
    holding_back = robot.halted or robot.blocked
    if holding_back:
        state: Piece = (f"▲ {holding_back}", "bold $text-warning")
    else:
        state = (
            (f"▸ {strings.MOVING}", "$text-success") if robot.moving else (f"○ {strings.AT_REST}", "$foreground 60%")
        )
    gripper = _figure(strings.GRIPPER, grip) if held is None else ((f"◆ {held.name}", "$text-accent"),)
    if wide:
        return [(*x, *y, *heading, *gripper), (*speed, *turning, state)]
    return [(*x, *y), (*heading, *speed), (state,) if held is None else (state, ("  ", ""), *gripper)]


def part_line(parts: Sequence[PartStatus], wide: bool) -> tuple[Piece, ...]:
    """How the engine's parts are: all of them, or on little space what is not ready."""
    if not parts:
        return (("◌ ", "$text-primary"), (strings.ENGINE_STARTING, "$foreground 60%"))
    if wide:
        pieces: list[Piece] = []
        for part in parts:
            sign, style = _PART_SIGNS[part.state]
            pieces += [(f"{sign} ", style), (f"{strings.PART_WORDS[part.name]}  ", "$foreground 60%")]
        return tuple(pieces)
    for state, word in (("failed", strings.BROKEN.lower()), ("loading", strings.LOADING), ("missing", strings.MISSING)):
        names = [strings.PART_WORDS[part.name] for part in parts if part.state == state]
        if names:
            sign, style = _PART_SIGNS[state]
            return ((f"{sign} ", style), (f"{word}: {', '.join(names)}", "$foreground 60%"))
    return (("✓ ", "$text-success"), (strings.ALL_READY, "$foreground 60%"))


def _figure(name: str, value: str) -> tuple[Piece, Piece]:
    return (f"{name} ", "$foreground 60%"), (f"{value}  ", "$foreground")


def _plain(value: float, digits: int) -> str:
    """Rounded, without the minus of −0."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
