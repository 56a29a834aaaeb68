"""Recordings of a wake word by who will say it: what is kept of them is the phrase, and what is none is refused."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest

from config import load
from config.schema import Settings, Vad
from engine.audio.satellite import Satellite as Far
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.source import RATE, to_int16
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from engine.errors import DeviceError, UsageError
from engine.wake.training.voices import Sound
from tests.satellite import Satellite
from tui.commands import doctor, recording, wake
from tui.commands.own_voice import phrase_in

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
LIMIT_S = 30.0
BEFORE_S = 1.0


def spoken() -> Sound:
    """“Stop”, and nothing else; its peak is at -14 dBFS."""
    sound = read_wav(SPEECH / "stop.wav") / np.float32(32768)
    loud = np.flatnonzero(np.abs(sound) > 0.03 * np.abs(sound).max())
    said = sound[loud[0] : loud[-1] + 1]
    return np.asarray(said * np.float32(10 ** (-14 / 20) / np.abs(said).max()), np.float32)


def room(seconds: float, noise_db: float) -> Sound:
    """Nobody speaks in it; its noise is so loud, dBFS."""
    noise = np.random.default_rng(0).normal(0, 10 ** (noise_db / 20), round(seconds * RATE))
    return np.asarray(noise, np.float32)


def said_in(seconds: float, noise_db: float, said: Sound, times: int = 1) -> Sound:
    sound = room(seconds, noise_db)
    for at in range(times):
        begin = round((BEFORE_S + at * (len(said) / RATE + 0.2)) * RATE)
        sound[begin : begin + len(said)] += said
    return sound


def cut(sound: Sound) -> Sound:
    return phrase_in(sound, "take.wav", make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)))


@pytest.mark.parametrize("noise_db", [-90, -70, -55, -45])
def test_of_a_recording_in_a_noisy_room_only_the_phrase_is_kept(noise_db: float) -> None:
    said = spoken()
    kept = cut(said_in(4.0, noise_db, said))
    assert len(kept) == pytest.approx(len(said), abs=0.2 * RATE)
    at = int(np.argmax(np.correlate(kept, said, "full"))) - len(said) + 1
    assert at == pytest.approx(0, abs=0.12 * RATE), "it begins where somebody began to speak"


def test_a_click_before_or_after_it_is_none_of_it() -> None:
    said = spoken()
    sound = said_in(4.0, -60, said)
    sound[RATE // 4 : RATE // 4 + 100] = 0.9
    sound[-RATE // 2 : -RATE // 2 + 100] = 0.9
    assert len(cut(sound)) == pytest.approx(len(said), abs=0.2 * RATE)


def test_a_recording_that_holds_nothing_else_is_kept_whole() -> None:
    said = spoken()
    assert len(cut(said)) == pytest.approx(len(said), abs=0.05 * RATE)


@pytest.mark.parametrize("noise_db", [-120, -55, -20])
@pytest.mark.parametrize("seconds", [0, 0.01, 1.0, 4.0])
def test_where_nobody_speaks_the_recording_is_named_and_what_to_do(seconds: float, noise_db: float) -> None:
    with pytest.raises(UsageError, match=r"Nobody is heard to speak in take\.wav\. Record it again"):
        cut(room(seconds, noise_db))


def test_who_talks_on_and_on_does_not_say_a_phrase() -> None:
    with pytest.raises(UsageError, match=r"The voice in take\.wav is heard for \d\.\d s\. A phrase takes"):
        cut(said_in(8.0, -60, spoken(), times=8))


# From the microphone


@asynccontextmanager
async def satellite() -> AsyncIterator[Satellite]:
    made = Satellite("")
    async with asyncio.timeout(LIMIT_S), await asyncio.start_server(made.serve, "127.0.0.1", 0) as server:
        made.address = f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        yield made


def settings(address: str) -> Settings:
    return load(overrides=(f"audio.device={address}",), environ={}, user_folder=Path("/nowhere"))


async def spoken_to(far: Satellite, *sounds: Sound) -> None:
    await far.streams.wait()
    for sound in sounds:
        await far.speak(to_int16(sound))


def recorded(*sounds: Sound) -> Sound:
    """One recording of "stop" with a microphone that hears this."""

    async def scenario() -> Sound:
        async with satellite() as far:
            speaking = asyncio.create_task(spoken_to(far, *sounds))
            try:
                return await wake._record(settings(far.address), "stop", 2)
            finally:
                await speaking

    return asyncio.run(scenario())


def test_who_was_not_heard_is_asked_for_that_recording_again(capsys: pytest.CaptureFixture[str]) -> None:
    seconds = wake.RECORDING_S + 0.04  # whole frames
    kept = recorded(room(seconds, -55), said_in(seconds, -55, spoken()))
    assert len(kept) == pytest.approx(len(spoken()), abs=0.2 * RATE)
    asked, why, again = capsys.readouterr().err.splitlines()
    assert asked == again == "2 of 3: say “stop” now"
    assert why.startswith("sayso: Nobody is heard to speak in recording 2. Record it again")


def test_who_is_never_heard_is_not_asked_for_ever() -> None:
    with pytest.raises(UsageError, match=r"Nobody is heard to speak in recording 2\..*`sayso doctor --mic` shows"):
        recorded(*[room(wake.RECORDING_S + 0.04, -55)] * wake.TAKES)


@pytest.mark.parametrize("sent_s", [0.0, 0.32])
def test_a_satellite_that_sends_nothing_is_not_waited_for_without_end(
    monkeypatch: pytest.MonkeyPatch, sent_s: float
) -> None:
    monkeypatch.setattr(recording, "PATIENCE_S", 0.1)
    monkeypatch.setattr(doctor, "RECORDING_S", 0.5)
    monkeypatch.setattr(wake, "RECORDING_S", 0.5)

    async def scenario() -> None:
        async with satellite() as far:
            speaking = asyncio.create_task(spoken_to(far, room(sent_s, -55)))
            with pytest.raises(DeviceError, match=rf"sent {sent_s:.1f} s of sound, of 0.5 s\. Is it muted"):
                await doctor._recorded(SatelliteMicrophone(Far(far.address)))
            await speaking
        async with satellite() as far:
            with pytest.raises(DeviceError, match="Is it muted"):
                await wake._record(settings(far.address), "stop", 1)

    asyncio.run(scenario())
