"""What lies about on the floor: the lidar looks over it, so nothing but the memory keeps the hull off it.

Ways are planned around it; and in every control tick a drive asks :func:`heed` whether its next stretch is clear. Where
a turn would sweep a corner of the hull over something the robot goes sideways instead, or away from it; where nothing
is clear it stands.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.memory import Thing
from engine.robot.clearance import free_time, gaps
from engine.robot.geometry import Pose, Twist
from engine.robot.robot import Footprint
from engine.skills.context import SkillContext

LOW: Final = 0.05
"""m: what stands lower lies on the floor."""
FEET: Final = 0.35
"""m from the middle of somebody within which what is seen low is their legs, and nothing is put on the floor."""
BESIDE: Final = 0.03
"""m that a way leads past something."""
MARGIN: Final = 0.012
"""m that a moving hull keeps at the least."""
_REACTION: Final = 0.08  # s until it brakes
_BRAKING, _TURN_BRAKING = 1.2, 6.0  # m/s² and rad/s², a little less than what it does
_NEAR: Final = 0.08  # m from which the robot retreats…
_RETREAT: Final = 0.12  # …at so many m/s
_CORNERS: Final = 12  # points that stand for a thing's outline
_STAYS_S: Final = 10.0  # for which somebody is taken to stand where they were seen


def strewn(context: SkillContext) -> list[Thing]:
    """Small things that are remembered to lie on the floor. From close by, legs look like one: the lidar sees those."""
    now = context.robot.state().t
    people = [person for person in context.world.people.everybody if now - person.seen_at < _STAYS_S]
    return [
        thing
        for thing in context.world.things
        if thing.surface < LOW and all(person.distance_to(*thing.position[:2]) > FEET for person in people)
    ]


def outline(things: Iterable[Thing]) -> NDArray[np.float64]:
    """Points around things and their middles, map frame, shape (n, 2)."""
    angles = np.linspace(0, 2 * math.pi, _CORNERS, endpoint=False)
    ring = np.concatenate((np.column_stack((np.cos(angles), np.sin(angles))), [(0.0, 0.0)]))
    found = [np.array(thing.position[:2]) + ring * thing.size[0] / 2 for thing in things]
    return np.concatenate(found) if found else np.empty((0, 2))


def seen_from(pose: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of the map frame in the base frame, shape (n, 2)."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = points[:, 0] - pose.x, points[:, 1] - pose.y
    return np.column_stack((c * x + s * y, c * y - s * x))


def heed(pose: Pose, things: Iterable[Thing], hull: Footprint, wanted: Sequence[Twist]) -> Twist | None:
    """The first of these motions that touches nothing soon, or else one away from what is too near; None when each of
    them would."""
    points = seen_from(pose, outline(things))
    points = points[np.hypot(points[:, 0], points[:, 1]) < 1.0]
    points = points[gaps(points, hull) > 0.0] if len(points) else points  # what is under it is not there
    for twist in (*wanted, *away_from(points, hull)):
        halting = max(math.hypot(twist.vx, twist.vy) / _BRAKING, abs(twist.wz) / _TURN_BRAKING)
        horizon = _REACTION + halting / 2
        if free_time(twist, horizon, points, hull, MARGIN).time >= horizon:
            return twist
    return None


def away_from(points: NDArray[np.float64], hull: Footprint) -> tuple[Twist, ...]:
    """Straight away from the nearest of these points (base frame), if it is near."""
    if not len(points):
        return ()
    apart = gaps(points, hull)
    x, y = points[int(apart.argmin())].tolist()
    near = float(apart.min())
    if near > _NEAR:
        return ()
    dx = x - max(-hull.length / 2, min(hull.length / 2, x))
    dy = y - max(-hull.width / 2, min(hull.width / 2, y))
    return (Twist(-_RETREAT * dx / near, -_RETREAT * dy / near),)


def in_the_way(thing: Thing, path: Sequence[tuple[float, float]], half_width: float) -> bool:
    """Whether the hull would touch it on a path."""
    x, y = thing.position[:2]
    near = half_width + thing.size[0] / 2 + BESIDE
    return any(_distance_to_stretch((x, y), a, b) < near for a, b in pairwise(path))


def nearest_to(pose: Pose, things: Iterable[Thing]) -> Thing | None:
    """The thing nearest to the robot."""
    return min(things, key=lambda thing: thing.distance_to(pose.x, pose.y), default=None)


def _distance_to_stretch(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = dx * dx + dy * dy
    along = 0.0 if length == 0 else max(0.0, min(1.0, ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / length))
    return math.dist(point, (a[0] + along * dx, a[1] + along * dy))
