"""The floor plan as characters: a pure function from the map and a size to cells, and back from metres to cells.

A character cell is about twice as high as wide. Walls and furniture are drawn in quarters of a cell (quadrant blocks,
which are solid), the planned way in braille (two by four dots a cell, which is fine). A cell has two colours, so it is
described by what its strokes and what its ground are; the colours belong to the theme.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Final, Literal

from msgspec import Struct
from rich.cells import cell_len

from tui.words.language import told

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from config.schema import Place
    from engine.perception.memory import Thing
    from engine.perception.people import PersonSeen
    from engine.robot.floor_map import FloorMap, Furniture, Room

Ground = Literal["outside", "floor", "furniture", "wall", "seen", "robot"]
Ink = Literal[
    "wall", "furniture", "label", "place", "path", "robot", "thing", "trail", "scan", "seen", "hand", "cursor"
]

_OUTSIDE, _FLOOR, _FURNITURE, _WALL = range(4)
_GROUNDS: Final[tuple[Ground, ...]] = ("outside", "floor", "furniture", "wall")
_QUADRANTS: Final = " ▘▝▀▖▌▞▛▗▚▐▜▄▙▟█"
"""By bits: 1 upper left, 2 upper right, 4 lower left, 8 lower right."""
_ARROWS: Final = "→↗↑↖←↙↓↘"
_BRAILLE: Final = 0x2800
_DOTS: Final = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
"""Bit of the braille dot by column and row within the cell (Unicode, block Braille Patterns)."""


class Cell(Struct, frozen=True):
    """One character of the plan. One that takes two columns is followed by a cell without any."""

    char: str
    ink: Ink
    ground: Ground
    colour: str = ""  # of a thing: the word for it…
    fade: int = 0  # …and by how many steps it has faded


class Frame(Struct, frozen=True):
    """Where the map lies on the characters: map metres → cells. North is up."""

    left: float  # m, map x at the left edge of column 0
    top: float  # m, map y at the upper edge of row 0
    cell_width: float  # m
    columns: int
    rows: int

    @property
    def cell_height(self) -> float:
        """m; a cell is twice as high as wide."""
        return 2 * self.cell_width

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Column and row of a point, with fractions; may lie outside."""
        return (x - self.left) / self.cell_width, (self.top - y) / self.cell_height

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """(row, column) of the cell that holds the point, None outside or for what is no number."""
        if not (math.isfinite(x) and math.isfinite(y)):
            return None
        column, row = self.at(x, y)
        if 0 <= column < self.columns and 0 <= row < self.rows:
            return int(row), int(column)
        return None


def fit(floor: FloorMap, columns: int, rows: int) -> Frame:
    """The largest frame that shows the whole map in ``columns`` × ``rows`` characters, about centred.

    It is nudged by parts of a cell to where the walls cover the fewest quarters: a thin wall on the border of two
    quarters would look twice as thick as its neighbour.
    """
    height = floor.occupied.shape[0] * floor.resolution
    width = floor.occupied.shape[1] * floor.resolution
    cell = max(width / max(1, columns - 0.5), height / (2 * max(1, rows - 0.5)), 1e-6)  # half a cell to nudge in
    left = floor.origin[0] + width / 2 - columns * cell / 2
    top = floor.origin[1] + height / 2 + rows * cell
    nudges = [number / 16 for number in range(-4, 5)]
    across = min(nudges, key=lambda nudge: _wall_quarters(floor, Frame(left + nudge * cell, top, cell, columns, rows)))
    left += across * cell
    down = min(
        nudges, key=lambda nudge: _wall_quarters(floor, Frame(left, top + nudge * cell * 2, cell, columns, rows))
    )
    return Frame(left, top + down * cell * 2, cell, columns, rows)


def draw(floor: FloorMap, places: Mapping[str, Place], frame: Frame) -> list[list[Cell]]:
    """Everything that stays: rows of cells with walls, furniture, names of rooms and symbols of places."""
    kinds = _quarters(floor, frame)
    cells = [
        [
            _cell([int(kinds[2 * row + down, 2 * column + right]) for down in (0, 1) for right in (0, 1)])
            for column in range(frame.columns)
        ]
        for row in range(frame.rows)
    ]
    taken: set[tuple[int, int]] = set()
    for symbol, place in places.items():
        at = frame.cell(place.position.x, place.position.y)
        if at is not None:
            row, column = at
            wide = cell_len(symbol[:1]) > 1
            column = min(column, frame.columns - 1 - wide)
            _write(cells, row, column, symbol[:1], "place")
            taken |= {(row, beside) for beside in range(column - 1, column + 2 + wide)}
    for room in floor.rooms:
        _label(cells, room, frame, taken)
    for thing in floor.furniture:
        _name_furniture(cells, thing, frame, taken)
    return cells


def way(path: Sequence[tuple[float, float]], frame: Frame, *, joined: bool = True) -> dict[tuple[int, int], str]:
    """The path as braille by (row, column); its corners alone where they are not to be joined."""
    dots: dict[tuple[int, int], int] = {}
    for x, y in _sampled(path, frame.cell_width / 2) if joined else path:
        cell = frame.cell(x, y)
        if cell is not None:
            column, row = frame.at(x, y)
            bit = _DOTS[min(1, int(column % 1 * 2))][min(3, int(row % 1 * 4))]
            dots[cell] = dots.get(cell, 0) | bit
    return {cell: chr(_BRAILLE + bits) for cell, bits in dots.items()}


def ahead(path: Sequence[tuple[float, float]], x: float, y: float) -> tuple[tuple[float, float], ...]:
    """What is left of the path for a robot at (x, y): from its nearest corner on."""
    if not path:
        return ()
    nearest = min(range(len(path)), key=lambda index: math.hypot(path[index][0] - x, path[index][1] - y))
    return ((x, y), *path[nearest + 1 :])


def arrow(yaw: float) -> str:
    """The arrow that points nearest to ``yaw`` (rad, counter-clockwise from east)."""
    return _ARROWS[round(yaw / (math.pi / 4)) % 8] if math.isfinite(yaw) else "?"


def thing_sign(thing: Thing, now: float) -> str:
    """A filled sign for a thing that was seen lately, an empty one for one that may have been moved since."""
    round_, square = ("○", "□") if thing.is_stale(now) else ("●", "■")
    return round_ if thing.kind in ("ball", "cup", "bottle") else square


def person_sign(person: PersonSeen, now: float) -> str:
    """The same for somebody."""
    return "☺" if person.is_stale(now) else "☻"


def _quarters(floor: FloorMap, frame: Frame) -> NDArray[np.int8]:
    """What lies on each quarter of a cell, shape (2 rows, 2 columns): walls win, however thin."""
    import numpy as np

    x, y = _edges(frame)
    middle_x, middle_y = (x[:-1] + x[1:]) / 2, (y[:-1] + y[1:]) / 2
    kinds = np.full((2 * frame.rows, 2 * frame.columns), _OUTSIDE, dtype=np.int8)

    def fill(shape: Room | Furniture, kind: int) -> None:
        in_y = (middle_y >= shape.y_min) & (middle_y <= shape.y_max)
        in_x = (middle_x >= shape.x_min) & (middle_x <= shape.x_max)
        kinds[in_y[:, None] & in_x[None, :]] = kind

    for room in floor.rooms:
        fill(room, _FLOOR)
    for thing in floor.furniture:
        fill(thing, _FURNITURE)
    kinds[_walls_by_quarter(floor, frame)] = _WALL
    return kinds


def _wall_quarters(floor: FloorMap, frame: Frame) -> int:
    return int(_walls_by_quarter(floor, frame).sum())


def _walls_by_quarter(floor: FloorMap, frame: Frame) -> NDArray[np.bool_]:
    """Whether any wall lies on each quarter, by differences of a summed-area table where they are large; shape
    (2 rows, 2 columns)."""
    import numpy as np

    walls = floor.occupied.copy()
    for thing in floor.furniture:  # occupied counts furniture too; a margin of a map cell for its rounded edges
        low = np.floor((np.array([thing.x_min, thing.y_min]) - floor.origin) / floor.resolution - 0.5).astype(int)
        high = np.ceil((np.array([thing.x_max, thing.y_max]) - floor.origin) / floor.resolution + 0.5).astype(int)
        low, high = np.maximum(low, 0), np.maximum(high, 0)
        walls[low[1] : high[1], low[0] : high[0]] = False
    if frame.cell_width / 2 < floor.resolution:  # many quarters to a cell of the map: what lies at their middles
        x, y = _edges(frame)
        at = ((x[:-1] + x[1:]) / 2 - floor.origin[0]) / floor.resolution
        along = ((y[:-1] + y[1:]) / 2 - floor.origin[1]) / floor.resolution
        padded = np.pad(walls, 1)
        row = np.clip(np.floor(along).astype(int) + 1, 0, padded.shape[0] - 1)
        column = np.clip(np.floor(at).astype(int) + 1, 0, padded.shape[1] - 1)
        found: NDArray[np.bool_] = padded[np.ix_(row, column)]
        return found
    total = np.zeros((walls.shape[0] + 1, walls.shape[1] + 1), dtype=np.int64)
    total[1:, 1:] = walls.cumsum(axis=0).cumsum(axis=1)
    x, y = _edges(frame)
    columns = np.clip(np.round((x - floor.origin[0]) / floor.resolution), 0, walls.shape[1]).astype(int)
    rows = np.clip(np.round((y - floor.origin[1]) / floor.resolution), 0, walls.shape[0]).astype(int)
    corner = total[np.ix_(rows, columns)]
    covered: NDArray[np.bool_] = corner[:-1, 1:] - corner[:-1, :-1] - corner[1:, 1:] + corner[1:, :-1] > 0
    return covered  # y falls from row to row, hence the signs


def _edges(frame: Frame) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Map coordinates of the borders between quarters, m: x rising, y falling."""
    import numpy as np  # here and not above: the first paint does not wait for it

    x = frame.left + frame.cell_width / 2 * np.arange(2 * frame.columns + 1, dtype=np.float64)
    y = frame.top - frame.cell_height / 2 * np.arange(2 * frame.rows + 1, dtype=np.float64)
    return x, y


def _cell(quarters: list[int]) -> Cell:
    strongest = max(quarters)
    if strongest < _FURNITURE:
        common = Counter(quarters).most_common(1)[0][0]
        return Cell(" ", "wall", _GROUNDS[common])
    bits = sum(1 << number for number, kind in enumerate(quarters) if kind == strongest)
    if bits == 15:  # all ground and no ink: a full block has gaps between lines in some fonts
        return Cell(" ", "wall", _GROUNDS[strongest])
    others = [kind for kind in quarters if kind != strongest]
    rest = max(set(others), key=lambda kind: (others.count(kind), -kind))
    return Cell(_QUADRANTS[bits], "wall" if strongest == _WALL else "furniture", _GROUNDS[rest])


def _label(cells: list[list[Cell]], room: Room, frame: Frame, taken: set[tuple[int, int]]) -> None:
    """Write the room's name on free floor, as near to the middle of what shows of it as there is room for it."""
    right, bottom = frame.left + frame.columns * frame.cell_width, frame.top - frame.rows * frame.cell_height
    middle, centre = frame.at(
        (max(room.x_min, frame.left) + min(room.x_max, right)) / 2,
        (max(room.y_min, bottom) + min(room.y_max, frame.top)) / 2,
    )
    name = told(room.name)
    width = cell_len(name)
    start = round(middle - width / 2)
    first, last = (int(frame.at(0, y)[1]) for y in (room.y_max, room.y_min))
    inside = range(int(frame.at(room.x_min, 0)[0]) + 1, int(frame.at(room.x_max, 0)[0]))  # not in a doorway
    for row in sorted(range(max(0, first), min(frame.rows, last + 1)), key=lambda row: abs(row + 0.5 - centre)):
        for shift in (0, 1, -1, 2, -2, 3, -3):
            spots = [(row, column) for column in range(start + shift, start + shift + width)]
            if spots[0][1] in inside and spots[-1][1] in inside and _is_free(cells, spots, taken):
                _write(cells, *spots[0], name, "label")
                return


def _name_furniture(cells: list[list[Cell]], thing: Furniture, frame: Frame, taken: set[tuple[int, int]]) -> None:
    """Write the name on the furniture where there is room for it, with a margin: names alone, and no crossword."""
    column, row = frame.at((thing.x_min + thing.x_max) / 2, (thing.y_min + thing.y_max) / 2)
    if not (0 <= row < frame.rows):
        return
    name = told(thing.name)
    width = cell_len(name)
    start = round(column - width / 2)
    spots = [(int(row), start + shift) for shift in range(-1, width + 1)]
    if _is_free(cells, spots, taken, "furniture"):
        _write(cells, int(row), start, name, "label")


def _write(cells: list[list[Cell]], row: int, column: int, text: str, ink: Ink) -> None:
    """Put text on the plan, from a column on; it keeps the ground that is there."""
    for char in text:
        width = cell_len(char)
        if not width:  # an accent belongs to the character before it
            continue
        cells[row][column] = Cell(char, ink, cells[row][column].ground)
        for behind in range(column + 1, column + width):
            cells[row][behind] = Cell("", ink, cells[row][behind].ground)
        column += width


def _is_free(
    cells: list[list[Cell]], spots: Iterable[tuple[int, int]], taken: set[tuple[int, int]], ground: Ground = "floor"
) -> bool:
    return all(
        0 <= column < len(cells[row]) and cells[row][column] == Cell(" ", "wall", ground) and (row, column) not in taken
        for row, column in spots
    )


def _sampled(path: Sequence[tuple[float, float]], step: float) -> Iterable[tuple[float, float]]:
    for (x, y), (next_x, next_y) in pairwise(path):
        count = min(2000, max(1, math.ceil(math.hypot(next_x - x, next_y - y) / step * 2)))
        for number in range(count):
            share = number / count
            yield x + (next_x - x) * share, y + (next_y - y) * share
    if path:
        yield path[-1]
