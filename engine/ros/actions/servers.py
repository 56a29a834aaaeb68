"""Goals that peers send to our actions."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Final

from engine.ros.actions.parts import (
    ALL,
    CANCEL,
    CANCELING,
    ENDS,
    EXECUTING,
    STATUS,
    Carrier,
    cancel_service,
    goal_id,
    id_of,
    nanoseconds,
)
from engine.ros.door import End, Execution, Message, Reply, Work

KEEP_S: Final = 60.0
"""How long a result waits for somebody who asks for it."""

_REJECTED, _UNKNOWN, _TERMINATED = 1, 2, 3  # why a goal is not cancelled (action_msgs/srv/CancelGoal)


class ActionServers:
    """What we carry out for peers."""

    def __init__(self, carrier: Carrier) -> None:
        self._carrier = carrier
        self._servers: dict[str, _ActionServer] = {}

    def serve(self, action: str, type: str, work: Work) -> None:
        """Carry out the goals of an action; in the door's thread."""
        self._servers[action] = _ActionServer(self._carrier, action, type, work)

    def give_up(self) -> None:
        """Nobody hears any more how goals end: have them ended."""
        for server in self._servers.values():
            server.give_up()


class _ActionServer:
    """One action. All but what :class:`_Execution` calls runs in the door's thread."""

    def __init__(self, carrier: Carrier, action: str, type: str, work: Work) -> None:
        self._carrier = carrier
        self._action = action
        self._type = type
        self._work = work
        self._goals: dict[bytes, _Execution] = {}
        # A client of rcl takes an action to be there only once these are advertised, too
        carrier.advertise(f"{action}/_action/feedback", f"{type}_FeedbackMessage")
        carrier.advertise(f"{action}/_action/status", STATUS, latched=True)
        carrier.serve(f"{action}/_action/send_goal", f"{type}_SendGoal", self._take)
        carrier.serve(f"{action}/_action/get_result", f"{type}_GetResult", self._get_result)
        carrier.serve(cancel_service(action), CANCEL, self._cancel)

    def give_up(self) -> None:
        for execution in tuple(self._goals.values()):
            if not execution.has_ended:
                self._work.cancel(execution)

    def _take(self, request: Message, reply: Reply) -> None:
        id, goal = id_of(request), request.get("goal")
        accepted = False
        execution = _Execution(self, id, goal if isinstance(goal, dict) else {})
        if len(id) == 16 and id not in self._goals:
            self._goals[id] = execution
            accepted = self._work.begin(execution)
            if not accepted:
                del self._goals[id]
        reply({"accepted": accepted, "stamp": execution.stamp})
        if accepted:
            execution.accept()
            self.tell_status()

    def _get_result(self, request: Message, reply: Reply) -> None:
        if (execution := self._goals.get(id_of(request))) is None:
            reply({"status": 0})
        else:
            execution.when_ended(lambda status, result: reply({"status": status, "result": result}))

    def _cancel(self, request: Message, reply: Reply) -> None:
        info: Any = request.get("goal_info")
        wanted, before = id_of(info), nanoseconds(info.get("stamp"))
        chosen = [
            execution
            for id, execution in self._goals.items()
            if id == wanted or (before and execution.since <= before) or (wanted == ALL and not before)
        ]
        cancelled = [execution for execution in chosen if execution.cancel()]
        code = 0
        if not cancelled and wanted != ALL:
            code = _UNKNOWN if wanted not in self._goals else _TERMINATED if chosen else _REJECTED
        reply({"return_code": code, "goals_canceling": [execution.info() for execution in cancelled]})
        if cancelled:
            self.tell_status()
        for execution in cancelled:
            self._work.cancel(execution)

    # What an execution does, in any thread

    def tell_feedback(self, id: bytes, message: Message) -> None:
        self._carrier.publish(
            f"{self._action}/_action/feedback",
            f"{self._type}_FeedbackMessage",
            {**goal_id(id), "feedback": message},
            every=True,
        )

    def end(self, id: bytes) -> None:
        self._carrier.soon(self.tell_status)
        self._carrier.later(KEEP_S, lambda: self._goals.pop(id, None))

    def tell_status(self) -> None:
        """In the door's thread."""
        states = [{"goal_info": one.info(), "status": one.status} for one in self._goals.values() if one.status]
        self._carrier.publish(
            f"{self._action}/_action/status", STATUS, {"status_list": states}, every=True, latched=True
        )


class _Execution:
    """An :class:`engine.ros.door.Execution`."""

    def __init__(self, server: _ActionServer, id: bytes, goal: Message) -> None:
        self.goal = goal
        self.since = time.time_ns()
        self.status = 0  # until it has been accepted
        self.stamp = {"sec": self.since // 10**9, "nanosec": self.since % 10**9}
        self._server = server
        self._id = id
        self._lock = threading.Lock()
        self._end: tuple[int, Message] | None = None
        self._asking: list[Callable[[int, Message], object]] = []

    @property
    def has_ended(self) -> bool:
        return self._end is not None

    def info(self) -> Message:
        return {**goal_id(self._id), "stamp": self.stamp}

    def accept(self) -> None:
        with self._lock:
            self.status = self._end[0] if self._end is not None else EXECUTING

    def cancel(self) -> bool:
        """Whether it is being cancelled now: not once it has ended."""
        with self._lock:
            if self._end is not None:
                return False
            self.status = CANCELING
            return True

    def when_ended(self, then: Callable[[int, Message], object]) -> None:
        with self._lock:
            if self._end is None:
                self._asking.append(then)
                return
        then(*self._end)

    def feedback(self, message: Message) -> None:
        if self._end is None:
            self._server.tell_feedback(self._id, message)

    def end(self, how: End, result: Message) -> None:
        with self._lock:
            if self._end is not None:
                return
            self._end = (ENDS[how], result)
            if self.status:
                self.status = ENDS[how]
            asking, self._asking = self._asking, []
        for then in asking:
            then(*self._end)
        self._server.end(self._id)


_CHECKED: type[Execution] = _Execution
