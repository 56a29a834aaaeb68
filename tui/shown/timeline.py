"""A turn as a Gantt chart in characters: one bar a stage on a common axis, which ends to an eighth of a cell.

Pure functions from a turn to bars and from a bar to cells; the colours belong to the theme. The axis is a round number
of seconds, so that a bar that grows does not move the others, and it is no longer than it takes to see what came before
the robot acted: a bar that goes on beyond it ends in ``›``. Silence that was recorded is a thin line; speech, and all
other work, is solid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, Literal, NamedTuple

from msgspec import Struct

from engine.events import Outcome
from tui.shown.turn import SAMPLE_S, STAGES, Span, Stage, Turn

AXES: Final = (1.0, 2.0, 3.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0, 120.0, 300.0)
"""Lengths of the axis, s."""
LONGEST_S: Final = 10.0
"""The axis is longer than this only where the thinking took longer, s."""
AHEAD: Final = 1.5
"""How much longer than until the first action the axis is, at least."""

Look = Literal["work", "again", "rest"]
"""``again``: work that follows other work of the stage without a gap to tell them apart."""
_BLOCKS: Final = " ▏▎▍▌▋▊▉█"
"""By eighths of a cell, from the left."""
_GAP: Final = 1e-3


class Stretch(Struct, frozen=True):
    """Part of a bar, from and to seconds since the turn began."""

    began: float
    ended: float
    look: Look = "work"


class Bar(Struct, frozen=True):
    """One stage of a turn."""

    stage: Stage
    stretches: tuple[Stretch, ...]
    milliseconds: int
    axis_s: float
    running: bool = False
    slow: bool = False
    outcome: Outcome = "ok"


class Cell(NamedTuple):
    """One character of a bar."""

    char: str
    look: Look


def axis(turn: Turn, now: float) -> float:
    """How many seconds the axis of a turn is long."""
    last = max([span.ended or now for span in turn.spans], default=turn.began)
    active = [span.began for span in turn.spans if span.stage in ("act", "speak")]
    until = (active[0] if active else last) - turn.began
    wanted = min(last - turn.began, max(LONGEST_S, AHEAD * until))
    return next((length for length in AXES if length >= wanted), AXES[-1])


def bars(turn: Turn, now: float) -> tuple[Bar, ...]:
    """The stages that the turn has come to, in their order. What still runs is rounded down, so that it is drawn anew
    twice a second and no oftener."""
    length, slow = axis(turn, now), turn.slowest(now)
    return tuple(_bar(turn, stage, now, length, stage == slow) for stage in STAGES if turn.of(stage))


def cells(bar: Bar, columns: int) -> Iterator[Cell]:
    """The bar in ``columns`` cells."""
    scale = 8 * columns / bar.axis_s
    ends = 8 * columns
    solid = [(_eighth(s.began, scale), _eighth(s.ended, scale), s.look) for s in bar.stretches if s.look != "rest"]
    thin = [(_eighth(s.began, scale), _eighth(s.ended, scale)) for s in bar.stretches if s.look == "rest"]
    solid = [(min(first, ends - 1), max(last, min(first, ends - 1) + 1), look) for first, last, look in solid]
    beyond = any(s.ended > bar.axis_s + _GAP for s in bar.stretches)
    for column in range(columns):
        first, last = 8 * column, 8 * column + 8
        if beyond and column == columns - 1:
            yield Cell("›", "work")
            continue
        here = [(max(a, first) - first, min(b, last) - first, look) for a, b, look in solid if a < last and b > first]
        if here:
            yield _block(here)
        elif any(a < last - 3 and b > first + 3 for a, b in thin):
            yield Cell("─", "rest")
        else:
            yield Cell(" ", "rest")


def _block(parts: Sequence[tuple[int, int, Look]]) -> Cell:
    """A cell with one stretch or more in it, each from and to an eighth."""
    start, end = min(part[0] for part in parts), max(part[1] for part in parts)
    look = max(parts, key=lambda part: part[1] - part[0])[2]
    if start < 2:
        return Cell(_BLOCKS[end], look)
    if end == 8:  # on the right there are only a half and an eighth
        return Cell("▐" if start < 6 else "▕", look)
    return Cell("▏" if start + end < 8 else "▕", look)


def _bar(turn: Turn, stage: Stage, now: float, axis_s: float, slow: bool) -> Bar:
    spans = turn.of(stage)
    running = any(span.ended is None for span in spans)
    seconds = turn.seconds(stage, now)
    outcome: Outcome = next((span.outcome for span in reversed(spans) if span.outcome != "ok"), "ok")
    if running:
        seconds = _rounded(seconds)
    stretches = tuple(_stretches(turn, spans, now))
    return Bar(stage, stretches, round(1000 * seconds), axis_s, running, slow, outcome)


def _stretches(turn: Turn, spans: tuple[Span, ...], now: float) -> Iterator[Stretch]:
    before, look = float("-inf"), "work"
    for span in spans:
        began = span.began - turn.began
        ended = began + _rounded(now - span.began) if span.ended is None else span.ended - turn.began
        if span.stage == "record":
            yield from _recorded(turn, began, ended)
            continue
        look = ("again" if look == "work" else "work") if began - before < _GAP else "work"
        before = ended
        yield Stretch(began, ended, "again" if look == "again" else "work")


def _recorded(turn: Turn, began: float, ended: float) -> Iterator[Stretch]:
    """Silence, speech, and silence of which nobody knows yet whether it is the end."""
    if turn.voice is None:
        yield Stretch(began, ended, "rest" if turn.samples else "work")
        return
    first, last = (min(max(t - turn.began, began), ended) for t in (turn.voice[0] - SAMPLE_S, turn.voice[1]))
    yield Stretch(began, first, "rest")
    yield Stretch(first, last)
    if last < ended:
        yield Stretch(last, ended, "rest")


def _rounded(seconds: float) -> float:
    """Down to a tenth, and from a second on to a half."""
    step = 0.1 if seconds < 1.0 else 0.5
    return max(0.0, int(seconds / step + 1e-9) * step)


def _eighth(seconds: float, scale: float) -> int:
    return round(seconds * scale)
