"""A picture as characters: half blocks with two colours each, upper and lower, and frames around what was recognised.

A line over which this goes may be slow, so a picture is made cheap before it is sent. Colours have five bits a channel.
A pixel keeps the colour that is on the screen until the new one differs so much that one sees it, and takes that of its
neighbour to the left or above where they hardly differ, because a run of one colour costs no more than one character.
Where much changes at once, less is enough to be seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from msgspec import Struct

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.perception.sighting import Sighting

STAYS: Final = 14
"""Of 255, in each channel: a pixel that changes by no more than this stays as it is."""
RUNS: Final = 10
"""The same between neighbours."""
COARSENESS: Final = (1, 2, 3, 4)
"""Steps by which both are widened where a picture would cost too much."""
SGR_BYTES: Final = 42
"""What a change of both colours costs on the line, with the reset behind it."""
PLAIN_BYTES: Final = 24
"""The same where both are one: a blank on a ground."""
JUMP_BYTES: Final = 9
"""What it costs to go elsewhere on the screen."""
BLOCK_BYTES: Final = 3
"""A half block in UTF-8."""

Colour = tuple[int, int, int]
"""Red, green, blue, 0…255."""
Mark = tuple[str, bool]
"""A character of a frame, and whether it is part of a name."""


class Extent(Struct, frozen=True):
    """How large a picture is shown: ``columns`` × ``rows`` characters, two pixels a character."""

    columns: int
    rows: int


def extent(width: int, height: int, columns: int, rows: int) -> Extent:
    """The largest that keeps the proportions of a picture (pixels) within so many characters."""
    across = min(columns, int(rows * 2 * width / max(1, height)))
    down = min(rows, round(across * height / max(1, width) / 2))
    return Extent(max(1, across), max(1, down))


def shrunk(rgb: NDArray[np.uint8], size: Extent) -> NDArray[np.uint8]:
    """The picture in as many pixels as can be shown, each the mean of what it stands for: shape
    (2 rows, columns, 3)."""
    import numpy as np  # here and not above: the first paint does not wait for it

    height, width = rgb.shape[:2]
    down = np.linspace(0, height, 2 * size.rows + 1).astype(int)
    across = np.linspace(0, width, size.columns + 1).astype(int)
    first_rows, first_columns = np.minimum(down[:-1], height - 1), np.minimum(across[:-1], width - 1)
    sums = np.add.reduceat(np.add.reduceat(rgb.astype(np.int64), first_rows, axis=0), first_columns, axis=1)
    counts = np.maximum(1, np.diff(down))[:, None] * np.maximum(1, np.diff(across))[None, :]
    means: NDArray[np.uint8] = np.minimum(255, sums // counts[:, :, None]).astype(np.uint8)
    return means


def settled(
    pixels: NDArray[np.uint8], shown: NDArray[np.uint8] | None, coarseness: int = 1, stays: int = STAYS
) -> NDArray[np.uint8]:
    """The pixels as they are shown next, with what is on the screen (of the same shape) kept where that is as good
    (``stays``); ``coarseness`` widens what counts as good."""
    import numpy as np

    coarse: NDArray[np.uint8] = ((pixels & 0xF8) | (pixels >> 5)).astype(np.uint8)
    new = pixels.astype(np.int16)
    if shown is not None:
        keep = np.abs(new - shown).max(axis=2) <= stays * coarseness
        coarse[keep] = shown[keep]
    else:
        keep = np.zeros(pixels.shape[:2], dtype=np.bool_)
    for column in range(pixels.shape[1]):  # from left to right: a run has the colour of its first pixel
        if column:
            like = np.abs(new[:, column] - coarse[:, column - 1]).max(axis=1) <= RUNS * coarseness
            like &= ~keep[:, column]
            coarse[like, column] = coarse[like, column - 1]
        upper, lower = coarse[0::2, column], coarse[1::2, column]  # one colour for both costs half
        alike = np.abs(new[1::2, column] - upper).max(axis=1) <= RUNS * coarseness
        alike &= ~keep[1::2, column]
        lower[alike] = upper[alike]
    return coarse


def afforded(pixels: NDArray[np.uint8], shown: NDArray[np.uint8] | None, limit: int) -> NDArray[np.uint8]:
    """As :func:`settled`, at no more than about ``limit`` bytes: coarser where much has changed, and where that would
    show nothing new, in parts, so that a view that stands becomes fine in the end."""
    for coarseness in COARSENESS:
        found = settled(pixels, shown, coarseness)
        if total(found, shown) <= limit:
            break
    if shown is None or coarseness == 1 or (found != shown).any():
        return found
    fine, parts, spent = settled(pixels, shown), shown.copy(), 0
    for row in range(len(fine) // 2):
        rows = slice(2 * row, 2 * row + 2)
        spent += total(fine[rows], shown[rows])
        if spent > limit and (parts != shown).any():
            break
        parts[rows] = fine[rows]
    return parts


def total(pixels: NDArray[np.uint8], shown: NDArray[np.uint8] | None) -> int:
    """About how many bytes it takes to show these pixels where those are on the screen."""
    cells = changed(shown, pixels)
    return sum(cost(pixels, row, *run) for row in range(len(cells)) for run in runs(cells[row].tolist()))


def changed(old: NDArray[np.uint8] | None, new: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Which characters differ: shape (rows, columns)."""
    import numpy as np

    if old is None or old.shape != new.shape:
        return np.ones((new.shape[0] // 2, new.shape[1]), dtype=np.bool_)
    pixels = (old != new).any(axis=2)
    found: NDArray[np.bool_] = pixels[0::2] | pixels[1::2]
    return found


def runs(row: Sequence[bool], gap: int = 3) -> list[tuple[int, int]]:
    """First column and length of each run of changed characters; small gaps are filled: cheaper than to jump."""
    found: list[tuple[int, int]] = []
    for column, is_changed in enumerate(row):
        if not is_changed:
            continue
        if found and column - (found[-1][0] + found[-1][1]) <= gap:
            found[-1] = (found[-1][0], column - found[-1][0] + 1)
        else:
            found.append((column, 1))
    return found


def cost(pixels: NDArray[np.uint8], row: int, first: int, length: int) -> int:
    """About how many bytes a run takes on the line."""
    pairs = pixels[2 * row : 2 * row + 2, first : first + length]
    new = (pairs[:, 1:] != pairs[:, :-1]).any(axis=(0, 2))
    plain = (pairs[0] == pairs[1]).all(axis=1)
    begins = [True, *new.tolist()]
    spent = JUMP_BYTES
    for begin, is_plain in zip(begins, plain.tolist(), strict=True):
        spent += (1 if is_plain else BLOCK_BYTES) + (begin and (PLAIN_BYTES if is_plain else SGR_BYTES))
    return spent


def frames(things: Sequence[Sighting], width: int, height: int, size: Extent) -> dict[tuple[int, int], Mark]:
    """Corners around things and their names, by row and column; ``width`` and ``height`` are the picture's, pixels. The
    nearest things come first, and have their names where there is no room for all."""
    corners: dict[tuple[int, int], Mark] = {}
    names: dict[tuple[int, int], Mark] = {}
    for thing in things:
        left, top, right, bottom = thing.box
        first = max(0, int(left * size.columns / width) - 1)
        last = min(size.columns - 1, int((right - 1) * size.columns / width) + 1)
        above = max(0, int(top * size.rows / height) - 1)
        below = min(size.rows - 1, int((bottom - 1) * size.rows / height) + 1)
        for at, char in (((above, first), "┌"), ((above, last), "┐"), ((below, first), "└"), ((below, last), "┘")):
            corners.setdefault(at, (char, False))
        start = max(0, min(first + 1, size.columns - len(thing.name)))
        for row in (above - 1, below + 1, above):
            spots = {(row, start + at): (char, True) for at, char in enumerate(thing.name[: size.columns])}
            around = {(row, start - 1), (row, start + len(thing.name))}
            if 0 <= row < size.rows and not names.keys() & (spots.keys() | around):
                names |= spots
                break
    return corners | names
