"""What the host drives: hardware, or its simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose, Twist
from engine.robot.host.memory import Record

STEP_S = 0.002
"""How much time one step of a body is, s: the host looks for a stop before each of them."""


class Body(Protocol):
    """Is told velocities and joint angles, and tells what it measures. Belongs to the thread that opened it.

    It knows no limits, no epochs and no map: whoever tells it something has made sure of all that. What is told to it
    holds until it is told otherwise. Nothing here blocks.
    """

    @property
    def trouble(self) -> str:
        """Why it can't be moved now, in words for people ("… was unplugged"); empty where it can."""
        ...

    @property
    def t(self) -> float:
        """The robot's own clock, s."""
        ...

    @property
    def twist(self) -> Twist:
        """Measured velocity, base frame."""
        ...

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured, rad, in the order of ``ARM_JOINTS``."""
        ...

    @property
    def lag(self) -> float:
        """By how much the measured joints may be behind what they were told while they follow it, rad."""
        ...

    @property
    def guard_pid(self) -> int:
        """Of the process that brings it to rest when the host dies; 0 where there is none."""
        ...

    @property
    def opening(self) -> float:
        """Of the gripper, measured, 0 closed … 1 open."""
        ...

    def step(self) -> None:
        """Let ``STEP_S`` pass: in a simulation they do, on hardware this sends and reads."""
        ...

    def drive(self, twist: Twist) -> None:
        """Tell the motors this velocity, from now on."""
        ...

    def place_arm(self, joints: Sequence[float], opening: float) -> None:
        """Tell the servos these angles, rad, and the gripper this opening."""
        ...

    def shine(self, rgb: tuple[int, int, int]) -> None:
        """Set the light, 0…255 each."""
        ...

    def beep(self, seconds: float) -> None:
        """Sound the buzzer for so long."""
        ...

    def odometry(self) -> Pose:
        """Where its own motion, added up, has brought it, from where it was put down. Asked once in every control
        period."""
        ...

    def scan(self) -> NDArray[np.float64] | None:
        """A turn of the lidar (``engine.robot.lidar``), m, inf where nothing was hit; None where there is none that is
        newer than the last one that was asked for."""
        ...

    def fill(self, record: Record) -> None:
        """Write what only this body knows into a record of ``memory.STATE``."""
        ...

    def close(self) -> None:
        """Let go of everything; it has been brought to rest before."""
        ...


class Navigator(Protocol):
    """What a body has beside that where it finds its way itself."""

    def go(self, goal: Pose, ticket: int) -> None:
        """Go there, in the frame of ``odometry``; how it fares, ``fill`` tells under this ticket."""
        ...

    def give_up(self) -> bool:
        """Go nowhere any more, and stand: at once, and without waiting for anybody. Whether it was on its way."""
        ...


class ArmMover(Protocol):
    """What a body has beside that where its arm finds its own way from one posture to the next."""

    def send_arm(self, joints: Sequence[float], speed: float) -> None:
        """Move the arm there, rad, no joint faster than ``speed``, rad/s."""
        ...

    def send_gripper(self, opening: float) -> None:
        """Open the gripper so far, 0 closed … 1 open."""
        ...

    @property
    def arm_fault(self) -> str:
        """Why the arm does not carry out what it was sent last, in words for people; empty where it does."""
        ...

    def hold_arm(self) -> None:
        """Stay where the arm is, without waiting for anybody."""
        ...
