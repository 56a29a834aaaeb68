"""The robot's own voice for real: what its loudspeaker plays is what its microphone hears."""

from __future__ import annotations

import asyncio
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from engine.audio.loudspeaker import Loudspeaker
from engine.audio.microphone import Microphone
from engine.audio.player import Player
from engine.audio.source import FRAME_S, RATE, Samples
from engine.audio.wav import read_wav
from tests.audio.server import SoundServer

pytestmark = pytest.mark.audio

LIMIT_S = 60.0
AROUND_S = 0.5
STRETCH = RATE // 2
WORDS = [read_wav(file) for file in sorted((Path(__file__).parents[2] / "assets" / "speech").glob("*.wav"))]


@pytest.fixture(autouse=True)
def _at_the_server(server: SoundServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process uses the test's sound server, whose microphone stands before the loudspeaker."""
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    argv = ["pactl", "set-default-source", "loudspeaker.monitor"]
    subprocess.run(argv, env=os.environ | server.environment, check=True)


def test_what_the_microphone_hears_is_what_sounded_when_it_sounded() -> None:
    """Two processes, two streams, and nothing known of the latency of either. A busy machine has gaps in what it plays
    and is late with what it hears, so that it is some stretch of it that must be found, where an echo is looked for."""

    async def scenario() -> tuple[Samples, Samples]:
        heard, begun = [], 0.0
        player = Player(Loudspeaker())
        await player.open()
        try:
            async with asyncio.timeout(LIMIT_S), Microphone() as microphone:
                playback = player.begin()
                for sound in WORDS[:3]:
                    await playback.feed(sound, RATE)
                playback.finish()
                while not playback.ended:
                    frame = await anext(microphone)
                    assert frame.at is not None
                    begun = begun or frame.at - FRAME_S
                    heard.append(frame.samples)
            whole = np.concatenate(heard)
            return whole, player.sounded.between(begun - AROUND_S, begun + len(whole) / RATE + AROUND_S)
        finally:
            await player.close()

    heard, sounded = asyncio.run(scenario())
    assert max(alike(heard, sounded, at) for at in range(0, len(heard) - STRETCH, STRETCH // 2)) > 0.9


def alike(heard: Samples, sounded: Samples, at: int) -> float:
    """How much a stretch of what was heard is like anything that sounded at most ``AROUND_S`` earlier or later."""
    stretch = heard[at : at + STRETCH].astype(float)
    around = sounded[at : at + STRETCH + 2 * round(AROUND_S * RATE)].astype(float)
    if stretch.std() < 100:
        return 0.0
    best = int(np.argmax(np.abs(np.correlate(around, stretch, "valid"))))
    return float(np.corrcoef(around[best : best + STRETCH], stretch)[0, 1])
