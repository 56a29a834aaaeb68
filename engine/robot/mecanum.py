"""Kinematics of a mecanum base: wheel speeds from a twist, and back.

Rollers at 45° in X arrangement, as on the usual four-wheel platforms. The wheels stand at the corners of a
rectangle of ``WHEELBASE`` × ``TRACK``.
"""

from __future__ import annotations

from engine.robot.geometry import Twist

WHEEL_RADIUS = 0.042  # m
WHEELBASE = 0.184  # m, front to rear axle
TRACK = 0.194  # m, left to right wheel

Wheels = tuple[float, float, float, float]
"""rad/s, front left, front right, rear left, rear right; positive rolls forward."""

_ARM = (WHEELBASE + TRACK) / 2


def wheel_speeds(twist: Twist) -> Wheels:
    """How fast each wheel turns so that the base moves with ``twist``."""
    vx, vy, turn = twist.vx, twist.vy, _ARM * twist.wz
    return (
        (vx - vy - turn) / WHEEL_RADIUS,
        (vx + vy + turn) / WHEEL_RADIUS,
        (vx + vy - turn) / WHEEL_RADIUS,
        (vx - vy + turn) / WHEEL_RADIUS,
    )


def twist_of(wheels: Wheels) -> Twist:
    """The twist that wheels turning at these speeds give, slip left aside."""
    fl, fr, rl, rr = wheels
    quarter = WHEEL_RADIUS / 4
    return Twist(quarter * (fl + fr + rl + rr), quarter * (-fl + fr + rl - rr), quarter * (-fl + fr - rl + rr) / _ARM)
