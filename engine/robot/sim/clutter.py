"""Scenes made up from a seed: one or two rooms with low tables, a bin, and small things lying about.

``clutter-7`` is the same scene today and tomorrow. Everything that lies about can be reached: on the floor it keeps its
distance from walls, furniture and other things, on a table it stands near an edge with free floor before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point

WALL_DISTANCE: Final = 0.32
"""Of things on the floor from walls and furniture, m."""
APART: Final = 0.3
"""Of things on the floor from one another, m."""
APART_ON_TABLE: Final = 0.15
"""Of things on one table from one another, m."""
EDGE: Final = (0.045, 0.08)
"""Of things on a table from its edge, m."""
FREE: Final = 0.75
"""Floor kept free around furniture that does not stand at the same wall, m."""

_TABLES = ("low table", "side table", "bench")
_COLOURS = ("red", "green", "blue", "yellow", "orange", "purple", "white")
_SIZES: dict[str, tuple[float, float]] = {
    "box": (0.03, 0.05), "cup": (0.07, 0.084), "bottle": (0.13, 0.16), "ball": (0.04, 0.06),
}  # fmt: skip
_MASSES = {"box": 0.05, "cup": 0.08, "bottle": 0.12, "ball": 0.03}  # kg
_WOODS = ("oak", "walnut", "birch")
_FLOORS = ("birch", "oak", "#cdb08a", "#dfe3e2")
_TRIES = 400


@dataclass
class _Room:
    name: str
    x: tuple[float, float]
    y: tuple[float, float]


@dataclass
class _Draft:
    """What has been placed so far."""

    rng: np.random.Generator
    rooms: list[_Room]
    door: Point | None
    start: Point = (0.0, 0.0)
    furniture: dict[str, dict[str, Any]] = field(default_factory=dict)
    objects: dict[str, dict[str, Any]] = field(default_factory=dict)
    places: dict[str, dict[str, Any]] = field(default_factory=dict)
    taken: list[tuple[float, float, float, float]] = field(default_factory=list)  # areas of furniture

    def clear(self, area: tuple[float, float, float, float], gap: float) -> bool:
        """Whether furniture at ``area`` leaves the door, the start and other furniture free."""
        free = [self.start, *([self.door] if self.door else [])]
        if any(_away(point, area) < 0.9 for point in free):
            return False
        return all(
            area[2] + gap <= other[0]
            or other[2] + gap <= area[0]
            or area[3] + gap <= other[1]
            or other[3] + gap <= area[1]
            for other in self.taken
        )  # fmt: skip


def clutter(seed: int, *, things: int | None = None, rooms: int | None = None) -> Scene:
    """The scene of a seed. ``things`` and ``rooms`` (1 or 2) are up to the seed where they are not given."""
    rng = np.random.default_rng(seed)
    draft = _rooms(rng, rooms or int(rng.integers(1, 3)))
    _furnish(draft)
    count = things or int(rng.integers(5, 9))
    kinds = [str(kind) for kind in rng.choice(list(_SIZES), size=count)]
    names = _names(rng, kinds)
    for index, (name, kind) in enumerate(zip(names, kinds, strict=True)):
        thing = _thing(rng, name, kind)
        if not (index % 2 and _on_a_table(draft, name, thing)):
            _on_the_floor(draft, name, thing)
    edges = [(room.x, room.y) for room in draft.rooms]
    bounds = {"x": [min(x[0] for x, _ in edges), max(x[1] for x, _ in edges)], "y": list(edges[0][1])}
    return Scene.model_validate(
        {
            "name": f"clutter-{seed}",
            "bounds": bounds,
            "start": {"x": draft.start[0], "y": draft.start[1], "yaw": float(rng.choice([0, 90, 180, 270]))},
            "rooms": {
                room.name: {"x": room.x, "y": room.y, "colour": _FLOORS[(seed + i) % len(_FLOORS)]}
                for i, room in enumerate(draft.rooms)
            },
            "doors": [{"between": ["room", "chamber"], "at": draft.door[1], "width": 1.1}] if draft.door else [],
            "furniture": draft.furniture,
            "objects": draft.objects,
            "landmarks": list(_landmarks(draft)),
            "places": draft.places,
        }
    )


def _rooms(rng: np.random.Generator, count: int) -> _Draft:
    """Side by side along x; the start is in the first."""
    depth = _round(rng.uniform(3.6, 4.6))
    width = _round(rng.uniform(3.8, 4.8))
    rooms = [_Room("room", (0.0, width), (0.0, depth))]
    door = None
    if count > 1:
        rooms.append(_Room("chamber", (width, _round(width + rng.uniform(3.4, 4.2))), (0.0, depth)))
        door = (width, _round(rng.uniform(1.2, depth - 1.2)))
    draft = _Draft(rng, rooms, door, start=(width / 2, depth / 2))
    for room in rooms:
        at = [sum(room.x) / 2, sum(room.y) / 2]
        draft.places[room.name] = {"at": at, "yaw": 0}
    return draft


def _furnish(draft: _Draft) -> None:
    """A bin, a table or two a room, and something that is only in the way."""
    rng = draft.rng
    _at_a_wall(draft, draft.rooms[0], "bin", {"kind": "bin", "size": (0.3, 0.3, 0.2), "colour": "slate"})
    tables = iter(_TABLES)
    for room in draft.rooms:
        for _ in range(2 if len(draft.rooms) == 1 else 1):
            size = (_round(rng.uniform(0.5, 0.9)), _round(rng.uniform(0.4, 0.55)), _round(rng.uniform(0.06, 0.14)))
            size = (size[0], size[1], max(size[2], 0.11))  # the lidar must see its edge
            _at_a_wall(
                draft, room, next(tables), {"kind": "low_table", "size": size, "colour": str(rng.choice(_WOODS))}
            )
    if rng.random() < 0.7:
        carton = {"kind": "carton", "size": (0.4, 0.35, 0.3), "colour": "cardboard"}
        _at_a_wall(draft, draft.rooms[-1], "carton", carton)


def _at_a_wall(draft: _Draft, room: _Room, name: str, piece: dict[str, Any]) -> None:
    """Put a piece with its back to a wall, and a place before it."""
    rng, (length, depth, _) = draft.rng, piece["size"]
    for _ in range(_TRIES):
        turn = int(rng.choice([0, 90, 180, 270]))
        extent = (length, depth) if turn % 180 == 0 else (depth, length)
        x0, x1, y0, y1 = (
            room.x[0] + 0.08 + extent[0] / 2,
            room.x[1] - 0.08 - extent[0] / 2,
            room.y[0] + 0.08 + extent[1] / 2,
            room.y[1] - 0.08 - extent[1] / 2,
        )
        along_x, along_y = _round(rng.uniform(x0, x1)), _round(rng.uniform(y0, y1))
        x, y = {0: (along_x, y1), 90: (x0, along_y), 180: (along_x, y0), 270: (x1, along_y)}[turn]
        area = (x - extent[0] / 2, y - extent[1] / 2, x + extent[0] / 2, y + extent[1] / 2)
        if not draft.clear(area, FREE):
            continue
        draft.taken.append(area)
        draft.furniture[name] = {**piece, "at": (x, y), "turn": turn}
        front = _front(turn)
        stand = (x + front[0] * (depth / 2 + 0.4), y + front[1] * (depth / 2 + 0.4))
        draft.places[name] = {"at": stand, "yaw": (turn + 90) % 360}
        return


def _front(turn: int) -> tuple[int, int]:
    """Where the front of a piece looks: along −y at turn 0."""
    return {0: (0, -1), 90: (1, 0), 180: (0, 1), 270: (-1, 0)}[turn]


def _names(rng: np.random.Generator, kinds: list[str]) -> list[str]:
    """A colour for each thing, so that no two things are called alike."""
    names: list[str] = []
    for kind in kinds:
        free = [f"{colour} {kind}" for colour in _COLOURS if f"{colour} {kind}" not in names]
        names.append(str(rng.choice(free)))
    return names


def _thing(rng: np.random.Generator, name: str, kind: str) -> dict[str, Any]:
    size = round(float(rng.uniform(*_SIZES[kind])), 3)
    turn = round(float(rng.uniform(0, 90)))
    return {"kind": kind, "colour": name.split()[0], "size": size, "mass": _MASSES[kind], "turn": turn}


def _on_a_table(draft: _Draft, name: str, thing: dict[str, Any]) -> bool:
    """Near the front edge of some table, if there is room."""
    rng = draft.rng
    tables = [n for n, piece in draft.furniture.items() if piece["kind"] == "low_table"]
    for _ in range(_TRIES):
        table = str(rng.choice(tables))
        piece = draft.furniture[table]
        length, depth, _ = piece["size"]
        front = _front(piece["turn"])
        along = (-front[1], front[0])
        out = depth / 2 - float(rng.uniform(*EDGE))
        aside = float(rng.uniform(-1, 1)) * (length / 2 - 0.09)
        x = piece["at"][0] + front[0] * out + along[0] * aside
        y = piece["at"][1] + front[1] * out + along[1] * aside
        others = [o["at"] for o in draft.objects.values() if o.get("stands_on") == table]
        if all(math.dist((x, y), other) > APART_ON_TABLE for other in others):
            draft.objects[name] = {**thing, "at": (round(x, 3), round(y, 3)), "stands_on": table}
            return True
    return False


def _on_the_floor(draft: _Draft, name: str, thing: dict[str, Any]) -> None:
    rng = draft.rng
    for _ in range(_TRIES):
        room = draft.rooms[int(rng.integers(len(draft.rooms)))]
        low, high = WALL_DISTANCE + 0.05, -WALL_DISTANCE - 0.05
        x = round(float(rng.uniform(room.x[0] + low, room.x[1] + high)), 3)
        y = round(float(rng.uniform(room.y[0] + low, room.y[1] + high)), 3)
        others = [o["at"] for o in draft.objects.values() if "stands_on" not in o]
        # Standing before a piece of furniture the robot must not push what lies there.
        places = [place["at"] for place in draft.places.values()]
        if (
            all(_away((x, y), area) > WALL_DISTANCE for area in draft.taken)
            and all(math.dist((x, y), other) > APART for other in others)
            and all(math.dist((x, y), place) > 0.4 for place in [*places, draft.start])
            and (draft.door is None or math.dist((x, y), draft.door) > 0.7)
        ):
            draft.objects[name] = {**thing, "at": (x, y)}
            return


def _landmarks(draft: _Draft) -> Iterator[dict[str, Any]]:
    """Two on every wall, where nothing tall stands before them and no door is."""
    number = 100
    for room in draft.rooms:
        (x0, x1), (y0, y1) = room.x, room.y
        for part in (0.28, 0.72):
            x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            for at, facing in (
                ((x, y0 + 0.055), 90), ((x, y1 - 0.055), 270), ((x0 + 0.055, y), 0), ((x1 - 0.055, y), 180),
            ):  # fmt: skip
                if draft.door is not None and math.dist(at, draft.door) < 0.8:
                    continue
                at = (round(at[0], 3), round(at[1], 3))
                yield {"id": number, "at": at, "z": 0.4, "facing": facing, "size": 0.24}
                number += 1


def _away(point: Point, area: tuple[float, float, float, float]) -> float:
    """From a rectangle, m; 0 inside."""
    dx = max(area[0] - point[0], 0.0, point[0] - area[2])
    dy = max(area[1] - point[1], 0.0, point[1] - area[3])
    return math.hypot(dx, dy)


def _round(value: float) -> float:
    return round(float(value), 2)
