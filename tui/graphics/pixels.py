"""A picture of few colours, as both protocols send it, with what was recognised drawn into it.

Both show a picture over the text, so frames and names are pixels, too. A camera's pixel covers two or three of the
screen's, so letters of 3 × 5 of them are about as large as those of the terminal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from msgspec import Struct

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.perception.sighting import Sighting
    from tui.graphics.tiles import Colour

MOST_COLUMNS: Final = 240
"""Pixels; a picture with more is made smaller before it is sent."""
LETTER: Final = (3, 5)
"""Width and height of a letter, pixels; one more column lies between two, and one pixel around a word."""
_ALPHABET: Final = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-"
_DRAWN: Final = (
    "25755 65656 34443 65556 74647 74644 34553 55755 72227 11152 55655 44447 57755 65555 25552 65644 25563 65655 "
    "34216 72222 55557 55552 55775 55255 55222 71247 75557 26227 71747 71717 55711 74717 74757 71122 75757 75717 00700"
)
"""An octal digit a row, from the top; its bits are the pixels."""
_LETTERS: Final = dict(zip(_ALPHABET, _DRAWN.split(), strict=True))


class Inks(Struct, frozen=True):
    """The colours of what is drawn into a picture."""

    frame: Colour
    name: Colour
    plate: Colour  # behind a name


class Indexed(Struct, frozen=True, eq=False):
    """A picture of few colours."""

    colours: NDArray[np.uint8]  # (n, 3)
    pixels: NDArray[np.uint8]  # (height, width): which of them

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """The picture in full: (height, width, 3)."""
        return self.colours[self.pixels]


def indexed(rgb: NDArray[np.uint8], most: int) -> Indexed:
    """The picture in its ``most`` (≤ 256) frequent colours; the others become the nearest of those."""
    import numpy as np  # here and not above: the first paint does not wait for it

    packed = (rgb[..., 0].astype(np.int64) << 16) | (rgb[..., 1].astype(np.int64) << 8) | rgb[..., 2]
    found, pixels, counts = np.unique(packed, return_inverse=True, return_counts=True)
    colours = np.stack([found >> 16, (found >> 8) & 255, found & 255], axis=1)
    kept = colours[np.sort(np.argsort(-counts, kind="stable")[:most])]
    nearest = ((colours[:, None] - kept[None]) ** 2).sum(axis=2).argmin(axis=1)
    return Indexed(kept.astype(np.uint8), nearest[pixels.reshape(packed.shape)].astype(np.uint8))


def marked(rgb: NDArray[np.uint8], things: Sequence[Sighting], width: int, height: int, inks: Inks) -> None:
    """Draw frames around things and their names into ``rgb``; boxes are in pixels of a picture of ``width`` ×
    ``height``. The nearest things come first, and have their names where there is no room for all."""
    down, across = rgb.shape[:2]
    taken: list[tuple[int, int, int, int]] = []
    for thing in reversed(things):  # the nearest is drawn last
        left, top, right, bottom = thing.box
        first, last = left * across // width, max(0, right - 1) * across // width
        above, below = top * down // height, max(0, bottom - 1) * down // height
        rgb[above, first : last + 1] = rgb[below, first : last + 1] = inks.frame
        rgb[above : below + 1, first] = rgb[above : below + 1, last] = inks.frame
    for thing in things:
        left, top, _, bottom = thing.box
        wide, high = len(thing.name) * (LETTER[0] + 1) + 1, LETTER[1] + 2
        x = max(0, min(left * across // width, across - wide))
        for y in (top * down // height - high, bottom * down // height, top * down // height + 1):
            plate = (x, y, x + wide, y + high)
            if 0 <= y <= down - high and not any(_overlap(plate, other) for other in taken):
                taken.append(plate)
                _write(rgb[y : y + high, x : x + wide], thing.name, inks)
                break


def _overlap(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _write(plate: NDArray[np.uint8], name: str, inks: Inks) -> None:
    """A word on its plate, which is a part of the picture."""
    plate[:] = inks.plate
    for place, char in enumerate(name.upper()):
        for row, bits in enumerate(_LETTERS.get(char, "00000")):
            for column in range(LETTER[0]):
                at = 1 + place * (LETTER[0] + 1) + column
                if int(bits) & 4 >> column and at < plate.shape[1]:
                    plate[1 + row, at] = inks.name
