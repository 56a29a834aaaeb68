"""A whole engine leaves nothing behind: no thread, process, open file or shared memory, whatever it was doing."""

from __future__ import annotations

import gc
import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest

from config import load
from engine import events
from engine.commands import Command, EndTask, Interrupt, Quit, Say, Wake
from engine.engine import Engine
from engine.events import Event
from engine.parts.loading import Sound
from tests.open_files import open_files

DEADLINE_S = 60.0
DDS = "fastrtps"
"""In the names of what other programs share that speak ROS 2; none of these sessions does."""


class Running:
    """An engine, and a way to wait for what it says."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self._seen: queue.SimpleQueue[Event] = queue.SimpleQueue()
        engine.subscribe(self._seen.put)

    def until(self, met: Callable[[events.Body], bool]) -> None:
        while not met(self._seen.get(timeout=DEADLINE_S).body):
            pass

    def do(self, text: str, met: Callable[[events.Body], bool]) -> None:
        self.engine.send(Say(text))
        self.until(met)


@contextmanager
def an_engine() -> Iterator[Running]:
    # In real time: a robot that is as fast as the machine may have arrived before anything tells that it moves.
    settings = load(overrides=["robot.speed=real", "session.record_log=true"], environ={})
    engine = Engine(settings, mode="test", sound=Sound("none"))
    running = Running(engine)
    engine.start()
    try:
        yield running
    finally:
        engine.send(Quit())
        assert engine.join(DEADLINE_S)


def moving(body: events.Body) -> bool:
    return isinstance(body, events.RobotStateView) and body.moving


def over(body: events.Body) -> bool:
    return isinstance(body, events.StateChanged) and body.result is not None


def listening(body: events.Body) -> bool:
    return isinstance(body, events.ListenStarted)


def traces() -> dict[str, object]:
    """What this process holds."""
    gc.collect()
    shared = Path("/dev/shm")
    return {
        "threads": sorted(thread.name for thread in threading.enumerate()),
        "files": open_files(),
        "processes": sorted(child.pid for child in psutil.Process().children(recursive=True)),
        "shared memory": sorted(path.name for path in shared.iterdir() if DDS not in path.name)
        if shared.is_dir()
        else [],
    }


def live(last: Command, during: str) -> None:
    """One session: something is said, a program runs, it is interrupted, and the last command comes in mid-drive."""
    with an_engine() as running:
        running.do("beep", over)
        running.do("patrol", moving)
        running.engine.send(Interrupt())
        running.until(over)
        running.engine.send(Wake())
        running.until(listening)
        running.do(during, moving)
        running.engine.send(last)


DRIVES = ("patrol", "go forward 3 metres")


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, object]]:
    """What this process holds after two sessions, with what Python itself opens once and keeps; all others are measured
    by it, so that what each leaves would add up."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SAYSO_STATE_DIR", str(tmp_path_factory.mktemp("state")))
        for during in DRIVES:
            live(Quit(), during)
        yield traces()


@pytest.mark.model
@pytest.mark.parametrize("last", [Quit(), EndTask(), Interrupt()], ids=["quit", "end task", "interrupt"])
@pytest.mark.parametrize("during", DRIVES)
def test_a_session_that_has_ended_leaves_nothing_behind(before: dict[str, object], last: Command, during: str) -> None:
    live(last, during)
    assert traces() == before
