"""The robot in figures: where it stands, how fast it is, what holds it back; and whether all parts are well."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from textual import events
from textual.content import Content
from textual.message import Message

from engine.robot.geometry import heading_in_degrees
from tui.keys.speeds import LIMITS, limit_beside
from tui.plan.chart import posture
from tui.shown.readiness import no_robot
from tui.terminal.link import LinkFigures
from tui.widgets.lines import Drawn, Lines
from tui.words import strings
from tui.words.hints import EDGES, Acting, fitting
from tui.words.language import told

if TYPE_CHECKING:
    from engine.perception.memory import Thing
    from engine.robot.robot import RobotState
    from tui.shown.view import View

_PART_SIGNS: Final = {
    "failed": ("✗", "$text-error"),
    "missing": ("–", "$text-warning"),
    "loading": ("◌", "$text-primary"),
    "ready": ("✓", "$text-success"),
}
_SIDES: Final = 4
"""Columns of the frame beside what is in it."""
_MINUS: Final = "−"
"""How the key of the hyphen is written here, beside a plus."""
_TITLE_AT: Final = 3
"""Column of the first character of the title, in the frame."""
WIDE: Final = 50
"""Columns from which all figures fit in two lines, and all parts in one."""

Piece = tuple[str, str]
"""Text and style."""


class Figures(Lines[tuple[Piece, ...]]):
    """Pose, speed and gripper, rounded to what can be read, and one line about the parts."""

    _link: LinkFigures | None = None
    _view: View | None = None

    class Limited(Message):
        """The robot may drive so many steps faster."""

        def __init__(self, step: int) -> None:
            super().__init__()
            self.step = step

    def __init__(self, acting: Acting, *, classes: str | None = None) -> None:
        """``acting`` says which keys act now."""
        super().__init__(classes=classes)
        self._acting = acting
        self._signs: tuple[tuple[int, range], ...] = ()  # of a click: how many steps faster, and its columns

    def entitle(self) -> None:
        """Write the title: how fast the robot may drive, and those of the keys that change that which act now."""
        robot = self._view.robot if self._view is not None else None
        title = strings.PANE_ROBOT
        self._signs = ()
        if robot is not None:
            limit = strings.SPEED_LIMITS[LIMITS.index(limit_beside(robot.speed_limit, 0))]
            slower, faster = self._key("speed_down"), self._key("speed_up")
            words = " ".join(filter(None, (slower, limit, faster)))
            title = strings.SPEED_LIMIT.format(robot=title, limit=words)
            end = _TITLE_AT + cell_len(title)
            start = end - cell_len(words)
            signs = (-1, range(start, start + cell_len(slower))), (1, range(end - cell_len(faster), end))
            self._signs = tuple(sign for sign in signs if sign[1])
        if str(self.border_title or "") != title:  # another one repaints the pane
            self.border_title = Content(title)

    def on_click(self, event: events.Click) -> None:
        """On a key in the title: another speed limit."""
        if event.y != 0:
            return
        for step, columns in self._signs:
            if columns.start - 1 <= event.x <= columns.stop:
                self.post_message(self.Limited(step))

    def _key(self, action: str) -> str:
        """The key that does this now; empty: none does."""
        key = self._acting(action) or ""
        return _MINUS if key == "-" else key

    def update_from(self, view: View) -> None:
        self._view = view
        self._arrange()

    def on_resize(self, event: events.Resize) -> None:
        self._arrange()
        self.tell(self._link)
        super().on_resize(event)

    def _arrange(self) -> None:
        if (view := self._view) is None:
            return
        wide, held = self.size.width >= WIDE, view.world.held if view.world is not None else None
        robot = view.robot
        lines = [((no_robot(view), "$foreground 60%"),)] if robot is None else figure_lines(robot, wide, held)
        self.show([*lines, part_line(view, wide, self.size.width)], matters=0)

    def tell(self, link: LinkFigures | None) -> None:
        """Say in the frame how good the line to the terminal is."""
        self._link = link
        subtitle = "" if link is None else link_words(link, self.size.width + _SIDES - EDGES)
        if subtitle != (self.border_subtitle or ""):
            self.border_subtitle = subtitle

    def drawn(self, item: tuple[Piece, ...]) -> Drawn:
        return Drawn(Content(""), Content.assemble(*item), nowrap=True)


def figure_lines(robot: RobotState, wide: bool, held: Thing | None = None) -> list[tuple[Piece, ...]]:
    """Where the robot is and what it does, in two lines or three."""
    pose, twist = robot.pose, robot.twist
    x, y = _figure("x", f"{_plain(pose.x, 2):>6} m"), _figure("y", f"{_plain(pose.y, 2):>6} m")
    heading = _figure(strings.HEADING, f"{heading_in_degrees(pose.yaw):3.0f}°")
    speed = _figure(strings.SPEED, f"{math.hypot(twist.vx, twist.vy):.2f} m/s")
    turning = _figure(strings.TURNING, f"{_plain(math.degrees(twist.wz), 0):>4}°/s")
    grip = strings.OPEN if robot.gripper > 0.8 else strings.CLOSED if robot.gripper < 0.1 else strings.HALF_OPEN
    how = posture(robot)
    arm = () if how == "folded" else _figure(strings.ARM, strings.ARM_WORDS[how])
    if robot.held_back:
        state: Piece = (f"▲ {told(robot.held_back)}", "bold $text-warning")
    else:
        state = (
            (f"▸ {strings.MOVING}", "$text-success") if robot.moving else (f"○ {strings.AT_REST}", "$foreground 60%")
        )
    charge: tuple[Piece, ...] = ()
    if (battery := robot.battery) is not None:
        name = f"▲ {strings.BATTERY_LOW}" if battery.low else strings.BATTERY
        style = "bold $text-warning" if battery.low else "$foreground"
        charge = ((f"{name} ", style if battery.low else "$foreground 60%"), (f"{battery.volts:.1f} V  ", style))
    gripper = _figure(strings.GRIPPER, grip) if held is None else ((f"◆ {told(held.name)}", "$text-accent"),)
    if wide:
        return [(*x, *y, *heading, *gripper), (*charge, *speed, *turning, *arm, state)]
    doing = (state, ("  ", ""), *arm) if arm else (state,)
    return [(*x, *y), (*heading, *(charge or speed)), doing if held is None else (*doing, ("  ", ""), *gripper)]


def link_words(link: LinkFigures, columns: int) -> str:
    """The line in figures: how late, how much, how often; where there is no room for words, the figures alone, and the
    last of them goes first."""
    rates = strings.LINK_RATES.format(link.bytes_per_s / 1000, link.frames_per_s)
    if not link.reports:
        return fitting(f"{strings.LINK_SILENT} · {rates}", columns, last=0)
    delay = f"{'–' if link.delay is None else round(1000 * link.delay)} ms"
    words = f"{strings.LINK_DELAY.format(delay)} · {rates}"
    return words if cell_len(words) <= columns else fitting(f"{delay} · {rates}", columns, last=0)


def part_line(view: View, wide: bool, columns: int) -> tuple[Piece, ...]:
    """How the engine's parts are: all of them, or on little space what is not ready. What is wrong comes first."""
    parts = view.parts
    if view.failed:
        return (("✗ ", "$text-error"), (strings.ENGINE_FAILED, "$foreground 60%"))
    if not parts:
        return (("◌ ", "$text-primary"), (strings.ENGINE_STARTING, "$foreground 60%"))
    telling = next((part for part in parts if part.state == "loading" and part.detail), None)
    if telling is not None and all(part.state != "failed" for part in parts):  # how far it is, which may take minutes
        sign, style = _PART_SIGNS["loading"]
        return ((f"{sign} ", style), (_pair(strings.PART_WORDS[telling.name], told(telling.detail)), "$foreground 60%"))
    if wide:
        pieces: list[Piece] = []
        for state, (sign, style) in _PART_SIGNS.items():  # one sign for all that are alike: six names fill the line
            if names := [strings.PART_WORDS[part.name] for part in parts if part.state == state]:
                pieces += [(f"{sign} ", style), (f"{' '.join(names)}  ", "$foreground 60%")]
        if pieces[-2][0] == "✓ " and sum(cell_len(text) for text, _ in pieces) > columns + 2:
            pieces[-1] = (strings.OTHERS_READY if len(pieces) > 2 else strings.ALL_READY, "$foreground 60%")
        return tuple(pieces)
    for state, word in (("failed", strings.BROKEN.lower()), ("loading", strings.LOADING), ("missing", strings.MISSING)):
        names = [strings.PART_WORDS[part.name] for part in parts if part.state == state]
        if names:
            sign, style = _PART_SIGNS[state]
            return ((f"{sign} ", style), (_pair(word, strings.COMMA.join(names)), "$foreground 60%"))
    return (("✓ ", "$text-success"), (strings.ALL_READY, "$foreground 60%"))


def _pair(what: str, how: str) -> str:
    return f"{what}{strings.COLON}{how}"


def _figure(name: str, value: str) -> tuple[Piece, Piece]:
    return (f"{name} ", "$foreground 60%"), (f"{value}  ", "$foreground")


def _plain(value: float, digits: int) -> str:
    """Rounded, without the minus of −0."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
