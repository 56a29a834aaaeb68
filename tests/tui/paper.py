"""A terminal as far as graphics go: pictures that are sent to it by sixel or kitty's protocol become pixels again."""

from __future__ import annotations

import base64
import re

import numpy as np
from numpy.typing import NDArray
from textual.geometry import Region

from tui.graphics.asking import Cell
from tui.graphics.tiles import Extent

SIZE = Extent(45, 17)
PLACE = Region(60, 10, 45, 17)
CELL = Cell(10, 20)


class Paper:
    """A terminal as far as its graphics go: it shows what it is sent, pixel by pixel."""

    def __init__(self, columns: int = 120, rows: int = 40, cell: Cell = CELL) -> None:
        self.cell = cell
        self.pixels = np.zeros((rows * cell.height, columns * cell.width, 3), dtype=np.uint8)  # sixel
        self.placed: dict[int, tuple[int, int, int, int, NDArray[np.uint8]]] = {}  # kitty: column, row, size, picture
        self._chunks = ""
        self._about: dict[str, str] = {}

    def feed(self, text: str) -> None:
        column = row = 0
        pattern = r"\x1b\[(\d+);(\d+)H|\x1b[P_].*?\x1b\\|\x1b[78]"
        rest = re.sub(pattern, "", text, flags=re.DOTALL)
        assert not rest, "nothing but pictures"
        for found in re.finditer(pattern, text, flags=re.DOTALL):
            if found[1]:
                row, column = int(found[1]) - 1, int(found[2]) - 1
            elif found[0] not in ("\x1b7", "\x1b8"):
                self.take(column, row, found[0])

    def take(self, column: int, row: int, sequence: str) -> None:
        """One sequence, with the cursor there."""
        if sequence.startswith("\x1bP0;1q"):
            self._sixel(column, row, sequence[6:-2])
        elif sequence.startswith("\x1b_G"):
            self._kitty(column, row, sequence[3:-2])
        else:
            raise AssertionError(sequence[:40])

    def overwrite(self, region: Region) -> None:
        """Text is written there."""
        height, width = self.cell.height, self.cell.width
        self.pixels[region.y * height : region.bottom * height, region.x * width : region.right * width] = 0

    def seen(self, place: Region = PLACE) -> NDArray[np.uint8]:
        """The pixels of a part of the screen."""
        if self.placed:
            ((column, row, columns, rows, picture),) = self.placed.values()
            assert Region(column, row, columns, rows) == place
            return picture
        height, width = self.cell.height, self.cell.width
        return self.pixels[place.y * height : place.bottom * height, place.x * width : place.right * width]

    @property
    def all(self) -> NDArray[np.uint8] | None:
        """All that is on it, wherever; None: nothing."""
        if self.placed:
            ((*_, picture),) = self.placed.values()
            return picture
        lit: NDArray[np.bool_] = self.pixels.max(axis=2) > 0
        if not lit.any():
            return None
        rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
        return self.pixels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]

    def _kitty(self, column: int, row: int, body: str) -> None:
        keys, _, data = body.partition(";")
        about = dict(pair.split("=") for pair in keys.split(","))
        if about.get("a") == "d":
            assert about["d"] == "I"
            self.placed.pop(int(about["i"]), None)
            return
        self._about = about if "a" in about else self._about
        self._chunks += data
        if about["m"] == "0":
            its = self._about
            assert (its["a"], its["f"], its["C"], its["q"]) == ("T", "100", "1", "2")
            place = (column, row, int(its["c"]), int(its["r"]))
            self.placed[int(its["i"])] = (*place, decoded(base64.b64decode(self._chunks)))
            self._chunks = ""

    def _sixel(self, column: int, row: int, body: str) -> None:
        attributes = re.match(r'"1;1;(\d+);(\d+)', body)
        assert attributes
        across, down = int(attributes[1]), int(attributes[2])
        colours: dict[int, tuple[int, ...]] = {}
        x = y = colour = 0
        origin_x, origin_y = column * self.cell.width, row * self.cell.height
        for number, mode, count, char in re.findall(
            r"#(\d+)((?:;\d+){4})?|(?:!(\d+))?([?-~$-])", body[attributes.end() :]
        ):
            if mode:
                assert mode.startswith(";2;")
                colours[int(number)] = tuple(round(int(part) * 255 / 100) for part in mode.split(";")[2:])
            elif number:
                colour = int(number)
            elif char == "$":
                x = 0
            elif char == "-":
                x, y = 0, y + 6
            else:
                length = int(count or 1)
                for bit in range(6):
                    if ord(char) - 63 >> bit & 1:
                        assert y + bit < down
                        assert x + length <= across
                        at = origin_y + y + bit
                        self.pixels[at, origin_x + x : origin_x + x + length] = colours[colour]
                x += length


def decoded(png: bytes) -> NDArray[np.uint8]:
    """A PNG file by another's hand."""
    import cv2

    bgr = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert bgr is not None
    return np.asarray(bgr[..., ::-1], dtype=np.uint8)


def far_off(seen: NDArray[np.uint8], rgb: NDArray[np.uint8]) -> float:
    """The share of a picture that is clearly another than the camera's; edges may be a pixel aside."""
    import cv2

    one, other = (cv2.resize(pixels, (80, 60), interpolation=cv2.INTER_AREA).astype(np.int16) for pixels in (seen, rgb))
    return float((np.abs(one - other).max(axis=2) > 30).mean())
