"""The one picture that stands on the terminal, and what has to be sent so that it is the newest, in its place, or gone.

Text and picture are two layers that know nothing of each other. So the picture goes behind each frame of text: this
knows what the frame has overwritten, which with sixel is lost, and where the picture belongs now. kitty's pictures are
sent as a whole, under one of two numbers in turn, so that the old one goes when the new one is there; of a sixel
picture the parts are sent that have changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import gcd
from typing import TYPE_CHECKING, Final, NamedTuple

from textual.geometry import Offset, Region

from tui.graphics import kitty, sixel
from tui.graphics.asking import Cell, Graphics
from tui.graphics.pixels import MOST_COLUMNS, Indexed, Inks, indexed, marked
from tui.graphics.tiles import COARSENESS, Extent, runs, settled, shrunk

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.perception.sighting import Sighting

LIMIT_BYTES: Final = 9000
"""What one picture may send, about, while it changes; it is made coarser up to there. One that stands becomes fine."""
STAYS: Final = 24
"""Of 255, in each channel: a pixel that changes by no more than this stays as it is. A single one that does not costs a
whole picture, or a part."""
FINE: Final = 2
"""Coarser pictures than this have half as many rows and columns."""
_NUMBERS: Final = (7341, 7342)
"""Of our pictures in kitty's memory."""


class Part(NamedTuple):
    """Something to be sent that covers some characters of the picture, with the cursor at the first of them."""

    region: Region
    data: str


class Surface:
    """Where pictures go on one terminal. In the UI thread."""

    def __init__(self, graphics: Graphics) -> None:
        self._cell = graphics.cell if graphics.protocol == "sixel" else None
        self._size = Extent(1, 1)
        self._aim: Indexed | None = None  # what is to be seen
        self._shown: Indexed | None = None  # what is
        self._place: Region | None = None  # and where on the screen, characters
        self._number = 0  # which of the two it is
        self._before: NDArray[np.uint8] | None = None  # the last one, as it was before anything was done to it
        self._tried: int = COARSENESS[0]  # how coarse it was sent
        self._ready: tuple[Indexed, Indexed | None, list[Part]] | None = None  # how one becomes the other

    def paint(self, rgb: NDArray[np.uint8], things: Sequence[Sighting], size: Extent, inks: Inks) -> int:
        """Aim at this picture, with frames around ``things``, as large as ``size``; gives how many bytes it sends."""
        import numpy as np  # here and not above: the first paint does not wait for it

        height, width = rgb.shape[:2]
        rows, columns = self._grid(height, width, size)
        fine = shrunk(rgb, Extent(columns, rows // 2))
        means = shrunk(rgb, Extent((columns + 1) // 2, (rows + 3) // 4))
        rough = means.repeat(2, axis=0).repeat(2, axis=1)[:rows, :columns]
        same = size == self._size and self._aim is not None and self._aim.pixels.shape == (rows, columns)
        old, self._size = self._aim.rgb if same and self._aim is not None else None, size

        def sent(coarseness: int) -> int:
            found = settled(fine if coarseness <= FINE else rough, old, coarseness, STAYS)
            marked(found, things, width, height, inks)
            return self._aim_at(indexed(found, kitty.MOST_COLOURS if self._cell is None else sixel.MOST_COLOURS))

        before, self._before = self._before, fine
        if old is not None and before is not None and np.abs(fine.astype(np.int16) - before).max() <= STAYS:
            self._tried = COARSENESS[0]
            return sent(self._tried)  # it stands, and becomes fine
        for coarseness in COARSENESS[max(0, self._tried - 2) :]:  # one step finer than the last one: each takes time
            self._tried = coarseness
            if (cost := sent(coarseness)) <= LIMIT_BYTES:
                break
        return cost

    def clear(self) -> None:
        """There is no picture."""
        self._aim = self._ready = None

    @property
    def spot(self) -> Offset | None:
        """A character of the picture that the next frame is going to cover; None: it covers nothing."""
        return self._ready[2][0].region.offset if self._ready is not None and self._ready[2] else None

    def behind(self, place: Region | None, rewritten: Iterable[Region]) -> str:
        """What to send behind a frame which wrote text to ``rewritten``; ``place`` is where the picture belongs on the
        screen, None while it is not to be seen."""
        if self._aim is None or place is None or place.size != (self._size.columns, self._size.rows):
            place = None
        written = ""
        if place != self._place:
            if self._shown is not None and self._cell is None:
                written = kitty.removed(_NUMBERS[self._number])
            self._shown, self._place = None, place
        if place is None or self._aim is None:
            return written
        hurt = [part.intersection(place).translate((-place.x, -place.y)) for part in rewritten if part.overlaps(place)]
        parts, self._ready = self._parts(self._aim, hurt), None  # kitty's is ready for one number only
        if parts:
            written += "\x1b7"
            for (column, row, _, _), data in parts:
                written += f"\x1b[{place.y + row + 1};{place.x + column + 1}H{data}"
            written += "\x1b8"
            if self._cell is None:
                written += kitty.removed(_NUMBERS[self._number]) if self._shown is not None else ""
                self._number = 1 - self._number
        self._shown = self._aim
        return written

    def gone(self) -> str:
        """What to send so that nothing of ours is left on the screen and in the terminal's memory; text overwrites
        sixel."""
        return "" if self._cell is not None else "".join(map(kitty.removed, _NUMBERS))

    def _aim_at(self, picture: Indexed) -> int:
        """Make this the next picture; gives what it sends."""
        shown = self._shown
        if shown is not None and shown.pixels.shape == picture.pixels.shape and (shown.rgb == picture.rgb).all():
            picture = shown
        self._aim, self._ready = picture, None
        parts = self._parts(picture, ())
        self._ready = (picture, shown, parts)
        return sum(len(part.data) for part in parts)

    def _parts(self, aim: Indexed, hurt: Sequence[Region]) -> list[Part]:
        """What to send so that ``aim`` is seen, where ``hurt`` (in characters of the picture) was overwritten."""
        if self._ready is not None and self._ready[0] is aim and self._ready[1] is self._shown:
            ready = self._ready[2]
            if all(any(part.region.contains_region(region) for part in ready) for region in hurt):
                return ready
        if self._cell is not None:
            return list(self._changed(aim, hurt, self._cell))
        whole = Region(0, 0, self._size.columns, self._size.rows)
        if aim is self._shown and whole not in hurt:  # which all of it is where a screen is drawn anew
            return []
        return [Part(whole, kitty.shown(aim, self._size, _NUMBERS[1 - self._number]))]

    def _changed(self, aim: Indexed, hurt: Sequence[Region], cell: Cell) -> Iterator[Part]:
        """The parts of a sixel picture that have to be sent: groups of rows."""
        import numpy as np

        rows, columns = self._maps(aim, cell)
        cells: NDArray[np.bool_] = np.ones((self._size.rows, self._size.columns), dtype=np.bool_)
        if aim is self._shown:
            cells[:] = False
        elif self._shown is not None and self._shown.pixels.shape == aim.pixels.shape:
            pixels = (self._shown.rgb != aim.rgb).any(axis=2)[rows][:, columns]
            cells = pixels.reshape(self._size.rows, cell.height, self._size.columns, cell.width).any(axis=(1, 3))
        for part in hurt:
            cells[part.y : part.bottom, part.x : part.right] = True
        step = sixel.BAND // gcd(cell.height, sixel.BAND)  # where a line of pixels begins with a row of text
        for first, length in runs([bool(row.any()) for row in cells], step):
            begin, end = first - first % step, first + length
            across = np.flatnonzero(cells[begin:end].any(axis=0))
            left, right = int(across[0]), int(across[-1]) + 1
            data = sixel.shown(
                aim,
                rows[begin * cell.height : end * cell.height],
                columns[left * cell.width : right * cell.width],
            )
            yield Part(Region(left, begin, right - left, end - begin), data)

    def _grid(self, height: int, width: int, size: Extent) -> tuple[int, int]:
        """In how many rows (an even number) and columns of pixels a picture of the camera is sent."""
        if self._cell is None:
            columns = min(width, MOST_COLUMNS)
            return 2 * max(1, round(columns * height / width / 2)), columns
        tall, wide = size.rows * self._cell.height, size.columns * self._cell.width
        fine = self._fineness(height, tall)
        return 2 * -(-tall * fine // (2 * sixel.BAND)), min(width, wide, MOST_COLUMNS)

    @staticmethod
    def _fineness(height: int, tall: int) -> int:
        """Rows of a sixel picture in a line, for one of ``height`` rows on ``tall`` pixels: whole ones cost least."""
        return min((1, 2, 3, 6), key=lambda rows: abs(rows * tall / sixel.BAND - height))

    def _maps(self, picture: Indexed, cell: Cell) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The row and the column of the picture for each of the screen's pixels."""
        import numpy as np

        tall, wide = self._size.rows * cell.height, self._size.columns * cell.width
        down, across = picture.pixels.shape
        fine = max(1, round(down * sixel.BAND / tall))
        return np.arange(tall) * fine // sixel.BAND, np.arange(wide) * across // wide
