"""A picture for terminals with sixel graphics (DEC STD 070): six rows of pixels in a line, one colour after another.

It is as large as its pixels on the screen, so a small picture is made large here: each of its columns becomes a run.
The terminal forgets those parts on which text is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tui.graphics.pixels import Indexed

MOST_COLOURS: Final = 64
"""A small palette; terminals have 256 colours for this, some fewer."""
BAND: Final = 6
"""Rows of pixels in a line."""


def shown(picture: Indexed, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> str:
    """Shows a part of the picture with its upper left corner at the cursor, which then is somewhere else. ``rows`` and
    ``columns`` say which row and column of the picture each of the screen's pixels has."""
    import numpy as np

    starts = np.flatnonzero(np.diff(columns, prepend=-1))
    widths = np.diff(starts, append=len(columns)).tolist()
    used = np.unique(picture.pixels[np.unique(rows)][:, columns[starts]])
    number = np.zeros(256, dtype=np.int64)
    number[used] = np.arange(len(used))
    palette = "".join(
        f"#{at};2;" + ";".join(str((int(value) * 100 + 127) // 255) for value in picture.colours[colour])
        for at, colour in enumerate(used.tolist())
    )
    lines = []
    for first in range(0, len(rows), BAND):
        band = number[picture.pixels[rows[first : first + BAND]][:, columns[starts]]]
        lines.append("$".join(_colours(band, widths)))
    return f'\x1bP0;1q"1;1;{len(columns)};{len(rows)}{palette}{"-".join(lines)}\x1b\\'


def _colours(band: NDArray[np.int64], widths: list[int]) -> Iterator[str]:
    """What each colour of a line has, with nothing behind its last pixel. ``band`` has up to six rows."""
    import numpy as np

    bit = 1 << np.arange(len(band))
    for colour in np.unique(band).tolist():
        bits = ((band == colour) * bit[:, None]).sum(axis=0).tolist()
        line = ""
        last = max(at for at, its in enumerate(bits) if its)
        for its, group in groupby(range(last + 1), key=bits.__getitem__):
            count = sum(widths[at] for at in group)
            line += chr(63 + its) * count if count <= 3 else f"!{count}{chr(63 + its)}"
        yield f"#{colour}{line}"
