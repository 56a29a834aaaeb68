"""The arm and the gripper of :mod:`tests.ros.robot`: two actions, served with the habits of ros2_control.

- A new goal ends the one before: it is aborted here, and cancelled by the controllers of ros2_control.
- A goal that is cancelled leaves the arm, or the fingers, where they are.
- A trajectory for other joints is refused.
- Fingers that something keeps from their goal have it aborted, and go on pressing (gripper_action_controller, whose
  ``allow_stalling`` is false unless somebody sets it).

The joints are called and counted otherwise than those of the simulation, as with most robots.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable
from typing import Any

from control_msgs.action import FollowJointTrajectory, GripperCommand  # type: ignore[import-not-found]
from rclpy.action import ActionServer, CancelResponse, GoalResponse  # type: ignore[import-not-found]

from tests.ros.lines import Line

ARM, GRIPPER = "/arm_controller/follow_joint_trajectory", "/gripper_controller/gripper_cmd"
JOINTS = {
    "arm_yaw_joint": (0.0, 1),
    "arm_shoulder_joint": (0.0, -1),
    "arm_elbow_joint": (math.pi / 2, 1),
    "arm_wrist_joint": (0.0, 1),
    "arm_roll_joint": (0.0, -1),
}
"""In the order of the simulation: what each tells where that one is at 0, and whether it counts the same way."""
FINGER = "finger_joint"
FEEDBACK_S = 0.1
HOLD = {"trajectory": "hold", "grip": "hold fingers"}

_Result = FollowJointTrajectory.Result


class Arm:
    """Both servers. ``tell`` orders the simulation."""

    def __init__(self, node: Any, group: Any, tell: Callable[[Line], object]) -> None:
        self._tell = tell
        self._numbers = itertools.count(1)
        self._news = threading.Condition()
        self._newest = {"trajectory": 0, "grip": 0}  # the number of the newest goal of each
        self._ended: dict[str, list[Any]] = {"trajectory": [0], "grip": [0]}
        self._joints: list[float] = []
        self._finger = math.nan
        self._servers = [
            ActionServer(
                node,
                FollowJointTrajectory,
                ARM,
                execute_callback=self._follow,
                goal_callback=lambda goal: GoalResponse.ACCEPT if _is_right(goal.trajectory) else GoalResponse.REJECT,
                cancel_callback=lambda goal: CancelResponse.ACCEPT,
                callback_group=group,
            ),
            ActionServer(
                node,
                GripperCommand,
                GRIPPER,
                execute_callback=self._grip,
                cancel_callback=lambda goal: CancelResponse.ACCEPT,
                callback_group=group,
            ),
        ]

    def hear(self, line: Line) -> tuple[list[str], list[float]]:
        """What the simulation tells; the joints by name, as ROS is told of them."""
        with self._news:
            self._joints = [zero + sign * at for (zero, sign), at in zip(JOINTS.values(), line["joints"], strict=True)]
            self._finger = line["finger"]
            for kind in self._ended:
                self._ended[kind] = line.get(kind, self._ended[kind])
            self._news.notify_all()
            return [*JOINTS, FINGER], [*self._joints, self._finger]

    def _follow(self, goal: Any) -> Any:
        told = goal.request.trajectory
        order = [told.joint_names.index(name) for name in JOINTS]
        points = []
        for point in told.points:
            places = (point.positions[place] for place in order)
            joints = [sign * (at - zero) for (zero, sign), at in zip(JOINTS.values(), places, strict=True)]
            points.append([_seconds(point.time_from_start), joints])
        number = self._begin("trajectory", {"do": "follow", "points": points})
        match self._until_it_ends(goal, "trajectory", number, self._feedback):
            case "canceled":
                goal.canceled()
                return _Result()
            case "replaced":
                goal.abort()
                why = "Current goal cancelled due to new incoming action."
                return _Result(error_code=_Result.INVALID_GOAL, error_string=why)
            case [_, _Result.SUCCESSFUL]:
                goal.succeed()
                return _Result()
            case [_, code]:
                goal.abort()
                return _Result(error_code=code, error_string="Aborted due to goal_time_tolerance exceeding.")

    def _grip(self, goal: Any) -> Any:
        number = self._begin("grip", {"do": "grip", "finger": goal.request.command.position})
        match self._until_it_ends(goal, "grip", number, lambda: GripperCommand.Feedback(position=self._finger)):
            case "canceled":
                goal.canceled()
            case "replaced":
                goal.abort()
            case [_, finger, stalled]:
                (goal.abort if stalled else goal.succeed)()
                return GripperCommand.Result(position=finger, stalled=stalled, reached_goal=not stalled)
        return GripperCommand.Result(position=self._finger)

    def _begin(self, kind: str, order: Line) -> int:
        """Newer goals get higher numbers, and the simulation hears of them in that order."""
        with self._news:
            self._newest[kind] = number = next(self._numbers)
            self._tell({**order, "number": number})
            self._news.notify_all()
        return number

    def _until_it_ends(self, goal: Any, kind: str, number: int, feedback: Callable[[], Any]) -> Any:
        """Its end as the simulation tells it, or "replaced", or "canceled"."""
        while True:
            with self._news:
                self._news.wait_for(
                    lambda: self._ended[kind][0] == number or self._newest[kind] != number or goal.is_cancel_requested,
                    FEEDBACK_S,
                )
                if self._newest[kind] != number:
                    return "replaced"
                if self._ended[kind][0] == number:
                    return self._ended[kind]
                if goal.is_cancel_requested:
                    self._tell({"do": HOLD[kind]})  # in here, so that it cannot hold a newer goal
                    return "canceled"
                told = feedback()
            goal.publish_feedback(told)

    def _feedback(self) -> Any:
        feedback = FollowJointTrajectory.Feedback(joint_names=list(JOINTS))
        feedback.actual.positions = self._joints
        return feedback


def _is_right(trajectory: Any) -> bool:
    times = [_seconds(point.time_from_start) for point in trajectory.points]
    rises = all(earlier < later for earlier, later in itertools.pairwise([0.0, *times]))
    fits = all(len(point.positions) == len(JOINTS) for point in trajectory.points)
    return sorted(trajectory.joint_names) == sorted(JOINTS) and bool(times) and rises and fits


def _seconds(duration: Any) -> float:
    return float(duration.sec + 1e-9 * duration.nanosec)
