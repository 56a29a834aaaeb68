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
