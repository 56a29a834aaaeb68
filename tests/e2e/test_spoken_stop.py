"""A stop that is said without a wake, through everything: sound, spotter, Whisper, the session, the physics."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import TypeVar

import pytest

from config import load
from engine import events
from engine.audio.simulated import SimulatedMicrophone
from engine.commands import Quit, Say
from engine.engine import Engine
from engine.errors import ModelError
from engine.events import Event
from engine.parts.loading import Sound, model_store
from engine.robot.robot import RobotState
from engine.wake.choice import MODEL
from tests.recogniser import Given, Scripted

DEADLINE_S = 60.0
B = TypeVar("B", bound=events.Body)


class Running:
    """An engine at whose microphone somebody says stop every few seconds, whatever the robot does."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self._seen: queue.SimpleQueue[Event] = queue.SimpleQueue()
        engine.subscribe(self._seen.put)

    def until(self, kind: type[B], having: Callable[[B], bool] = lambda body: True) -> B:
        """The next event of this kind that fits."""
        while not (isinstance(body := self._seen.get(timeout=DEADLINE_S).body, kind) and having(body)):
            pass
        return body

    def until_paused(self) -> RobotState:
        """The robot's own word for it; it publishes what has changed a few times a second at most."""
        return self.until_robot(lambda state: state.paused)

    def until_robot(self, met: Callable[[RobotState], bool]) -> RobotState:
        """The robot's state, once this is true of it."""
        deadline = time.monotonic() + DEADLINE_S
        while time.monotonic() < deadline:
            if (state := self.engine.robot_state()) is not None and met(state):
                return state
        raise AssertionError(f"It never came to that: {state}")

    def drive(self, *parts: str) -> None:
        """Begin a long drive once these parts are there, and the first plan, which takes much longer than the next."""
        waited = set(parts)
        while waited:
            waited.discard(self.until(events.Log).source)
        self.engine.send(Say("what can you do?"))
        self.until(events.StateChanged, lambda body: body.result is not None)
        self.engine.send(Say("go forward 4 metres"))


@contextmanager
def running(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Running]:
    monkeypatch.setenv("SAYSO_STATE_DIR", str(folder))
    speech = Path(str(files("assets") / "speech" / "stop.wav"))
    microphone = SimulatedMicrophone([speech], every_s=4.0)
    engine = Engine(load(environ={}), mode="test", sound=Sound("source", microphone))
    held = Running(engine)
    engine.start()
    try:
        yield held
    finally:
        engine.send(Quit())
        assert engine.join(DEADLINE_S)


@pytest.mark.model
def test_a_spoken_stop_without_a_wake_stops_a_robot_in_mid_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running(tmp_path, monkeypatch) as held:
        held.drive("recogniser")
        heard = held.until(events.TranscriptFinal, lambda body: body.source == "overheard")
        assert "stop" in heard.text.lower()
        held.until_robot(lambda state: state.command.is_zero)
        assert held.until(events.SpeechEnded).text == "Stopped."


class Deaf(Scripted):
    """A recogniser that understands only what it is told to expect, once it may, or not even that."""

    def __init__(self, *, confirms: bool) -> None:
        super().__init__(self._understood)
        self._confirms = confirms
        self.may_confirm = threading.Event()

    def _understood(self, given: Given) -> str:
        assert not given.vocabulary or self.may_confirm.wait(DEADLINE_S)
        return "Stop." if self._confirms and given.vocabulary else "Shop."


@pytest.fixture
def spotter() -> None:
    """What spots words is installed."""
    try:
        model_store(load(environ={})).find(MODEL)
    except ModelError as error:
        pytest.skip(str(error))


@pytest.mark.model
@pytest.mark.usefixtures("spotter")
def test_a_stop_that_only_the_spotter_hears_pauses_the_robot_and_is_one_when_it_is_confirmed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ears = Deaf(confirms=True)
    monkeypatch.setattr("engine.parts.ears.make_isolated_recogniser", lambda settings: ears)
    with running(tmp_path, monkeypatch) as held:
        held.drive("recogniser", "wake words")
        assert held.until(events.MotionPaused).phrase == "stop"
        held.until_paused()
        ears.may_confirm.set()
        assert held.until(events.InterruptRaised).scope == "stop"
        assert held.until(events.ActionFinished).outcome == "interrupted"
        held.until_robot(lambda state: state.command.is_zero and not state.paused)


@pytest.mark.model
@pytest.mark.usefixtures("spotter")
def test_a_robot_that_paused_for_nothing_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ears = Deaf(confirms=False)
    monkeypatch.setattr("engine.parts.ears.make_isolated_recogniser", lambda settings: ears)
    with running(tmp_path, monkeypatch) as held:
        held.drive("recogniser", "wake words")
        held.until(events.MotionPaused)
        paused_at = held.until_paused().pose
        ears.may_confirm.set()
        assert held.until(events.MotionResumed).false_pauses == 1
        held.until(events.RobotStateView, lambda body: body.twist.vx > 0.2)
        state = held.engine.robot_state()
        assert state is not None
        assert state.pose.distance_to(paused_at) > 0.0
        assert state.halted is None
