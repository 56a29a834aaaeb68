"""An arm that is sent to a posture and finds its own way there, as a controller of ROS does it: what
:class:`engine.robot.host.arm_motion.ArmMotion` is for servos that are told every angle on the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from engine.robot.host.arm_motion import MAX_SPEED, Ranges
from engine.robot.host.body import ArmMover, Body
from engine.robot.host.envelope import clamp_joints

THERE: Final = 0.03
"""rad of every joint from its goal, within which it is there."""


class SentArm:
    """``mover`` is the body."""

    def __init__(self, body: Body, mover: ArmMover, ranges: Ranges) -> None:
        self._body = body
        self._mover = mover
        self._ranges = ranges
        self._paused = False
        self._goal: tuple[tuple[float, ...], float] | None = None  # under way, and at what speed
        self._rests = body.joints
        self.grip_target = body.opening
        self.fault = ""
        """Why its last motion was given up, in words for people; empty from when it is moved again."""

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured, rad."""
        return self._body.joints

    @property
    def targets(self) -> tuple[float, ...]:
        """Where it was sent, rad."""
        return self._goal[0] if self._goal is not None else self._rests

    @property
    def opening(self) -> float:
        """Of the gripper, measured, 0 closed … 1 open."""
        return self._body.opening

    @property
    def paused(self) -> bool:
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        """It stays where it is, and goes on to its goal when it is let go."""
        changed, self._paused = paused != self._paused, paused
        if not changed or self._goal is None:
            return
        if paused:
            self._mover.hold_arm()
        else:
            self._mover.send_arm(*self._goal)

    def resume_grip(self, opening: float) -> None:
        """Grip as it was told before, at once: what it holds must not fall."""
        self.grip(opening)

    def move(self, joints: Sequence[float], speed: float) -> bool:
        """Set a goal; within the ranges of the joints. One that is not finite is refused."""
        goal = clamp_joints(joints, self._ranges)
        if goal is None or not math.isfinite(speed) or speed <= 0:
            return False
        wanted = tuple(goal), min(speed, MAX_SPEED)
        if wanted != self._goal:
            self._goal, self.fault = wanted, ""
            if not self._paused:
                self._mover.send_arm(*wanted)
        return True

    def grip(self, opening: float) -> bool:
        """Open or close the gripper; closing goes on until something is between the fingers."""
        if not math.isfinite(opening):
            return False
        self.grip_target = max(0.0, min(1.0, opening))
        self._mover.send_gripper(self.grip_target)
        return True

    def hold(self, *, anew: bool = False) -> None:
        """Stay where the arm is now; the gripper keeps its grip."""
        del anew
        if self._goal is not None:
            self._mover.hold_arm()
        self._goal, self._rests = None, self._body.joints

    def step(self, dt: float) -> None:
        """Time passes; it moves by itself, or tells that it cannot."""
        del dt
        if self._goal is None or self._paused:
            return
        if fault := self._mover.arm_fault:
            self._mover.hold_arm()
            self._goal, self._rests, self.fault = None, self._body.joints, fault
            return
        goal = self._goal[0]
        if all(abs(told - is_) < THERE for told, is_ in zip(goal, self._body.joints, strict=True)):
            self._goal, self._rests = None, goal
