"""A contact sheet: the same moment of the console at several sizes and in several themes, as one small SVG.

A picture of its own for each would be ten times as large: here a line of the screen is one element, a style is a class
of one letter, and what is drawn on the screen's own ground needs no ground. Equal screens make equal sheets.

``python -m tests.tui.sheets FOLDER`` renders them there, to be looked at.
"""

from __future__ import annotations

import string
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from rich.cells import cell_len
from rich.color import Color
from rich.style import Style
from textual.app import App

from tests.tui.pictures import FONT, SCREENSHOTS, png_of

SHEETS = SCREENSHOTS / "states"
CELL_WIDTH, CELL_HEIGHT = 10, 19
FONT_SIZE = 16.61
"""At which a cell of that font is so wide, and boxes and blocks meet."""
GAP = 20
_NO_COLOUR = "#808080"
"""That of a terminal, which is nobody's theme: to be seen as a mistake."""


@dataclass(frozen=True, slots=True)
class Run:
    """Cells in a row that look the same."""

    x: int  # columns
    text: str
    width: int  # columns
    colour: str
    ground: str
    looks: str  # further declarations of its style


@dataclass(frozen=True, slots=True)
class Shot:
    """A screen as it stood."""

    title: str
    columns: int
    rows: tuple[tuple[Run, ...], ...]

    @property
    def text(self) -> str:
        return "\n".join("".join(run.text for run in row) for row in self.rows)


def shot_of(app: App[Any], title: str) -> Shot:
    """The screen as it stands."""
    rows = tuple(tuple(joined(_runs(strip))) for strip in app.screen._compositor.render_strips())
    return Shot(title, app.size.width, rows)


def sheet_of(shots: Sequence[Sequence[Shot]]) -> str:
    """Several screens as one picture, in rows."""
    names = _Names()
    body, y, widest = [], GAP, 0
    for row in shots:
        x = GAP
        for shot in row:
            body += _drawn(shot, x, y, names)
            x += shot.columns * CELL_WIDTH + GAP
        widest = max(widest, x)
        y += max(len(shot.rows) for shot in row) * CELL_HEIGHT + 2 * GAP
    ground = f'<rect width="{widest}" height="{y}" fill="#808890"/>'
    return _svg((widest, y), 1.0, names, [ground, *body])


def picture_of(shot: Shot, scale: float) -> str:
    """One screen as a picture."""
    names = _Names()
    size = (shot.columns * CELL_WIDTH, len(shot.rows) * CELL_HEIGHT)
    return _svg(size, scale, names, list(_drawn(shot, 0, 0, names)))


def _svg(size: tuple[int, int], scale: float, names: _Names, body: list[str]) -> str:
    width, height = size
    shown = f' width="{round(width * scale)}" height="{round(height * scale)}"' if scale != 1.0 else ""
    return "\n".join(
        (
            f'<svg viewBox="0 0 {width} {height}"{shown} xmlns="http://www.w3.org/2000/svg" xml:space="preserve">',
            "<!-- The console in one state, made and compared by tests/tui/test_states.py -->",
            "<style>",
            f'text{{font:{FONT_SIZE}px "{FONT}",monospace}}',
            *(f".{name}{{{style}}}" for style, name in names.of.items()),
            "</style>",
            *body,
            "</svg>",
            "",
        )
    )


class _Names:
    """Short names for styles, in the order in which they are first needed."""

    def __init__(self) -> None:
        self.of: dict[str, str] = {}
        self._free = ("".join(letters) for size in (1, 2) for letters in product(string.ascii_letters, repeat=size))

    def name(self, style: str) -> str:
        return self.of.get(style) or self.of.setdefault(style, next(self._free))


def _drawn(shot: Shot, left: int, top: int, names: _Names) -> Iterator[str]:
    width, height = shot.columns * CELL_WIDTH, len(shot.rows) * CELL_HEIGHT
    grounds = Counter({run.ground: 0 for row in shot.rows for run in row})
    for run in (run for row in shot.rows for run in row):
        grounds[run.ground] += run.width
    own = grounds.most_common(1)[0][0]
    yield f'<g transform="translate({left},{top})">'
    if shot.title:
        yield f'<text y="-4">{escape(shot.title)}</text>'
    yield f'<rect width="{width}" height="{height}" class="{names.name(f"fill:{own}")}"/>'
    for number, row in enumerate(shot.rows):
        y = number * CELL_HEIGHT
        for x, columns, ground in _grounds(row):
            if ground != own:
                place = f'x="{x * CELL_WIDTH}" y="{y}" width="{columns * CELL_WIDTH}" height="{CELL_HEIGHT}"'
                yield f'<rect {place} class="{names.name(f"fill:{ground}")}"/>'
        spans = "".join(
            f'<tspan x="{run.x * CELL_WIDTH}" class="{names.name(f"fill:{run.colour}{run.looks}")}">'
            f"{escape(run.text)}</tspan>"
            for run in row
            if run.text.strip()
        )
        if spans:
            yield f'<text y="{y + 15}">{spans}</text>'
    yield "</g>"


def _grounds(row: Sequence[Run]) -> Iterator[tuple[int, int, str]]:
    """Column, columns and colour of what is behind a row."""
    x, columns, ground = 0, 0, ""
    for run in row:
        if run.ground != ground:
            if columns:
                yield x, columns, ground
            x, columns, ground = run.x, 0, run.ground
        columns += run.width
    yield x, columns, ground


def joined(runs: Iterable[Run]) -> Iterator[Run]:
    """They in as few parts as look the same."""
    kept: Run | None = None
    for run in runs:
        if kept is not None and _continues(run, kept):
            kept = replace(kept, text=kept.text + run.text, width=kept.width + run.width)
            continue
        if kept is not None:
            yield kept
        kept = run
    if kept is not None:
        yield kept


def _runs(strip: Any) -> Iterator[Run]:
    """A line of the screen."""
    x = 0
    for segment in strip:
        if segment.text:
            yield Run(x, segment.text, width := cell_len(segment.text), *_looks(segment.style or Style()))
            x += width


def _continues(run: Run, before: Run) -> bool:
    """White space has no colour."""
    if run.ground != before.ground:
        return False
    unlined = "decoration" not in run.looks + before.looks
    return (run.colour, run.looks) == (before.colour, before.looks) or (unlined and not run.text.strip())


def _looks(style: Style) -> tuple[str, str, str]:
    """Colour, ground, and further declarations."""
    colour, ground = _hex(style.color), _hex(style.bgcolor)
    if style.reverse:
        colour, ground = ground, colour
    lines = [name for name, on in (("underline", style.underline), ("line-through", style.strike)) if on]
    looks = [
        ";font-weight:bold" if style.bold else "",
        ";font-style:italic" if style.italic else "",
        f";text-decoration:{' '.join(lines)}" if lines else "",
    ]
    return colour, ground, "".join(looks)


def _hex(colour: Color | None) -> str:
    return _NO_COLOUR if colour is None or colour.is_default else colour.get_truecolor().hex


def main() -> None:
    folder = Path(sys.argv[1])
    for sheet in sorted(SHEETS.glob("*.svg")):
        png = folder / f"{sheet.stem}.png"
        png.write_bytes(png_of(sheet.read_text()))
        print(png)


if __name__ == "__main__":
    main()
