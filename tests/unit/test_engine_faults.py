"""A fault in what an engine does in the background is told at once, and what it kept is not called ready any more."""

from __future__ import annotations

import queue
from pathlib import Path

import pytest

from config import load
from engine.commands import Quit, Wake
from engine.engine import Engine
from engine.events import ErrorRaised, Event
from engine.parts.ears import Ears
from engine.parts.loading import Sound
from engine.planner.phrases import stopping

LIMIT_S = 60


def test_a_fault_in_the_ears_is_told_and_whoever_wakes_the_robot_hears_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def broken(self: Ears) -> None:
        raise FloatingPointError("injected")

    monkeypatch.setattr(Ears, "keep", broken)
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path))
    stopping._words.cache_clear()
    settings = load(overrides=("planner.profile=phrases", "voice.when=never", "wake.words=[]"), environ={})
    engine = Engine(settings, mode="engine", sound=Sound("none"))
    published: queue.SimpleQueue[Event] = queue.SimpleQueue()
    engine.subscribe(published.put)

    def error() -> str:
        while not isinstance(body := published.get(timeout=LIMIT_S).body, ErrorRaised):
            pass
        return body.message

    engine.start()
    try:
        assert stopping._words.cache_info().currsize == 1, "nobody who says something waits for the words of a stop"
        fault = "The microphone has a fault: FloatingPointError('injected')."
        assert error() == fault
        states = {part.name: part.state for part in engine.status()}
        assert (states["microphone"], states["recogniser"]) == ("failed", "failed")
        engine.send(Wake("key"))
        assert error() == fault
    finally:
        engine.send(Quit())
        assert engine.join(LIMIT_S)
