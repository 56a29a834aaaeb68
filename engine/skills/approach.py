"""Standing where the arm reaches: from a point on the map to a place for the base, and the way there.

Around the point there are many places from which the arm, pointing straight ahead, gets there. Those where the hull
has room (between walls and furniture, what the lidar sees, and what is remembered to lie about) are ranked by the way
to them and by how comfortably the arm reaches; the best few are tried.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.memory import Thing
from engine.robot.clearance import gaps
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Point, Pose, wrap
from engine.robot.occupancy import Unreachable
from engine.skills.context import SkillContext
from engine.skills.hand import fold, from_map
from engine.skills.outcome import Result, fail, ok
from engine.skills.strewn import outline, seen_from, strewn
from engine.skills.travel import go_to, way_to

Reach = Callable[[float], float | None]
"""How uncomfortable it is to reach the point from this distance (m from the base's centre, straight ahead), in the
seconds that one would drive to avoid it; None where it is out of reach."""

MARGIN: Final = 0.08
"""m between the hull and what the obstacle stop would keep it from; it stops at 6 cm."""
LOOSE_MARGIN: Final = 0.025
"""m between the hull and small things on the floor, which only the memory knows."""
_DIRECTIONS = 24
_DISTANCES = np.arange(0.18, 0.44, 0.01)
_TRIES = 3  # places that are driven to before giving up
_ROUTED = 6  # places whose way is worked out
_AROUND = 0.8  # m around the point in which obstacles matter
_NO_TURN = 4.0  # s that it is worth to find room for turning
_SPEED, _TURN_SPEED = 0.4, 1.5  # m/s and rad/s, for estimating times


@dataclass(frozen=True, slots=True)
class Stand:
    """A place for the base."""

    pose: Pose
    cost: float  # s, without the way there


async def stand_before(
    context: SkillContext, point: Point, reach: Reach, name: str, *, radius: float = 0.0, target: Thing | None = None
) -> Result:
    """Stand so that ``point`` (map frame) is straight ahead within ``reach``. ``radius`` m around it belong to what is
    there, which may itself be an obstacle: ``target``, in the memory, is not to be kept clear of beyond that."""
    if not await fold(context):
        return fail("no_progress", "The arm does not fold, so I do not drive.")
    refused: list[Pose] = []
    trouble: Result | None = None
    for _ in range(_TRIES):
        stands = [stand for stand in places_to_stand(context, point, reach, radius, target) if _is_new(stand, refused)]
        if not stands:
            break
        best = _nearest_by_way(context, stands)
        if isinstance(best, Unreachable):
            return trouble or fail("unreachable", f"I cannot get to {name}. {best.message}")
        result = await go_to(context, best, name)
        if result.ok or _stands_well(context.pose, point, reach):
            return ok(f"I stand before {name}.")
        if result.error_code not in ("path_blocked", "unreachable", "no_progress", "door_closed"):
            return result
        trouble = result
        refused.append(best)
    if trouble is not None:
        return trouble
    return fail("out_of_reach", f"There is no place to stand from which the arm reaches {name}.")


def _stands_well(pose: Pose, point: Point, reach: Reach) -> bool:
    """Whether the arm reaches the point from where the robot stands, though not from the very place that was meant."""
    x, y, _ = from_map(pose, point)
    return abs(math.atan2(y, x)) < 0.5 and reach(math.hypot(x, y)) is not None


def places_to_stand(
    context: SkillContext, point: Point, reach: Reach, radius: float, target: Thing | None = None
) -> list[Stand]:
    """Every place where the hull has room and the arm reaches, the cheapest first (the way there not counted)."""
    robot = context.robot
    hull = robot.footprint
    costs = [(float(distance), reach(float(distance))) for distance in _DISTANCES]
    possible = [(d, cost) for d, cost in costs if cost is not None and d > hull.length / 2 + radius + LOOSE_MARGIN]
    state = robot.state()
    hard = np.concatenate((outlines(robot.floor_map, point), _around(robot.scan().on_map(state.pose, 4.0), point)))
    hard = hard[np.hypot(hard[:, 0] - point[0], hard[:, 1] - point[1]) > radius + 0.03] if radius else hard
    loose = [thing for thing in strewn(context) if target is None or thing.number != target.number]
    lying = outline(loose)
    found = []
    for theta in np.arange(_DIRECTIONS) * (2 * math.pi / _DIRECTIONS):
        for distance, cost in possible:
            x, y = point[0] - distance * math.cos(theta), point[1] - distance * math.sin(theta)
            pose = Pose(float(x), float(y), wrap(float(theta)))
            if not _inside(robot.floor_map, pose):
                continue
            if len(hard) and gaps(seen_from(pose, hard), hull).min() < MARGIN:
                continue
            if len(lying) and gaps(seen_from(pose, lying), hull).min() < LOOSE_MARGIN:
                continue
            no_turn = len(lying) and np.hypot(lying[:, 0] - x, lying[:, 1] - y).min() < hull.radius + LOOSE_MARGIN
            found.append(Stand(pose, cost + _NO_TURN if no_turn else cost))
    return sorted(found, key=lambda stand: stand.cost)


def outlines(floor: FloorMap, point: Point, around: float = _AROUND) -> NDArray[np.float64]:
    """What is fixed near ``point``, as points in the map frame, shape (n, 2): the edges of furniture exactly, the rest
    by the cells of the map."""
    found = [np.empty((0, 2))]
    rows, columns = np.nonzero(floor.occupied)
    half = floor.resolution / 2
    centres = np.column_stack(
        (floor.origin[0] + columns * floor.resolution + half, floor.origin[1] + rows * floor.resolution + half)
    )
    centres = _around(centres, point, around)
    for piece in floor.furniture:
        nearest = (min(max(point[0], piece.x_min), piece.x_max), min(max(point[1], piece.y_min), piece.y_max))
        if math.dist(nearest, point[:2]) > around:
            continue
        xs = np.linspace(piece.x_min, piece.x_max, math.ceil((piece.x_max - piece.x_min) / 0.02) + 1)
        ys = np.linspace(piece.y_min, piece.y_max, math.ceil((piece.y_max - piece.y_min) / 0.02) + 1)
        x, y = np.meshgrid(xs, ys)
        found.append(np.column_stack((x.ravel(), y.ravel())))
        slack = floor.resolution
        inside = (centres[:, 0] > piece.x_min - slack) & (centres[:, 0] < piece.x_max + slack)
        inside &= (centres[:, 1] > piece.y_min - slack) & (centres[:, 1] < piece.y_max + slack)
        centres = centres[~inside]
    for dx in (-half, half):
        found += [centres + np.array([dx, dy]) for dy in (-half, half)]
    return np.concatenate(found)


def _around(points: NDArray[np.float64], point: Point, around: float = _AROUND) -> NDArray[np.float64]:
    near = np.hypot(points[:, 0] - point[0], points[:, 1] - point[1]) < around
    chosen: NDArray[np.float64] = points[near]
    return chosen


def _inside(floor: FloorMap, pose: Pose) -> bool:
    return not floor.rooms or any(room.holds(pose.x, pose.y) for room in floor.rooms)


def _is_new(stand: Stand, refused: list[Pose]) -> bool:
    return all(stand.pose.distance_to(pose) > 0.12 for pose in refused)


def _nearest_by_way(context: SkillContext, stands: list[Stand]) -> Pose | Unreachable:
    """The place that costs least with the way there, or why there is no way to any."""
    now = context.pose

    def estimate(stand: Stand) -> float:
        turn = abs(wrap(stand.pose.yaw - now.yaw))
        return stand.cost + now.distance_to(stand.pose) / _SPEED + 0.5 * turn / _TURN_SPEED

    directions: dict[int, Stand] = {}
    for stand in sorted(stands, key=estimate):
        directions.setdefault(round(stand.pose.yaw / (2 * math.pi) * 12) % 12, stand)
    best = math.inf
    found: Pose | Unreachable = Unreachable("no_way", "No way leads there.")
    for stand in list(directions.values())[:_ROUTED]:
        if estimate(stand) >= best:
            break
        way = way_to(context, stand.pose)
        if isinstance(way, Unreachable):
            found = way if isinstance(found, Unreachable) else found
            continue
        cost = stand.cost + way.length / _SPEED + 0.5 * abs(wrap(stand.pose.yaw - now.yaw)) / _TURN_SPEED
        if cost < best:
            best, found = cost, stand.pose
    return found
