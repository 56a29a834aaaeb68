"""A film of a terminal: what came to stand on it, and when.

What is kept is not what a program sent but the fewest characters that bring the screen there: a third of the size, and
a terminal that plays it is neither asked anything nor left in another mode.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import pyte
from pyte.screens import Char

from tests.tui.pictures import png_of
from tests.tui.sheets import Run, Shot, joined, picture_of

IDLE_S = 1.5
"""What takes longer without a change is shown as long as this."""
LAST_S = 4.0
"""For so long the end stands."""
TOGETHER_S = 0.05
"""What comes no later than this after the rest belongs to the same frame."""
SLOW_S = 0.4
"""Between two pictures of the moving picture."""
SCALE = 0.8
"""Of the moving picture, for a page as wide as those of GitHub."""
_LOOKS = (("bold", "1", "22"), ("italics", "3", "23"), ("underscore", "4", "24"), ("reverse", "7", "27"))
"""Names of looks, and the codes that begin and end them."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A change of the screen."""

    at: float  # s since the first one
    written: str


class Film:
    """Takes what is sent to a terminal."""

    def __init__(self, columns: int, rows: int) -> None:
        self._screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._screen)
        self._shown: dict[tuple[int, int], Char] = {}
        self._style = self._screen.default_char
        self._frames: list[Frame] = []
        self._began: float | None = None
        self._fed = float("inf")

    def take(self, data: bytes, now: float) -> None:
        """This came, at this time, s."""
        if now > self._fed + TOGETHER_S:
            self._cut()
        self._stream.feed(data)
        self._fed = now

    def frames(self) -> list[Frame]:
        """All so far."""
        self._cut()
        return list(self._frames)

    def _cut(self) -> None:
        text = "".join(self._changes())
        self._screen.dirty.clear()
        if text and self._began is None:
            self._began, text = self._fed, "\x1b[?25l\x1b[2J" + text
        if text:
            self._frames.append(Frame(self._fed - (self._began or 0.0), text))

    def _changes(self) -> Iterator[str]:
        for row in sorted(self._screen.dirty):
            cursor = -1
            for column in range(self._screen.columns):
                cell = self._screen.buffer[row][column]
                if cell == self._shown.get((row, column), self._screen.default_char):
                    continue
                self._shown[row, column] = cell
                if not cell.data:  # the right half of the one before
                    cursor = column + 1
                    continue
                if cursor != column:
                    yield f"\x1b[{row + 1};{column + 1}H"
                yield self._styled(cell) + cell.data
                cursor = column + 1

    def _styled(self, cell: Char) -> str:
        """What makes the next character look like this one, given how the last one looked."""
        before, self._style = self._style, cell
        codes = [
            begin if getattr(cell, name) else end
            for name, begin, end in _LOOKS
            if getattr(cell, name) != getattr(before, name)
        ]
        codes += [_colour(cell.fg, 38)] if cell.fg != before.fg else []
        codes += [_colour(cell.bg, 48)] if cell.bg != before.bg else []
        return f"\x1b[{';'.join(codes)}m" if codes else ""


def _colour(name: str, ground: int) -> str:
    return str(ground + 1) if name == "default" else f"{ground};2;{';'.join(map(str, bytes.fromhex(name)))}"


# What is made of it


def asciicast(frames: list[Frame], columns: int, rows: int) -> str:
    """The film as asciinema plays it, version 2."""
    header = {"version": 2, "width": columns, "height": rows, "title": "sayso", "idle_time_limit": IDLE_S}
    lines: list[Any] = [{**header, "env": {"TERM": "xterm-256color"}}]
    lines += [[round(frame.at, 2), "o", frame.written] for frame in frames]
    return "".join(json.dumps(line, ensure_ascii=False, separators=(",", ":")) + "\n" for line in lines)


def moving_picture(frames: list[Frame], columns: int, rows: int) -> bytes:
    """The film as an animated WebP, without loss."""
    from PIL import Image

    screen = pyte.Screen(columns, rows)
    stream = pyte.Stream(screen)
    pictures, lasted, shown_at = [], [], 0.0
    for frame, following in pairwise([*frames, None]):
        assert frame is not None
        stream.feed(frame.written)
        until = frame.at + LAST_S if following is None else following.at
        if following is not None and until - shown_at < SLOW_S:
            continue
        png = png_of(picture_of(shot_of_terminal(screen), SCALE))
        pictures.append(Image.open(io.BytesIO(png)).convert("RGB"))
        lasted.append(round(1000 * (LAST_S if following is None else min(IDLE_S, until - shown_at))))
        shown_at = until
    file = io.BytesIO()
    pictures[0].save(
        file, "WEBP", save_all=True, append_images=pictures[1:], duration=lasted, loop=0, lossless=True, method=4
    )
    return file.getvalue()


def shot_of_terminal(screen: pyte.Screen) -> Shot:
    """What stands on a terminal."""
    rows = (
        [
            Run(column, cell.data, len(cell.data), *_looks(cell))
            for column in range(screen.columns)
            if (cell := screen.buffer[row][column]).data
        ]
        for row in range(screen.lines)
    )
    return Shot("", screen.columns, tuple(tuple(joined(row)) for row in rows))


def _looks(cell: Char) -> tuple[str, str, str]:
    colour, ground = (f"#{name}" if name != "default" else "#0f1318" for name in (cell.fg, cell.bg))
    if cell.reverse:
        colour, ground = ground, colour
    return colour, ground, ";font-weight:bold" if cell.bold else ""
