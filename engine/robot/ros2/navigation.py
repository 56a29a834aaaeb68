"""Nav2, or whatever else serves ``NavigateToPose``, as what finds the way for a robot of ROS 2.

Commands come in the host's thread and wait for nothing; how it fares comes in the door's. What is heard of a goal that
has been given up, or of one before the last, changes nothing but that its end is known.

A goal that was lost, because the door was shut, may still be under way: nobody there knows that we are gone. So all
goals are cancelled as soon as the door is open again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from engine.robot.geometry import Pose
from engine.robot.host.memory import Record
from engine.robot.robot import Faring
from engine.ros.actions.parts import ALL, CANCEL, cancel_request, cancel_service
from engine.ros.door import Code, Door, Goal, Message, Outcome

NAVIGATE: Final = "nav2_msgs/action/NavigateToPose"
AGAIN_S: Final = 0.2
"""Between two requests to cancel what may be under way."""
QUIET_S: Final = 1.0
"""For so long nothing must have been there to cancel: a goal may be taken late."""
FOUND_S: Final = 10.0
"""In which a door that was opened anew has found a navigation that is there: nodes take their time for that."""
STUBBORN_S: Final = 2.0
"""In which a navigation has to end once it is told to."""
_FARING: Final[dict[Code, Faring]] = {"succeeded": "arrived", "aborted": "failed"}


class Navigation:
    """One action server, and the last goal that it was sent."""

    def __init__(self, door: Door, action: str, clock: Callable[[], float], *, astray: bool = False) -> None:
        """``astray``: whoever had the robot before may have left a goal under way."""
        self._door, self._action, self._clock = door, action, clock
        self._sent = 0  # goals
        self._goal: Goal | None = None  # under way
        self._open: set[int] = set()  # which of them have not ended
        self._given_up_at = -math.inf
        self._astray = astray  # one may be under way of which nobody hears any more
        self._asking = False
        self._asked_at = -math.inf
        self._first_asked_at: float | None = None  # since the door is open
        self._quiet_since: float | None = None  # nothing has been there to cancel
        self._ticket = 0
        self._how: Faring = "going"
        self._left, self._code, self._why = math.nan, 0, ""

    @property
    def is_ending(self) -> bool:
        """It has been told to stop, and has not said yet that it has."""
        return bool(self._open) and self._goal is None

    @property
    def is_stubborn(self) -> bool:
        """It goes on although it was told to stop, for all that is known."""
        return self.is_ending and self._clock() - self._given_up_at > STUBBORN_S

    @property
    def is_under_way(self) -> bool:
        """It drives the robot, and is to."""
        return self._goal is not None

    @property
    def may_drive(self) -> bool:
        """It may drive the robot, as far as anybody knows."""
        return bool(self._open) or self._astray or self._clock() - self._given_up_at < STUBBORN_S

    @property
    def is_astray(self) -> bool:
        """A goal that was lost may still drive the robot."""
        return self._astray

    def recall(self) -> None:
        """Cancel whatever is under way there, once the door is open again; to be called now and then."""
        late = self.is_ending and self._clock() - self._given_up_at > AGAIN_S
        if not self._astray and not late:
            return
        if self._door.trouble:
            self._first_asked_at = None
            return
        now = self._clock()
        if self._asking or now - self._asked_at < AGAIN_S:
            return
        self._asking, self._asked_at = True, now
        self._first_asked_at = now if self._first_asked_at is None else self._first_asked_at
        self._door.call(cancel_service(self._action), CANCEL, cancel_request(ALL), self._recalled)

    def go(self, goal: Pose, frame: str, ticket: int) -> None:
        """Send the robot there, in this frame; it leaves off whatever it did."""
        self._sent += 1
        number = self._sent
        self._ticket, self._how = ticket, "going"
        self._left, self._code, self._why = math.nan, 0, ""
        self._open.add(number)
        self._goal = self._door.send_goal(
            self._action,
            NAVIGATE,
            goal_message(goal, frame),
            lambda outcome: self._ended(number, outcome),
            feedback=lambda message: self._told(number, message),
        )

    def give_up(self) -> bool:
        """Go nowhere any more; whether it was on its way. Nobody waits for it: who wants the robot to stand tells it so
        beside this."""
        goal, self._goal = self._goal, None
        if goal is None:
            return False
        self._given_up_at = self._clock()
        if self._how == "going":
            self._how = "canceled"
        goal.cancel()
        return True

    def fill(self, record: Record) -> None:
        """Write how it fares into a record of ``memory.STATE``."""
        record["going"], record["going_how"] = self._ticket, self._how.encode()
        record["going_left"], record["going_code"] = self._left, self._code
        record["going_why"] = self._why.encode()[:96]

    # In the door's thread

    def _told(self, number: int, message: Message) -> None:
        if number == self._sent:
            self._left = _number(message.get("distance_remaining"), math.nan)

    def _recalled(self, outcome: Outcome) -> None:
        self._asking = False
        now, since = self._clock(), self._first_asked_at
        is_missing = outcome.code == "no_server" and since is not None and now - since > FOUND_S
        stands = outcome.code == "succeeded" and not outcome.result.get("return_code")
        if not stands or outcome.result.get("goals_canceling"):
            self._quiet_since = None  # a request that was taken, or refused, is no end
        elif self._quiet_since is None:
            self._quiet_since = now
        elif now - self._quiet_since >= QUIET_S:
            self._astray = False
        if is_missing:
            self._astray = False
        if not self._astray:
            self._first_asked_at = self._quiet_since = None

    def _ended(self, number: int, outcome: Outcome) -> None:
        self._open.discard(number)
        if outcome.code in ("lost", "timed_out", "rejected"):  # a server that was slow may take it yet
            self._astray = True
        if number != self._sent or self._goal is None:
            return
        self._goal = None
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
