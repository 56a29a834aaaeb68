"""Ways over the floor: from the map of what stands there to a path of straight stretches, or the reason for none.

The robot travels with a clearance all around (its circle plus a margin) and prefers more. It may start or end nearer
to things than that, as at a table, where only the hull in its real orientation must fit. A* runs on the grid; then
every detour of the grid is pulled straight as long as that costs no clearance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.robot.clearance import gaps
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from engine.robot.robot import Footprint

Point = tuple[float, float]
"""Map frame, m."""
Distances = NDArray[np.float64]

COMFORT = 0.2
"""m of clearance beyond the necessary that the robot prefers to have."""

_HULL_MARGIN = 0.02  # m around the hull that start and goal must have
_NEAR = 0.5  # m around start and goal where less clearance is allowed
_TIGHT_COST = 30.0  # of a cell with less than the clearance, where that is allowed
_COMFORT_COST = 4.0  # more, of a cell with just the clearance


@dataclass(frozen=True, slots=True)
class Route:
    """A way from start to goal; ``points`` begins at the start and ends at the goal."""

    points: tuple[Point, ...]

    @property
    def length(self) -> float:
        """m."""
        return sum(math.dist(a, b) for a, b in zip(self.points, self.points[1:], strict=False))


@dataclass(frozen=True, slots=True)
class Unreachable:
    """Why there is no way, as a word for programs and a sentence for people."""

    reason: Literal["outside_map", "start_blocked", "goal_blocked", "no_way"]
    message: str


def inflate(floor: FloorMap, radius: float) -> NDArray[np.bool_]:
    """Cells whose centre is nearer than ``radius`` m to an occupied cell; same shape as ``floor.occupied``."""
    blocked: NDArray[np.bool_] = distances(floor.occupied, floor.resolution, radius) < radius
    return blocked


def distances(occupied: NDArray[np.bool_], resolution: float, limit: float) -> Distances:
    """Distance of every cell's centre from the nearest occupied cell's edge, m, exact up to ``limit``.

    Two passes: along columns by counting, then across rows by trying every offset within the limit.
    """
    rows, _ = occupied.shape
    far = limit / resolution + 2
    along = np.where(occupied, 0.0, far)
    for row in range(1, rows):
        np.minimum(along[row], along[row - 1] + 1, out=along[row])
    for row in range(rows - 2, -1, -1):
        np.minimum(along[row], along[row + 1] + 1, out=along[row])
    squared = along**2
    best = squared.copy()
    for offset in range(1, math.ceil(far)):
        np.minimum(best[:, offset:], squared[:, :-offset] + offset**2, out=best[:, offset:])
        np.minimum(best[:, :-offset], squared[:, offset:] + offset**2, out=best[:, :-offset])
    cells: Distances = np.maximum(np.sqrt(best) - 0.5, 0.0) * resolution
    return cells


def route(
    floor: FloorMap,
    start: Pose,
    goal: Pose,
    hull: Footprint,
    *,
    margin: float = 0.06,
    extra: NDArray[np.float64] | None = None,
) -> Route | Unreachable:
    """The way from ``start`` to ``goal``. ``extra`` are obstacles that are not on the map, as points in the map frame,
    shape (n, 2): lidar hits, for instance."""
    grid = _Grid(floor)
    for pose, what in ((start, "robot"), (goal, "goal")):
        if not grid.holds((pose.x, pose.y)):
            return Unreachable("outside_map", f"The {what} at ({pose.x:.2f}, {pose.y:.2f}) is outside the map.")
    if (point := _hull_collision(grid, extra, goal, hull)) is not None:
        return Unreachable("goal_blocked", f"There is no room at the goal: {_what_is_at(floor, point)} is there.")
    occupied = _with_extra(grid, extra, start, hull)
    clearance = hull.radius + margin
    free = distances(occupied, floor.resolution, clearance + COMFORT)
    weights = _weights(grid, free, clearance, hull, ((start.x, start.y), (goal.x, goal.y)))
    first, last = grid.cell((start.x, start.y)), grid.cell((goal.x, goal.y))
    weights[first] = weights[last] = 1.0
    import pyastar2d  # loads a C library, only where a robot navigates

    cells = pyastar2d.astar_path(weights, first, last, allow_diagonal=True)
    if cells is None:
        return _no_way(floor, free, clearance, start, goal)
    points = [(start.x, start.y), *(grid.centre(cell) for cell in cells[1:-1]), (goal.x, goal.y)]
    return Route(tuple(_straighten(grid, free, points, clearance)))


class _Grid:
    """Between map coordinates and cells."""

    def __init__(self, floor: FloorMap) -> None:
        self.occupied, self.resolution, self._origin = floor.occupied, floor.resolution, floor.origin

    def cell(self, point: Point) -> tuple[int, int]:
        """Row and column."""
        x, y = point
        return math.floor((y - self._origin[1]) / self.resolution), math.floor((x - self._origin[0]) / self.resolution)

    def centre(self, cell: NDArray[np.int32] | tuple[int, int]) -> Point:
        row, column = int(cell[0]), int(cell[1])
        return self._origin[0] + (column + 0.5) * self.resolution, self._origin[1] + (row + 0.5) * self.resolution

    def holds(self, point: Point) -> bool:
        row, column = self.cell(point)
        rows, columns = self.occupied.shape
        return bool(0 <= row < rows and 0 <= column < columns)

    def cells(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of points, shape (n, 2), those outside left out."""
        columns, rows = np.floor((points - np.array(self._origin)) / self.resolution).astype(np.int64).T
        inside = (rows >= 0) & (rows < self.occupied.shape[0]) & (columns >= 0) & (columns < self.occupied.shape[1])
        return rows[inside], columns[inside]

    def distance_from(self, point: Point) -> Distances:
        """Of every cell's centre, m."""
        rows, columns = self.occupied.shape
        y = self._origin[1] + (np.arange(rows) + 0.5) * self.resolution - point[1]
        x = self._origin[0] + (np.arange(columns) + 0.5) * self.resolution - point[0]
        grid: Distances = np.hypot(x[None, :], y[:, None])
        return grid


def _with_extra(grid: _Grid, extra: NDArray[np.float64] | None, start: Pose, hull: Footprint) -> NDArray[np.bool_]:
    """The map with the extra obstacles, except where the robot itself stands."""
    if extra is None or len(extra) == 0:
        return grid.occupied
    occupied = grid.occupied.copy()
    apart = np.hypot(extra[:, 0] - start.x, extra[:, 1] - start.y) > hull.width / 2 + grid.resolution
    occupied[grid.cells(extra[apart])] = True
    return occupied


def _hull_collision(grid: _Grid, extra: NDArray[np.float64] | None, pose: Pose, hull: Footprint) -> Point | None:
    """An occupied point under the hull at ``pose``, or an extra obstacle there, if there is one."""
    nx, ny = (max(2, math.ceil(size / grid.resolution * 2)) for size in (hull.length, hull.width))
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, nx) * (hull.length + 2 * _HULL_MARGIN),
        np.linspace(-0.5, 0.5, ny) * (hull.width + 2 * _HULL_MARGIN),
    )
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    under = np.column_stack((pose.x + (c * x - s * y).ravel(), pose.y + (s * x + c * y).ravel()))
    rows, columns = grid.cells(under)
    hits = np.flatnonzero(grid.occupied[rows, columns])
    if len(hits):
        return grid.centre((int(rows[hits[0]]), int(columns[hits[0]])))
    if extra is None or not len(extra):
        return None
    dx, dy = extra[:, 0] - pose.x, extra[:, 1] - pose.y  # known better than to a cell
    near = gaps(np.column_stack((c * dx + s * dy, c * dy - s * dx)), hull)
    x, y = extra[int(near.argmin())].tolist()
    return (x, y) if near.min() < _HULL_MARGIN else None


def _weights(
    grid: _Grid, free: Distances, clearance: float, hull: Footprint, ends: tuple[Point, Point]
) -> NDArray[np.float32]:
    """Cost of every cell; inf where the robot must not go."""
    comfort = np.clip((clearance + COMFORT - free) / COMFORT, 0.0, 1.0)
    weights = (1.0 + _COMFORT_COST * comfort**2).astype(np.float32)
    tight = free < clearance
    weights[tight] = np.inf
    for end in ends:
        allowed = tight & (free >= hull.width / 2) & (grid.distance_from(end) < _NEAR)
        weights[allowed] = _TIGHT_COST
    return weights


def _straighten(grid: _Grid, free: Distances, points: list[Point], clearance: float) -> list[Point]:
    """Leave out every point that can be left out without coming nearer to anything than comfort or the path itself."""
    samples = np.array([free[grid.cell(point)] for point in points])
    kept, at = [points[0]], 0
    while at < len(points) - 1:
        low, high = at + 1, len(points) - 1
        while low < high:  # the furthest point in sight, by halving: sight rarely comes back once it is lost
            middle = (low + high + 1) // 2
            enough = min(clearance + COMFORT * 0.75, float(samples[at : middle + 1].min()))
            if _in_sight(grid, free, points[at], points[middle], enough):
                low = middle
            else:
                high = middle - 1
        at = low
        kept.append(points[at])
    return kept


def _in_sight(grid: _Grid, free: Distances, a: Point, b: Point, enough: float) -> bool:
    count = max(2, math.ceil(math.dist(a, b) / grid.resolution * 2))
    rows, columns = grid.cells(np.linspace(a, b, count))
    return bool((free[rows, columns] >= enough - 1e-9).all())


def _no_way(floor: FloorMap, free: Distances, clearance: float, start: Pose, goal: Pose) -> Unreachable:
    """Say which end is the trouble."""
    grid = _Grid(floor)
    for pose, reason, what in ((start, "start_blocked", "robot"), (goal, "goal_blocked", "goal")):
        around = grid.distance_from((pose.x, pose.y)) < _NEAR
        if not (free[around] >= clearance).any():
            beside = _what_is_near(floor, (pose.x, pose.y))
            message = f"The {what} is hemmed in by {beside}."
            return Unreachable("start_blocked" if reason == "start_blocked" else "goal_blocked", message)
    room = next((r.name for r in floor.rooms if r.x_min <= goal.x <= r.x_max and r.y_min <= goal.y <= r.y_max), None)
    where = f" in the {room}" if room else ""
    return Unreachable("no_way", f"No way is wide enough to the goal{where}.")


def _what_is_at(floor: FloorMap, point: Point) -> str:
    for thing in floor.furniture:
        slack = floor.resolution
        if (
            thing.x_min - slack <= point[0] <= thing.x_max + slack
            and thing.y_min - slack <= point[1] <= thing.y_max + slack
        ):
            return f"the {thing.name}"
    row, column = _Grid(floor).cell(point)
    return "a wall" if floor.occupied[row, column] else "an obstacle"


def _what_is_near(floor: FloorMap, point: Point) -> str:
    def distance(x_min: float, y_min: float, x_max: float, y_max: float) -> float:
        return math.hypot(max(x_min - point[0], 0, point[0] - x_max), max(y_min - point[1], 0, point[1] - y_max))

    near = [(distance(f.x_min, f.y_min, f.x_max, f.y_max), f.name) for f in floor.furniture]
    gap, name = min(near, default=(math.inf, ""))
    return f"the {name}" if gap < _NEAR else "walls or obstacles"
