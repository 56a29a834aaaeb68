"""Goals of ``execute_plan``: each becomes a request to the session, like any other, and ends exactly once.

What the session does with requests that come while one is carried out (``session.busy``) holds for goals, too. A goal
that is cancelled while its turn runs interrupts it, there and then; one that only waits is withdrawn.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from ulid import ULID

from engine import events
from engine.commands import Command, Interrupt, Say, Withdraw
from engine.errors import SaysoError, one_line
from engine.events import Event, TurnResult
from engine.graph.complaints import Complaints
from engine.graph.messages import action_over, call_told, goal_over, goal_refused, read_plan, whole
from engine.ros.door import End, Execution, Message
from engine.skills.registry import SkillRegistry
from engine.strict_json import read_json

WAITING: Final = 8
"""Goals that may wait for their turn."""
MOST_ID: Final = 200
"""Characters of the id of a goal on a topic."""


@dataclass(slots=True, eq=False)
class _Goal:
    """A goal that has not ended."""

    execution: Execution
    id: str  # of the request
    begun: bool = False  # the session has taken it
    turn: str | None = None
    cancelled: bool = False
    results: list[dict[str, Any]] = field(default_factory=list)


class Goals:
    """Carries out goals that peers send, a :class:`engine.ros.door.Work`. Thread-safe; :meth:`see` is for the bus.

    ``busy`` is what the session does with a request that comes while one is carried out.
    """

    def __init__(
        self, ask: Callable[[Command], object], registry: SkillRegistry, busy: str, complain: Complaints
    ) -> None:
        self._ask = ask
        self._registry = registry
        self._busy = busy
        self._complain = complain
        self._lock = threading.Lock()  # held for moments only: nobody is called meanwhile
        self._goals: dict[str, _Goal] = {}  # by the id of the request
        self._closed = False

    # What doors call

    def begin(self, execution: Execution) -> bool:
        if self._closed:
            return False
        try:
            asked = read_plan(execution.goal.get("plan"), self._registry)
        except SaysoError as error:
            self._complain(f"A goal was refused: {one_line(str(error))}")
            execution.end("aborted", goal_refused(error))
            return True
        except Exception as error:  # noqa: BLE001 - nothing raises in the door's thread
            self._complain(f"A goal was refused: {one_line(repr(error))}")
            execution.end("aborted", goal_over("failed", f"A fault in sayso itself: {error!r}."))
            return True
        goal = _Goal(execution, str(ULID()))
        with self._lock:
            is_full = sum(not other.begun for other in self._goals.values()) >= WAITING
            if not is_full:
                self._goals[goal.id] = goal
        if is_full:
            why = f"{WAITING} goals wait already."
            self._complain(f"A goal was refused: {why}")
            execution.end("aborted", goal_over("refused", why))
            return True
        self._ask(Say(asked.text, id=goal.id))
        return True

    def cancel(self, execution: Execution) -> None:
        with self._lock:
            goal = next((goal for goal in self._goals.values() if goal.execution is execution), None)
            if goal is None:
                return
            goal.cancelled = True
            begun = goal.begun
        self._ask(Interrupt() if begun else Withdraw(goal.id))

    # What becomes of them

    def see(self, event: Event) -> None:
        """Follow what happens. A turn is known by the acknowledgement of its request."""
        match event.body:
            case events.Ack(do="say", id=id, ok=ok, message=message) if id in self._goals:
                self._acknowledged(self._goals[id], event.turn, message, ok=ok)
            case events.ActionStarted(index=index, total=total, name=name, args=args):
                if (goal := self._of(event)) is not None:
                    doing = f"executing step {index} of {total}: {call_told(name, args, self._registry)}"
                    goal.execution.feedback({"step": index, "steps": total, "message": whole(doing)})
            case events.ActionFinished() as done:
                if (goal := self._of(event)) is not None:
                    goal.results.append(action_over(done, self._registry))
            case events.StateChanged(result=result) if result is not None:
                if (goal := self._of(event)) is not None:
                    self._over(goal, result)

    def close(self) -> None:
        """Whatever has not ended ends here, and nothing begins any more."""
        self._closed = True
        for goal in tuple(self._goals.values()):
            self._end(goal, "interrupted", "The session ends.")

    def _acknowledged(self, goal: _Goal, turn: str | None, message: str, *, ok: bool) -> None:
        if not ok:
            busy = self._busy == "reject" and not goal.cancelled
            self._end(goal, "refused" if busy else "interrupted", message)
            return
        with self._lock:
            goal.begun, goal.turn = True, turn
            cancelled = goal.cancelled
        if cancelled:  # in this moment: nothing of it has moved yet
            self._ask(Interrupt())

    def _of(self, event: Event) -> _Goal | None:
        """The goal that an event belongs to. The end of a task has no turn; it comes right after its
        acknowledgement."""
        return next((goal for goal in tuple(self._goals.values()) if goal.begun and goal.turn == event.turn), None)

    def _over(self, goal: _Goal, result: TurnResult) -> None:
        outcome = "failed" if result.outcome == "unheard" else result.outcome
        self._end(goal, outcome, result.message)

    def _end(self, goal: _Goal, outcome: str, message: str) -> None:
        with self._lock:
            if self._goals.pop(goal.id, None) is None:
                return
        how: End = "succeeded" if outcome == "done" else "aborted"
        if goal.cancelled and outcome == "interrupted":
            how = "canceled"
        goal.execution.end(how, goal_over(outcome, message, goal.results))


class TopicGoals:
    """The same goals for peers that have no ``sayso_interfaces``: JSON in Strings, each with an ``id``."""

    def __init__(self, goals: Goals, feedback: Callable[[Message], None], result: Callable[[Message], None]) -> None:
        """``feedback`` and ``result`` publish an object."""
        self._goals = goals
        self._feedback = feedback
        self._result = result
        self._running: dict[str | int, _TopicExecution] = {}

    def begin(self, wanted: dict[str, Any]) -> None:
        """``{"id": …, "plan": …}``: the plan is a text, or an object or a list in its place."""
        id = wanted.get("id")
        if isinstance(id, bool) or not isinstance(id, str | int) or len(str(id)) > MOST_ID:
            self._result({"id": None, "status": "aborted", **_unpacked(goal_over("refused", "It has no id."))})
            return
        if id in self._running:
            why = "A goal with this id is carried out already; this one is not."
            self._result({"id": id, "status": "rejected", **_unpacked(goal_over("refused", why))})
            return
        execution = _TopicExecution(wanted, id, self._feedback, self._over)
        self._running[id] = execution
        self._goals.begin(execution)

    def cancel(self, wanted: dict[str, Any]) -> bool:
        """``{"id": …}``; whether there is such a goal."""
        id = wanted.get("id")
        execution = self._running.get(id) if isinstance(id, str | int) else None
        if execution is not None:
            self._goals.cancel(execution)
        return execution is not None

    def _over(self, id: str | int, how: End, result: Message) -> None:
        self._running.pop(id, None)
        self._result({"id": id, "status": how, **_unpacked(result)})


class _TopicExecution:
    """A goal that came in a String, an :class:`engine.ros.door.Execution`."""

    def __init__(
        self,
        goal: Message,
        id: str | int,
        feedback: Callable[[Message], None],
        over: Callable[[str | int, End, Message], None],
    ) -> None:
        self.goal = goal
        self._id = id
        self._feedback = feedback
        self._over = over

    def feedback(self, message: Message) -> None:
        self._feedback({"id": self._id, **message})

    def end(self, how: End, result: Message) -> None:  # Goals does so once
        self._over(self._id, how, result)


def _unpacked(result: Message) -> dict[str, Any]:
    """The result with its list in place of the JSON of it."""
    return {**result, "results": read_json(result["results"])}
