"""Walls and the floor map, worked out from a scene without starting the simulation.

A wall stands on every edge of a room, once where two rooms share it, and is cut where a door is. The floor map marks
what stands on the floor and how high it is, as a robot that had mapped the flat with a depth camera would know it: legs
of a table count as the whole table, furniture is where it was then, loose objects and people are not in it, and all
doors are open.
"""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Literal

import numpy as np

from engine.errors import SceneError
from engine.robot.floor_map import Doorway, FloorMap, Furniture, Landmark, Room, Wall
from engine.robot.geometry import wrap
from engine.robot.sim.furniture import FLAT, parts_of
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Door, Span

RESOLUTION = 0.05
"""m per cell of the floor map."""

_Line = tuple[Literal["x", "y"], float]
"""``("x", 1.8)`` is the line x = 1.8."""


def wall_pieces(scene: Scene) -> tuple[Wall, ...]:
    """All walls with the doors cut out. Raises :class:`SceneError` for a door that no wall has."""
    lines: dict[_Line, list[Span]] = defaultdict(list)
    for room in scene.rooms.values():
        for x in room.x:
            lines["x", x].append(room.y)
        for y in room.y:
            lines["y", y].append(room.x)
    gaps: dict[_Line, list[Span]] = defaultdict(list)
    for door in scene.doors:
        line, gap = _gap(scene, door)
        gaps[line].append(gap)
    half = scene.walls.thickness / 2
    pieces = []
    for (axis, at), spans in lines.items():
        crossing = {c: _union(s) for (a, c), s in lines.items() if a != axis}
        for low, high in _without(_union(spans), sorted(gaps[axis, at]), half, axis, at, crossing):
            if axis == "x":
                pieces.append(Wall(at - half, low, at + half, high))
            else:
                pieces.append(Wall(low, at - half, high, at + half))
    return tuple(pieces)


def floor_map(scene: Scene) -> FloorMap:
    """The map of what is fixed: walls and furniture."""
    half = scene.walls.thickness / 2
    origin = (scene.bounds.x[0] - half, scene.bounds.y[0] - half)
    columns = math.ceil((scene.bounds.x[1] + half - origin[0]) / RESOLUTION - 1e-6)
    rows = math.ceil((scene.bounds.y[1] + half - origin[1]) / RESOLUTION - 1e-6)
    occupied = np.zeros((rows, columns), dtype=np.bool_)
    tops = np.zeros((rows, columns), dtype=np.float32)

    def cells(x_min: float, y_min: float, x_max: float, y_max: float) -> tuple[slice, slice]:
        """Every cell that the rectangle overlaps by more than a rounding error."""
        c0, r0 = (math.floor((v - o) / RESOLUTION + 1e-6) for v, o in zip((x_min, y_min), origin, strict=True))
        c1, r1 = (math.ceil((v - o) / RESOLUTION - 1e-6) for v, o in zip((x_max, y_max), origin, strict=True))
        return slice(max(0, r0), max(0, r1)), slice(max(0, c0), max(0, c1))

    furniture = tuple(
        Furniture(name, *piece.mapped_area, height=piece.size[2], kind=piece.kind)
        for name, piece in scene.furniture.items()
        if piece.mapped and piece.kind not in FLAT
    )
    walls = wall_pieces(scene)
    for wall in walls:
        here = cells(wall.x_min, wall.y_min, wall.x_max, wall.y_max)
        occupied[here], tops[here] = True, np.inf
    for thing in furniture:
        occupied[cells(thing.x_min, thing.y_min, thing.x_max, thing.y_max)] = True
        for *area, top in parts_of(scene.furniture[thing.name]):
            here = cells(*area)
            tops[here] = np.maximum(tops[here], top)
    occupied.setflags(write=False)
    tops.setflags(write=False)
    rooms = tuple(Room(name, r.x[0], r.y[0], r.x[1], r.y[1]) for name, r in scene.rooms.items())
    doors = tuple(_doorway(scene, door) for door in scene.doors)
    tags = tuple(Landmark(mark.id, *mark.at, mark.z, wrap(mark.yaw), mark.size) for mark in scene.landmarks)
    return FloorMap(RESOLUTION, origin, occupied, rooms, furniture, doors, tags, walls, tops)


def door_leaf(scene: Scene, door: Door) -> Wall:
    """What fills the gap when the door is closed."""
    (axis, at), (low, high) = _gap(scene, door)
    half = scene.walls.thickness / 4
    if axis == "x":
        return Wall(at - half, low, at + half, high)
    return Wall(low, at - half, high, at + half)


def _doorway(scene: Scene, door: Door) -> Doorway:
    (axis, at), _ = _gap(scene, door)
    x, y = (at, door.at) if axis == "x" else (door.at, at)
    return Doorway(door.between, x, y, door.width)


def _gap(scene: Scene, door: Door) -> tuple[_Line, Span]:
    """On which line the door is, and from where to where."""
    first, second = (scene.rooms[name] for name in door.between)
    low, high = door.at - door.width / 2, door.at + door.width / 2
    candidates: tuple[tuple[Literal["x", "y"], tuple[Span, Span], tuple[Span, Span]], ...] = (
        ("x", (first.x, second.x), (first.y, second.y)),
        ("y", (first.y, second.y), (first.x, second.x)),
    )
    for axis, across, along in candidates:
        shared = set(across[0]) & set(across[1])
        start, end = max(along[0][0], along[1][0]), min(along[0][1], along[1][1])
        if shared and start <= low and high <= end:
            return (axis, shared.pop()), (low, high)
    raise SceneError(
        f"Scene {scene.name}: the door between {door.between[0]} and {door.between[1]} at {door.at:g} m,"
        f" {door.width:g} m wide, is not in a wall that they share."
    )


def _union(spans: list[Span]) -> list[Span]:
    merged: list[Span] = []
    for low, high in sorted(spans):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _joint(axis: str, at: float, end: float, half: float, crossing: dict[float, list[Span]]) -> float:
    """How far a wall reaches beyond the end of its line, so that walls meet without overlapping, m.

    Walls along x end at the face of the wall they meet. Walls along y do so only at a T; at a corner they close it.
    """
    if axis == "y":
        return -half
    passes = any(low < at < high for low, high in crossing.get(end, ()))
    return -half if passes else half


def _without(
    spans: list[Span], gaps: list[Span], half: float, axis: str, at: float, crossing: dict[float, list[Span]]
) -> list[Span]:
    """The stretches between the gaps, with their outer ends joined to the crossing walls."""
    pieces = []
    for low, high in spans:
        start = low - _joint(axis, at, low, half, crossing)
        for gap_start, gap_end in gaps:
            if low <= gap_start and gap_end <= high:
                pieces.append((start, gap_start))
                start = gap_end
        pieces.append((start, high + _joint(axis, at, high, half, crossing)))
    return [piece for piece in pieces if piece[1] > piece[0]]
