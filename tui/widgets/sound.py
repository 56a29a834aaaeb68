"""The sound of a turn as a picture in characters: its peaks over time, from the levels that the events tell.

A level comes ten times a second, and between two of them the envelope is drawn as a straight line. Its height is linear
in dB, so that quiet speech and noise are seen as well. Solid and coloured is what counted as speech; the rule below
says the same without colours.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from textual.content import Content

from tui.shown.turn import SAMPLE_S, Sample, Turn
from tui.widgets.lines import Drawn
from tui.widgets.page import MARGIN, Row
from tui.words import strings

ROWS: Final = 4
"""Cells of the picture, of four dots each."""
STEP: Final = 5
"""Levels by which the picture of a recording that goes on grows."""
FLOOR_DB: Final = -60.0
_BRAILLE: Final = 0x2800
_LEFT: Final = (0x01, 0x02, 0x04, 0x40)
_RIGHT: Final = (0x08, 0x10, 0x20, 0x80)
"""Bits of the braille dots from top to bottom (Unicode, block Braille Patterns)."""


class Wave(NamedTuple):
    """One row of the picture: ``row`` counts from the top; -1 is the rule below it."""

    samples: tuple[Sample, ...]
    row: int


def wave(turn: Turn) -> Iterator[Row | Wave]:
    """The picture of a turn's sound, with its figures. All of it moves with every level that comes, which is much to
    send: while somebody is recorded, it is drawn anew twice a second."""
    samples = turn.samples if turn.listened is not None else turn.samples[: len(turn.samples) // STEP * STEP]
    if not samples:
        return
    peak = max(sample.peak_db for sample in samples)
    listened = samples[-1].t - samples[0].t + SAMPLE_S
    speech = turn.listened.speech_s if turn.listened is not None else SAMPLE_S * sum(s.voiced for s in samples)
    shown = f"{max(-99.0, peak):.0f}".replace("-", "−")
    figures = strings.SOUND_FIGURES.format(listened=listened, speech=speech, peak=shown)
    yield Row(strings.PART_SOUND, ((figures, "$foreground 60%"),))
    for row in (*range(ROWS), -1):
        yield Wave(samples, row)
    yield Row("")


def drawn_wave(item: Wave, width: int) -> Drawn:
    """One row of the picture in the width that there is."""
    columns = max(1, width - MARGIN)
    samples = item.samples
    voiced = [samples[_nearest(column, columns, len(samples))].voiced for column in range(columns)]
    if item.row < 0:
        runs = [(strings.RULE_SPEECH if voice else strings.RULE_QUIET, _style(voice)) for voice in voiced]
    else:
        runs = [(_cell(samples, column, columns, item.row), _style(voice)) for column, voice in enumerate(voiced)]
    return Drawn(Content(" " * MARGIN), Content.assemble(*_joined(runs)), nowrap=True)


def _cell(samples: tuple[Sample, ...], column: int, columns: int, row: int) -> str:
    middle, bits = 2 * ROWS, 0
    for dots, x in ((_LEFT, 2 * column), (_RIGHT, 2 * column + 1)):
        height = envelope(samples, x / max(1, 2 * columns - 1)) * middle
        for number, bit in enumerate(dots):
            away = abs(4 * row + number + 0.5 - middle)
            if away <= max(0.5, height):
                bits |= bit
    return chr(_BRAILLE + bits)


def envelope(samples: tuple[Sample, ...], share: float) -> float:
    """The peak at a share (0…1) of the recording, as a share of the height between the floor and full scale."""
    at = share * (len(samples) - 1)
    first = min(int(at), len(samples) - 1)
    second = min(first + 1, len(samples) - 1)
    peak = samples[first].peak_db + (at - first) * (samples[second].peak_db - samples[first].peak_db)
    return max(0.0, min(1.0, (peak - FLOOR_DB) / -FLOOR_DB))


def _nearest(column: int, columns: int, count: int) -> int:
    return round(column / max(1, columns - 1) * (count - 1))


def _style(voiced: bool) -> str:
    return "$text-success" if voiced else "$foreground 35%"


def _joined(cells: list[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    text, style = "", ""
    for char, its_style in cells:
        if its_style != style and text:
            yield text, style
            text = ""
        text, style = text + char, its_style
    yield text, style
