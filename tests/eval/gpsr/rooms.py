"""The rooms of a made-up house: a corridor with two rooms on either side, their doors and their furniture.

Lengths are m, map frame: x along the corridor, whose middle is at y = 0. Furniture stands with its back to a wall; what
things are put on is low, because the arm reaches no higher.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from engine.robot.sim.clutter import _away, _front
from engine.robot.sim.scene_parts import Point
from tests.eval.gpsr.lexicon import CHINESE

Area = tuple[float, float, float, float]

LOW: Final = 0.14
"""Height of what things are put on."""
CORRIDOR: Final = "corridor"
DOOR: Final = 1.0
FREE: Final = 0.62
"""Floor between two pieces of furniture."""
SLOT: Final = 0.17
"""Along a piece of furniture for each thing on it."""
STAND: Final = 0.4
"""Before a piece of furniture, where the robot is sent to."""
_TRIES: Final = 300

_LOW: Final = {"kind": "low_table"}
FURNITURE: Final[Mapping[str, Mapping[str, Mapping[str, Any]]]] = {
    "bedroom": {
        "bed": {"kind": "bed", "size": (1.6, 1.9, 0.9), "accent": "#7d93a8"},
        "desk": {**_LOW, "size": (0.9, 0.5, LOW), "colour": "birch"},
        "side table": {**_LOW, "size": (0.6, 0.45, LOW)},
    },
    "dining room": {
        "dining table": {**_LOW, "size": (1.2, 0.6, LOW), "colour": "walnut"},
        "palm": {"kind": "plant", "size": (0.5, 0.5, 1.1), "colour": "terracotta"},
    },
    "living room": {
        "couch": {"kind": "sofa", "size": (1.9, 0.9, 0.78), "colour": "petrol", "accent": "#d9b26a"},
        "bookcase": {**_LOW, "size": (0.9, 0.4, LOW), "colour": "walnut"},
        "end table": {**_LOW, "size": (0.6, 0.45, LOW), "colour": "birch"},
    },
    "kitchen": {
        "counter": {**_LOW, "size": (1.1, 0.5, LOW), "colour": "walnut"},
        "dishwasher": {"kind": "wardrobe", "size": (0.6, 0.6, 0.85), "colour": "white"},
        "cupboard": {**_LOW, "size": (0.8, 0.45, LOW)},
        "storage table": {**_LOW, "size": (0.8, 0.45, LOW), "colour": "birch"},
        "sink": {**_LOW, "size": (0.6, 0.45, LOW), "colour": "steel"},
        "bin": {"kind": "bin", "size": (0.3, 0.3, 0.2), "colour": "slate"},
    },
}
"""What stands in which room; all but the palm and the bin have the grammar's names."""
TALL: Final = frozenset({"bed", "sofa", "wardrobe", "chair", "plant", "carton"})
"""Kinds that hide what hangs on the wall behind them."""


class NoHouse(Exception):
    """What is needed finds no room in this house; another one may have it."""


@dataclass(frozen=True, slots=True)
class Opening:
    """A door between the corridor and a room."""

    room: str
    at: Point
    into: int  # 1: the room is north of the corridor, −1: south

    @property
    def inside(self) -> Point:
        return self.at[0], self.at[1] + 0.7 * self.into


@dataclass
class Draft:
    """What has been placed so far."""

    rng: np.random.Generator
    rooms: dict[str, Area] = field(default_factory=dict)
    doors: dict[str, Opening] = field(default_factory=dict)
    furniture: dict[str, dict[str, Any]] = field(default_factory=dict)
    places: dict[str, dict[str, Any]] = field(default_factory=dict)
    objects: dict[str, dict[str, Any]] = field(default_factory=dict)
    people: dict[str, dict[str, Any]] = field(default_factory=dict)
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def uniform(self, low: float, high: float) -> float:
        return round(float(self.rng.uniform(low, high)), 2)

    def areas(self) -> Iterator[Area]:
        """Where furniture stands."""
        for piece in self.furniture.values():
            yield area_of(piece)

    def room_of(self, name: str) -> str:
        """The room that a place or a piece of furniture is in, or the room itself."""
        if name in self.rooms:
            return name
        x, y = self.furniture[name]["at"] if name in self.furniture else self.places[name]["at"]
        return next(room for room, area in self.rooms.items() if _away((x, y), area) == 0)

    def stands(self) -> list[Point]:
        """Where the robot is sent to, and where it begins."""
        return [*(place["at"] for place in self.places.values()), self.start[:2]]

    def bodies(self) -> list[Point]:
        """Where people stand, sit and lie."""
        return [person["path"][0] for person in self.people.values()]


def area_of(piece: Mapping[str, Any]) -> Area:
    (x, y), (length, depth, _) = piece["at"], piece["size"]
    ex, ey = (length, depth) if piece.get("turn", 0) % 180 == 0 else (depth, length)
    return x - ex / 2, y - ey / 2, x + ex / 2, y + ey / 2


def front_of(piece: Mapping[str, Any]) -> tuple[Point, Point]:
    """Where its front looks, and to the right along it as somebody before it sees it."""
    front = _front(piece.get("turn", 0))
    return front, (-front[1], front[0])


def before(piece: Mapping[str, Any], out: float, aside: float = 0.0) -> Point:
    """So far before its front, and so far to the right along it."""
    front, right = front_of(piece)
    x, y = piece["at"]
    away = piece["size"][1] / 2 + out
    return round(x + front[0] * away + right[0] * aside, 3), round(y + front[1] * away + right[1] * aside, 3)


def furnished(rng: np.random.Generator, many: Mapping[str, int]) -> Draft:
    """A house with furniture that has room for so many things side by side. Raises :class:`NoHouse`."""
    draft = Draft(rng)
    _rooms(draft)
    for room, pieces in FURNITURE.items():
        for name, piece in pieces.items():
            length, depth, height = piece["size"]
            size = (max(length, SLOT * many.get(name, 0) + 0.1), depth, height)
            _at_a_wall(draft, room, name, {"colour": "oak", **piece, "size": size})
    _spots(draft)
    return draft


def _rooms(draft: Draft) -> None:
    """Two rooms north of the corridor and two south of it, in random order."""
    half = draft.uniform(1.0, 1.15)
    length = draft.uniform(9.8, 11.0)
    names = [str(name) for name in draft.rng.permutation(list(FURNITURE))]
    west, east = -length / 2, length / 2
    draft.rooms[CORRIDOR] = (west, -half, east, half)
    for side, pair in ((1, names[:2]), (-1, names[2:])):
        middle = draft.uniform(-0.4, 0.4)
        depth = draft.uniform(3.9, 4.5)
        low, high = (half, half + depth) if side > 0 else (-half - depth, -half)
        for name, (x0, x1) in zip(pair, ((west, middle), (middle, east)), strict=True):
            draft.rooms[name] = (x0, low, x1, high)
            draft.doors[name] = Opening(name, (draft.uniform(x0 + 1.0, x1 - 1.0), side * half), side)


def _at_a_wall(draft: Draft, room: str, name: str, piece: dict[str, Any]) -> None:
    x_min, y_min, x_max, y_max = draft.rooms[room]
    length, depth, _ = piece["size"]
    for _ in range(_TRIES):
        turn = int(draft.rng.choice([0, 90, 180, 270]))
        ex, ey = (length, depth) if turn % 180 == 0 else (depth, length)
        x0, x1 = x_min + 0.08 + ex / 2, x_max - 0.08 - ex / 2
        y0, y1 = y_min + 0.08 + ey / 2, y_max - 0.08 - ey / 2
        x, y = draft.uniform(x0, x1), draft.uniform(y0, y1)
        at = {0: (x, y1), 90: (x0, y), 180: (x, y0), 270: (x1, y)}[turn]
        placed = {**piece, "at": (round(at[0], 3), round(at[1], 3)), "turn": turn}
        stand = before(placed, STAND)
        if (
            all(_apart(area_of(placed), other) >= FREE for other in draft.areas())
            and _away(draft.doors[room].at, area_of(placed)) > 0.95
            and all(_away(stand, other) > 0.3 for other in draft.areas())
            and all(_away(place["at"], area_of(placed)) > 0.3 for place in draft.places.values())
        ):
            draft.furniture[name] = placed
            if piece["kind"] not in ("bin", "plant"):
                draft.places[name] = {"at": stand, "yaw": (turn + 90) % 360}
            return
    raise NoHouse(f"no room for the {name}")


def _spots(draft: Draft) -> None:
    """Places that are no furniture: both ends of the corridor, an exit, the middle of each room."""
    x0, _, x1, _ = draft.rooms[CORRIDOR]
    draft.places["entrance"] = {"at": (round(x0 + 0.8, 3), 0.0), "yaw": 180}
    draft.places["taxi"] = {"at": (round(x1 - 0.8, 3), 0.0), "yaw": 0}
    draft.places["exit"] = {"at": free_point(draft, "living room", wall=0.7), "yaw": 90}
    draft.places[CORRIDOR] = {"at": (round((x0 + x1) / 2, 3), 0.0), "yaw": 0}
    for room in FURNITURE:
        draft.places[room] = {"at": free_point(draft, room, middle=True), "yaw": 0}


def free_point(
    draft: Draft, room: str, *, wall: float = 0.5, furniture: float = 0.45, stands: float = 0.5, people: float = 0.9,
    middle: bool = False,
) -> Point:  # fmt: skip
    """A point of a room's floor, so far from everything. Raises :class:`NoHouse`."""
    x0, y0, x1, y1 = draft.rooms[room]
    doors = [door.at for door in draft.doors.values()]
    for attempt in range(_TRIES):
        if middle:
            spread = attempt / _TRIES
            x = draft.uniform((x0 + x1) / 2 - spread, (x0 + x1) / 2 + spread)
            y = draft.uniform((y0 + y1) / 2 - spread, (y0 + y1) / 2 + spread)
        else:
            x, y = draft.uniform(x0 + wall, x1 - wall), draft.uniform(y0 + wall, y1 - wall)
        if (
            all(_away((x, y), area) > furniture for area in draft.areas())
            and all(math.dist((x, y), door) > 0.85 for door in doors)
            and all(math.dist((x, y), stand) > stands for stand in draft.stands())
            and all(math.dist((x, y), body) > people for body in draft.bodies())
            and all(
                math.dist((x, y), thing["at"]) > 0.4 for thing in draft.objects.values() if "stands_on" not in thing
            )
        ):
            return x, y
    raise NoHouse(f"no free floor in the {room}")


def landmarks(draft: Draft) -> Iterator[dict[str, Any]]:
    """AprilTags on the walls, where no door is and nothing tall stands before them."""
    number = 100
    doors = [door.at for door in draft.doors.values()]
    tall = [area_of(piece) for piece in draft.furniture.values() if piece["kind"] in TALL]
    for room, (x0, y0, x1, y1) in draft.rooms.items():
        along = (0.1, 0.3, 0.5, 0.7, 0.9) if room == CORRIDOR else (0.2, 0.5, 0.8)
        across = (0.5,) if room == CORRIDOR else along
        faces = [
            ((x0 + part * (x1 - x0), y), facing)
            for part in along
            for y, facing in ((y0 + 0.055, 90), (y1 - 0.055, 270))
        ]
        faces += [
            ((x, y0 + part * (y1 - y0)), facing)
            for part in across
            for x, facing in ((x0 + 0.055, 0), (x1 - 0.055, 180))
        ]
        for at, facing in faces:
            if all(math.dist(at, door) > 0.75 for door in doors) and all(_away(at, area) > 0.25 for area in tall):
                rounded = (round(at[0], 3), round(at[1], 3))
                yield {"id": number, "at": rounded, "z": 0.36, "facing": facing, "size": 0.24}
                number += 1


def with_aliases(parts: Mapping[str, Mapping[str, Any]], more: Mapping[str, Iterable[str]]) -> dict[str, Any]:
    """With their Chinese names, and others."""
    return {
        name: {**part, "aliases": (*([CHINESE[name]] if name in CHINESE else []), *more.get(name, ()))}
        for name, part in parts.items()
    }


def _apart(a: Area, b: Area) -> float:
    """Floor between two rectangles, m; 0 where they touch."""
    dx = max(a[0] - b[2], b[0] - a[2], 0.0)
    dy = max(a[1] - b[3], b[1] - a[3], 0.0)
    return math.hypot(dx, dy)
