"""Each test runs with each of the three ways into a graph that this machine has."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from engine.ros.door import Door, Outcome
from tests.ros import environment
from tests.ros.ways import ByRclpy, ByRosbridge, ByZenoh, Way

LIMIT_S = 20.0
"""In which what a test waits for has happened, on a busy machine, too."""
AGAIN_S = 0.1

WAYS: dict[str, Callable[[], Way]] = {"rosbridge": ByRosbridge, "zenoh": ByZenoh, "rclpy": ByRclpy}


def needs_ros() -> None:
    """Skip where there is no ROS for tests."""
    if why := environment.missing():
        _skip(why)


def _skip(why: str) -> None:
    if os.environ.get("TEST_ROS") == "required":
        pytest.fail(why)
    pytest.skip(why)


@pytest.fixture(scope="session", params=WAYS)
def way(request: pytest.FixtureRequest) -> Iterator[Way]:
    """What runs for one way."""
    if request.param != "zenoh":
        needs_ros()
    if request.param == "rosbridge" and environment.bridge() is None:
        pytest.skip(f"The published rosbridge is no wheel: {environment.BRIDGE} says in which folder it is.")
    way = WAYS[request.param]()
    yield way
    way.close()


@pytest.fixture(scope="session")
def door(way: Way) -> Iterator[Door]:
    """A door that all tests of one way share."""
    door = way.open()
    until_called(door, "/peer/set", "std_srvs/srv/SetBool", "succeeded")
    yield door
    door.close()


class Ending:
    """Gets one outcome."""

    def __init__(self) -> None:
        self._outcomes: queue.SimpleQueue[Outcome] = queue.SimpleQueue()

    def __call__(self, outcome: Outcome) -> None:
        self._outcomes.put(outcome)

    def outcome(self) -> Outcome:
        """Once it is there."""
        return self._outcomes.get(timeout=LIMIT_S)

    @property
    def is_there(self) -> bool:
        return not self._outcomes.empty()


def until_heard(heard: queue.SimpleQueue[Any], do: Callable[[], object]) -> Any:
    """Do it again and again, until something is heard: nodes need a moment to find each other."""
    end = time.monotonic() + LIMIT_S
    while time.monotonic() < end:
        do()
        try:
            return heard.get(timeout=AGAIN_S)
        except queue.Empty:
            continue
    raise AssertionError("nothing has been heard")


def until(holds: Callable[[], object]) -> None:
    """Wait until this holds; a door has no event for it."""
    end, never = time.monotonic() + LIMIT_S, threading.Event()
    while not holds():
        assert time.monotonic() < end
        never.wait(AGAIN_S / 2)


def until_called(door: Door, service: str, type: str, code: str) -> None:
    """Call again and again, until it ends so: nodes need a moment to find and to miss each other."""
    end, codes = time.monotonic() + LIMIT_S, [""]
    while codes[-1] != code and time.monotonic() < end:
        ending = Ending()
        door.call(service, type, {}, ending, limit_s=1.0)
        codes.append(ending.outcome().code)
    assert codes[-1] == code, codes
