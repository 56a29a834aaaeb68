"""From joints to servo positions and back.

A servo counts degrees of its own and takes positions: servos 1 to 4 turn 0–180° from 3100 down to 900, servo 5 0–270°
from 380 up to 3700, servo 6 0–180° from 900 up to 3100. (Source: ``Rosmaster_Lib`` V3.3.9.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from engine.robot.description import ArmOf
from engine.robot.rosmaster.frames import SERVOS

_TURNS = {5: (270.0, 380.0, 3700.0), 6: (180.0, 900.0, 3100.0)}
_USUAL = (180.0, 3100.0, 900.0)

Pulses = tuple[int, int, int, int, int, int]


def pulse(number: int, degrees: float) -> int:
    """The position of servo ``number`` at this angle; angles beyond its ends are its ends."""
    whole, low, high = _TURNS.get(number, _USUAL)
    return round(low + (high - low) * max(0.0, min(whole, degrees)) / whole)


def degrees(number: int, pulse: int) -> float:
    """The reverse of :func:`pulse`."""
    whole, low, high = _TURNS.get(number, _USUAL)
    return (pulse - low) / (high - low) * whole


class Servos:
    """The six servos of one arm."""

    def __init__(self, arm: ArmOf) -> None:
        self._joints = [joint.servo for joint in arm.joints.values() if joint.servo is not None]
        self._gripper = arm.gripper

    def pulses(self, joints: Sequence[float], opening: float) -> Pulses:
        """Positions for joint angles, rad, and an opening of the gripper, 0 to 1."""
        found = [pulse(number, 90.0) for number in range(1, SERVOS + 1)]
        for servo, angle in zip(self._joints, joints, strict=True):
            found[servo.number - 1] = pulse(servo.number, servo.zero + servo.sign * math.degrees(angle))
        grip = self._gripper
        found[grip.servo - 1] = pulse(grip.servo, grip.closed + opening * (grip.open - grip.closed))
        one, two, three, four, five, six = found
        return one, two, three, four, five, six

    def angles(self, pulses: Sequence[int], before: Sequence[float]) -> tuple[float, ...]:
        """Joint angles for positions, rad; one that did not answer (negative) is where it was ``before``."""
        return tuple(
            math.radians((degrees(servo.number, pulses[servo.number - 1]) - servo.zero) * servo.sign)
            if pulses[servo.number - 1] > 0
            else old
            for servo, old in zip(self._joints, before, strict=True)
        )

    def opening(self, pulses: Sequence[int], before: float) -> float:
        """The opening of the gripper for positions, 0 to 1."""
        grip = self._gripper
        at = pulses[grip.servo - 1]
        if at <= 0:
            return before
        return max(0.0, min(1.0, (degrees(grip.servo, at) - grip.closed) / (grip.open - grip.closed)))
