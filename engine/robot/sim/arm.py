"""The arm's controller: servo targets that move along a straight line in joint space, smoothly and not too fast."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.robot.arm import ARM_JOINTS
from engine.robot.envelope import clamp_joints
from engine.robot.sim.dimensions import FINGER_TRAVEL, JOINT_RANGES

MAX_SPEED = 2.5
"""rad/s of any joint, whatever a command asks for."""
ACCELERATION = 8.0  # rad/s² of the joint that moves furthest
GRIPPER_SPEED = 2.0  # of the opening per second


class Arm:
    """Five servos and the gripper. ``move`` and ``grip`` set goals, ``step`` moves the servo targets towards them."""

    def __init__(self, model: Any, data: Any) -> None:
        self._data = data
        self._positions = np.array([model.joint(name).qposadr[0] for name in ARM_JOINTS])
        self._fingers = np.array([model.joint(f"finger {side}").qposadr[0] for side in ("left", "right")])
        self._servos = np.array([model.actuator(name).id for name in ARM_JOINTS])
        self._motor = model.actuator("gripper").id
        self.paused = False
        """It stays where it is, and goes on to its goal when it is let go."""
        self.targets = self.joints
        self._goal = self.targets
        self._most, self._speed = MAX_SPEED, 0.0
        self._opening = self._wanted_opening = self.opening
        self._tell()

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured, rad."""
        return tuple(self._data.qpos[self._positions].tolist())

    @property
    def opening(self) -> float:
        """Measured, 0 closed … 1 open."""
        return max(0.0, min(1.0, float(self._data.qpos[self._fingers].mean()) / FINGER_TRAVEL))

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
        goal = clamp_joints(joints, JOINT_RANGES)
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

    def hold(self) -> None:
        """Stay where the arm is now; the gripper keeps its grip."""
        self.targets = self._goal = self.joints
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
        self._data.ctrl[self._servos] = self.targets
        self._data.ctrl[self._motor] = self._opening * FINGER_TRAVEL
