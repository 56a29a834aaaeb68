"""How an arm moves: servo targets that go along a straight line in joint space, smoothly and not too fast."""

from __future__ import annotations

import math
from collections.abc import Sequence

from engine.robot.host.body import Body
from engine.robot.host.envelope import clamp_joints

MAX_SPEED = 2.5
"""rad/s of any joint, whatever a command asks for."""
ACCELERATION = 8.0  # rad/s² of the joint that moves furthest
GRIPPER_SPEED = 2.0  # of the opening per second

Ranges = Sequence[tuple[float, float]]
"""Of the joints, rad, in the order of ``ARM_JOINTS``."""


class ArmMotion:
    """Five servos and the gripper. ``move`` and ``grip`` set goals, ``step`` moves the servo targets towards them."""

    def __init__(self, body: Body, ranges: Ranges) -> None:
        self._body = body
        self._ranges = ranges
        self.paused = False
        """It stays where it is, and goes on to its goal when it is let go."""
        self.fault = ""
        """None is known: servos say nothing."""
        self.targets = self.joints
        self._goal = self.targets
        self._most, self._speed = MAX_SPEED, 0.0
        self._opening = self._wanted_opening = self.opening
        self._tell()

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured, rad."""
        return self._body.joints

    @property
    def opening(self) -> float:
        """Measured, 0 closed … 1 open."""
        return self._body.opening

    @property
    def grip_target(self) -> float:
        """What the gripper is told, 0 … 1."""
        return self._opening

    def resume_grip(self, opening: float) -> None:
        """Grip as it was told before, at once: what it holds must not fall."""
        self._opening = self._wanted_opening = opening
        self._tell()

    def move(self, joints: Sequence[float], speed: float) -> bool:
        """Set a goal; within the ranges of the joints. One that is not finite is refused."""
        goal = clamp_joints(joints, self._ranges)
        if goal is None or not math.isfinite(speed) or speed <= 0:
            return False
        self._goal, self._most = goal, min(speed, MAX_SPEED)
        return True

    def grip(self, opening: float) -> bool:
        """Open or close the gripper; closing goes on until something is between the fingers."""
        if not math.isfinite(opening):
            return False
        self._wanted_opening = max(0.0, min(1.0, opening))
        return True

    def hold(self, *, anew: bool = False) -> None:
        """Stay where the arm is now; the gripper keeps its grip. Servos that are measured late are where they were told
        to be, unless they are further from it than that can be, or ``anew`` says that they need not be there."""
        lag = 0.0 if anew else self._body.lag
        pairs = zip(self.targets, self.joints, strict=True)
        self.targets = self._goal = tuple(told if abs(told - is_) < lag else is_ for told, is_ in pairs)
        self._speed = 0.0
        self._wanted_opening = self._opening
        self._tell()

    def step(self, dt: float) -> None:
        """Advance the targets by ``dt`` seconds."""
        if self.paused:
            self._speed = 0.0
            return
        if self.targets == self._goal and self._opening == self._wanted_opening:
            return
        left = [goal - target for goal, target in zip(self._goal, self.targets, strict=True)]
        furthest = max(abs(way) for way in left)
        self._speed = min(self._speed + ACCELERATION * dt, self._most, math.sqrt(2 * ACCELERATION * furthest))
        if furthest <= max(self._speed * dt, 1e-4):
            self.targets, self._speed = self._goal, 0.0
        else:
            part = self._speed * dt / furthest
            self.targets = tuple(target + part * way for target, way in zip(self.targets, left, strict=True))
        change = self._wanted_opening - self._opening
        most = GRIPPER_SPEED * dt
        self._opening = self._wanted_opening if abs(change) <= most else self._opening + math.copysign(most, change)
        self._tell()

    def _tell(self) -> None:
        self._body.place_arm(self.targets, self._opening)
