"""The turns as a timeline: the newest first, each with a line that says what came of it and one bar a stage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Final, NamedTuple

from rich.cells import cell_len
from textual import events
from textual.content import Content
from textual.message import Message

from tui.shown.timeline import Bar, Cell, axis, bars, cells
from tui.shown.turn import Stage, Turn
from tui.widgets.growing import mark
from tui.widgets.lines import Drawn, Item, Lines
from tui.widgets.page import Piece
from tui.widgets.queue import SIGNS
from tui.words import strings
from tui.words.hints import JOINT, Acting, hint_line
from tui.words.widths import right

_LEAST_ROWS: Final = 10
"""Twice as many rows as there is room for are made ready, and no fewer than this; browsing reaches the others."""
RESULTS: Final = {
    "done": ("✓", "$text-success"),
    "failed": ("✗", "$text-error"),
    "clarify": ("?", "$text-warning"),
    "answered": ("?", "$foreground 60%"),
    "declined": ("■", "$text-warning"),
    "replaced": ("■", "$text-warning"),
    "withdrawn": ("■", "$text-warning"),
    "no_order": ("∅", "$foreground 60%"),
    "refused": ("⊘", "$text-error"),
    "interrupted": ("■", "$text-warning"),
    "timeout": ("✗", "$text-error"),
    "unheard": ("∅", "$foreground 60%"),
    "open": ("◌", "bold $text-primary"),
}
_INKS: Final[dict[Stage, tuple[str, str]]] = {
    "wake": ("$foreground 50%", "$foreground 30%"),
    "record": ("$foreground 50%", "$foreground 30%"),
    "endpoint": ("$primary", "$primary 60%"),
    "recognise": ("$primary", "$primary 60%"),
    "decide": ("$primary", "$primary 60%"),
    "plan": ("$primary", "$primary 60%"),
    "act": ("$success", "$success 60%"),
    "speak": ("$secondary", "$secondary 60%"),
}
_SLOW: Final = ("$warning", "$warning 60%")
_REST: Final = "$foreground 30%"
_DIM: Final = "$foreground 60%"


class Head(NamedTuple):
    """The line above the bars of a turn."""

    number: int
    text: str
    outcome: str
    total: str
    shown: bool  # it is the one that enter opens


class Offered(NamedTuple):
    """The line below the bars of a turn about which something may be asked in a word."""

    pieces: tuple[Piece, ...]  # text and style

    @property
    def words(self) -> str:
        """With the keys that ask for it."""
        return "".join(text for text, _ in self.pieces)


class FromTop(Lines[Item]):
    """Lines that begin at the top with the one that matters, until somebody scrolls."""

    def scroll_lines(self, lines: int) -> None:
        super().scroll_lines(lines)
        self._held = self._top != min(self._top_for_what_matters(), self._last_top)

    def _top_for_what_matters(self) -> int:
        return sum(len(self._cache[item]) for item in self._items[: self._matters or 0])


class Timeline(FromTop[Head | Bar | Offered | str]):
    """The last turns, newest first; the one that is browsed to is kept in view."""

    class Chosen(Message):
        """Somebody clicked on a turn."""

        def __init__(self, number: int) -> None:
            super().__init__()
            self.number = number

    def __init__(self, acting: Acting, *, classes: str | None = None) -> None:
        """``acting`` says which keys act now."""
        super().__init__(classes=classes)
        self._acting = acting
        self._foot = Content("")
        self._known: tuple[Sequence[Turn], Turn | None, float] = ((), None, 0.0)  # what it was told to show
        self._fresh = 0
        self._offers: Mapping[str, tuple[Piece, ...]] = {}

    def offer(self, offers: Mapping[str, tuple[Piece, ...]]) -> None:
        """What may be asked about turns, by their ids; to be shown with the next news."""
        self._offers = offers

    def hint(self) -> None:
        """Write below the pane how many turns are new, and how one looks at others, once there are some."""
        if not self._known[0]:
            return
        fresh = mark(strings.NEW_TURNS.format(self._fresh), "turns") if self._fresh else Content("")
        keys = Content(hint_line(strings.BROWSE, self._acting))
        foot = Content(JOINT).join([part for part in (fresh, keys) if part])
        if not foot.is_same(self._foot):  # another one repaints the pane
            self._foot = self.border_subtitle = foot

    def update_from(self, turns: Sequence[Turn], browsed: Turn | None, now: float, fresh: int = 0) -> None:
        """Show the turns as of event time ``now``; ``browsed`` is the one that the user looks at, and ``fresh`` have
        begun since."""
        self._known = turns, browsed, now
        if browsed is not None and browsed not in turns:  # so old that others forget it
            turns = (browsed, *turns)
        first = turns.index(browsed) if browsed is not None else len(turns) - 1
        last = min(first + 3, len(turns) - 1)  # some newer ones above it, to go back to
        items: list[Head | Bar | Offered | str] = []
        matters = 0
        for number in range(last, -1, -1):
            turn = turns[number]
            if number == first:
                matters = len(items)
            items += [head(turn, shown=number == first), *bars(turn, now)]
            if pieces := self._offers.get(turn.id):
                items.append(Offered(pieces))
            if len(items) - matters > 2 * max(_LEAST_ROWS, self.size.height):
                break
        self._fresh = fresh
        self.show(items or [strings.NO_TURNS], matters=matters)

    def on_resize(self, event: events.Resize) -> None:
        """There may be room for more of them."""
        self.update_from(*self._known, self._fresh)
        super().on_resize(event)

    def on_click(self, event: events.Click) -> None:
        at = self.clicked(event)
        heads = [item for item in self._items[: at + 1] if isinstance(item, Head)] if at is not None else []
        if heads:
            self.post_message(self.Chosen(heads[-1].number))

    def drawn(self, item: Head | Bar | Offered | str) -> Drawn:
        if isinstance(item, Offered):
            return Drawn(Content("  "), Content.assemble(*item.pieces), nowrap=True)
        if isinstance(item, str):
            return Drawn(Content(""), Content.styled(item, _DIM))
        return drawn_head(item) if isinstance(item, Head) else drawn_bar(item, self.size.width)


def head(turn: Turn, *, shown: bool) -> Head:
    """The line above the bars of a turn."""
    return Head(turn.number, asked(turn), turn.outcome, total(turn), shown)


def asked(turn: Turn) -> str:
    """What was asked, or why that is not known."""
    if turn.text or turn.open:
        return turn.text or (strings.LISTENS if turn.listened is None else strings.RECOGNISES)
    if turn.unheard is not None:
        return strings.REJECTED[turn.unheard.reason]
    if turn.cut is None and turn.listened is not None and turn.listened.reason in ("no_speech", "device_lost"):
        return strings.LISTEN_ENDS[turn.listened.reason]
    return strings.NOTHING_SAID if turn.cut is not None else strings.NOT_HEARD


def total(turn: Turn) -> str:
    """From the end of speech to the first motion, or else to the first word."""
    if turn.to_motion is not None:
        return strings.TO_MOTION.format(milliseconds=milliseconds(turn.to_motion))
    if turn.to_answer is not None and not turn.open:
        return strings.TO_ANSWER.format(milliseconds=milliseconds(turn.to_answer))
    return ""


def milliseconds(seconds: float) -> str:
    """As everywhere on a timeline: in whole milliseconds."""
    return f"{round(1000 * seconds)} ms"


def _named(stage: str) -> str:
    """The name of a stage, in as many columns as the widest of them."""
    return right(stage, max(map(cell_len, strings.STAGES.values())))


def drawn_head(item: Head) -> Drawn:
    sign, style = RESULTS[item.outcome]
    gutter = Content.assemble((f"{sign} ", style), (f"{item.number:>2} ", "bold $text-accent" if item.shown else _DIM))
    body = Content.styled(item.text, "bold $foreground" if item.shown else "$foreground")
    return Drawn(gutter, body, Content.styled(item.total, "$foreground"), nowrap=True)


def drawn_bar(bar: Bar, width: int) -> Drawn:
    """``  ▸ recognise     ████            280 ms``: the slow stage is marked and bold."""
    name = f"{_named(strings.STAGES[bar.stage])} "
    gutter = Content.assemble(
        ("▸ " if bar.slow else "  ", "bold $text-warning"), (name, "bold $foreground" if bar.slow else _DIM)
    )
    sign, style = ("◌", "$text-primary") if bar.running else ("", "") if bar.outcome == "ok" else SIGNS[bar.outcome]
    figure = "bold $text-warning" if bar.slow else "$foreground"
    aside = Content.assemble((f"{sign} ", style), (f"{milliseconds(bar.milliseconds / 1000):>10}", figure))
    columns = max(1, width - gutter.cell_length - aside.cell_length - 1)
    ink = _SLOW if bar.slow else _INKS[bar.stage]
    return Drawn(gutter, Content.assemble(*_runs(cells(bar, columns), ink)), aside, nowrap=True)


def _runs(drawn: Iterator[Cell], ink: tuple[str, str]) -> Iterator[tuple[str, str]]:
    """Cells of one look joined: text and style."""
    styles = {"work": ink[0], "again": ink[1], "rest": _REST}
    for look, group in groupby(drawn, key=lambda cell: cell.look):
        yield "".join(cell.char for cell in group), styles[look]


class Total(NamedTuple):
    """How long somebody waited in all: from when to when, in seconds since the turn began."""

    name: str
    since: str  # in words
    began: float
    ended: float
    axis_s: float


def totals(turn: Turn, now: float) -> Iterator[Total]:
    """From the end of speech (or from the request that was typed) to the first motion and to the first word."""
    if turn.asked is None:
        return
    began, length = turn.asked - turn.began, axis(turn, now)
    spoken = turn.heard is not None and turn.heard.source == "speech"
    since = strings.SINCE_SPEECH if spoken else strings.SINCE_REQUEST
    for name, waited in ((strings.STAGE_TO_MOTION, turn.to_motion), (strings.STAGE_TO_ANSWER, turn.to_answer)):
        if waited is not None:
            yield Total(name, since, began, began + waited, length)


def drawn_total(item: Total, width: int) -> Drawn:
    """``to motion      ├──────┤    620 ms``, on the axis of the bars."""
    gutter = Content.styled(f"  {_named(item.name)} ", "$foreground")
    aside = Content.styled(f"  {milliseconds(item.ended - item.began):>10}", "bold $foreground")
    columns = max(1, width - gutter.cell_length - aside.cell_length - 1)
    first, last = (min(columns - 1, int(t / item.axis_s * columns)) for t in (item.began, item.ended))
    span = "│" if first == last else f"├{'─' * (last - first - 1)}┤"
    return Drawn(gutter, Content.assemble((" " * first + span, "$foreground"), (f"  {item.since}", _DIM)), aside, True)
