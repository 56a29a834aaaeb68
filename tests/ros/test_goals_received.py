"""Goals that peers send to us through each door."""

from __future__ import annotations

import itertools
import queue

import pytest

from engine.ros.door import Door, Execution
from tests.ros.conftest import LIMIT_S
from tests.ros.peers import FIBONACCI
from tests.ros.ways import Way

_NUMBERS = itertools.count()


class Work:
    """Takes goals, or none, and leaves it to the test what becomes of them."""

    def __init__(self, takes: bool = True) -> None:
        self._takes = takes
        self.begun: queue.SimpleQueue[Execution] = queue.SimpleQueue()
        self.cancelled: queue.SimpleQueue[Execution] = queue.SimpleQueue()

    def begin(self, execution: Execution) -> bool:
        self.begun.put(execution)
        return self._takes

    def cancel(self, execution: Execution) -> None:
        self.cancelled.put(execution)


@pytest.fixture
def action() -> str:
    """A name that no other test uses."""
    return f"/ours/act_{next(_NUMBERS)}"


def test_a_peer_gets_feedback_and_the_result(way: Way, door: Door, action: str) -> None:
    work = Work()
    door.serve_action(action, FIBONACCI, work)
    goal = way.peer.goal(action, FIBONACCI, {"order": 4})
    execution = work.begun.get(timeout=LIMIT_S)
    assert execution.goal["order"] == 4
    execution.feedback({"sequence": [0, 1]})
    assert list(goal.feedback.get(timeout=LIMIT_S)["sequence"]) == [0, 1]
    execution.end("succeeded", {"sequence": [0, 1, 1]})
    how, result = goal.ended.get(timeout=LIMIT_S)
    assert (how, list(result["sequence"])) == ("succeeded", [0, 1, 1])


def test_only_the_first_end_counts(way: Way, door: Door, action: str) -> None:
    work = Work()
    door.serve_action(action, FIBONACCI, work)
    goal = way.peer.goal(action, FIBONACCI, {"order": 4})
    execution = work.begun.get(timeout=LIMIT_S)
    execution.end("aborted", {"sequence": [1]})
    execution.end("succeeded", {"sequence": [2]})
    how, result = goal.ended.get(timeout=LIMIT_S)
    assert (how, list(result["sequence"])) == ("aborted", [1])


def test_a_peer_cancels(way: Way, door: Door, action: str) -> None:
    work = Work()
    door.serve_action(action, FIBONACCI, work)
    goal = way.peer.goal(action, FIBONACCI, {"order": 4})
    execution = work.begun.get(timeout=LIMIT_S)
    goal.cancel()
    assert work.cancelled.get(timeout=LIMIT_S) is execution
    execution.end("canceled", {"sequence": [0]})
    how, result = goal.ended.get(timeout=LIMIT_S)
    assert (how, list(result["sequence"])) == ("canceled", [0])


def test_a_goal_that_a_peer_cancels_may_still_succeed(way: Way, door: Door, action: str) -> None:
    work = Work()
    door.serve_action(action, FIBONACCI, work)
    goal = way.peer.goal(action, FIBONACCI, {"order": 4})
    execution = work.begun.get(timeout=LIMIT_S)
    goal.cancel()
    work.cancelled.get(timeout=LIMIT_S)
    execution.end("succeeded", {"sequence": [0, 1]})
    assert goal.ended.get(timeout=LIMIT_S)[0] == "succeeded"


def test_a_peer_is_refused(way: Way, door: Door, action: str) -> None:
    work = Work(takes=False)
    door.serve_action(action, FIBONACCI, work)
    goal = way.peer.goal(action, FIBONACCI, {"order": 4})
    work.begun.get(timeout=LIMIT_S)
    if way.name == "rosbridge":  # a bridge takes all goals, and aborts what is refused
        assert goal.ended.get(timeout=LIMIT_S)[0] == "aborted"
    else:
        assert goal.accepted.get(timeout=LIMIT_S) is False


def test_goals_of_one_action_run_side_by_side(way: Way, door: Door, action: str) -> None:
    work = Work()
    door.serve_action(action, FIBONACCI, work)
    goals = {order: way.peer.goal(action, FIBONACCI, {"order": order}) for order in (1, 2)}
    executions = [work.begun.get(timeout=LIMIT_S) for _ in goals]
    for execution in reversed(executions):
        execution.end("succeeded", {"sequence": [execution.goal["order"]]})
    for order, goal in goals.items():
        assert list(goal.ended.get(timeout=LIMIT_S)[1]["sequence"]) == [order]
