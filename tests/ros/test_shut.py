"""What becomes of subscriptions, servers and goals when a door is shut, and when what is behind it is gone."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from engine.ros.door import Door
from tests.ros.conftest import LIMIT_S, Ending, until, until_called, until_heard
from tests.ros.peers import FIBONACCI
from tests.ros.ways import Way

STRING, SET = "std_msgs/msg/String", "std_srvs/srv/SetBool"


@pytest.fixture
def own(way: Way) -> Iterator[Door]:
    """A door for one test."""
    door = way.open()
    until_called(door, "/peer/set", SET, "succeeded")
    yield door
    door.close()


def begin(door: Door) -> Ending:
    """A goal that is under way, and keeps its peer busy no longer than a test needs."""
    ending, under_way = Ending(), threading.Event()
    door.send_goal("/peer/slow", FIBONACCI, {"order": 300}, ending, feedback=lambda message: under_way.set())
    assert under_way.wait(LIMIT_S)
    return ending


def test_what_has_not_ended_when_a_door_is_closed_is_lost(way: Way, own: Door) -> None:
    goal, call = begin(own), Ending()
    own.call("/peer/mute", "std_srvs/srv/Trigger", {}, call, limit_s=60.0)
    own.close()
    assert goal.outcome().code == "lost"
    assert call.outcome().code == "lost"


def test_what_is_published_last_goes_out(way: Way, own: Door) -> None:
    heard = way.peer.listen("/last", STRING)
    until_heard(heard, lambda: own.publish("/last", STRING, {"data": "first"}))
    own.publish("/last", STRING, {"data": "last"})
    own.close()
    said = ""
    while said != "last":
        said = heard.get(timeout=LIMIT_S)["data"]


def test_what_a_closed_door_served_is_not_there_any_more(way: Way, own: Door) -> None:
    own.serve("/own/set", SET, lambda message, reply: reply({"success": True, "message": ""}))
    assert way.peer.call("/own/set", SET, {"data": True}).get(timeout=LIMIT_S) is not None
    own.close()
    answer: Any = True
    for _ in range(8):
        with contextlib.suppress(queue.Empty):  # it was there, but not long enough to answer
            answer = way.peer.call("/own/set", SET, {"data": True}, limit_s=1.0).get(timeout=2.0)
        if answer is None:
            break
    assert answer is None


def test_all_holds_when_the_way_is_cut_and_mended(way: Way, own: Door) -> None:
    if way.name == "rclpy":
        pytest.skip("Nothing lies between a node and its graph.")
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    own.subscribe("/news", STRING, heard.put)
    own.serve("/held/set", SET, lambda message, reply: reply({"success": True, "message": "held"}))
    until_heard(heard, lambda: way.peer.publish("/news", STRING, {"data": "before"}))
    goal, call = begin(own), Ending()
    own.call("/peer/mute", "std_srvs/srv/Trigger", {}, call, limit_s=60.0)
    way.cut()
    assert goal.outcome().code == "lost"
    assert call.outcome().code == "lost"
    until(lambda: own.trouble)
    way.mend()
    while until_heard(heard, lambda: way.peer.publish("/news", STRING, {"data": "after"}))["data"] != "after":
        pass
    until(lambda: not own.trouble)
    response = None
    for _ in range(8):
        with contextlib.suppress(queue.Empty):  # it was the one of the killed bridge, not missed yet
            response = way.peer.call("/held/set", SET, {"data": True}).get(timeout=2.0)
        if response is not None:
            break
    assert response == {"success": True, "message": "held"}
    way.peer.close()  # to it the killed bridge lives on for a while, which keeps it from hearing the new one
    way.new_peer()
