"""A goal of ours that nobody wants any more, over a door that knows only topics and services."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from engine.ros.actions.clients import ActionClients
from engine.ros.door import Message, Outcome, Reply, Take, Then


class Table:
    """A carrier that a test holds in its hand."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Then, Callable[[], bool]]] = []
        self.due: list[Callable[[], object]] = []

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False, latched: bool = False) -> None:
        raise AssertionError("no client does")

    def advertise(self, topic: str, type: str, *, latched: bool = False) -> None:
        raise AssertionError("no client does")

    def subscribe(self, topic: str, type: str, take: Take) -> None:
        """Nothing is fed back here."""

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
        self.calls.append((service.rsplit("/", 1)[-1], then, wanted))

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        raise AssertionError("no client does")

    def soon(self, act: Callable[[], object]) -> object:
        return act()

    def later(self, delay_s: float, act: Callable[[], object]) -> Callable[[], object]:
        self.due.append(act)
        return lambda: None

    def asked(self) -> list[str]:
        return [name for name, _, _ in self.calls]


def begun() -> tuple[Table, Any, list[Outcome]]:
    table, ends = Table(), list[Outcome]()
    goal = ActionClients(table).prepare("/act", "a/action/B", {}, ends.append, lambda message: None, None)
    goal.begin()
    return table, goal, ends


def test_one_that_is_cancelled_while_its_server_is_looked_for_is_not_sent() -> None:
    table, goal, ends = begun()
    [(name, then, wanted)] = table.calls
    assert name == "send_goal"
    assert wanted()
    goal.cancel()
    assert not wanted()
    then(Outcome("canceled"))
    assert [end.code for end in ends] == ["canceled"]
    assert table.asked() == ["send_goal"]


def test_one_that_is_under_way_is_cancelled_again_until_it_has_ended() -> None:
    table, goal, ends = begun()
    table.calls[0][1](Outcome("succeeded", {"accepted": True}))
    assert table.asked() == ["send_goal", "get_result"]
    goal.cancel()
    goal.cancel()
    for _ in range(2):
        table.due.pop()()
    assert table.asked()[2:] == ["cancel_goal"] * 3
    table.calls[1][1](Outcome("succeeded", {"status": 5, "result": {}}))
    assert [end.code for end in ends] == ["canceled"]
    table.due.pop()()
    assert table.asked()[5:] == []
