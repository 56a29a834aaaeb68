"""Following a path: from where the robot is to the velocity it should have now.

A mecanum base can move in any direction; it still turns its front along the way, so that lidar and camera look
where it goes, and turns to the goal's direction at the end. It aims at a point a little ahead on the path, slows
down before corners, and closes the last centimetres by position. Time does not occur here; progress along the path
is the only state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from engine.robot.geometry import ZERO, Pose, Twist, wrap

LOOKAHEAD = 0.18
"""m ahead on the path that the robot aims at."""
POSITION_TOLERANCE = 0.01
"""m; arrived when nearer than this…"""
YAW_TOLERANCE = 0.015
"""rad; …and turned to within this (0.9°)."""

_BRAKING = 0.7  # m/s² counted on before the goal and corners, half of what the base can do
_TURN_BRAKING = 4.0  # rad/s²
_POSITION_GAIN = 4.0  # 1/s
_YAW_GAIN = 4.0  # 1/s
_FACING = 0.9  # rad of heading error above which the robot turns before it goes
_CORNER_SPEED = 0.25  # m/s through a right-angled corner
_SIDLE = 0.25  # m/s without turning
_SHORT = 0.35  # m; shorter ways are driven without turning the front along them


@dataclass(frozen=True, slots=True)
class Guidance:
    """What to do now."""

    twist: Twist  # base frame
    remaining: float  # m along the path to the goal
    arrived: bool


class Follower:
    """Follows one path to one goal; :meth:`guide` is called once per tick with the newest pose."""

    def __init__(
        self, path: Sequence[tuple[float, float]], goal_yaw: float, *, speed: float = 0.5, turn_speed: float = 1.8
    ) -> None:
        """``path`` begins where the robot is, map frame, m; ``speed`` in m/s, ``turn_speed`` in rad/s."""
        if len(path) < 2:
            raise ValueError("a path has a start and an end")
        self._path = tuple(path)
        self._goal_yaw = goal_yaw
        self._speed, self._turn_speed = speed, turn_speed
        self._at = [0.0]  # length of the path up to each point
        for a, b in zip(self._path, self._path[1:], strict=False):
            self._at.append(self._at[-1] + math.dist(a, b))
        self._done = 0.0  # how far along the path the robot has come, m; never decreases
        self._turns_along = self.length > _SHORT

    @property
    def length(self) -> float:
        """Of the whole path, m."""
        return self._at[-1]

    @property
    def progress(self) -> float:
        """0 at the start … 1 at the goal."""
        return 1.0 if self.length == 0 else min(1.0, self._done / self.length)

    def ahead(self, step: float = 0.1) -> tuple[tuple[float, float], ...]:
        """The rest of the path: where the robot is on it now, its corners, the goal (map frame, m)."""
        here = self._point(self._done)
        return (here, *(point for point, at in zip(self._path, self._at, strict=True) if at > self._done + step / 10))

    def sidle(self, pose: Pose) -> Twist:
        """Where to go from ``pose`` without turning, for where there is no room to turn."""
        aim = self._point(self._done + LOOKAHEAD)
        off = math.hypot(aim[0] - pose.x, aim[1] - pose.y)
        bearing = wrap(math.atan2(aim[1] - pose.y, aim[0] - pose.x) - pose.yaw)
        speed = min(_SIDLE, _POSITION_GAIN * off, self._braking_speed(self.length - self._done + off))
        return Twist(speed * math.cos(bearing), speed * math.sin(bearing))

    def guide(self, pose: Pose) -> Guidance:
        """Where to go from ``pose``."""
        self._advance(pose)
        goal = self._path[-1]
        remaining = self.length - self._done
        off = math.hypot(goal[0] - pose.x, goal[1] - pose.y)
        if off <= LOOKAHEAD and remaining <= LOOKAHEAD:
            return self._close_in(pose, off)
        aim = self._point(self._done + LOOKAHEAD)
        bearing = math.atan2(aim[1] - pose.y, aim[0] - pose.x)
        heading_error = wrap(bearing - pose.yaw)
        wz = self._turn(heading_error if self._turns_along else wrap(self._goal_yaw - pose.yaw))
        speed = min(self._speed, self._braking_speed(remaining), self._corner_speed())
        if self._turns_along:
            speed *= max(0.0, math.cos(heading_error)) if abs(heading_error) < _FACING else 0.0
        twist = Twist(speed * math.cos(heading_error), speed * math.sin(heading_error), wz)
        return Guidance(twist, remaining, arrived=False)

    def _close_in(self, pose: Pose, off: float) -> Guidance:
        """The last stretch: straight to the goal in any direction, turning to the goal's yaw meanwhile."""
        goal = self._path[-1]
        yaw_error = wrap(self._goal_yaw - pose.yaw)
        if off <= POSITION_TOLERANCE and abs(yaw_error) <= YAW_TOLERANCE:
            self._done = self.length
            return Guidance(ZERO, 0.0, arrived=True)
        bearing = wrap(math.atan2(goal[1] - pose.y, goal[0] - pose.x) - pose.yaw)
        speed = min(self._speed, _POSITION_GAIN * off, self._braking_speed(off))
        twist = Twist(speed * math.cos(bearing), speed * math.sin(bearing), self._turn(yaw_error))
        return Guidance(twist, off, arrived=False)

    def _turn(self, error: float) -> float:
        """rad/s that close a heading error without overshooting."""
        fastest = min(self._turn_speed, _YAW_GAIN * abs(error), math.sqrt(2 * _TURN_BRAKING * abs(error)))
        return math.copysign(fastest, error)

    def _advance(self, pose: Pose) -> None:
        """Move progress to the nearest point of the path within reach ahead; further on the path may come back."""
        best, best_gap = self._done, math.inf
        reach = self._done + 3 * LOOKAHEAD
        for i, (a, b) in enumerate(zip(self._path, self._path[1:], strict=False)):
            if self._at[i + 1] < self._done or self._at[i] > reach:
                continue
            length = self._at[i + 1] - self._at[i]
            if length == 0:
                continue
            along = ((pose.x - a[0]) * (b[0] - a[0]) + (pose.y - a[1]) * (b[1] - a[1])) / length
            at = min(max(self._at[i] + min(max(along, 0.0), length), self._done), reach)
            x, y = self._point(at)
            gap = math.hypot(pose.x - x, pose.y - y)
            if gap < best_gap - 1e-9:
                best, best_gap = at, gap
        self._done = best

    def _point(self, at: float) -> tuple[float, float]:
        """The point of the path at this length, the goal beyond its end."""
        for i in range(len(self._path) - 1):
            if at <= self._at[i + 1]:
                length = self._at[i + 1] - self._at[i]
                part = (at - self._at[i]) / length if length else 0.0
                a, b = self._path[i], self._path[i + 1]
                return a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])
        return self._path[-1]

    def _corner_speed(self) -> float:
        """How fast the robot may be for the corners still ahead."""
        fastest = math.inf
        for i in range(1, len(self._path) - 1):
            before = self._at[i] - self._done
            if before < -LOOKAHEAD / 2:
                continue
            (ax, ay), (bx, by), (cx, cy) = self._path[i - 1 : i + 2]
            bend = abs(wrap(math.atan2(cy - by, cx - bx) - math.atan2(by - ay, bx - ax)))
            through = _CORNER_SPEED / max(math.sin(min(bend, math.pi / 2)), 1e-3)
            distance = max(0.0, before - LOOKAHEAD)
            fastest = min(fastest, math.sqrt(through**2 + 2 * _BRAKING * distance))
        return fastest

    @staticmethod
    def _braking_speed(distance: float) -> float:
        return math.sqrt(2 * _BRAKING * max(distance, 0.0))
