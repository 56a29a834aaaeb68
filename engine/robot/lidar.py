"""What a turn of a lidar is to everything here: 360 distances around the robot's centre."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose

RAYS = 360
"""Directions."""
OWN_M = 0.02
"""By so much a scan may be off: only what lies deeper in the hull is the robot itself."""

_turn = np.arange(RAYS, dtype=np.float64) * (2 * math.pi / RAYS)
LIDAR_ANGLES: NDArray[np.float64] = np.where(_turn <= math.pi, _turn, _turn - 2 * math.pi)
"""Directions of the rays, rad, base frame: the first looks forward, then counter-clockwise, in (−π, π]."""
LIDAR_ANGLES.setflags(write=False)
DIRECTIONS: NDArray[np.float64] = np.column_stack((np.cos(LIDAR_ANGLES), np.sin(LIDAR_ANGLES)))
"""The same as unit vectors, shape (RAYS, 2)."""
DIRECTIONS.setflags(write=False)


def ranges_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The distances of a scan that has hit ``points`` (base frame, shape (n, 2), m): the nearest in every direction,
    inf where there is none."""
    ranges = np.full(RAYS, np.inf)
    ray = np.rint(np.arctan2(points[:, 1], points[:, 0]) * (RAYS / (2 * math.pi))).astype(np.intp) % RAYS
    np.minimum.at(ranges, ray, np.hypot(points[:, 0], points[:, 1]))
    return ranges


def points(ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    """The hits of a scan in the base frame, shape (n, 2), m."""
    hit = np.isfinite(ranges)
    found: NDArray[np.float64] = DIRECTIONS[hit] * ranges[hit, None]
    return found


def outside(points: NDArray[np.float64], length: float, width: float) -> NDArray[np.bool_]:
    """Which of these points, base frame, shape (n, 2), are not of the robot itself, whose hull has this size, m."""
    deep = np.array((length, width)) / 2 - OWN_M
    own: NDArray[np.bool_] = np.all(np.abs(points) < deep, axis=1)
    return ~own


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn: points in the base frame that the robot had when each came, shape (n, 2), m, and those moments, s."""

    points: NDArray[np.float64]
    times: NDArray[np.float64]

    def seen_from(self, been: NDArray[np.float64], here: Pose) -> NDArray[np.float64]:
        """Its points as they lie around the robot that is ``here`` by now, shape (n, 2), m. ``been`` is where it was:
        rows of s, m, m and rad, in the order of time; in between, it is interpolated."""
        when = been[:, 0]
        x, y = np.interp(self.times, when, been[:, 1]), np.interp(self.times, when, been[:, 2])
        yaw = np.interp(self.times, when, np.unwrap(been[:, 3]))
        cos, sin = np.cos(yaw), np.sin(yaw)
        ahead, aside = self.points.T
        there = np.column_stack((x + cos * ahead - sin * aside - here.x, y + sin * ahead + cos * aside - here.y))
        c, s = math.cos(here.yaw), math.sin(here.yaw)
        around: NDArray[np.float64] = there @ np.array([[c, -s], [s, c]])
        return around
