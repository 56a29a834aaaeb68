"""The safety envelope of the base: the last thing between any command and the motors.

It runs in the robot process, below everything that plans or decides. In every control period it takes the newest
command, lets it die after its lifetime, limits speed and acceleration, and then takes away as much speed as needed
for the hull to halt before an obstacle, the edge of the workspace or a keep-out zone. It only ever takes away: no
motion comes out of it that was not asked for, except that a glancing approach is bent along the obstacle.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from config.schema import Limits
from engine.robot.clearance import Free, Points, free_time
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.robot import SLOWEST, Footprint

REACTION = 0.05
"""s between deciding to brake and braking: one control period, the lag of the motors, and a margin."""
TURN_MARGIN = 0.015
"""m. A turn sweeps the corners of the hull 4 cm beyond its sides, so it may use up the margin down to this; else a
robot that has driven up to a wall could never turn away from it."""
GLANCING = 0.3
"""Largest part of the speed, towards an obstacle, that is cut off while the rest goes on along it (17°)."""
SCAN_LIFETIME = 0.5
"""s after which a lidar scan says nothing any more; without one the robot does not drive."""

_SIDES = (
    "ahead", "ahead on the left", "on the left", "behind on the left",
    "behind", "behind on the right", "on the right", "ahead on the right",
)  # fmt: skip
_BRAKING = 0.8  # of the allowed acceleration is counted on when braking for obstacles
_FENCE_STEP = 0.03  # m between the points that stand for an edge
_HELD_BACK = 0.2  # of the wanted speed: below this the command counts as blocked


@dataclass(frozen=True, slots=True)
class Shaped:
    """What the motors are told, and what held them back."""

    twist: Twist
    blocked: str | None = None


class Envelope:
    """State between control periods: the standing command and what was last sent to the motors."""

    def __init__(self, limits: Limits, hull: Footprint) -> None:
        self._limits = limits
        self._hull = hull
        self._wanted = ZERO
        self._until = -math.inf
        self._sent = ZERO
        self._share, self._slower = 1.0, limits
        self.reach = _reach(limits, hull)
        """What is further than this from the robot's middle changes nothing, at any speed that is allowed, m."""

    def command(self, twist: Twist, t: float) -> bool:
        """Take a new command at robot time ``t``; one that is not finite is refused and means standing still."""
        sound = all(math.isfinite(v) for v in (twist.vx, twist.vy, twist.wz))
        self._wanted = clamp(twist, self._limits) if sound else ZERO
        self._until = t + self._limits.command_lifetime_s
        return sound

    def limit_speed(self, share: float) -> None:
        """Allow this share of the limits' speeds from now on, also for what is commanded already; anything but a number
        from ``SLOWEST`` to 1 means the nearest of the two."""
        share = min(1.0, max(SLOWEST, share)) if math.isfinite(share) else 1.0
        if share != self._share:
            speeds = {"linear_speed": self._limits.linear_speed, "angular_speed": self._limits.angular_speed}
            slower = {name: share * speed for name, speed in speeds.items()}
            self._share, self._slower = share, self._limits.model_copy(update=slower)

    def halt(self) -> None:
        """Forget the command and stand still at once, without a ramp."""
        self._wanted, self._sent, self._until = ZERO, ZERO, -math.inf

    @property
    def idle(self) -> bool:
        """Nothing is commanded and nothing moves: whatever is around, :meth:`shape` tells the motors to stand."""
        return self._wanted.is_zero and self._sent.is_zero

    def shape(self, t: float, dt: float, obstacles: Points | None) -> Shaped:
        """What the motors are told for the next ``dt`` seconds.

        ``obstacles`` are points in the base frame; None means that nothing can be seen, and then nothing moves.
        """
        if t >= self._until and not self._wanted.is_zero:
            self.halt()  # whoever drove is gone: no ramp
        wanted = clamp(self._wanted, self._slower)
        if obstacles is None and not wanted.is_zero:
            self._sent = ZERO
            return Shaped(ZERO, "no lidar scan")
        ramped = ramp(self._sent, wanted, dt, self._limits)
        shaped = Shaped(ramped) if obstacles is None else self._short_of(obstacles, ramped, wanted)
        self._sent = shaped.twist
        return shaped

    def _short_of(self, obstacles: Points, twist: Twist, wanted: Twist) -> Shaped:
        """Slow ``twist`` down so that the hull can still halt in front of every obstacle."""
        if twist.is_zero and wanted.is_zero:
            return Shaped(ZERO)
        margin = self._limits.obstacle_margin
        straight, ahead = self._slow(Twist(twist.vx, twist.vy), obstacles, margin)
        if ahead is not None:
            straight = max(straight, self._along(ahead, twist, obstacles), key=lambda v: _progress(v, twist))
        turning = Twist(straight.vx, straight.vy, twist.wz)
        result, beside = self._slow(turning, obstacles, min(margin, TURN_MARGIN)) if twist.wz else (straight, None)
        held_back = _progress(result, wanted) < _HELD_BACK * _progress(wanted, wanted)
        in_the_way = ahead or beside
        return Shaped(result, describe(in_the_way) if held_back and in_the_way is not None else None)

    def _slow(self, twist: Twist, obstacles: Points, margin: float) -> tuple[Twist, Free | None]:
        """The fastest multiple of ``twist`` that can be braked within the free part of its arc."""
        linear = _BRAKING * self._limits.linear_acceleration
        angular = _BRAKING * self._limits.angular_acceleration
        brake = max(math.hypot(twist.vx, twist.vy) / linear, abs(twist.wz) / angular)
        horizon = REACTION + brake / 2
        free = free_time(twist, horizon, obstacles, self._hull, margin)
        if free.time >= horizon:
            return twist, None
        # At a fraction s of the speed, reaction and braking use up s·(REACTION + s·brake/2) of the arc.
        root = math.sqrt(REACTION**2 + 2 * brake * free.time)
        s = 2 * free.time / (REACTION + root)
        s = s if s > 0.01 else 0.0
        return Twist(s * twist.vx, s * twist.vy, s * twist.wz), free

    def _along(self, ahead: Free, twist: Twist, obstacles: Points) -> Twist:
        """The part of a glancing motion that runs along the obstacle; standing still when it is not glancing."""
        into = twist.vx * ahead.normal[0] + twist.vy * ahead.normal[1]
        if not 0 < into <= GLANCING * math.hypot(twist.vx, twist.vy):
            return ZERO
        aside = Twist(twist.vx - into * ahead.normal[0], twist.vy - into * ahead.normal[1])
        return self._slow(aside, obstacles, self._limits.obstacle_margin)[0]


def _reach(limits: Limits, hull: Footprint) -> float:
    speed, turn = math.sqrt(2) * limits.linear_speed, limits.angular_speed
    brake = max(speed / limits.linear_acceleration, turn / limits.angular_acceleration) / _BRAKING
    return (speed + turn * hull.radius) * (REACTION + brake / 2) + hull.radius + limits.obstacle_margin + 0.05


def clamp(twist: Twist, limits: Limits) -> Twist:
    """Within the speed limits; direction of travel is kept."""
    fastest = max(abs(twist.vx), abs(twist.vy))
    scale = min(1.0, limits.linear_speed / fastest) if fastest > 0 else 1.0
    wz = max(-limits.angular_speed, min(limits.angular_speed, twist.wz))
    return Twist(twist.vx * scale, twist.vy * scale, wz)


def ramp(now: Twist, wanted: Twist, dt: float, limits: Limits) -> Twist:
    """From ``now`` towards ``wanted`` as far as the accelerations allow in ``dt`` seconds."""
    dx, dy = wanted.vx - now.vx, wanted.vy - now.vy
    change, most = math.hypot(dx, dy), limits.linear_acceleration * dt
    part = 1.0 if change <= most else most / change
    turn = max(-limits.angular_acceleration * dt, min(limits.angular_acceleration * dt, wanted.wz - now.wz))
    if part == 1.0 and now.wz + turn == wanted.wz:
        return wanted
    return Twist(now.vx + part * dx, now.vy + part * dy, now.wz + turn)


def fence(areas: Iterable[tuple[float, float, float, float]]) -> Points:
    """The outlines of rectangles (x_min, y_min, x_max, y_max) as points in the map frame: edges not to cross."""
    points: list[tuple[float, float]] = []
    for x0, y0, x1, y1 in areas:
        corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        for (ax, ay), (bx, by) in zip(corners, (*corners[1:], corners[0]), strict=True):
            count = max(1, math.ceil(math.hypot(bx - ax, by - ay) / _FENCE_STEP))
            points += [(ax + (bx - ax) * i / count, ay + (by - ay) * i / count) for i in range(count)]
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def into_base_frame(points: Points, pose: Pose) -> Points:
    """Map frame to base frame."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = points[:, 0] - pose.x, points[:, 1] - pose.y
    return np.column_stack((c * x + s * y, c * y - s * x))


def into_map_frame(points: Points, pose: Pose) -> Points:
    """Base frame to map frame."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = points[:, 0], points[:, 1]
    return np.column_stack((pose.x + c * x - s * y, pose.y + s * x + c * y))


def clamp_joints(joints: Sequence[float], ranges: Sequence[tuple[float, float]]) -> tuple[float, ...] | None:
    """Within the ranges; None when a value is not finite or the count is wrong."""
    if len(joints) != len(ranges) or not all(math.isfinite(joint) for joint in joints):
        return None
    return tuple(max(low, min(high, joint)) for joint, (low, high) in zip(joints, ranges, strict=True))


def describe(free: Free) -> str:
    """For people: ``obstacle 0.08 m ahead``."""
    if free.point is None:
        return "obstacle"
    angle = math.atan2(free.point[1], free.point[0])
    return f"obstacle {free.gap:.2f} m {_SIDES[round(angle / (math.pi / 4)) % 8]}"


def _progress(twist: Twist, wanted: Twist) -> float:
    """How much of ``wanted`` is in ``twist``, m²/s² (a radian a second counts as 0.2 m/s at the hull)."""
    return twist.vx * wanted.vx + twist.vy * wanted.vy + 0.04 * twist.wz * wanted.wz
