"""Where the rooms, pieces of furniture and places of a scene are to whoever walks there by their names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from engine.robot.geometry import Pose
from engine.robot.occupancy import Unreachable, distances, route
from engine.robot.robot import Footprint
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point

_BODY: Final = Footprint(0.3, 0.3)
_ROOM: Final = 0.35
"""m from walls and furniture to where somebody stands at the end."""
_APART: Final = 1.0
"""m from others."""


class Destinations:
    """Of one scene; its map is made when it is first asked for."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        named = [(name, room.aliases, _middle(room.x, room.y)) for name, room in scene.rooms.items()]
        named += [(name, piece.aliases, piece.at) for name, piece in scene.furniture.items()]
        named += [(name, place.aliases, place.at) for name, place in scene.places.items()]
        self._at = {word.casefold(): at for name, aliases, at in named for word in (name, *aliases)}

    def way(self, start: Point, name: str, others: Sequence[Point] = ()) -> tuple[Point, ...]:
        """The corners of the way there, the last where there is room to stand nearest to its middle, beside others;
        empty where nothing is called so, or no way leads there."""
        middle = self._at.get(name.casefold().strip())
        if middle is None:
            return ()
        floor = floor_map(self._scene)
        room = next((area for area in self._scene.rooms.values() if area.contains(*middle)), None)
        rows, columns = np.nonzero(distances(floor.occupied, floor.resolution, _ROOM) >= _ROOM)
        xs, ys = (floor.origin[axis] + (index + 0.5) * floor.resolution for axis, index in enumerate((columns, rows)))
        inside = np.ones(len(xs), dtype=bool)
        if room is not None:
            inside = (xs > room.x[0]) & (xs < room.x[1]) & (ys > room.y[0]) & (ys < room.y[1])
        for x, y in others:
            inside &= np.hypot(xs - x, ys - y) > _APART
        if not inside.any():
            return ()
        xs, ys = xs[inside], ys[inside]
        nearest = int(np.hypot(xs - middle[0], ys - middle[1]).argmin())
        goal = float(xs[nearest]), float(ys[nearest])
        found = route(floor, Pose(*start, 0.0), Pose(*goal, math.atan2(goal[1] - start[1], goal[0] - start[0])), _BODY)
        return () if isinstance(found, Unreachable) else found.points[1:]


def _middle(x: tuple[float, float], y: tuple[float, float]) -> Point:
    return (x[0] + x[1]) / 2, (y[0] + y[1]) / 2
