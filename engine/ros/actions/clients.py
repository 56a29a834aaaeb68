"""Goals that we send to the actions of peers."""

from __future__ import annotations

import math
import uuid
from collections.abc import Callable
from dataclasses import dataclass

from engine.ros.actions.parts import CANCEL, CANCEL_AGAIN_S, CODES, Carrier, cancel_request, goal_id, id_of
from engine.ros.door import ACCEPT_S, Goal, Message, Outcome, Take, Then


class ActionClients:
    """Goals of ours. Thread-safe."""

    def __init__(self, carrier: Carrier) -> None:
        self._carrier = carrier
        self._goals: dict[bytes, SentGoal] = {}
        self._heard: set[tuple[str, str]] = set()  # actions whose feedback is heard, with their types

    def prepare(
        self, action: str, type: str, goal: Message, then: Then, feedback: Take, limit_s: float | None
    ) -> SentGoal:
        """A goal that is sent when it is begun."""

        def over(outcome: Outcome) -> None:
            self._goals.pop(sent.id, None)
            then(outcome)

        def begun() -> None:
            self._goals[sent.id] = sent
            if (action, type) not in self._heard:
                self._heard.add((action, type))
                self._carrier.subscribe(f"{action}/_action/feedback", f"{type}_FeedbackMessage", self._hear)

        sent = SentGoal(_Order(action, type, goal, feedback, limit_s), self._carrier, over, begun)
        return sent

    def _hear(self, message: Message) -> None:
        goal = self._goals.get(id_of(message))
        if goal is not None and isinstance(told := message.get("feedback"), dict):
            goal.feedback(told)


@dataclass(frozen=True, slots=True)
class _Order:
    """What is wanted of an action."""

    action: str
    type: str
    goal: Message
    feedback: Take
    limit_s: float | None


class SentGoal:
    """A :class:`engine.ros.door.Goal`. All but :meth:`cancel` runs in the door's thread."""

    def __init__(self, order: _Order, carrier: Carrier, then: Then, begun: Callable[[], object]) -> None:
        self.id = uuid.uuid4().bytes
        self.feedback = order.feedback
        self._order = order
        self._carrier = carrier
        self._then: Then | None = then
        self._begun = begun
        self._accepted = False
        self._unwanted = False
        self._stop_timer: Callable[[], object] = lambda: None

    def begin(self) -> None:
        """Send it."""
        self._begun()
        if (limit_s := self._order.limit_s) is not None:
            self._stop_timer = self._carrier.later(limit_s, lambda: self._time_out(limit_s))
        request = {**goal_id(self.id), "goal": self._order.goal}
        service = f"{self._order.type}_SendGoal"
        self._call("send_goal", service, request, self._hear_accepted, wanted=lambda: not self._unwanted)

    def cancel(self) -> None:
        self._carrier.soon(self._cancel)

    def _cancel(self) -> None:
        if self._unwanted:
            return
        self._unwanted = True
        if self._accepted:
            self._keep_cancelling()

    def _hear_accepted(self, outcome: Outcome) -> None:
        if outcome.code == "timed_out":
            # It may still take the goal, which nobody wants any more
            self._ask_to_cancel()
        if outcome.code != "succeeded":
            self._end(Outcome(outcome.code, why=outcome.why))
        elif not outcome.result.get("accepted"):
            self._end(Outcome("rejected", why=f"the server of {self._order.action} has rejected it"))
        else:
            self._accepted = True
            if self._unwanted:
                self._keep_cancelling()
            if self._then is not None:
                request, service = goal_id(self.id), f"{self._order.type}_GetResult"
                self._call("get_result", service, request, self._hear_result, math.inf)

    def _hear_result(self, outcome: Outcome) -> None:
        if outcome.code != "succeeded":
            self._end(Outcome(outcome.code, why=outcome.why))
            return
        result, status = outcome.result.get("result"), outcome.result.get("status")
        if (code := CODES.get(status)) is None:
            self._end(Outcome("lost", why=f"the server of {self._order.action} does not know this goal any more"))
        else:
            why = "" if code == "succeeded" else f"the server of {self._order.action} has {code} it"
            self._end(Outcome(code, result if isinstance(result, dict) else {}, why))

    def _time_out(self, limit_s: float) -> None:
        self._cancel()
        self._end(Outcome("timed_out", why=f"it has not ended within {limit_s:g} s"))

    def _end(self, outcome: Outcome) -> None:
        then, self._then = self._then, None
        if then is not None:
            self._stop_timer()
            then(outcome)

    def _keep_cancelling(self) -> None:
        """Until it has ended."""
        self._ask_to_cancel()
        self._carrier.later(CANCEL_AGAIN_S, self._cancel_again)

    def _cancel_again(self) -> None:
        if self._then is not None:
            self._keep_cancelling()

    def _ask_to_cancel(self) -> None:
        self._call("cancel_goal", CANCEL, cancel_request(self.id), lambda outcome: None)

    def _call(
        self,
        part: str,
        type: str,
        request: Message,
        then: Then,
        limit_s: float = ACCEPT_S,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        service = f"{self._order.action}/_action/{part}"
        self._carrier.call(service, type, request, then, limit_s=limit_s, wanted=wanted)


_CHECKED: type[Goal] = SentGoal
