"""The status line: what the robot is doing now, as a colour and a word, and the keys. Nothing in it changes places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.widgets import Static

from tui import strings
from tui.model import ConsoleModel
from tui.terminal import WIDE_COLUMNS

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
    "WAITING": ("◇", "$foreground on $panel"),
}
_STARTING: Final = ("◌", "$foreground on $panel")
_BROKEN: Final = ("✗", "bold $text on $error")
_CHIP: Final = 16


@dataclass(frozen=True, slots=True)
class Hint:
    """A key and its word in the status line."""

    key: str
    word: str
    matters: bool
    urgent: bool = False
    """The key to reach for: set off by its colour when it matters."""


class StatusLine(Horizontal):
    """Chip, task and keys. ``esc stop`` stands where it stood, whatever the rest says."""

    def __init__(self) -> None:
        super().__init__()
        self._chip_part = Static(id="chip", markup=False)
        self._task_part = Static(id="task", markup=False)
        self._keys_part = Static(id="keys", markup=False)

    def compose(self) -> ComposeResult:
        yield self._chip_part
        yield self._task_part
        yield self._keys_part

    def update_from(self, model: ConsoleModel, *, started: bool, notice: str, hints: Sequence[Hint]) -> None:
        """Show state and keys; a ``notice`` stands in the task's place."""
        _put(self._chip_part, _chip(model, started))
        _put(
            self._task_part,
            Content.styled(f" {notice}", "bold $text-warning")
            if notice
            else _task(model, self.size.width >= WIDE_COLUMNS),
        )
        _put(self._keys_part, _keys(hints))


def _put(static: Static, content: Content) -> None:
    old = static.content
    if isinstance(old, Content) and content.is_same(old):
        return
    wider = static.styles.is_auto_width and Content(str(old)).cell_length != content.cell_length
    static.update(content, layout=wider)  # a layout that nobody needs would repaint the whole line, and more


def _chip(model: ConsoleModel, started: bool) -> Content:
    if model.problem is not None and model.problem.fatal:
        (sign, style), word = _BROKEN, strings.BROKEN
    elif model.ended is not None:
        (sign, style), word = _SIGNS["WAITING"], strings.ENDED
    elif not started:
        (sign, style), word = _STARTING, strings.STARTING
    else:
        (sign, style), word = _SIGNS[model.state], strings.STATE_WORDS[model.state]
    return Content.styled(f" {sign} {word}".ljust(_CHIP), style)


def _task(model: ConsoleModel, with_goal: bool) -> Content:
    parts: list[tuple[str, str]] = [(f" {strings.TASK} {model.cycle}", "$foreground 60%")]
    if with_goal and model.plan is not None and model.plan.goal:
        parts.append((f"  {model.plan.goal}", "$foreground"))
    return Content.assemble(*parts)


def _keys(hints: Sequence[Hint]) -> Content:
    parts: list[tuple[str, str]] = []
    for hint in hints:
        if not hint.matters:
            parts.append((f" {hint.key} {hint.word} ", "$foreground 60%"))
        elif hint.urgent:
            parts.append((f" {hint.key} {hint.word} ", "bold $background on $error"))
        else:
            parts += [(f" {hint.key}", "bold $text-accent"), (f" {hint.word} ", "$foreground")]
    return Content.assemble(*parts)
