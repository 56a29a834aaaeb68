"""Goals that we send through each door."""

from __future__ import annotations

import queue
import threading
import time
from typing import Any

from engine.ros.door import ACCEPT_S, Door
from tests.ros.conftest import LIMIT_S, Ending, until_called
from tests.ros.peers import FIBONACCI
from tests.ros.ways import Way

LONG = {"order": 100_000}
"""A goal that nobody waits for the end of."""


def test_a_goal_is_carried_out_with_feedback(way: Way, door: Door) -> None:
    ending, heard = Ending(), queue.SimpleQueue[Any]()
    door.send_goal("/peer/slow", FIBONACCI, {"order": 6}, ending, feedback=heard.put)
    outcome = ending.outcome()
    assert outcome.code == "succeeded", outcome.why
    assert list(outcome.result["sequence"]) == [0, 1, 1, 2, 3, 5, 8, 13]
    assert list(heard.get(timeout=LIMIT_S)["sequence"])[:2] == [0, 1]


def test_two_goals_at_the_same_time_have_their_own_ends(way: Way, door: Door) -> None:
    endings = {order: Ending() for order in (12, 3)}
    for order, ending in endings.items():
        door.send_goal("/peer/slow", FIBONACCI, {"order": order}, ending)
    lengths = {order: len(ending.outcome().result["sequence"]) for order, ending in endings.items()}
    assert lengths == {12: 14, 3: 5}


def test_a_goal_is_cancelled_in_mid_flight(way: Way, door: Door) -> None:
    ending, under_way = Ending(), threading.Event()
    goal = door.send_goal("/peer/slow", FIBONACCI, LONG, ending, feedback=lambda message: under_way.set())
    assert under_way.wait(LIMIT_S)
    began = time.monotonic()
    goal.cancel()
    goal.cancel()
    outcome = ending.outcome()
    assert outcome.code == "canceled"
    assert len(outcome.result["sequence"]) > 2
    assert time.monotonic() - began < 3.0


def test_a_goal_that_is_cancelled_at_once_ends_so(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/slow", FIBONACCI, LONG, ending).cancel()
    assert ending.outcome().code == "canceled"


def test_a_goal_that_is_refused_is_told(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/picky", FIBONACCI, {"order": 3}, ending)
    outcome = ending.outcome()
    assert outcome.code == "rejected"
    assert outcome.why


def test_a_goal_that_fails_is_told_with_its_result(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/failing", FIBONACCI, {"order": 9}, ending)
    outcome = ending.outcome()
    assert outcome.code == "aborted"
    assert list(outcome.result["sequence"]) == [0, 1, 1, 2]


def test_an_action_that_nobody_serves_is_told(way: Way, door: Door) -> None:
    ending, began = Ending(), time.monotonic()
    door.send_goal("/nobody/acts", FIBONACCI, {"order": 3}, ending)
    assert ending.outcome().code == "no_server"
    assert time.monotonic() - began < 2 * ACCEPT_S


def test_a_goal_that_lasts_too_long_is_cancelled(way: Way, door: Door) -> None:
    ending, more = Ending(), Ending()
    door.send_goal("/peer/slow", FIBONACCI, LONG, ending, limit_s=1.0)
    assert ending.outcome().code == "timed_out"
    door.send_goal("/peer/slow", FIBONACCI, {"order": 2}, more)
    assert more.outcome().code == "succeeded"


def test_a_server_that_ignores_a_cancel_finishes(way: Way, door: Door) -> None:
    ending, under_way = Ending(), threading.Event()
    goal = door.send_goal("/peer/stubborn", FIBONACCI, {"order": 30}, ending, feedback=lambda message: under_way.set())
    assert under_way.wait(LIMIT_S)
    goal.cancel()
    outcome = ending.outcome()
    assert outcome.code == "succeeded", outcome.why
    assert len(outcome.result["sequence"]) == 32


def test_a_server_that_ignores_a_cancel_is_given_up_in_time(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/stubborn", FIBONACCI, {"order": 500}, ending, limit_s=0.5)
    assert ending.outcome().code == "timed_out"


def test_an_action_of_a_type_that_is_known_nowhere_is_told(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/slow", "no_such_msgs/action/Nothing", {}, ending)
    outcome = ending.outcome()
    assert outcome.code in ("bad_type", "rejected")
    assert outcome.why


def test_a_server_that_dies_in_mid_flight_is_told(way: Way, door: Door) -> None:
    ending = Ending()
    door.send_goal("/peer/dying", FIBONACCI, LONG, ending)
    outcome = ending.outcome()
    assert outcome.code == "lost"
    assert outcome.why
    way.new_peer()
    until_called(door, "/peer/set", "std_srvs/srv/SetBool", "succeeded")
