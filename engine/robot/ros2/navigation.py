"""Nav2, or whatever else serves ``NavigateToPose``, as what finds the way for a robot of ROS 2.

Commands come in the host's thread, how it fares in the door's (:mod:`engine.robot.ros2.moving_action`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from engine.robot.geometry import Pose
from engine.robot.host.memory import Record
from engine.robot.robot import Faring
from engine.robot.ros2.moving_action import MovingAction
from engine.ros.door import Code, Door, Message, Outcome

NAVIGATE: Final = "nav2_msgs/action/NavigateToPose"
_FARING: Final[dict[Code, Faring]] = {"succeeded": "arrived", "aborted": "failed"}


class Navigation:
    """One server of journeys, and how the last one fares."""

    def __init__(self, door: Door, action: str, clock: Callable[[], float], *, astray: bool = False) -> None:
        """``astray``: whoever had the robot before may have left a journey under way."""
        self.action = MovingAction(door, action, NAVIGATE, clock, astray=astray)
        self._ticket = 0
        self._how: Faring = "going"
        self._left, self._code, self._why = math.nan, 0, ""

    def go(self, goal: Pose, frame: str, ticket: int) -> None:
        """Send the robot there, in this frame; it leaves off whatever it did."""
        if ticket != self._ticket:
            self._left = math.nan
        self._ticket, self._how = ticket, "going"
        self._code, self._why = 0, ""
        self.action.send(goal_message(goal, frame), self._ended, self._told)

    def give_up(self) -> bool:
        """Go nowhere any more; whether it was on its way. Nobody waits for it: who wants the robot to stand tells it so
        beside this."""
        was_on_its_way = self.action.give_up()
        if was_on_its_way and self._how == "going":
            self._how = "canceled"
        return was_on_its_way

    def fill(self, record: Record) -> None:
        """Write how it fares into a record of ``memory.STATE``."""
        record["going"], record["going_how"] = self._ticket, self._how.encode()
        record["going_left"], record["going_code"] = self._left, self._code
        record["going_why"] = self._why.encode()[:96]

    # In the door's thread

    def _told(self, message: Message) -> None:
        self._left = _number(message.get("distance_remaining"), math.nan)

    def _ended(self, outcome: Outcome) -> None:
        self._code = int(_number(outcome.result.get("error_code"), 0.0))
        told = outcome.result.get("error_msg")
        self._why = told if isinstance(told, str) and told else outcome.why
        self._how = _FARING.get(outcome.code, outcome.code)  # type: ignore[arg-type]


def goal_message(goal: Pose, frame: str) -> dict[str, Any]:
    """A goal of ``NavigateToPose``; with no time in it, for whatever is known of the frames by then."""
    half = goal.yaw / 2
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
    pose = {"position": {"x": goal.x, "y": goal.y, "z": 0.0}, "orientation": turn}
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame}
    return {"pose": {"header": header, "pose": pose}, "behavior_tree": ""}


def _number(value: object, otherwise: float) -> float:
    try:
        found = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return otherwise
    return found if abs(found) < 1e9 else otherwise
