"""The actions of the plan, one a line, with a sign, and a duration that runs while the action does."""

from __future__ import annotations

from typing import Final, NamedTuple

from textual.content import Content

from tui import strings
from tui.facts import Phase, Row
from tui.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines

SIGNS: Final[dict[Phase, tuple[str, str]]] = {
    "queued": ("○", "$foreground 60%"),
    "running": ("▸", "$text-primary bold"),
    "ok": ("✓", "$text-success"),
    "failed": ("✗", "$text-error"),
    "interrupted": ("■", "$text-warning"),
    "uncertain": ("?", "$text-warning"),
}
_BAR: Final = 8
_ROOM_FOR_BAR: Final = 48
"""Columns below which the bar gives its room to the words."""


class Shown(NamedTuple):
    """One line of the queue, with its moving figures already rounded: equal lines are not drawn twice."""

    phase: Phase | None
    number: int
    call: str
    message: str
    seconds: str
    filled: int | None  # eighths of the progress bar


class ActionQueue(Lines[Shown]):
    """The queue; the action that runs is kept in view."""

    def update_from(self, model: ConsoleModel, now: float) -> None:
        """Show the queue with durations as of event time ``now``."""
        rows = [_shown(row, now) for row in model.queue]
        running = next((number for number, row in enumerate(model.queue) if row.phase == "running"), None)
        self.show(rows or [Shown(None, 0, strings.NO_ACTIONS, "", "", None)], matters=running)

    def drawn(self, item: Shown) -> Drawn:
        if item.phase is None:
            return Drawn(Content(""), Content.styled(item.call, "$foreground 60%"))
        sign, style = SIGNS[item.phase]
        gutter = Content.assemble((f"{sign} ", style), (f"{item.number} ", "$foreground 60%"))
        body = Content.styled(item.call, _CALL_STYLES.get(item.phase, "$foreground"))
        if item.message:
            body = Content.assemble(body, ("  " + item.message, "$foreground 60%"))
        bar = _bar(item.filled) if item.filled is not None and self.size.width >= _ROOM_FOR_BAR else Content("")
        aside = Content.assemble(bar, (f"{item.seconds:>7}", "$foreground" if item.phase == "running" else _DIM))
        return Drawn(gutter, body, aside, nowrap=item.phase != "failed")


_DIM: Final = "$foreground 60%"
_CALL_STYLES: Final[dict[Phase, str]] = {"queued": "$foreground 60%", "running": "bold $foreground"}


def _shown(row: Row, now: float) -> Shown:
    elapsed = row.elapsed(now)
    filled = None if row.fraction is None else round(max(0.0, min(1.0, row.fraction)) * _BAR)
    return Shown(row.phase, row.index, row.call, row.message, "" if elapsed is None else f"{elapsed:.1f} s", filled)


def _bar(filled: int) -> Content:
    return Content.assemble(("━" * filled, "$text-primary"), ("━" * (_BAR - filled), "$foreground 20%"))
