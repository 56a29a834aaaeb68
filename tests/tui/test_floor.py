"""The floor plan in characters."""

from __future__ import annotations

import math

import pytest

from tests.tui.scripted import PATH, PLACES, flat
from tui.plan.floor import ahead, arrow, draw, fit, way

FLAT = flat()


def lines(columns: int, rows: int) -> list[str]:
    return ["".join(cell.char for cell in row) for row in draw(FLAT, PLACES, fit(FLAT, columns, rows))]


def test_rooms_places_and_walls_are_where_they_belong() -> None:
    frame = fit(FLAT, 55, 22)
    cells = draw(FLAT, PLACES, frame)
    for symbol, place in PLACES.items():
        at = frame.cell(place.position.x, place.position.y)
        assert at is not None
        assert cells[at[0]][at[1]].char == symbol
    text = "\n".join(lines(55, 22))
    assert all(room.name in text for room in FLAT.rooms)
    bed = frame.cell(3.6, -3.0)
    assert bed is not None
    assert cells[bed[0]][bed[1]].ground == "furniture"


@pytest.mark.parametrize("size", [(55, 22), (30, 13), (2, 2), (200, 60), (7, 40)])
def test_the_whole_map_fits_whatever_the_size(size: tuple[int, int]) -> None:
    frame = fit(FLAT, *size)
    assert [len(line) for line in lines(*size)] == [size[0]] * size[1]
    for corner in ((-4.97, -3.97), (4.97, 3.97), (-4.97, 3.97), (4.97, -3.97)):
        assert frame.cell(*corner) is not None


def test_doors_stay_open() -> None:
    for size in ((55, 22), (30, 13)):
        frame = fit(FLAT, *size)
        cells = draw(FLAT, {}, frame)
        for door in ((-1.5, 0.0), (0.15, 0.9), (3.05, 0.9), (0.55, -0.9)):
            at = frame.cell(*door)
            assert at is not None
            assert cells[at[0]][at[1]].ground == "floor"
            assert cells[at[0]][at[1]].char == " "


def test_the_way_is_one_line_of_dots_from_end_to_end() -> None:
    frame = fit(FLAT, 55, 22)
    cells = way(PATH, frame)
    assert frame.cell(*PATH[0]) in cells
    assert frame.cell(*PATH[-1]) in cells
    assert all(0x2800 < ord(char) <= 0x28FF for char in cells.values())
    for row, column in cells:
        beside = {(row + down, column + right) for down in (-1, 0, 1) for right in (-1, 0, 1)} - {(row, column)}
        assert beside & cells.keys()


def test_the_way_behind_the_robot_is_not_drawn() -> None:
    assert ahead(PATH, *PATH[3]) == PATH[3:]
    assert ahead((), 0, 0) == ()


def test_the_arrow_points_where_the_robot_looks() -> None:
    assert [arrow(math.radians(degrees)) for degrees in (0, 90, 180, -90, 44, 359)] == list("→↑←↓↗→")
    assert arrow(math.nan) == "?"


def test_points_off_the_map_have_no_cell() -> None:
    frame = fit(FLAT, 55, 22)
    assert frame.cell(99, 0) is None
    assert frame.cell(math.nan, 0) is None
