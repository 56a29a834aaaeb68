"""Which way the robot faces, by the walls around it.

The rooms of a map are rectangles along its axes. What the lidar sees as straight therefore runs along one of them, or
nearly so where somebody has pushed a chair; and where most of it agrees on a direction, that one is an axis. Which of
the four it is odometry knows. Unlike a landmark this is in sight nearly everywhere, and needs no map of what stands
where.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose, wrap
from engine.robot.robot import RobotState, Scan

QUARTER: Final = math.pi / 2
REACH: Final = math.radians(12)
"""By how much odometry may be wrong; walls at other angles are other things."""
AGREEING: Final = math.radians(1.5)
"""How far from their common direction pieces of wall may be."""
ENOUGH: Final = 1.2
"""m of wall that have to agree…"""
MOST: Final = 0.6
"""…and how much of what runs nearly that way they have to be."""
SIGMA: Final = math.radians(0.4)
ANGULAR_ACCELERATION: Final = 4.0
"""rad/s² by which the robot may have changed its turning since the scan."""
_STEP = (0.01, 0.25)  # m between neighbouring points of one wall; it is straight where three of them are in line
_STRAIGHT = math.radians(2)


@dataclass(frozen=True, slots=True)
class Heading:
    """Which way the base faced."""

    yaw: float  # rad, map frame
    sigma: float  # rad


def heading(scan: Scan, now: RobotState, t: float, believed: Pose) -> Heading | None:
    """Which way the robot faced at ``t``, when it ``believed`` to be there, by a scan from about then; None where
    there is too little wall, or where it does not agree. ``now`` tells how fast it turns."""
    since = t - scan.t
    yaw = believed.yaw - now.twist.wz * since
    off = _off(scan, yaw)
    if off is None:
        return None
    turned = ANGULAR_ACCELERATION * abs(since) * (abs(now.t - t) + abs(since))
    return Heading(wrap(believed.yaw + off), math.hypot(SIGMA, turned))


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """What is straight in a scan: stretches between neighbouring points, base frame when it was taken."""

    middles: NDArray[np.float64]  # shape (n, 2), m
    along: NDArray[np.float64]  # shape (n,), rad, either way
    length: NDArray[np.float64]  # shape (n,), m


def straight(scan: Scan) -> Pieces:
    """What may be a wall, or the side of something."""
    seen = np.isfinite(scan.ranges)
    x, y = scan.ranges[seen] * np.cos(scan.angles[seen]), scan.ranges[seen] * np.sin(scan.angles[seen])
    dx, dy = np.roll(x, -1) - x, np.roll(y, -1) - y
    length, along = np.hypot(dx, dy), np.arctan2(dy, dx)
    bend = np.abs(np.remainder(np.roll(along, -1) - along + QUARTER, math.pi) - QUARTER)
    wall = (length > _STEP[0]) & (length < _STEP[1]) & (np.roll(length, -1) < _STEP[1]) & (bend < _STRAIGHT)
    return Pieces(np.column_stack((x + dx / 2, y + dy / 2))[wall], along[wall], length[wall])


def _off(scan: Scan, yaw: float) -> float | None:
    """By how much the robot's heading is greater than ``yaw``, rad."""
    pieces = straight(scan)
    # A wall along an axis appears in the base frame at minus the heading, up to quarter turns.
    off = -(np.remainder(pieces.along + yaw + QUARTER / 2, QUARTER) - QUARTER / 2)
    near = np.abs(off) < REACH
    off, weight = off[near], pieces.length[near]
    if not len(off):
        return None
    order = np.argsort(off)
    common = float(off[order][np.searchsorted(np.cumsum(weight[order]), weight.sum() / 2)])
    for _ in range(2):
        agreed = np.abs(off - common) < AGREEING
        if weight[agreed].sum() < max(ENOUGH, MOST * weight.sum()):
            return None
        common = float(np.average(off[agreed], weights=weight[agreed]))
    return common
