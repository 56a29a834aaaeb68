"""A navigation for robots that find their way themselves, in tests: over the map, around what the lidar sees, and the
numbers by which Nav2 says why it gave up."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from engine.robot.floor_map import FloorMap
from engine.robot.follow import Follower
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.occupancy import Unreachable, route
from engine.robot.robot import Footprint, Scan

ARRIVED: Final = 0
NO_WAY: Final = 208
NO_PROGRESS: Final = 105
SEEN_M: Final = 2.5
AHEAD_M: Final = 0.12
"""What is nearer than that before the hull stops it, unless it is beyond the goal."""
AT_GOAL_M: Final = 0.02
"""By so much it may drive past its goal."""
DETOURS: Final = 4


class Pilot:
    """One journey; :meth:`guide` is asked some 20 times a second."""

    def __init__(self, floor: FloorMap, hull: Footprint, goal: Pose, speed: float = 0.4) -> None:
        self._floor, self._hull, self._goal, self._speed = floor, hull, goal, speed
        self._seen = np.empty((0, 2))
        self._detours = 0
        self._way: Follower | None = None
        self.left = math.nan
        """m of its way."""

    def guide(self, pose: Pose, scan: Scan) -> Twist | int:
        """The velocity to drive at, or how it has ended."""
        if self._way is None:
            way = route(self._floor, pose, self._goal, self._hull, extra=self._seen)
            if isinstance(way, Unreachable):
                return NO_WAY
            self._way = Follower(way.points, self._goal.yaw, speed=self._speed)
        guidance = self._way.guide(pose)
        self.left = guidance.remaining
        if guidance.arrived:
            return ARRIVED
        if self._is_blocked(guidance.twist, scan):
            self._detours += 1
            if self._detours > DETOURS:
                return NO_PROGRESS
            self._seen = np.concatenate((self._seen, scan.on_map(pose, SEEN_M)))
            self._way = None
            return ZERO
        return guidance.twist

    def _is_blocked(self, twist: Twist, scan: Scan) -> bool:
        """Whether something stands where it is about to drive."""
        speed = math.hypot(twist.vx, twist.vy)
        if speed < 0.02:
            return False
        points = scan.on_map(Pose(0.0, 0.0, -math.atan2(twist.vy, twist.vx)), SEEN_M)  # x is where it goes
        reach = self._hull.radius if abs(twist.vy) > 0.05 else self._hull.length / 2
        ahead = (points[:, 0] > 0) & (points[:, 0] < reach + min(AHEAD_M, self.left + AT_GOAL_M))
        return bool(np.any(ahead & (np.abs(points[:, 1]) < self._hull.width / 2 + 0.02)))
