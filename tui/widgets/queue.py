"""The actions of the plan, one a line, with a sign, and a duration that runs while the action does."""

from __future__ import annotations

from typing import Final, NamedTuple

from textual.content import Content

from tui.shown.facts import Phase, Row
from tui.shown.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines
from tui.words import strings
from tui.words.language import told

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
_ROOM_FOR_WORDS: Final = 5
"""Lines below which what runs has one of them, so that the next one is in view, too."""


class Shown(NamedTuple):
    """One line of the queue, with its moving figures already rounded: equal lines are not drawn twice."""

    phase: Phase | None
    number: int
    call: str
    message: str
    seconds: str
    filled: int | None  # eighths of the progress bar
    whole: bool = True  # all of its words, on as many lines as they need


class ActionQueue(Lines[Shown]):
    """The queue; the action that runs is kept in view, and the next one with it. While something runs it has the room
    for its words; afterwards those have it that did not end well."""

    _summary = ""

    def update_from(self, model: ConsoleModel, now: float, stop: str) -> None:
        """Show the queue with durations as of event time ``now``; ``stop`` is the key that ends what runs."""
        running = next((number for number, row in enumerate(model.queue) if row.phase == "running"), None)
        summary = _summary(model, stop) if running is not None or model.waiting else ""
        if summary != self._summary:  # another one repaints the pane
            self._summary = self.border_subtitle = summary
        roomy = self.size.height >= _ROOM_FOR_WORDS
        rows = [
            _shown(row, now, roomy if row.phase == "running" else running is None and row.phase not in ("queued", "ok"))
            for row in model.queue
        ]
        following = None if running is None else min(running + 1, len(rows) - 1)
        self.show(rows or [Shown(None, 0, strings.NO_ACTIONS, "", "", None)], matters=following)

    def drawn(self, item: Shown) -> Drawn:
        if item.phase is None:
            return Drawn(Content(""), Content.styled(item.call, "$foreground 60%"))
        sign, style = SIGNS[item.phase]
        gutter = Content.assemble((f"{sign} ", style), (f"{item.number} ", "$foreground 60%"))
        body = Content.styled(item.call, _CALL_STYLES.get(item.phase, "$foreground"))
        if item.message:
            reason = "$foreground 80%" if item.phase == "failed" else _DIM
            body = Content.assemble(body, ("  " + item.message, reason))
        bar = _bar(item.filled) if item.filled is not None and self.size.width >= _ROOM_FOR_BAR else Content("")
        aside = Content.assemble(bar, (f"{item.seconds:>7}", "$foreground" if item.phase == "running" else _DIM))
        return Drawn(gutter, body, aside, nowrap=not item.whole)


_DIM: Final = "$foreground 60%"
_CALL_STYLES: Final[dict[Phase, str]] = {"queued": "$foreground 60%", "running": "bold $foreground"}


def _shown(row: Row, now: float, whole: bool) -> Shown:
    elapsed = row.elapsed(now)
    filled = None if row.fraction is None else round(max(0.0, min(1.0, row.fraction)) * _BAR)
    seconds = "" if elapsed is None else f"{elapsed:.1f} s"
    return Shown(row.phase, row.index, told(row.call), told(row.message), seconds, filled, whole)


def _summary(model: ConsoleModel, stop: str) -> str:
    """How far the plan is, how many requests wait behind it, and what stops all that."""
    ended = sum(row.phase not in ("queued", "running") for row in model.queue)
    failed = sum(row.phase == "failed" for row in model.queue)
    parts = [strings.STEPS_ENDED.format(ended, len(model.queue))] if len(model.queue) > 1 else []
    parts += [strings.STEPS_FAILED.format(failed)] if failed else []
    parts += [strings.REQUESTS_WAIT.format(len(model.waiting))] if model.waiting else []
    return " · ".join((*parts, strings.KEY_STOPS.format(stop)))


def _bar(filled: int) -> Content:
    return Content.assemble(("━" * filled, "$text-primary"), ("━" * (_BAR - filled), "$foreground 20%"))
