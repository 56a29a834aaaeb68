"""What every door to a ROS 2 graph can do: topics, services and actions, as a client and as a server.

Messages are plain mappings, as rosbridge writes them in JSON: fields by name, nested messages as mappings, arrays as
lists (or numpy arrays, where they are long). Arrays of octets are ``bytes`` on their way out; on their way in each door
has its own habit, and :func:`octets` reads them all. Types are named as ROS does: ``geometry_msgs/msg/Twist``,
``std_srvs/srv/Trigger``, ``nav2_msgs/action/NavigateToPose``.

Nothing here blocks, and nothing raises because of what a peer does. Whatever is given to be called is called in the
door's own thread, one at a time: it must not block either, and raises nothing. A door that is shut is no error of
whoever uses it: what is published meanwhile is dropped, for a robot must not be told tomorrow what was meant today;
subscriptions and servers hold when it opens again; calls and goals end with ``lost``. ``trouble`` tells.
"""

from __future__ import annotations

import binascii
from base64 import b64decode
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

Message = Mapping[str, Any]
Take = Callable[[Message], object]
"""Gets a message."""

Code = Literal["succeeded", "aborted", "canceled", "rejected", "no_server", "timed_out", "lost", "bad_type"]
"""How a call or a goal ended. ``lost``: the door was shut before the end was known. ``bad_type``: one of the two sides
does not know this type, or knows another one by this name."""
End = Literal["succeeded", "aborted", "canceled"]
"""How whoever carries out a goal may end it."""

CALL_S = 5.0
"""In which a service must have answered."""
ACCEPT_S = 3.0
"""In which an action's server must have taken a goal, or refused it."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a call or a goal ended: exactly one for each."""

    code: Code
    result: Message = field(default_factory=dict)
    """The response of a service, the result of an action; empty where there is none."""
    why: str = ""
    """In words for people, where it did not succeed."""


Then = Callable[[Outcome], object]
"""Gets the outcome, once."""


class Goal(Protocol):
    """A goal that we have sent."""

    def cancel(self) -> None:
        """Ask its server to give it up, as soon as it can be asked; again does no harm. Its outcome tells how it
        ended: a server may well finish it, or ignore us."""
        ...


class Execution(Protocol):
    """A goal that a peer has sent to us. Thread-safe, all of it."""

    @property
    def goal(self) -> Message: ...

    def feedback(self, message: Message) -> None:
        """Tell how far it is."""
        ...

    def end(self, how: End, result: Message) -> None:
        """It has ended; only the first counts."""
        ...


class Work(Protocol):
    """What carries out goals that peers send."""

    def begin(self, execution: Execution) -> bool:
        """Take it up; False rejects it. Whoever takes it ends it, now or later, from any thread."""
        ...

    def cancel(self, execution: Execution) -> None:
        """Its client, or anybody, wants it to be given up: end it as ``canceled`` when it has been."""
        ...


@dataclass(frozen=True, slots=True)
class Graph:
    """What is there, by name; each with its type."""

    topics: Mapping[str, str] = field(default_factory=dict)
    services: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    why: str = ""
    """Why it could not be found out, in words for people; empty where it could."""


Reply = Callable[[Message], object]
"""Answers a request, once; later and from any thread, if need be."""


class Door(Protocol):
    """A way into one graph. Thread-safe, all of it."""

    @property
    def trouble(self) -> str:
        """Why nothing passes now, in words for people; empty where it does."""
        ...

    def mismatches(self) -> Mapping[str, str]:
        """What cannot work though the door is open, by topic, service or action, in words for people: a type that is
        not known here, or that a peer means otherwise."""
        ...

    def advertise(self, topic: str, type: str) -> None:
        """Let peers know that it will be published: those who listen then miss nothing."""
        ...

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        """Publish soon. Of two that have not gone out yet on one topic only the newer one does, unless ``every`` one
        counts."""
        ...

    def subscribe(
        self,
        topic: str,
        type: str,
        take: Take,
        *,
        every_s: float = 0.0,
        latched: bool = False,
        every: bool = False,
    ) -> None:
        """Have the messages of a topic, but no more than one in ``every_s``; one subscription a topic. Where they come
        faster than they pass, only the newest do, unless ``every`` one counts. ``latched``: also the last one that was
        published before (``transient_local``), as a map is."""
        ...

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = CALL_S) -> None:
        """Call a service."""
        ...

    def send_goal(
        self,
        action: str,
        type: str,
        goal: Message,
        then: Then,
        *,
        feedback: Take = lambda message: None,
        limit_s: float | None = None,
    ) -> Goal:
        """Have a goal carried out. One that lasts longer than ``limit_s`` is cancelled and ends with ``timed_out``; a
        server that says nothing within ``ACCEPT_S`` ends it with ``no_server``, or ``timed_out`` where it is there."""
        ...

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        """Answer whoever calls this service."""
        ...

    def serve_action(self, action: str, type: str, work: Work) -> None:
        """Carry out the goals of an action."""
        ...

    def graph(self, then: Callable[[Graph], object]) -> None:
        """Find out what is there."""
        ...

    def close(self) -> None:
        """Shut it; what was published has gone out, if it can within a moment. What we serve is not there any more, and
        whatever has not ended ends with ``lost``."""
        ...


def octets(value: object) -> bytes | None:
    """An array of octets as it came through a door: ``bytes``, base64 as rosbridge writes it, or numbers in a list or
    array; None where it is nothing of these."""
    if isinstance(value, int):
        return None  # that many zeros, to Python
    if isinstance(value, str):
        try:
            return b64decode(value, validate=True)
        except (binascii.Error, ValueError):
            return None
    try:
        return bytes(value)  # type: ignore[call-overload, no-any-return]
    except (TypeError, ValueError, MemoryError):
        return None
