"""Where the robot is and how it moves: points, poses, velocities, and the frames they are told in.

*map* is fixed to the floor, x east, y north, yaw counter-clockwise from x. *base* is fixed to the robot, x forward, y
left. Units are SI and radians throughout.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float, float]
"""x, y and z, m; whoever has one says in which frame."""


def wrap(angle: float) -> float:
    """``angle`` in (-π, π], rad."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


def heading_in_degrees(yaw: float) -> float:
    """A heading (``yaw`` in rad) as people read it everywhere: whole degrees from 0 to 359, 0° east, counter-clockwise.
    What programs read stays in rad."""
    return round(math.degrees(yaw), 0) % 360


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the robot stands, map frame."""

    x: float  # m
    y: float  # m
    yaw: float  # rad, in (-π, π]

    def distance_to(self, other: Pose) -> float:
        """Straight-line distance, m."""
        return math.hypot(other.x - self.x, other.y - self.y)


@dataclass(frozen=True, slots=True)
class Twist:
    """Velocity of the base, base frame."""

    vx: float = 0.0  # m/s, forward
    vy: float = 0.0  # m/s, to the left
    wz: float = 0.0  # rad/s, counter-clockwise

    @property
    def is_zero(self) -> bool:
        return self.vx == 0.0 and self.vy == 0.0 and self.wz == 0.0


ZERO = Twist()


UNMOVED = Pose(0.0, 0.0, 0.0)
"""The rigid motion that moves nothing."""


def compose(first: Pose, then: Pose) -> Pose:
    """``then``, which is told in the frame of ``first``, in the frame that ``first`` is told in."""
    c, s = math.cos(first.yaw), math.sin(first.yaw)
    return Pose(first.x + c * then.x - s * then.y, first.y + s * then.x + c * then.y, wrap(first.yaw + then.yaw))


def inverse(pose: Pose) -> Pose:
    """What ``compose`` makes nothing of: the outer frame, told in the frame of ``pose``."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose(-c * pose.x - s * pose.y, s * pose.x - c * pose.y, wrap(-pose.yaw))
