"""The status line: what the robot is doing now, as a colour and a word, and the keys. Nothing in it changes places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.message import Message
from textual.widgets import Static

from tui.shown.readiness import lost, named, waited_for
from tui.terminal.terminal import WIDE_COLUMNS
from tui.words import strings
from tui.words.widths import left

if TYPE_CHECKING:
    from tui.shown.view import Hint, View

_SIGNS: Final = {
    "IDLE": ("○", "$foreground on $panel"),
    "LISTENING": ("●", "bold $background on $accent"),
    "TRANSCRIBING": ("◐", "bold $background on $primary-lighten-1"),
    "DECIDING": ("◔", "bold $background on $primary-lighten-1"),
    "PLANNING": ("◑", "bold $background on $primary-lighten-1"),
    "CLARIFYING": ("?", "bold $background on $warning"),
    "SPEAKING": ("♪", "bold $background on $primary-lighten-1"),
    "ACTING": ("▸", "bold $background on $success"),
    "FEEDBACK": ("↻", "bold $background on $primary-lighten-1"),
    "WAITING": ("○", "$foreground on $panel"),
}
_STARTING: Final = ("◌", "$foreground on $panel")
_BROKEN: Final = ("✗", "bold $text on $error")
_ESTOP: Final = ("■", "bold $text on $error")
_CHIP: Final = 16
_IMPORTANCE: Final = (
    "send",
    "back",
    "wake",
    "type",
    "pane_next",
    "end_task",
    "leave",
    "help",
    "earlier",
    "palette",
    "leave_now",
)
"""Of the keys by action: those that come last here go first where there is no room for all."""


class StatusLine(Horizontal):
    """Chip, the key that stops, how many requests wait, task, other keys. ``esc stop`` stands where it stood, whatever
    the rest says."""

    class Chosen(Message):
        """Somebody clicked on the key of this action."""

        def __init__(self, action: str) -> None:
            super().__init__()
            self.action = action

    def __init__(self) -> None:
        super().__init__()
        self._shown: dict[Static, Sequence[Hint]] = {}  # the keys in either part
        self._notice_does = ""  # the action that a click on the notice does
        self._chip_part = Static(id="chip", markup=False)
        self._stop_part = Static(id="stop", markup=False)
        self._waiting_part = Static(id="waiting", markup=False)
        self._task_part = Static(id="task", markup=False)
        self._keys_part = Static(id="keys", markup=False)

    def compose(self) -> ComposeResult:
        yield self._chip_part
        yield self._stop_part
        yield self._waiting_part
        yield self._task_part
        yield self._keys_part

    def update_from(self, view: View) -> None:
        """Show state and keys; a notice stands in the task's place, and goes before keys. How many requests wait goes
        before keys as well, and is left out as a whole."""
        columns = self.app.size.width  # our own is not known before the first layout
        urgent = [hint for hint in view.hints if hint.urgent]
        stop = _keys(urgent)
        room = columns - _CHIP - stop.cell_length
        notice = f" {view.notice} " if view.notice else ""
        count = len(view.model.waiting)
        waiting = f" {strings.REQUESTS_WAIT.format(count)} " if count else ""
        if cell_len(waiting + notice) > room:
            waiting = ""
        room -= cell_len(waiting)
        others = [hint for hint in view.hints if not hint.urgent]
        fit = _fitting(others, room - cell_len(notice))
        keys = _keys(fit)
        self._notice_does = view.notice_does
        self._shown = {self._stop_part: urgent, self._keys_part: fit}
        _put(self._chip_part, chip(view))
        _put(self._stop_part, stop)
        _put(self._waiting_part, Content.styled(waiting, "$text-accent"))
        style = "bold $text-error" if view.standstill else "bold $text-warning"
        shown = Content.styled(notice.rstrip(), style) if notice else None
        _put(self._task_part, shown or _task(view, columns >= WIDE_COLUMNS, room - keys.cell_length))
        _put(self._keys_part, keys)

    def on_click(self, event: events.Click) -> None:
        """A key that is clicked on does what it does."""
        if self._notice_does and self._task_part.region.contains(*event.screen_offset):
            self.post_message(self.Chosen(self._notice_does))
            return
        for part, hints in self._shown.items():
            if part.region.contains(*event.screen_offset):
                column = event.screen_offset.x - part.region.x
                for hint in hints:
                    column -= cell_len(hint.text)
                    if column < 0:
                        self.post_message(self.Chosen(hint.action))
                        return


def has_room(notice: str, view: View, columns: int) -> bool:
    """Whether a status line so wide says all of this notice, and nothing else in its place."""
    stop = sum(cell_len(hint.text) for hint in view.hints if hint.urgent)
    return not view.standstill and cell_len(f" {notice} ") <= columns - _CHIP - stop


def is_pressed(view: View) -> bool:
    """Whether the emergency stop is."""
    return view.robot is not None and view.robot.estop


def _put(static: Static, content: Content) -> None:
    old = static.content
    if isinstance(old, Content) and content.is_same(old):
        return
    wider = static.styles.is_auto_width and Content(str(old)).cell_length != content.cell_length
    static.update(content, layout=wider)  # a layout that nobody needs would repaint the whole line, and more


def chip(view: View) -> Content:
    """What the robot is doing now, as a sign and a word in a colour."""
    model = view.model
    if is_pressed(view):
        (sign, style), word = _ESTOP, strings.ESTOP
    elif model.problem is not None and model.problem.fatal:
        (sign, style), word = _BROKEN, strings.BROKEN
    elif model.ended is not None:
        (sign, style), word = _SIGNS["WAITING"], strings.ENDED
    elif not view.started:
        (sign, style), word = _STARTING, strings.STARTING
    elif model.state in ("IDLE", "WAITING") and lost(view.parts):
        (sign, style), word = _BROKEN, strings.BROKEN
    elif waited_for(model, view.parts):
        (sign, style), word = _STARTING, strings.LOADS
    else:
        thinks = model.state in ("IDLE", "WAITING") and model.plan is not None and model.plan.stage == "thinking"
        state = "PLANNING" if thinks else model.state  # which the engine enters when it knows how it thinks
        state = "CLARIFYING" if model.asks else state
        (sign, style), word = _SIGNS[state], strings.STATE_WORDS[state]
    return Content.styled(left(f" {sign} {word}", _CHIP), style)


def _task(view: View, wide: bool, columns: int) -> Content:
    """Which task it is, or nothing where that would be cut; on a ``wide`` line also what for, or what it waits for."""
    model, task = view.model, f" {strings.TASK} {view.model.cycle}"
    parts: list[tuple[str, str]] = [(task, "$foreground 60%")] if cell_len(task) < columns else []
    waits = waited_for(model, view.parts) if view.started and model.ended is None else ()
    if wide and waits:
        parts.append((f"  {strings.LOADS_PARTS.format(parts=named(waits))}", "$foreground 80%"))
    elif wide and model.plan is not None and model.plan.goal:
        parts.append((f"  {model.plan.goal}", "$foreground"))
    return Content.assemble(*parts)


def _fitting(hints: Sequence[Hint], columns: int) -> list[Hint]:
    """As many as there is room for, in their order, each as a whole."""
    there = list(hints)
    while there and sum(cell_len(hint.text) for hint in there) > columns:
        there.remove(max(there, key=lambda hint: _IMPORTANCE.index(hint.action)))
    return there


def _keys(hints: Sequence[Hint]) -> Content:
    parts: list[tuple[str, str]] = []
    for hint in hints:
        if not hint.matters:
            parts.append((hint.text, "$foreground 60%"))
        elif hint.urgent:
            parts.append((hint.text, "bold $background on $error"))
        else:
            parts += [(f" {hint.key}", "bold $text-accent"), (f" {hint.word} ", "$foreground")]
    return Content.assemble(*parts)
