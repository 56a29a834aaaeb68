"""The arm and the gripper of a robot of ROS 2: where their joints are on ``/joint_states``, and two actions that move
them, ``FollowJointTrajectory`` and ``GripperCommand`` (control_msgs). Commands wait for nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

from engine.robot.arm import ARM_JOINTS
from engine.robot.description import RosArmOf
from engine.robot.ros2.moving_action import MovingAction
from engine.ros.door import Door, Message, Outcome

STATES: Final = "sensor_msgs/msg/JointState"
FOLLOW: Final = "control_msgs/action/FollowJointTrajectory"
GRIP: Final = "control_msgs/action/GripperCommand"
SHORTEST_S: Final = 0.2
"""Of a motion: a controller needs a moment to begin."""
SEND_S: Final = 0.1
"""Between two motions: whoever leads the hand along a line tells more."""


class RosArm:
    """One arm. What it hears comes in the door's thread."""

    def __init__(self, door: Door, about: RosArmOf, clock: Callable[[], float], *, astray: bool = False) -> None:
        """``astray``: whoever had the robot before may have left a motion under way."""
        self._door, self._about, self._clock = door, about, clock
        self.joints: tuple[float, ...] = (0.0,) * len(ARM_JOINTS)
        """Measured, rad, in the order of ``ARM_JOINTS``."""
        self.opening = 0.0
        """Of the gripper, measured, 0 closed … 1 open."""
        self.is_known = False
        """Its joints have been heard of."""
        self.fault = ""
        """Why the last motion was not carried out, in words for people; empty from when the next is sent."""
        self.action = MovingAction(door, about.trajectory, FOLLOW, clock, astray=astray)
        self._next: tuple[Sequence[float], float] | None = None  # to be sent, and how fast
        self._sent_at = -math.inf
        self._gripping: float | None = None
        door.subscribe(about.states, STATES, self._take)

    def send(self, joints: Sequence[float], speed: float) -> None:
        """Move all joints there, none faster than ``speed``, rad/s. Of several within ``SEND_S`` only the last one
        counts."""
        self.fault = ""
        self._next = joints, speed
        self._send_next()

    def hold(self) -> None:
        """Stay where it is: a controller that is cancelled holds."""
        self._next = None
        self.action.give_up()

    def step(self) -> None:
        """Time passes; in the host's thread."""
        self._send_next()
        self.action.look_after()

    def grip(self, opening: float) -> None:
        """Open or close the gripper."""
        about = self._about.gripper
        if about is None or opening == self._gripping:
            return
        self._gripping = opening
        position = about.closed + opening * (about.open - about.closed)
        command = {"command": {"position": position, "max_effort": about.effort}}
        self._door.send_goal(about.action, GRIP, command, lambda outcome: self._gripped(opening, outcome))

    def _send_next(self) -> None:
        if self._next is None or (now := self._clock()) - self._sent_at < SEND_S:
            return
        (joints, speed), self._next, self._sent_at = self._next, None, now
        furthest = max(abs(goal - is_) for goal, is_ in zip(joints, self.joints, strict=True))
        took = max(furthest / speed, SHORTEST_S)
        named = self._about.joints.values()
        told = [joint.zero + joint.sign * angle for joint, angle in zip(named, joints, strict=True)]
        seconds = math.floor(took)
        point = {"positions": told, "time_from_start": {"sec": seconds, "nanosec": int((took - seconds) * 1e9)}}
        trajectory = {"joint_names": [joint.name for joint in named], "points": [point]}
        self.action.send({"trajectory": trajectory}, self._moved)

    # In the door's thread

    def _take(self, message: Message) -> None:
        """A ``JointState``, which may tell of some joints alone."""
        try:
            told = dict(zip(map(str, message["name"]), message["position"], strict=True))
        except (KeyError, TypeError, ValueError):
            return
        at = {name: float(angle) for name, angle in told.items() if _is_angle(angle)}
        named = tuple(self._about.joints.values())
        if all(joint.name in at for joint in named):
            self.joints = tuple((at[joint.name] - joint.zero) * joint.sign for joint in named)
            self.is_known = True
        about = self._about.gripper
        if about is not None and about.joint in at:
            self.opening = max(0.0, min(1.0, (at[about.joint] - about.closed) / (about.open - about.closed)))

    def _moved(self, outcome: Outcome) -> None:
        told: Any = outcome.result.get("error_string")
        if outcome.code != "succeeded":
            self.fault = told if isinstance(told, str) and told else outcome.why or outcome.code

    def _gripped(self, opening: float, outcome: Outcome) -> None:
        """A gripper that something keeps from closing has done what it was told, for its controller, or has failed."""
        failed = outcome.code not in ("succeeded", "canceled", "aborted")
        if failed and self._gripping == opening:
            self._gripping = None  # so that it can be told again


def _is_angle(value: object) -> bool:
    """A joint that is not measured, such as a wheel's, is told as null or as no number."""
    return isinstance(value, int | float) and abs(value) < 1e9
