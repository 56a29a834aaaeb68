"""The robot's answer to a wake sounds in the microphone while somebody speaks already: nothing of what they say waits
for it, is lost, or is spoilt by it.

The ears, the player and its sounds are the real ones, under virtual time; the room between loudspeaker and microphone
is computed, block by block, from what the player plays.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from config.schema import Endpoint, Vad
from engine import events
from engine.asr.recogniser import Transcript
from engine.audio.clocked import ClockedOutput
from engine.audio.echo import EchoCanceller
from engine.audio.endpoint import Utterance
from engine.audio.player import Player
from engine.audio.sounded import Sounded
from engine.audio.sounds import sound
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Samples
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from engine.bus import Bus
from engine.chimes import Chimes
from engine.clock import SystemClock
from engine.hearing.hearing import Hearing
from tests.recogniser import Given, Scripted
from tests.room import NOISE, VOICE, Room, convolved, loudness, samples
from tests.unit.test_whisper import recogniser
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
ENDPOINT = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=3
)
WOKEN_S = 1.0
"""When the wake word has ended, s of the microphone's sound."""
LATE_S = 0.12
"""How much later it was found: a spotter needs as long."""


@functools.cache
def spoken(name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """As loud as a person is in the microphone, from its first word on."""
    said = read_wav(SPEECH / f"{name}.wav") / 32768
    first = int(np.argmax(np.abs(said) > 0.02 * np.abs(said).max()))
    return np.asarray(said[first:] * (VOICE / loudness(said[first:])))


class Heard:
    """A microphone in the room where the robot's loudspeaker is: ``speech`` begins at ``at``, and the sounds are so
    much louder than a person (``echo_db``)."""

    live = True
    name = "microphone"
    warnings = ()

    def __init__(
        self, played: Sounded, speech: np.ndarray[tuple[int], np.dtype[np.float64]], at: float, echo_db: float
    ):
        self._played = played
        first = round(at * RATE)
        self.speech = np.zeros(first + len(speech) + 8 * RATE)
        self.speech[first : first + len(speech)] = speech
        impulse = Room(delay_s=0.05)._impulse()
        chime = convolved(np.pad(np.asarray(sound("wake", RATE), np.float64), (0, len(impulse))), impulse)
        self._impulse = impulse * (VOICE * 10 ** (echo_db / 20) / loudness(chime))
        self._noise = np.random.default_rng(2)
        self._frames = 0
        self._begun = 0.0

    async def __aenter__(self) -> Heard:
        self._begun = asyncio.get_running_loop().time()
        return self

    async def __aexit__(self, *error: object) -> None: ...

    def __aiter__(self) -> AsyncIterator[Frame]:
        return self

    async def __anext__(self) -> Frame:
        first = self._frames * FRAME_SAMPLES
        self._frames += 1
        end = self._frames * FRAME_S
        loop = asyncio.get_running_loop()
        await asyncio.sleep(max(0.0, self._begun + end - loop.time()))
        past = len(self._impulse)
        played = self._played.samples(round(self._begun * RATE) + first - past, past + FRAME_SAMPLES) / 32768
        heard = convolved(played, self._impulse)[-FRAME_SAMPLES:] + self._noise.normal(0, NOISE, FRAME_SAMPLES)
        return Frame(samples(heard + self.speech[first : first + FRAME_SAMPLES]), end, loop.time())


def more_and_more(given: Given) -> str:
    """Who talks on says another word all the time."""
    return f"{round(given.seconds / FRAME_S)} words"


@dataclass(frozen=True)
class Listened:
    utterance: Utterance
    clean: Samples  # what was said during it, by itself
    began: float  # s: when the recording began, and when it was over
    ended: float
    sounds: float  # s that the loudspeaker sounded


async def listened(
    name: str, gap_s: float, *, echo_db: float = 0.0, sounds: bool = True, answer_s: float = 0.0
) -> Listened:
    """Somebody says the wake word, and ``gap_s`` later the rest. Before, the robot has spoken for ``answer_s``."""
    loop, bus, room = asyncio.get_running_loop(), Bus(SystemClock()), Sounded()
    player = Player(ClockedOutput(RATE, lambda block: room.add(block, RATE, loop.time())))
    began: list[float] = []
    woken = WOKEN_S + answer_s
    bus.subscribe(lambda event: began.append(loop.time()) if event.kind == "listen.started" else None)
    bus.subscribe(Chimes(player).see)
    microphone = Heard(room, spoken(name), woken + gap_s, echo_db)
    vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    hearing = Hearing(lambda: microphone, vad, ENDPOINT, Scripted(more_and_more), echo=EchoCanceller(player.sounded))
    if sounds:
        await player.open()
    async with hearing:
        if answer_s:
            playback = player.begin()
            await playback.feed(samples(np.tile(spoken("raise_your_arm"), 20)[: round(answer_s * RATE)]), RATE)
            playback.finish()
        await asyncio.sleep(woken + LATE_S)
        hearing.mark()
        bus.publish(events.WakeHeard("word", "hey sayso"), epoch=1)
        utterance = await hearing.listen(bus.bound(turn="1", epoch=1))
        ended = loop.time()
    assert isinstance(utterance, Utterance)
    first = round(utterance.start * RATE)
    clean = samples(microphone.speech[first : first + len(utterance.samples)])
    played = room.samples(0, round(ended * RATE))
    await player.close()
    return Listened(utterance, clean, began[0], ended, float(np.count_nonzero(played)) / RATE)


def kept(found: Listened) -> float:
    """How much of what was said is in its recording, by its loudness; of 1."""
    clean = found.clean.astype(np.float64)
    return float(np.dot(found.utterance.samples, clean) / np.dot(clean, clean))


@pytest.mark.parametrize("gap_s", [0.1, 0.3, 0.5])
def test_what_is_said_over_the_answer_to_a_wake_is_recorded_as_if_there_were_none(gap_s: float) -> None:
    without = run(listened("turn_left_ninety_degrees", gap_s, sounds=False))
    found = run(listened("turn_left_ninety_degrees", gap_s, echo_db=6.0))
    assert found.sounds > 0.3
    assert without.sounds == 0
    assert found.began == without.began == WOKEN_S + LATE_S
    assert found.utterance.start <= WOKEN_S + gap_s
    assert found.ended == pytest.approx(without.ended, abs=3 * FRAME_S)
    assert kept(found) == pytest.approx(1.0, abs=0.1)


def test_a_single_word_is_not_lost_either() -> None:
    assert kept(run(listened("stop", 0.3))) == pytest.approx(1.0, abs=0.1)


def test_it_does_not_matter_that_an_answer_was_heard_before() -> None:
    assert kept(run(listened("stop", 0.3, answer_s=3.0))) == pytest.approx(1.0, abs=0.1)


@pytest.mark.model
@pytest.mark.parametrize(
    ("name", "words"),
    [("go_to_the_kitchen", "go to the kitchen"), ("turn_left_ninety_degrees", "turn left 90 degrees")],
)
def test_it_is_understood(name: str, words: str) -> None:
    found = run(listened(name, 0.1))
    told = recogniser().transcribe(found.utterance.samples / np.float32(32768))
    assert isinstance(told, Transcript)
    assert told.text.strip(".").casefold() == words
