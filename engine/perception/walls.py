"""Where the robot stands, from the walls of the house.

What the lidar sees as straight along an axis of the map, about where the map has the face of a wall that looks at the
robot, is that wall. It tells how far the robot is from it, and nothing of where along it; two that meet tell the place.
Furniture hides walls and its own faces are less well known, so what is seen on it or close by says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from engine.perception.compass import AGREEING, ANGULAR_ACCELERATION, Heading, straight
from engine.robot.floor_map import FloorMap, Furniture
from engine.robot.geometry import Pose
from engine.robot.robot import RobotState, Scan

REACH: Final = 0.15
"""m that odometry may be wrong by; what is further from a wall of the map is something else."""
FLAT: Final = 0.02
"""m to either side of their middle in which points are of one face…"""
ENOUGH: Final = 0.3
"""…m of it that have to be…"""
MOST: Final = 0.6
"""…and how much of what is seen about there."""
SIGMA: Final = 0.01
"""m, of the lidar and of the map."""
LINEAR_ACCELERATION: Final = 1.5
"""m/s² by which the robot may have changed its speed since the scan."""
_END = 0.05  # m at the ends of a wall where what is seen may be round the corner


@dataclass(frozen=True, slots=True)
class WallSighting:
    """A stretch of a wall that the map knows."""

    x: float  # of the middle of what is seen, base frame when the picture was taken, m
    y: float
    axis: Literal[0, 1]  # which coordinate it tells: 0 is x, 1 is y
    at: float  # that coordinate of the wall's face, map frame, m
    sigma: float  # m


@dataclass(frozen=True, slots=True)
class _Face:
    """One side of a wall."""

    axis: Literal[0, 1]
    at: float
    low: float  # its ends
    high: float
    looks: int  # 1 along the axis, −1 against it


def walls(
    scan: Scan, now: RobotState, t: float, believed: Pose, heading: Heading, house: FloorMap
) -> tuple[WallSighting, ...]:
    """The walls of the ``house`` in a scan from about ``t``, when the robot ``believed`` to be there and its
    ``heading`` was told by the same scan. ``now`` tells how fast it moves."""
    pieces = straight(scan)
    since = t - scan.t
    yaw = heading.yaw - now.twist.wz * since
    start = np.array([believed.x, believed.y]) - since * _turned(heading.yaw) @ (now.twist.vx, now.twist.vy)
    seen = pieces.middles @ _turned(yaw).T + start
    along = pieces.along + yaw
    length = np.where(_at_any(house.furniture, seen), 0.0, pieces.length)
    across = (length * (np.abs(np.cos(along)) < AGREEING), length * (np.abs(np.sin(along)) < AGREEING))
    age = abs(since) * (abs(now.t - t) + abs(since))
    found = []
    for face in _faces(house):
        if (start[face.axis] - face.at) * face.looks <= 0:
            continue
        weight = _on(face, seen, across[face.axis])
        if weight is None:
            continue
        middle = np.average(seen, axis=0, weights=weight) - (believed.x, believed.y)
        sigma = math.hypot(SIGMA, LINEAR_ACCELERATION * age, ANGULAR_ACCELERATION * age * middle[1 - face.axis])
        x, y = (float(each) for each in _turned(-heading.yaw) @ middle)
        found.append(WallSighting(x, y, face.axis, face.at, sigma))
    return tuple(found)


def _on(face: _Face, seen: NDArray[np.float64], length: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """How much of each piece with its middle ``seen`` on the map is of this face; None where that is too little."""
    across, beside = seen[:, face.axis], seen[:, 1 - face.axis]
    near = (np.abs(across - face.at) < REACH) & (beside > face.low + _END) & (beside < face.high - _END)
    length = length * near
    if length.sum() < ENOUGH:
        return None
    order = np.argsort(across)
    middle = across[order][np.searchsorted(np.cumsum(length[order]), length.sum() / 2)]
    flat = length * (np.abs(across - middle) < FLAT)
    return flat if flat.sum() > max(ENOUGH, MOST * length.sum()) else None


def _faces(house: FloorMap) -> Iterator[_Face]:
    for wall in house.walls:
        yield _Face(0, wall.x_min, wall.y_min, wall.y_max, -1)
        yield _Face(0, wall.x_max, wall.y_min, wall.y_max, 1)
        yield _Face(1, wall.y_min, wall.x_min, wall.x_max, -1)
        yield _Face(1, wall.y_max, wall.x_min, wall.x_max, 1)


def _turned(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def _at_any(furniture: tuple[Furniture, ...], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the points may be on a piece of furniture, or before it."""
    near = np.zeros(len(points), dtype=np.bool_)
    for piece in furniture:
        low, high = (piece.x_min - REACH, piece.y_min - REACH), (piece.x_max + REACH, piece.y_max + REACH)
        near |= ((points > low) & (points < high)).all(axis=1)
    return near
