"""What moves the arm and the gripper of the simulated robot for :mod:`tests.ros.simulation`: two controllers with the
habits of ros2_control (``joint_trajectory_controller`` and ``gripper_action_controller``, Jazzy).

A trajectory begins at the measured joints and goes along straight lines in joint space. One that does not get there in
time is given up. A gripper that something keeps from its goal goes on pressing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from engine.robot.host.body import STEP_S
from engine.robot.sim.dimensions import FINGER_TRAVEL
from engine.robot.sim.simulated import SimulatedBody

SUCCESSFUL, GOAL_TOLERANCE_VIOLATED = 0, -5
"""Of a ``FollowJointTrajectory``."""
TOLERANCE: Final = 0.02
"""rad of every joint from the end of its trajectory, within which it is there."""
GRACE_S: Final = 1.0
"""In which it must be there once the trajectory is over."""
FINGER_SPEED: Final = 0.07  # m/s
FINGER_TOLERANCE: Final = 0.001  # m
STALLED_SPEED: Final = 0.001
"""m/s; fingers that are slower for STALLED_S are kept from their goal."""
STALLED_S: Final = 0.3

Points = Sequence[tuple[float, Sequence[float]]]
"""When from now, s, the joints are where, rad."""


@dataclass(slots=True)
class _Trajectory:
    number: int
    began: float  # robot time, s
    times: Sequence[float]
    joints: np.ndarray[Any, Any]  # shape (points, joints), rad

    def at(self, t: float) -> tuple[float, ...]:
        return tuple(float(np.interp(t - self.began, self.times, column)) for column in self.joints.T)


@dataclass(slots=True)
class _Grip:
    number: int
    goal: float  # m
    moved_at: float  # robot time, s


class Controllers:
    """Both. How a goal has ended is among the news, by the number it was given with."""

    def __init__(self, body: SimulatedBody) -> None:
        self._body = body
        self._told = body.joints
        self._finger = self._finger_told = self._finger_goal = self.finger
        self._trajectory: _Trajectory | None = None
        self._grip: _Grip | None = None
        self._news: dict[str, Any] = {}

    @property
    def finger(self) -> float:
        """Where a finger is, measured, m from where both meet."""
        return self._body.opening * FINGER_TRAVEL

    def follow(self, number: int, points: Points) -> None:
        """Follow this trajectory in place of any other."""
        times = [0.0, *(when for when, _ in points)]
        joints = np.array([self._body.joints, *(where for _, where in points)])
        self._trajectory = _Trajectory(number, self._body.t, times, joints)

    def hold(self) -> None:
        """Stay where the arm is."""
        self._trajectory = None
        self._told = self._body.joints

    def grip(self, number: int, finger: float) -> None:
        """Bring the fingers there, m."""
        self._finger_goal = max(0.0, min(FINGER_TRAVEL, finger))
        self._grip = _Grip(number, self._finger_goal, self._body.t)

    def hold_fingers(self) -> None:
        """Stay where the fingers are."""
        self._grip = None
        self._finger_told = self._finger_goal = self.finger

    def news(self) -> dict[str, Any]:
        """What has ended since it was asked last."""
        news, self._news = self._news, {}
        return news

    def step(self) -> None:
        """Before each step of the body."""
        if self._trajectory is not None:
            self._told = self._trajectory.at(self._body.t)
            self._end_trajectory(self._trajectory)
        change, most = self._finger_goal - self._finger_told, FINGER_SPEED * STEP_S
        self._finger_told += math.copysign(min(abs(change), most), change)
        if self._grip is not None:
            self._end_grip(self._grip)
        self._body.place_arm(self._told, self._finger_told / FINGER_TRAVEL)

    def _end_trajectory(self, trajectory: _Trajectory) -> None:
        late = self._body.t - trajectory.began - trajectory.times[-1]
        if late < 0:
            return
        goal = trajectory.joints[-1]
        if np.abs(goal - self._body.joints).max() < TOLERANCE:
            self._trajectory = None
            self._news["trajectory"] = [trajectory.number, SUCCESSFUL]
        elif late > GRACE_S:
            self.hold()
            self._news["trajectory"] = [trajectory.number, GOAL_TOLERANCE_VIOLATED]

    def _end_grip(self, grip: _Grip) -> None:
        finger, before = self.finger, self._finger
        self._finger = finger
        if abs(finger - before) > STALLED_SPEED * STEP_S:
            grip.moved_at = self._body.t
        reached = abs(finger - grip.goal) < FINGER_TOLERANCE
        stalled = not reached and self._body.t - grip.moved_at > STALLED_S
        if reached or stalled:
            self._grip = None
            self._news["grip"] = [grip.number, finger, stalled]
