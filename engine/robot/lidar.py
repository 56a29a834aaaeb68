"""What a turn of a lidar is to everything here: 360 distances around the robot's centre."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

RAYS = 360
"""Directions."""

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
