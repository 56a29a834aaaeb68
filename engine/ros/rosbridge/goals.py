"""Calls and goals through a rosbridge, each over a connection that it has for itself.

What a bridge does not tell, is found out beside it (seen in rosbridge_suite 2.x): a goal that is refused, or whose
server is gone, gets no answer at all. So whether there is a server is asked before and again and again, and whether it
took the goal is read from its status topic. A goal is cancelled over another connection, twice: by the operation of
the protocol, which finds it there, and by the service of ROS itself, which works where the operation waits for the end
of the goal (rosbridge_suite issue 909).
"""

from __future__ import annotations

import asyncio
import contextlib
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from engine.ros.actions.parts import (
    ACCEPTED,
    CANCEL_AGAIN_S,
    CODES,
    EXECUTING,
    UNDER_WAY,
    cancel_request,
    cancel_service,
    nanoseconds,
)
from engine.ros.door import ACCEPT_S, Code, Message, Outcome, Take, octets
from engine.ros.rosbridge.line import GONE, Line, Lines, why

_LOOK_S: Final = 1.0
"""Between two looks whether the server is still there, while nothing is heard of it."""
_GRACE_S: Final = 2.0
"""In which a goal that took too long has to end once it is cancelled."""

Id = tuple[int, ...]
"""Of a goal, as its server has it."""


async def call(lines: Lines, service: str, request: Message, limit_s: float) -> Outcome:
    """Call a service; the bridge finds its type."""
    order = {"op": "call_service", "id": _new_id(), "service": service, "args": request}
    try:
        async with asyncio.timeout(limit_s), lines.one() as line:
            await line.send(order)
            async for heard in line.heard():
                if heard.get("id") == order["id"] and heard.get("op") == "service_response":
                    return _of_call(heard, service)
    except TimeoutError:
        return Outcome("timed_out", why=f"{service} has not answered for {limit_s:g} s")
    except GONE as error:
        return Outcome("lost", why=why(error))
    return Outcome("lost", why="the bridge has closed the connection")


def _of_call(heard: dict[str, Any], service: str) -> Outcome:
    values = heard.get("values")
    if heard.get("result") and isinstance(values, dict):
        return Outcome("succeeded", values)
    return Outcome(*_what_failed(str(values), f"there is no service {service}"))


def _what_failed(told: str, absent: str) -> tuple[Code, Message, str]:
    if "does not exist" in told:
        return "no_server", {}, absent
    if "Unable to import" in told or "InvalidModule" in told or "InvalidClass" in told:
        return "bad_type", {}, f"the bridge does not know this type: {told[:200]}"
    return "aborted", {}, told[:200] or "the bridge gives no reason"


@dataclass(eq=False)
class Goal:
    """A goal on its way through a bridge, a :class:`engine.ros.door.Goal`. Lives in the loop of the door, but for
    ``cancel``."""

    action: str
    type: str
    goal: Message
    feedback: Take
    limit_s: float | None
    soon: Callable[[Callable[[], object]], object]
    """Does something in the door's loop."""
    told: Callable[[dict[str, Any]], object]
    """Says something over the connection on which topics go."""
    id: str = field(default_factory=lambda: _new_id())
    _cancelled: bool = False
    _late: bool = False
    _taken: bool = False
    _has_feedback: bool = False
    _server_ids: dict[Id, int] = field(default_factory=dict)
    """By which its server may know it, each with when that goal was taken: the newest is the likeliest."""
    _accept_by: float = 0.0
    """When its server must have taken it."""
    _heard_at: float = 0.0
    _outcome: Outcome | None = None
    _news: asyncio.Event = field(default_factory=asyncio.Event)

    def cancel(self) -> None:
        self.soon(self._cancel)

    def _cancel(self) -> None:
        if not self._cancelled:
            self._cancelled = True
            self.told(self._order_to_cancel)
        self._news.set()

    @property
    def _order_to_cancel(self) -> dict[str, Any]:
        return {"op": "cancel_action_goal", "id": self.id, "action": self.action}

    async def run(self, lines: Lines, statuses: Statuses) -> Outcome:
        """Send it and wait for its end."""
        if (gone := await self._server_gone(lines)) is not None:
            return gone
        if self._cancelled:
            return Outcome("canceled", why="it was cancelled before it was sent")
        statuses.expect(self)
        try:
            async with lines.one() as line:
                await line.send(self._sending)
                outcome = await self._until_it_ends(line, lines, statuses)
                if outcome.code in ("succeeded", "canceled", "aborted"):
                    return outcome
                raise _Unfinished(outcome)  # the bridge still waits for it, and does nothing else on this connection
        except _Unfinished as unfinished:
            return unfinished.outcome
        except GONE as error:
            return Outcome("lost", why=why(error))
        finally:
            statuses.forget(self)

    @property
    def _sending(self) -> dict[str, Any]:
        about = {"action": self.action, "action_type": self.type, "args": self.goal}
        return {"op": "send_action_goal", "id": self.id, **about, "feedback": True}

    async def _until_it_ends(self, line: Line, lines: Lines, statuses: Statuses) -> Outcome:
        loop = asyncio.get_running_loop()
        began = loop.time()
        self._accept_by = began + ACCEPT_S
        hearing = asyncio.create_task(self._hear(line, statuses))
        looking = asyncio.create_task(self._look(lines))
        self._heard_at = began
        cancelling: asyncio.Task[None] | None = None
        try:
            while self._outcome is None:
                now = loop.time()
                limits = [self._accept_by] if not self._taken else []
                if self.limit_s is not None:
                    limits.append(began + self.limit_s + (_GRACE_S if self._late else 0.0))
                if limits and now >= min(limits):
                    if not self._taken:
                        self._outcome = Outcome("rejected", why=f"{self.action} has not taken the goal")
                        break
                    if self._late:
                        break
                    self._late = True
                    self._cancel()
                if self._cancelled and cancelling is None:
                    cancelling = asyncio.create_task(self._keep_cancelling(lines))
                self._news.clear()
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._news.wait(), min(limits) - now if limits else None)
        finally:
            for task in (hearing, looking, cancelling):
                if task is not None:
                    task.cancel()
        if self._late:
            return Outcome("timed_out", why=f"{self.action} took longer than {self.limit_s:g} s")
        return self._outcome or Outcome("lost", why="nobody knows how it ended")

    def seen(self, id: Id, stamp: int) -> None:
        """Its server has taken a goal that may be this one."""
        self._taken = True
        self._server_ids[id] = stamp
        self._news.set()

    def over(self, id: Id) -> None:
        """A goal that might be this one has ended. Where nothing is heard of this one, it was somebody else's."""
        if self._server_ids.pop(id, None) is not None and not self._server_ids and not self._has_feedback:
            self._taken, self._accept_by = False, asyncio.get_running_loop().time() + ACCEPT_S
            self._news.set()

    def _end(self, outcome: Outcome) -> None:
        self._outcome = self._outcome or outcome
        self._news.set()

    async def _hear(self, line: Line, statuses: Statuses) -> None:
        try:
            async for heard in line.heard():
                if heard.get("op") == "status" and "send_action_goal" in str(heard.get("msg")):
                    self._end(Outcome("no_server", why="this bridge knows no actions"))
                if heard.get("id") != self.id:
                    continue
                values = heard.get("values")
                if heard.get("op") == "action_feedback" and isinstance(values, dict):
                    self._taken = self._has_feedback = True
                    self._heard_at = asyncio.get_running_loop().time()
                    statuses.forget(self)  # it was taken before: what is taken from now on is not this one
                    self.feedback(values)
                elif heard.get("op") == "action_result":
                    self._end(self._of_result(heard, values))
            self._end(Outcome("lost", why="the bridge has closed the connection"))
        except GONE as error:
            self._end(Outcome("lost", why=why(error)))

    def _of_result(self, heard: dict[str, Any], values: object) -> Outcome:
        code = CODES.get(heard.get("status")) if heard.get("result") else None
        if code is not None and isinstance(values, dict):
            return Outcome(code, values, "" if code == "succeeded" else f"{self.action} has {code} it")
        told = str(values)
        if "rejected" in told:
            return Outcome("rejected", why=told[:200])
        return Outcome(*_what_failed(told, f"there is no action {self.action}"))

    async def _look(self, lines: Lines) -> None:
        """End it when its server is gone: the bridge would wait for ever."""
        while True:
            await asyncio.sleep(_LOOK_S)
            if asyncio.get_running_loop().time() - self._heard_at < _LOOK_S:
                continue  # it lives
            if await self._server_gone(lines) is not None:
                self._end(Outcome("lost", why=f"the server of {self.action} is gone"))
                return

    async def _server_gone(self, lines: Lines) -> Outcome | None:
        """How it ends because nobody serves it; None where somebody does. Whoever is there answers that there is no
        such goal to cancel."""
        outcome = await call(lines, cancel_service(self.action), cancel_request(uuid.uuid4().bytes), ACCEPT_S)
        if outcome.code == "no_server":
            return Outcome("no_server", why=f"nobody serves {self.action}")
        return outcome if outcome.code in ("lost", "timed_out") else None

    async def _keep_cancelling(self, lines: Lines) -> None:
        """Until somebody ends this task: a bridge forgets what it is told before the server has the goal."""
        while True:
            if self._server_ids:
                request = cancel_request(bytes(max(self._server_ids, key=self._server_ids.__getitem__)))
                await call(lines, cancel_service(self.action), request, ACCEPT_S)
            await asyncio.sleep(CANCEL_AGAIN_S)
            self.told(self._order_to_cancel)


class Statuses:
    """What the status topic of one action says. It tells no goal by whose it is: one that is taken while a single one
    of ours is expected may be that one, the newest most likely; of several of ours, each gets one in turn."""

    def __init__(self) -> None:
        self._known: set[Id] = set()
        self._expecting: list[Goal] = []
        self._given: dict[Id, Goal] = {}

    def expect(self, goal: Goal) -> None:
        """From now on it may be taken."""
        self._expecting.append(goal)

    def forget(self, goal: Goal) -> None:
        """From now on nothing that is taken is this one."""
        if goal in self._expecting:
            self._expecting.remove(goal)

    def hear(self, message: Message) -> None:
        """A ``GoalStatusArray``."""
        with contextlib.suppress(KeyError, TypeError, ValueError):
            now = {_id_of(status): status for status in message["status_list"]}
            states = {id: int(status["status"]) for id, status in now.items()}
            stamps = {id: nanoseconds(status["goal_info"].get("stamp")) for id, status in now.items()}
            new = [id for id, state in states.items() if id not in self._known and state in (ACCEPTED, EXECUTING)]
            self._known = set(now)
            for id in [id for id in self._given if states.get(id) not in UNDER_WAY]:
                self._given.pop(id).over(id)
            for id in sorted(new, key=stamps.__getitem__):
                if self._expecting:
                    self._give(id, stamps[id])

    def _give(self, id: Id, stamp: int) -> None:
        goal = self._expecting[0]
        if len(self._expecting) > 1:
            self.forget(goal)
        self._given[id] = goal
        goal.seen(id, stamp)


def _id_of(status: Message) -> Id:
    found = status["goal_info"]["goal_id"]["uuid"]
    return tuple(octets(found) or found)


class _Unfinished(Exception):
    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.code)
        self.outcome = outcome


def _new_id() -> str:
    return f"sayso:{uuid.uuid4().hex}"
