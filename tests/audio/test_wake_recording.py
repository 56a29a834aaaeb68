"""Recordings of a wake word by who will say it, from a real (virtual) microphone."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path

import numpy as np
import pytest

from config import load
from engine.audio.wav import read_wav
from tests.audio.server import SoundServer
from tui.commands import wake

pytestmark = pytest.mark.audio

SPEECH = Path(__file__).parents[2] / "assets" / "speech"


def test_who_says_nothing_is_asked_again_and_what_is_said_is_recorded(
    server: SoundServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    told: list[str] = []
    speaking: list[threading.Thread] = []

    def hear(words: str) -> None:
        told.append(words)
        if sum("now" in line for line in told) == 2:  # the first time, nobody says anything
            speaking.append(threading.Thread(target=server.play, args=(SPEECH / "go_to_the_kitchen.wav",)))
            speaking[0].start()

    monkeypatch.setattr(wake, "say", hear)
    sound = asyncio.run(wake._record(load(environ={}), "go to the kitchen", 1))
    speaking[0].join()
    assert told[0] == told[2] == "1 of 3: say “go to the kitchen” now"
    assert told[1].startswith("sayso: Nobody is heard to speak in recording 1.")
    assert len(told) == 3
    assert len(sound) / wake.RATE == pytest.approx(len(read_wav(SPEECH / "go_to_the_kitchen.wav")) / wake.RATE, abs=0.4)
    assert np.abs(sound).max() > 0.05
