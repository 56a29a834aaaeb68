"""Services through each door, both ways."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from engine.ros.door import Door, Message, Reply
from tests.ros.conftest import LIMIT_S, Ending
from tests.ros.ways import Way

SET, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"


def test_a_service_answers(way: Way, door: Door) -> None:
    ending = Ending()
    door.call("/peer/set", SET, {"data": True}, ending)
    outcome = ending.outcome()
    assert (outcome.code, dict(outcome.result)) == ("succeeded", {"success": True, "message": "it was True"})


def test_calls_at_the_same_time_get_their_own_answers(way: Way, door: Door) -> None:
    endings = [Ending() for _ in range(6)]
    for index, ending in enumerate(endings):
        door.call("/peer/set", SET, {"data": index % 2 == 0}, ending)
    assert [ending.outcome().result["success"] for ending in endings] == [True, False] * 3


def test_a_service_that_is_not_there_is_told(way: Way, door: Door) -> None:
    ending = Ending()
    door.call("/nobody/there", TRIGGER, {}, ending)
    outcome = ending.outcome()
    assert outcome.code == "no_server"
    assert "/nobody/there" in outcome.why


def test_a_service_that_never_answers_is_given_up(way: Way, door: Door) -> None:
    ending = Ending()
    door.call("/peer/mute", TRIGGER, {}, ending, limit_s=1.0)
    assert ending.outcome().code == "timed_out"
    door.call("/peer/set", SET, {"data": True}, ending)
    assert ending.outcome().code == "succeeded"


def test_a_type_that_is_known_nowhere_is_told(way: Way, door: Door) -> None:
    if way.name == "rosbridge":
        pytest.skip("A bridge asks the graph for the type of a service, whatever it is told.")
    ending = Ending()
    door.call("/peer/set", "no_such_msgs/srv/Nothing", {}, ending)
    outcome = ending.outcome()
    assert outcome.code == "bad_type"
    assert outcome.why


def test_a_service_of_another_type_is_no_success(way: Way, door: Door) -> None:
    ending = Ending()
    door.call("/peer/mute", SET, {"data": True}, ending, limit_s=2.0)
    outcome = ending.outcome()
    assert outcome.code in ("bad_type", "no_server", "aborted", "timed_out")
    assert outcome.why


def test_a_request_that_does_not_fit_is_told(way: Way, door: Door) -> None:
    ending = Ending()
    door.call("/peer/set", SET, {"no_such_field": 1}, ending)
    assert ending.outcome().code in ("bad_type", "aborted")


def test_a_peer_gets_an_answer_that_comes_later_from_another_thread(way: Way, door: Door) -> None:
    asked: list[Message] = []

    def answer(message: Message, reply: Reply) -> None:
        asked.append(message)
        threading.Thread(target=reply, args=({"success": True, "message": "later"},)).start()

    door.serve("/ours/set", SET, answer)
    assert way.peer.call("/ours/set", SET, {"data": True}).get(timeout=LIMIT_S) == {
        "success": True,
        "message": "later",
    }
    assert asked == [{"data": True}]


def test_answers_may_come_in_another_order(way: Way, door: Door) -> None:
    waiting: list[Any] = []
    both = threading.Event()

    def answer(message: Message, reply: Reply) -> None:
        waiting.append((message["data"], reply))
        if len(waiting) == 2:
            both.set()

    door.serve("/ours/order", SET, answer)
    first, second = (way.peer.call("/ours/order", SET, {"data": data}) for data in (True, False))
    assert both.wait(LIMIT_S)
    for data, reply in reversed(waiting):
        reply({"success": data, "message": ""})
    assert first.get(timeout=LIMIT_S)["success"] is True
    assert second.get(timeout=LIMIT_S)["success"] is False
