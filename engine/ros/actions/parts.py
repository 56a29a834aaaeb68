"""Actions of ROS 2, from three services and two topics below the action's name (source: the design of actions,
https://design.ros2.org/articles/actions.html).

``send_goal`` takes a goal or rejects it, ``get_result`` answers when it has ended, ``cancel_goal`` asks for its end;
``feedback`` tells how far it is, and ``status`` how all goals are. A door whose protocol knows only topics and services
has actions by :mod:`engine.ros.actions.clients` and :mod:`engine.ros.actions.servers`; here is what both need.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, Final, Protocol

from engine.ros.door import Code, End, Message, Reply, Take, Then, octets

CANCEL: Final = "action_msgs/srv/CancelGoal"
STATUS: Final = "action_msgs/msg/GoalStatusArray"

EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 2, 3, 4, 5, 6
"""States of a goal (action_msgs/msg/GoalStatus); 0 is that of a goal that nobody knows."""
ENDS: Final[dict[End, int]] = {"succeeded": SUCCEEDED, "canceled": CANCELED, "aborted": ABORTED}
CODES: Final[dict[object, Code]] = {SUCCEEDED: "succeeded", CANCELED: "canceled", ABORTED: "aborted"}


class Carrier(Protocol):
    """What actions need of a door. It calls back in one thread."""

    def publish(
        self, topic: str, type: str, message: Message, *, every: bool = False, latched: bool = False
    ) -> None: ...
    def advertise(self, topic: str, type: str, *, latched: bool = False) -> None: ...
    def subscribe(self, topic: str, type: str, take: Take) -> None: ...
    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float) -> None: ...
    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None: ...
    def soon(self, act: Callable[[], object]) -> object: ...
    def later(self, delay_s: float, act: Callable[[], object]) -> Callable[[], object]: ...


def goal_id(id: bytes) -> dict[str, Any]:
    return {"goal_id": {"uuid": id}}


def id_of(message: object) -> bytes:
    """Of the goal that a message is about; empty where it tells none."""
    with contextlib.suppress(KeyError, TypeError):
        return octets(message["goal_id"]["uuid"]) or b""  # type: ignore[index]
    return b""
