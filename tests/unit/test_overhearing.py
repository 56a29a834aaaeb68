"""A stop is heard without a wake; nothing else is, and nothing waits for it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import numpy as np
import pytest

from config import load
from config.schema import Endpoint
from engine import events
from engine.asr.recogniser import Recogniser, Rejected, RejectReason, Transcript
from engine.audio.endpoint import Utterance
from engine.audio.pipe import PushSource
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Samples, Source
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource
from engine.bus import Bus
from engine.clock import SystemClock
from engine.hearing.hearing import Hearing
from engine.hearing.overhearing import CONFIDENT, Alert
from engine.hearing.speech_watch import SpeechWatch
from engine.parts.ears import Ears
from engine.parts.loading import Sound
from engine.parts.part import Part
from engine.planner.phrases.stopping import is_stop
from tests.bench.speech import noise
from tests.recogniser import Scripted
from tests.unit.hears import all_read
from tests.unit.overheard import COMMAND, DECODING, LONG, SPEECH, STOP, VAD, Listening, quiet, suspecting
from tests.unit.test_whisper import model_folder, recogniser
from tests.virtual_time import run

ENDPOINT = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=2
)


# When something is recognised


def asks(pattern: str) -> list[tuple[int, list[int]]]:
    """What is asked for in a stream of frames (s: speech, .: none): after which frame, and which frames."""
    watch, asked = SpeechWatch(), []
    for number, sign in enumerate(pattern):
        frame = Frame(np.full(FRAME_SAMPLES, number, np.int16), number * FRAME_S)
        if (said := watch.push(frame, sign == "s")) is not None:
            asked.append((number, said.samples[::FRAME_SAMPLES].tolist()))
    return asked


def test_a_word_is_recognised_at_the_first_short_pause_with_its_onset() -> None:
    assert asks("." * 20 + "s" * 10 + ".." + "." * 40) == [(31, list(range(10, 32)))]


def test_a_click_is_no_word() -> None:
    assert asks("." * 20 + "ss" + "." * 20 + "s" + "." * 20) == []


def test_the_gap_within_a_word_is_no_pause() -> None:
    assert asks("." * 10 + "s" * 4 + "." + "s" * 4 + ".." + "." * 20) == [(20, list(range(21)))]


def test_as_much_as_a_stop_is_recognised_without_waiting_for_the_pause() -> None:
    assert asks("." * 20 + "s" * 14 + "." * 20) == [(30, list(range(10, 31))), (35, list(range(10, 36)))]


def test_who_talks_on_is_listened_to_every_half_second_but_not_again_from_the_beginning() -> None:
    asked = asks("." * 20 + "s" * 200)
    assert [number for number, _ in asked] == list(range(30, 220, 16))
    assert asked[0][1] == list(range(10, 31))
    assert all(frames[-1] == number and len(frames) <= 94 for number, frames in asked)


def test_at_a_pause_the_whole_sentence_counts() -> None:
    number, frames = asks("." * 20 + "s" * 150 + "..")[-1]
    assert number == 171
    assert frames == list(range(10, 172))


def test_after_half_a_second_of_silence_another_sentence_begins() -> None:
    first, second = asks("." * 10 + "s" * 10 + "." * 16 + "s" * 10 + "..")
    assert first == (21, list(range(22)))
    assert second == (47, list(range(26, 48)))


# Who is told, in which thread, and who is not


def works(ears: Scripted) -> list[str]:
    """What the recogniser was asked for."""
    return ["overheard" if given.quick and not given.vocabulary else "command" for given in ears.passes]


class Told:
    """Who is to know of a stop: what they were told, and in which thread."""

    def __init__(self) -> None:
        self.words: list[str] = []
        self.threads: list[str] = []
        self._arrived = asyncio.Event()
        self._loop = asyncio.get_running_loop()

    def __call__(self, words: str) -> None:
        self.words.append(words)
        self.threads.append(threading.current_thread().name)
        self._loop.call_soon_threadsafe(self._arrived.set)

    async def wait(self) -> None:
        async with asyncio.timeout(20):
            await self._arrived.wait()


@asynccontextmanager
async def overhearing(source: Source, recogniser: Recogniser) -> AsyncIterator[tuple[Hearing, Told]]:
    """A hearing that overhears ``source``."""
    told = Told()
    hearing = Hearing(
        lambda: source,
        make_vad(VAD),
        ENDPOINT,
        recogniser,
        vocabulary=("kitchen",),
        alert=Alert(make_vad(VAD), is_stop, told),
    )
    async with hearing:
        hearing.overhear(True)
        yield hearing, told


def saying(*sounds: Samples) -> PushSource:
    """A live source that has this to say, and then silence."""
    source = PushSource()
    source.push(np.concatenate((quiet(1), *sounds, quiet(1))).tobytes())
    return source


async def heard_out(hearing: Hearing) -> None:
    """Let all be read, and whatever was overheard be recognised."""
    await all_read()
    await hearing.load()  # queues up behind it


def test_a_stop_is_told_in_the_thread_that_recognised_it() -> None:
    async def scenario() -> None:
        ears = Scripted("No, no, stop! Stop!")
        ears.may_answer.clear()
        async with overhearing(saying(STOP), ears) as (hearing, told):
            await asyncio.to_thread(ears.began.wait, 20)
            await all_read()
            ears.may_answer.set()
            await told.wait()
            await heard_out(hearing)
            assert told.words == ["No, no, stop! Stop!"]
            assert told.threads == ["recogniser_0"]

    asyncio.run(scenario())


@pytest.mark.parametrize("text", ["Do you want some tea?", "Don't stop.", "去停车场"])
def test_what_else_is_said_is_told_to_nobody(text: str) -> None:
    async def scenario() -> None:
        ears = Scripted(text)
        async with overhearing(saying(COMMAND), ears) as (hearing, told):
            await heard_out(hearing)
            assert works(ears)
            assert told.words == []

    asyncio.run(scenario())


@pytest.mark.parametrize(("reason", "stops"), [("low_confidence", True), ("no_speech", False), ("artefact", False)])
def test_a_doubtful_stop_is_a_stop_but_sound_that_is_no_speech_is_none(reason: RejectReason, stops: bool) -> None:
    async def scenario() -> None:
        async with overhearing(saying(STOP), Scripted(Rejected(reason, "…", "Stop", DECODING))) as (hearing, told):
            await heard_out(hearing)
            assert set(told.words) == ({"Stop"} if stops else set())

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("amid", "stops"),
    [
        (Transcript("停下", CONFIDENT + 0.05, DECODING), True),
        (Transcript("停下", CONFIDENT - 0.05, DECODING), False),
        (Rejected("low_confidence", "…", "停下", DECODING), False),
        (Transcript("Stop", CONFIDENT - 0.05, DECODING), True),
        (Rejected("low_confidence", "…", "Stop", DECODING), True),
        (Transcript("Wait", CONFIDENT + 0.05, DECODING), False),
    ],
    ids=[
        "sure",
        "doubtful",
        "low confidence",
        "doubtful in English",
        "low confidence in English",
        "the beginning of more",
    ],
)
def test_amid_what_somebody_says_a_stop_counts_that_is_sure_and_none_that_may_be_the_beginning_of_more(
    amid: Transcript | Rejected, stops: bool
) -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), COMMAND, quiet(1))))
        assert len(ears.passes) > 1
        assert ears.told == [amid.text] * stops

    suspecting(scenario, amid, "Stoppard is a writer.")


def test_nothing_is_overheard_before_it_is_switched_on_nor_after_it_is_switched_off() -> None:
    async def scenario() -> None:
        ears, source = Scripted("Stop!"), PushSource()
        async with overhearing(source, ears) as (hearing, told):
            hearing.overhear(False)
            source.push(np.concatenate((quiet(1), STOP, quiet(1))).tobytes())
            await heard_out(hearing)
            hearing.overhear(True)
            source.push(quiet(2).tobytes())
            await heard_out(hearing)
            assert works(ears) == []
            assert told.words == []

    asyncio.run(scenario())


def test_switching_off_drops_what_is_being_recognised() -> None:
    async def scenario() -> None:
        slow = Scripted("Stop!")
        slow.may_answer.clear()
        async with overhearing(saying(STOP), slow) as (hearing, told):
            await asyncio.to_thread(slow.began.wait, 20)
            hearing.overhear(False)
            slow.may_answer.set()
            await heard_out(hearing)
            assert told.words == []

    asyncio.run(scenario())


def test_what_waits_is_replaced_by_what_is_newer() -> None:
    async def scenario() -> None:
        slow = Scripted("Well, as I said.")
        slow.may_answer.clear()
        source = saying(COMMAND)
        async with overhearing(source, slow) as (hearing, _):
            await asyncio.to_thread(slow.began.wait, 20)
            for _ in range(5):
                source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            await all_read()
            slow.may_answer.set()
            await heard_out(hearing)
            assert works(slow) == ["overheard"] * 2

    asyncio.run(scenario())


def test_a_command_waits_for_nothing_that_was_overheard_before_it() -> None:
    async def scenario() -> None:
        slow = Scripted("Go to the kitchen.")
        slow.may_answer.clear()
        source = saying(COMMAND)
        emit = Bus(SystemClock()).bound(turn=None, epoch=1)
        async with overhearing(source, slow) as (hearing, _):
            await asyncio.to_thread(slow.began.wait, 20)
            source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            await all_read()
            utterance = Utterance(COMMAND, 0.0, len(COMMAND) / RATE, 1.0)
            transcribing = asyncio.ensure_future(hearing.transcribe(utterance, emit))
            await asyncio.sleep(0)
            slow.may_answer.set()
            assert isinstance(await transcribing, events.TranscriptFinal)
            await heard_out(hearing)
            assert works(slow) == ["overheard", "command"], "the one that was running, and then the command"

    asyncio.run(scenario())


def test_a_recording_is_listened_to_and_never_overheard() -> None:
    async def scenario() -> None:
        ears = Scripted("Stop!")
        emit = Bus(SystemClock()).bound(turn=None, epoch=1)
        async with overhearing(WavSource(SPEECH / "stop.wav", "fast"), ears) as (hearing, told):
            assert isinstance(await hearing.listen(emit), Utterance)
            await heard_out(hearing)
            assert works(ears) == []
            assert told.words == []

    asyncio.run(scenario())


# The real recogniser


@pytest.mark.model
def test_whisper_overhears_a_stop_at_the_simulated_microphone() -> None:
    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        microphone = SimulatedMicrophone([SPEECH / "stop.wav"], every_s=None)
        async with overhearing(microphone, recogniser()) as (hearing, told):
            await hearing.load()
            await asyncio.sleep(2)
            assert told.words == []
            microphone.speak()
            began = loop.time()
            await told.wait()
            assert is_stop(told.words[0])
            assert loop.time() - began < len(STOP) / RATE + 0.3, "of sound: the recogniser's time does not count here"

    run(scenario())


@pytest.mark.model
@pytest.mark.parametrize(
    ("sounds", "stops"),
    [
        ((STOP, quiet(0.2), STOP), True),
        ((LONG, quiet(0.4), STOP), True),
        ((LONG, quiet(0.3), COMMAND), False),
        ((noise(4, 0),), False),
        ((np.random.default_rng(1).normal(0, 3000, 4 * RATE).astype(np.int16),), False),
    ],
    ids=["twice", "after a sentence", "two sentences", "kitchen noise", "white noise"],
)
def test_whisper_overhears_stops_and_nothing_else(sounds: tuple[Samples, ...], stops: bool) -> None:
    async def scenario() -> None:
        async with overhearing(saying(*sounds), recogniser()) as (hearing, told):
            await heard_out(hearing)
            assert bool(told.words) == stops, told.words

    asyncio.run(scenario())


@pytest.mark.model
def test_the_ears_of_an_engine_tell_of_a_stop_that_they_overhear() -> None:
    model_folder()

    async def scenario() -> None:
        told = Told()
        microphone = SimulatedMicrophone([SPEECH / "stop.wav"], every_s=None)
        part: Part[Hearing] = Part("recogniser", lambda status: None)
        sound = Sound("source", microphone)
        ears = Ears(load(), sound, Part("microphone", lambda status: None), part, on_words=told)
        keeping = asyncio.create_task(ears.keep())
        hearing = await part.get()
        hearing.overhear(True)
        microphone.speak()
        await told.wait()
        assert is_stop(told.words[0])
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    run(scenario())
