"""Where people of a scene can walk and what they see past: its walls, closed doors and furniture, as rectangles."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.robot.sim.floor import door_leaf, wall_pieces
from engine.robot.sim.furniture import FLAT
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point


class FreeFloor:
    """Of one scene, as it stands now: not what the map has."""

    def __init__(self, scene: Scene) -> None:
        leaves = tuple(door_leaf(scene, door) for door in scene.doors if door.closed)
        walls = [(wall.x_min, wall.y_min, wall.x_max, wall.y_max) for wall in (*wall_pieces(scene), *leaves)]
        pieces = [piece.area for piece in scene.furniture.values() if piece.kind not in FLAT]
        self._walls = np.array(walls).reshape(-1, 4)
        self._everything = np.array([*walls, *pieces]).reshape(-1, 4)

    def can_see(self, start: Point, end: Point) -> bool:
        """Whether no wall is between."""
        return not _meets(self._walls, start, [end], 0.0)[0]

    def can_walk(self, start: Point, ends: Sequence[Point], margin: float) -> list[bool]:
        """Whether the straight way to each of these keeps so far from everything, m; where somebody is already nearer
        than that, it may lead away."""
        found: list[bool] = (~_meets(self._everything, start, ends, margin)).tolist()
        return found


def _meets(areas: NDArray[np.float64], start: Point, ends: Sequence[Point], margin: float) -> NDArray[np.bool_]:
    """Which lines meet one of these rectangles (x_min, y_min, x_max, y_max), grown by a margin, other than one that
    they begin in."""
    here, ways = np.array(start), np.subtract(np.reshape(ends, (-1, 1, 2)), start)  # by line, rectangle and axis
    low, high = areas[:, :2] - margin, areas[:, 2:] + margin
    ways = np.where(np.abs(ways) < 1e-9, 1e-9, ways)
    one, other = (low - here) / ways, (high - here) / ways  # how far along the line it meets each side, 0…1
    enters, leaves = np.minimum(one, other).max(axis=2), np.maximum(one, other).min(axis=2)
    begins_in = ((low < here) & (here < high)).all(axis=1)
    met: NDArray[np.bool_] = ((enters <= leaves) & (leaves >= 0) & (enters <= 1) & ~begins_in).any(axis=1)
    return met


def ahead(here: Point, yaw: float, metres: float) -> Point:
    """The point so far away in a direction, rad, map frame."""
    return here[0] + metres * math.cos(yaw), here[1] + metres * math.sin(yaw)


def direction(start: Point, end: Point) -> float:
    """From one point to another, rad, map frame."""
    return math.atan2(end[1] - start[1], end[0] - start[0])
