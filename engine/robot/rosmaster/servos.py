"""From joints to servo positions and back.

A servo counts degrees of its own and takes positions: servos 1 to 4 turn 0–180° from 3100 down to 900, servo 5 0–270°
from 380 up to 3700, servo 6 0–180° from 900 up to 3100. (Source: ``Rosmaster_Lib`` V3.3.9.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from engine.robot.description import ArmOf
from engine.robot.rosmaster.frames import SERVOS

_TURNS = {5: (270.0, 380.0, 3700.0), 6: (180.0, 900.0, 3100.0)}
_USUAL = (180.0, 3100.0, 900.0)

_BEYOND: Final = 60
"""By how much a reading may be beyond the servo's ends."""
_FAR: Final = 300
"""From one reading to the next no servo turns further, 0.1 s apart."""

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
    """The six servos of one arm, and where they are known to be."""

    def __init__(self, arm: ArmOf) -> None:
        self._joints = [joint.servo for joint in arm.joints.values() if joint.servo is not None]
        self._gripper = arm.gripper
        self._used = {servo.number for servo in self._joints} | {arm.gripper.servo}
        self.forget()

    def forget(self) -> None:
        """They may be anywhere."""
        self._at: list[int | None] = [None] * SERVOS
        self._doubted: list[tuple[int, int]] = [(0, 0)] * SERVOS  # a reading that nobody believes yet, and how often

    def read(self, pulses: Sequence[int]) -> None:
        """What they say. One that is beyond the servo's ends is none; one that is far from the last is believed when it
        has been said three times, and the first when it has been said twice."""
        for index, said in enumerate(pulses):
            _, one, other = _TURNS.get(index + 1, _USUAL)
            if not min(one, other) - _BEYOND <= said <= max(one, other) + _BEYOND:
                continue
            at, (doubted, times) = self._at[index], self._doubted[index]
            if at is not None and abs(said - at) <= _FAR:
                self._at[index], self._doubted[index] = said, (0, 0)
                continue
            times = times + 1 if times and abs(said - doubted) <= _FAR else 1
            believed = times >= (2 if at is None else 3)
            self._at[index] = said if believed else at
            self._doubted[index] = (0, 0) if believed else (said, times)

    @property
    def known(self) -> Pulses | None:
        """Where all that the arm uses are; None while one of them has not said so."""
        at = self._at
        if any(at[number - 1] is None for number in self._used):
            return None
        one, two, three, four, five, six = (
            pulse(number, 90.0) if said is None else said for number, said in enumerate(at, 1)
        )
        return one, two, three, four, five, six

    def pulses(self, joints: Sequence[float], opening: float) -> Pulses:
        """Positions for joint angles, rad, and an opening of the gripper, 0 to 1."""
        found = [pulse(number, 90.0) for number in range(1, SERVOS + 1)]
        for servo, angle in zip(self._joints, joints, strict=True):
            found[servo.number - 1] = pulse(servo.number, servo.zero + servo.sign * math.degrees(angle))
        grip = self._gripper
        found[grip.servo - 1] = pulse(grip.servo, grip.closed + opening * (grip.open - grip.closed))
        one, two, three, four, five, six = found
        return one, two, three, four, five, six

    def angles(self, pulses: Sequence[int]) -> tuple[float, ...]:
        """Joint angles for positions, rad."""
        return tuple(
            math.radians((degrees(servo.number, pulses[servo.number - 1]) - servo.zero) * servo.sign)
            for servo in self._joints
        )

    def opening(self, pulses: Sequence[int]) -> float:
        """The opening of the gripper for positions, 0 to 1."""
        grip = self._gripper
        at = degrees(grip.servo, pulses[grip.servo - 1])
        return max(0.0, min(1.0, (at - grip.closed) / (grip.open - grip.closed)))
