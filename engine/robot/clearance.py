"""How far the hull can go along a motion before it comes too near to an obstacle.

Obstacles are points in the base frame (lidar hits, the outline of keep-out zones). A constant twist moves the hull
along an arc; the arc is followed in small steps, and the first step at which a point is nearer to the rectangle of
the hull than allowed ends the free part. Pure functions, no state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Twist
from engine.robot.robot import Footprint

Points = NDArray[np.float64]
"""Shape (n, 2), base frame, m."""

_STEP = 0.01  # m that the outermost point of the hull moves between two looks


@dataclass(frozen=True, slots=True)
class Free:
    """The free part of an arc."""

    time: float  # s along the arc at the given twist; inf when nothing is in the way within the horizon
    point: tuple[float, float] | None = None  # the obstacle that ends it, base frame now, m
    gap: float = math.inf  # distance of that obstacle from the hull now, m
    normal: tuple[float, float] = (0.0, 0.0)  # from the hull to the obstacle where they come too near, base frame now


def gaps(points: Points, hull: Footprint) -> NDArray[np.float64]:
    """Distance of each point from the hull, m; 0 inside."""
    dx = np.maximum(np.abs(points[:, 0]) - hull.length / 2, 0.0)
    dy = np.maximum(np.abs(points[:, 1]) - hull.width / 2, 0.0)
    distances: NDArray[np.float64] = np.hypot(dx, dy)
    return distances


def free_time(twist: Twist, horizon: float, points: Points, hull: Footprint, margin: float) -> Free:
    """How long ``twist`` can be kept up within ``horizon`` seconds with every point at least ``margin`` away.

    Where a point is nearer than ``margin`` already, the robot may move on as long as nothing comes nearer than that,
    so that it can leave a tight spot.
    """
    reach = (math.hypot(twist.vx, twist.vy) + abs(twist.wz) * hull.radius) * horizon
    if reach <= 0.0 or len(points) == 0:
        return Free(math.inf)
    near = points[np.hypot(points[:, 0], points[:, 1]) < hull.radius + margin + reach + _STEP]
    if len(near) == 0:
        return Free(math.inf)
    now = gaps(near, hull)
    allowed = min(margin, float(now.min()) - 1e-6)
    times = np.linspace(0.0, horizon, math.ceil(reach / _STEP) + 1)[1:]
    moved = _seen_from(twist, times, near)
    dx = np.maximum(np.abs(moved[..., 0]) - hull.length / 2, 0.0)
    dy = np.maximum(np.abs(moved[..., 1]) - hull.width / 2, 0.0)
    distance = np.hypot(dx, dy)  # shape (times, points)
    nearest = distance.min(axis=1)
    hits = np.flatnonzero(nearest < allowed)
    if len(hits) == 0:
        return Free(math.inf)
    first = int(hits[0])
    which = int(distance[first].argmin())
    # Between the last free look and the first hit the gap shrinks almost evenly: the border lies in between.
    before = float(distance[first - 1, which]) if first else float(now[which])
    after = float(distance[first, which])
    part = (before - allowed) / (before - after) if before > after else 0.0
    start = float(times[first - 1]) if first else 0.0
    time = start + max(0.0, min(1.0, part)) * (float(times[first]) - start)
    x, y = (float(v) for v in near[which])
    return Free(time, (x, y), float(now[which]), _normal(moved[first, which], hull, twist.wz * time))


def _seen_from(twist: Twist, times: NDArray[np.float64], points: Points) -> NDArray[np.float64]:
    """The points in the frame of the hull after each time along the arc, shape (times, points, 2)."""
    turned = twist.wz * times
    if abs(twist.wz) > 1e-9:
        a, b = np.sin(turned) / twist.wz, (1 - np.cos(turned)) / twist.wz
    else:
        a, b = times, np.zeros_like(times)
    x = points[None, :, 0] - (twist.vx * a - twist.vy * b)[:, None]
    y = points[None, :, 1] - (twist.vx * b + twist.vy * a)[:, None]
    c, s = np.cos(turned)[:, None], np.sin(turned)[:, None]
    return np.stack((c * x + s * y, c * y - s * x), axis=-1)


def _normal(point: NDArray[np.float64], hull: Footprint, turned: float) -> tuple[float, float]:
    """Unit vector from the hull towards ``point``, turned back into the base frame of now."""
    dx = point[0] - np.clip(point[0], -hull.length / 2, hull.length / 2)
    dy = point[1] - np.clip(point[1], -hull.width / 2, hull.width / 2)
    if dx == 0.0 and dy == 0.0:
        dx, dy = point[0], point[1]
    size = math.hypot(dx, dy) or 1.0
    c, s = math.cos(turned), math.sin(turned)
    return float((c * dx - s * dy) / size), float((s * dx + c * dy) / size)
