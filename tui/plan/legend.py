"""What the signs of the map mean, and who and what was seen, where and when: short entries of a sign and its words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from typing import TYPE_CHECKING, Final

from msgspec import Struct
from rich.cells import cell_len

from tui.plan.chart import TRAIL, Moving, faded
from tui.plan.floor import Cell, Ink, person_sign, thing_sign
from tui.plan.targets import ago
from tui.shown.facts import printable
from tui.words import strings
from tui.words.language import told

if TYPE_CHECKING:
    from config.schema import Place
    from engine.robot.floor_map import FloorMap

_SIGNS: Final[tuple[tuple[str, Ink, str], ...]] = (
    ("→↗↑↖←↙↓↘?", "robot", "robot"),
    ("▶◀▼▲", "robot", "robot_outside"),
    ("", "path", "path"),
    (TRAIL, "trail", "trail"),
    ("", "scan", "scan"),
    ("■", "thing", "thing"),
    ("●", "thing", "round"),
    ("□○", "thing", "stale"),
    ("☻", "thing", "person"),
    ("☺", "thing", "person_stale"),
    ("◇", "hand", "hand"),
    ("◆", "thing", "held"),
)
"""The characters of each kind, or all of an ink."""
_GAP: Final = 2


class Entry(Struct, frozen=True):
    """A sign as it stands on the map, and what it is."""

    sign: Cell
    words: str

    @property
    def columns(self) -> int:
        """So many it takes, with a blank behind the sign."""
        return cell_len(self.sign.char) + 1 + cell_len(self.words)


Row = tuple[Entry, ...]


def legend(
    moving: Moving, floor: FloorMap, places: Mapping[str, Place], shown: Set[tuple[str, Ink]], columns: int, rows: int
) -> tuple[Row, ...]:
    """Of what is ``shown``, by character and ink: the signs, then the places, as many on a line as it has room for;
    then a line for each person and each thing that was seen, the newest first; of all that as much as there is room
    for."""
    signs: list[Entry] = []
    for chars, ink, word in _SIGNS:
        found = min(
            (char for char, its in shown if its == ink and char.strip() and (char in chars or not chars)), default=""
        )
        if found:
            signs.append(Entry(Cell(found, ink, "floor", "grey" if ink == "thing" else ""), strings.MAP_SIGNS[word]))
    named = [
        Entry(Cell(symbol[:1], "place", "floor"), printable(told(place.name)))
        for symbol, place in places.items()
        if (symbol[:1], "place") in shown
    ]
    listed = [*_packed(signs, columns), *_packed(named, columns), *((entry,) for entry in _seen(moving, floor))]
    return tuple(listed[: max(0, rows)])


def _packed(entries: Sequence[Entry], columns: int) -> Iterator[Row]:
    row: list[Entry] = []
    for entry in entries:
        if row and sum(one.columns + _GAP for one in row) + entry.columns > columns:
            yield tuple(row)
            row = []
        row.append(entry)
    if row:
        yield tuple(row)


def _seen(moving: Moving, floor: FloorMap) -> Iterator[Entry]:
    for person in sorted(moving.people, key=lambda one: -one.seen_at):
        age = moving.now - person.seen_at
        sign = Cell(person_sign(person, moving.now), "thing", "floor", person.shirt or "grey", faded(age))
        yield Entry(sign, _told(person.name or "person", floor, person.position, age))
    for thing in sorted(moving.things, key=lambda one: -one.seen_at):
        age = moving.now - thing.seen_at
        sign = Cell(thing_sign(thing, moving.now), "thing", "floor", thing.colour, faded(age))
        yield Entry(sign, _told(thing.name, floor, thing.position, age))


def _told(name: str, floor: FloorMap, position: Sequence[float], age: float) -> str:
    x, y = position[:2]
    rooms = (room.name for room in floor.rooms if room.x_min <= x <= room.x_max and room.y_min <= y <= room.y_max)
    where = next(rooms, f"({x:.1f}, {y:.1f})")
    return printable(f"{told(name)} · {told(where)} · {ago(age)}")
