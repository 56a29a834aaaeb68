"""Where the wheels have brought the robot: encoder counts added up, with the board's attitude for the direction.

A wheel that turned by so many counts has rolled so far. Four of them give the way forward, the way to the left and the
turn; slip makes the turn the worst of the three, so the gyroscope's is taken where the board sends one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from engine.robot.description import Description, Wheels
from engine.robot.geometry import UNMOVED, Pose, Twist, compose, wrap

ATTITUDE_S: Final = 0.3
"""From this long without one, the wheels alone say how far it has turned."""
_WRAP: Final = 1 << 32  # counts are 32 bits wide
_ODD: Final = 0.1
"""rad by which a direction may change at once; one that changes by more than the robot can turn is odd, and ignored."""
_NEAR_M: Final = 0.05
"""Counts that stand for less begin: where they stood for more before, the board has begun to count anew."""


class Odometry:
    """Adds up the motion of one board since this was made."""

    def __init__(self, description: Description, start: Pose = UNMOVED) -> None:
        assert description.wheels is not None, "a board has wheels"
        self._wheels: Wheels = description.wheels
        self._drive = description.drive
        self._fastest = 1.5 * (description.speeds.forward + description.speeds.sideways)
        self._fastest_turn = 1.5 * description.speeds.turn
        self._counts: Sequence[int] | None = None
        self._counts_t = -math.inf
        self._yaw: float | None = None
        self._yaw_t = -math.inf
        self._turned = 0.0  # by attitude, and not yet part of the pose
        self.pose = start

    def attitude(self, yaw: float, t: float) -> None:
        """The board's direction at ``t``, rad and s."""
        most = self._fastest_turn * (t - self._yaw_t) + _ODD
        if self._yaw is not None and abs(turn := wrap(yaw - self._yaw)) <= most:
            self._turned += turn
        self._yaw, self._yaw_t = yaw, t

    def encoders(self, counts: Sequence[int], t: float) -> None:
        """The board's counts at ``t``: front left, rear left, front right, rear right. Those that come after the line
        was gone for a while tell how far it went meanwhile, unless the board has begun anew."""
        before, elapsed = self._counts, t - self._counts_t
        self._counts, self._counts_t = counts, t
        if before is None:
            self._turned = 0.0
            return
        per_count = 2 * math.pi * self._wheels.radius / self._wheels.counts
        rolled = [per_count * _difference(new, old) for new, old in zip(counts, before, strict=True)]
        anew = _furthest(counts, per_count) < _NEAR_M < _furthest(before, per_count) and _furthest(rolled, 1) > _NEAR_M
        if anew or _furthest(rolled, 1) > self._fastest * elapsed + _NEAR_M:
            self._turned = 0.0
            return
        front_left, rear_left, front_right, rear_right = rolled
        forward = sum(rolled) / 4
        left = (-front_left + rear_left + front_right - rear_right) / 4 if self._drive == "mecanum" else 0.0
        arm = (self._wheels.base + self._wheels.track) / 2 if self._drive == "mecanum" else self._wheels.track / 2
        turn = (front_right + rear_right - front_left - rear_left) / 4 / arm
        if t - self._yaw_t < ATTITUDE_S:
            turn = self._turned
        self._turned = 0.0
        self._add(forward, left, turn)

    def speed(self, twist: Twist, dt: float) -> None:
        """What a board that sends no counts says that it has done for ``dt`` s."""
        if self._counts is None and 0 < dt < ATTITUDE_S:
            self._add(twist.vx * dt, twist.vy * dt, twist.wz * dt)

    def _add(self, forward: float, left: float, turn: float) -> None:
        """On an arc, whose chord points half of the turn further."""
        c, s = math.cos(turn / 2), math.sin(turn / 2)
        self.pose = compose(self.pose, Pose(c * forward - s * left, s * forward + c * left, turn))


def counts_of(description: Description, twist: Twist, dt: float) -> tuple[float, float, float, float]:
    """By how many counts the wheels turn while the robot moves so for ``dt`` s (for the emulator)."""
    wheels = description.wheels
    assert wheels is not None, "a board has wheels"
    arm = (wheels.base + wheels.track) / 2 if description.drive == "mecanum" else wheels.track / 2
    per_metre = wheels.counts / (2 * math.pi * wheels.radius) * dt
    turn, aside = arm * twist.wz, twist.vy if description.drive == "mecanum" else 0.0
    return (
        (twist.vx - aside - turn) * per_metre,
        (twist.vx + aside - turn) * per_metre,
        (twist.vx + aside + turn) * per_metre,
        (twist.vx - aside + turn) * per_metre,
    )


def _furthest(values: Sequence[float], scale: float) -> float:
    return max(abs(scale * value) for value in values)


def _difference(new: int, old: int) -> int:
    return (new - old + _WRAP // 2) % _WRAP - _WRAP // 2
