"""Actions of ROS 2, from three services and two topics below the action's name (source: the design of actions,
https://design.ros2.org/articles/actions.html).

``send_goal`` takes a goal or rejects it, ``get_result`` answers when it has ended, ``cancel_goal`` asks for its end;
``feedback`` tells how far it is, and ``status`` how all goals are. A door whose protocol knows only topics and services
has actions by :mod:`engine.ros.actions.clients` and :mod:`engine.ros.actions.servers`. Here is what they need, and what
every door and robot needs of the names and numbers.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, Final, Protocol

from engine.ros.door import Code, End, Message, Reply, Take, Then, octets

CANCEL: Final = "action_msgs/srv/CancelGoal"
STATUS: Final = "action_msgs/msg/GoalStatusArray"

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 1, 2, 3, 4, 5, 6
"""States of a goal (action_msgs/msg/GoalStatus); 0 is that of a goal that nobody knows."""
UNDER_WAY: Final = (ACCEPTED, EXECUTING, CANCELING)
"""States of a goal that has not ended."""
ENDS: Final[dict[End, int]] = {"succeeded": SUCCEEDED, "canceled": CANCELED, "aborted": ABORTED}
CODES: Final[dict[object, Code]] = {SUCCEEDED: "succeeded", CANCELED: "canceled", ABORTED: "aborted"}
CANCEL_AGAIN_S: Final = 0.1
"""Between two requests to cancel a goal, until it has ended: one may get lost, or come too early."""
ALL: Final = bytes(16)
"""The id that means every goal where one is to be cancelled."""


class Carrier(Protocol):
    """What actions need of a door. It calls back in one thread."""

    def publish(
        self, topic: str, type: str, message: Message, *, every: bool = False, latched: bool = False
    ) -> None: ...
    def advertise(self, topic: str, type: str, *, latched: bool = False) -> None: ...
    def subscribe(self, topic: str, type: str, take: Take) -> None: ...
    def call(
        self,
        service: str,
        type: str,
        request: Message,
        then: Then,
        *,
        limit_s: float,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """``wanted`` is asked just before it is sent, which is once its server is there; where it is not any more, the
        call ends with ``canceled``."""
        ...

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None: ...
    def soon(self, act: Callable[[], object]) -> object: ...
    def later(self, delay_s: float, act: Callable[[], object]) -> Callable[[], object]: ...


def goal_id(id: bytes) -> dict[str, Any]:
    return {"goal_id": {"uuid": id}}


def cancel_service(action: str) -> str:
    """The name of the service that cancels goals of an action; its type is ``CANCEL``."""
    return f"{action}/_action/cancel_goal"


def cancel_request(id: bytes) -> dict[str, Any]:
    """What that service is asked: to cancel one goal, or ``ALL``."""
    return {"goal_info": {"goal_id": {"uuid": list(id)}, "stamp": {"sec": 0, "nanosec": 0}}}


def id_of(message: object) -> bytes:
    """Of the goal that a message is about; empty where it tells none."""
    with contextlib.suppress(KeyError, TypeError):
        return octets(message["goal_id"]["uuid"]) or b""  # type: ignore[index]
    return b""


def nanoseconds(stamp: Any) -> int:
    """Of a time as ROS tells it; 0 where it tells none."""
    return int(stamp["sec"]) * 10**9 + int(stamp["nanosec"]) if stamp else 0
