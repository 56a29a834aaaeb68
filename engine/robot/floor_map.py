"""What a robot knows of the house before it has looked: the map drawn when the house was mapped.

Walls and furniture as cells that are occupied, then the walls as they were measured, and by name: rooms, furniture,
doorways, and the tags that are fixed to the house. Loose things are not on it. Everything is in the map frame, m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class FloorMap:
    """What is fixed on the floor: walls and furniture, as the map drawn when the house was mapped."""

    resolution: float  # m per cell
    origin: tuple[float, float]  # map coordinates of the outer corner of cell [0, 0], m
    occupied: NDArray[np.bool_]  # shape (rows, columns); row is y, column is x
    rooms: tuple[Room, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    doors: tuple[Doorway, ...] = ()
    tags: tuple[Landmark, ...] = ()
    walls: tuple[Wall, ...] = ()
    tops: NDArray[np.float32] | None = None
    """How high what stands in each cell is, m: 0 on free floor, inf where nobody knows and for walls. Shape as
    ``occupied``. None: the map tells no heights, as one that was drawn with a lidar."""

    def holds(self, x: float, y: float) -> bool:
        """Whether the point lies on the map, border included."""
        (rows, columns), (x_min, y_min) = self.occupied.shape, self.origin
        return bool(0 <= x - x_min <= columns * self.resolution and 0 <= y - y_min <= rows * self.resolution)


@dataclass(frozen=True, slots=True)
class Room:
    """A named rectangle of floor, map frame, m."""

    name: str
    x_min: float
    y_min: float
    x_max: float
    y_max: float

    def holds(self, x: float, y: float) -> bool:
        """Whether the point lies in the room, border included."""
        return self.x_min <= x <= self.x_max and self.y_min <= y <= self.y_max


@dataclass(frozen=True, slots=True)
class Wall:
    """A stretch of wall, without the doors in it, as a rectangle on the floor, map frame, m."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float


@dataclass(frozen=True, slots=True)
class Furniture:
    """A named piece of furniture as a rectangle on the floor, map frame, m."""

    name: str
    x_min: float
    y_min: float
    x_max: float
    y_max: float
    height: float = 0.0  # of its top; 0 where that is not known
    kind: str = ""  # bin, low_table, …

    def holds(self, x: float, y: float, *, margin: float = 0.0) -> bool:
        """Whether the point lies on it, at least ``margin`` m from its edges."""
        return self.x_min + margin <= x <= self.x_max - margin and self.y_min + margin <= y <= self.y_max - margin

    def away(self, x: float, y: float) -> float:
        """From its edge to a point beside it, m; 0 on it."""
        beside_x = max(self.x_min - x, 0.0, x - self.x_max)
        return math.hypot(beside_x, max(self.y_min - y, 0.0, y - self.y_max))


@dataclass(frozen=True, slots=True)
class Doorway:
    """A gap in a wall between two rooms."""

    between: tuple[str, str]
    x: float  # of its middle, map frame, m
    y: float
    width: float  # m


@dataclass(frozen=True, slots=True)
class Landmark:
    """An AprilTag of the family 36h11 that is fixed to the house, by which a robot can tell where it is."""

    id: int
    x: float  # of its middle, map frame, m
    y: float
    z: float
    yaw: float  # direction in which its face looks, map frame, rad; it hangs upright
    size: float  # edge of the black square, m
