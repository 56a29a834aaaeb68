"""A stop that is said without a wake, through everything: sound, voice activity, Whisper, the session, the physics."""

from __future__ import annotations

import queue
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest

from config import load
from engine import events
from engine.audio.simulated import SimulatedMicrophone
from engine.commands import Quit, Say
from engine.engine import Engine
from engine.events import Event
from engine.loading import Sound

DEADLINE_S = 60.0


@pytest.mark.model
def test_a_spoken_stop_without_a_wake_stops_a_robot_in_mid_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path))
    speech = Path(str(files("assets") / "speech" / "stop.wav"))
    microphone = SimulatedMicrophone([speech], every_s=4.0)  # says stop now and then, whatever the robot does
    engine = Engine(load(environ={}), mode="test", sound=Sound("source", microphone))
    seen: queue.SimpleQueue[Event] = queue.SimpleQueue()
    engine.subscribe(seen.put)
    engine.start()

    def until(met: Callable[[events.Body], bool]) -> events.Body:
        while not met(body := seen.get(timeout=DEADLINE_S).body):
            pass
        return body

    try:
        until(lambda body: isinstance(body, events.Log) and body.source == "recogniser")
        engine.send(Say("go forward 4 metres"))
        heard = until(lambda body: isinstance(body, events.TranscriptFinal) and body.source == "overheard")
        assert isinstance(heard, events.TranscriptFinal)
        assert "stop" in heard.text.lower()
        state = engine.robot_state()
        assert state is not None
        assert state.command.is_zero
        answer = until(lambda body: isinstance(body, events.SpeechEnded))
        assert isinstance(answer, events.SpeechEnded)
        assert answer.text == "Stopped."
    finally:
        engine.send(Quit())
        assert engine.join(DEADLINE_S)
