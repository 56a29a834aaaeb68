"""From sound to a transcript, and what happens when somebody changes their mind."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from config.schema import Endpoint, Vad
from engine import events
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.audio.endpoint import Utterance
from engine.audio.level import SILENT
from engine.audio.pipe import PushSource
from engine.audio.ring import CATCH_UP_S, Ring
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, RATE, Frame, Samples, Source
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource, read_wav
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import DeviceError, ModelError, SaysoError
from engine.hearing import Hearing, NothingHeard
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
ENDPOINT = Endpoint(pre_roll_s=0.3, start_s=0.1, silence_s=0.6, max_length_s=15, no_speech_s=2)
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


class Scripted:
    """A recogniser that answers when the test lets it: what a test of timing cannot have from a real one."""

    name = "scripted"

    def __init__(self, answer: Transcript | Rejected | SaysoError | None = None) -> None:
        self.answer = answer or Transcript("Go to the kitchen.", 0.9, Decoding("en", -0.1, 0.02, 1.4, 0.2, 10))
        self.may_answer = threading.Event()
        self.may_answer.set()
        self.began = threading.Event()
        self.heard: list[tuple[float, tuple[str, ...], str]] = []  # peak, vocabulary, thread
        self.saw_cancellation = False

    def load(self) -> None:
        if isinstance(self.answer, ModelError):
            raise self.answer

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Transcript | Rejected:
        self.heard.append((float(np.abs(samples).max()), tuple(vocabulary), threading.current_thread().name))
        self.began.set()
        assert self.may_answer.wait(20)
        self.saw_cancellation = cancelled()
        if isinstance(self.answer, SaysoError):
            raise self.answer
        return self.answer

    def close(self) -> None: ...


class Ears:
    """A Hearing and what it published."""

    def __init__(self, hearing: Hearing, recogniser: Scripted) -> None:
        self.hearing = hearing
        self.recogniser = recogniser
        self.published: list[events.Event] = []
        bus = Bus(SystemClock())
        bus.subscribe(self.published.append)
        self.emit = bus.bound(turn=None, epoch=7)

    @property
    def kinds(self) -> list[str]:
        return [event.kind for event in self.published if event.kind != "listen.level"]

    def last(self) -> events.Body:
        return self.published[-1].body


@asynccontextmanager
async def ears(
    open_source: Callable[[], Source],
    recogniser: Scripted | None = None,
    *,
    gain_db: float = 0.0,
    on_lost: Callable[[SaysoError], None] | None = None,
) -> AsyncIterator[Ears]:
    recogniser = recogniser or Scripted()
    hearing = Hearing(
        open_source,
        make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)),
        ENDPOINT,
        recogniser,
        vocabulary=("kitchen",),
        gain_db=gain_db,
        on_lost=on_lost,
    )
    async with hearing:
        yield Ears(hearing, recogniser)


def pushed(*sounds: Samples, end: bool = False) -> PushSource:
    """A live source that has this to say."""
    source = PushSource()
    source.push(np.concatenate(sounds).tobytes())
    if end:
        source.finish()
    return source


async def settle() -> None:
    """Let the background reader take what there is."""
    for _ in range(20):
        await asyncio.sleep(0)


def an_utterance() -> Utterance:
    return Utterance(COMMAND, 0.0, len(COMMAND) / RATE, 1.0)


# Listening


def test_a_file_is_heard_and_its_events_are_in_order() -> None:
    async def scenario() -> None:
        async with ears(lambda: WavSource(SPEECH / "go_to_the_kitchen.wav", "fast")) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            found = await it.hearing.transcribe(heard, it.emit)
            assert isinstance(found, events.TranscriptFinal)
            assert found.text == "Go to the kitchen."
            assert it.kinds == ["listen.started", "listen.ended", "transcript.final"]
            ended = it.published[-2].body
            assert isinstance(ended, events.ListenEnded)
            assert ended.reason == "source_ended"
            assert ended.audio_s == pytest.approx(heard.duration)
            assert 0.5 < ended.speech_s < ended.audio_s
            assert it.recogniser.heard[0][1:] == (("kitchen",), "recogniser_0")
            assert await it.hearing.listen(it.emit) == NothingHeard(
                "source_ended", "The sound of go_to_the_kitchen.wav ended and nobody spoke."
            )

    asyncio.run(scenario())


def test_levels_come_ten_times_a_second_and_tell_speech_from_silence() -> None:
    async def scenario() -> None:
        async with ears(lambda: pushed(quiet(1), COMMAND, quiet(1))) as it:
            assert isinstance(await it.hearing.listen(it.emit), Utterance)
            levels = [event.body for event in it.published if isinstance(event.body, events.ListenLevel)]
            ended = it.last()
            assert isinstance(ended, events.ListenEnded)
            assert len(levels) / (ended.audio_s + 1 + 0.6) == pytest.approx(10, abs=3)
            assert not levels[0].in_speech
            assert levels[0].rms_db < -70
            assert max(level.peak_db for level in levels) == pytest.approx(-6, abs=1)
            assert any(level.in_speech and level.speech_probability > 0.9 for level in levels)

    asyncio.run(scenario())


def test_nobody_speaking_is_an_answer_and_no_error() -> None:
    async def scenario() -> None:
        async with ears(lambda: pushed(quiet(5))) as it:
            assert await it.hearing.listen(it.emit) == NothingHeard("no_speech", "Nobody spoke for 2 s.")
            assert it.kinds == ["listen.started", "listen.ended"]
            assert it.last() == events.ListenEnded("no_speech", 0.0, 0.0)

    asyncio.run(scenario())


def test_sound_from_before_the_pre_roll_is_not_heard() -> None:
    async def scenario() -> None:
        source = pushed(COMMAND, quiet(1))
        async with ears(lambda: source) as it:
            await settle()
            source.push(quiet(3).tobytes())
            assert isinstance(await it.hearing.listen(it.emit), NothingHeard)

    asyncio.run(scenario())


def test_sound_since_the_mark_waits_for_a_listener_who_is_late() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            it.hearing.mark()
            source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            await settle()
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.duration == pytest.approx(len(COMMAND) / RATE, abs=0.4)

    asyncio.run(scenario())


def test_a_second_mark_forgets_what_came_before_it() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            it.hearing.mark()
            source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            await settle()
            it.hearing.mark()
            source.push(quiet(3).tobytes())
            assert isinstance(await it.hearing.listen(it.emit), NothingHeard)

    asyncio.run(scenario())


def test_sound_that_has_waited_is_not_given_all_at_once() -> None:
    """Judging it would keep a processor busy that the robot process needs in order to stop."""

    async def body() -> None:
        loop = asyncio.get_running_loop()
        ring = Ring(10)
        for number in range(10):
            ring.put(Frame(quiet(FRAME_S), number * FRAME_S))
        ring.listen()
        times = []
        for _ in range(10):
            await ring.get()
            times.append(loop.time())
        gaps = np.diff(times)
        assert (gaps[:-1] > 0.9 * CATCH_UP_S).all()
        assert times[-1] - times[0] < FRAME_S, "caught up before the next frame"

    run(body())


def test_the_simulated_microphone_is_heard_in_its_own_time() -> None:
    async def scenario() -> float:
        async with ears(lambda: SimulatedMicrophone([SPEECH / "go_to_the_kitchen.wav"], every_s=1)) as it:
            assert isinstance(await it.hearing.listen(it.emit), Utterance)
            assert it.hearing.level != SILENT
            return asyncio.get_running_loop().time()

    assert 1.5 < run(scenario()) < 4


def test_a_cancelled_listener_leaves_no_trace_but_the_event() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            listening = asyncio.ensure_future(it.hearing.listen(it.emit))
            await settle()
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
            assert it.last() == events.ListenEnded("cancelled", 0.0, 0.0)
            source.push(np.concatenate((quiet(0.2), COMMAND, quiet(1))).tobytes())
            it.hearing.mark()
            assert isinstance(await it.hearing.listen(it.emit, restarted=True), Utterance)
            assert it.kinds == ["listen.started", "listen.ended"] * 2

    asyncio.run(scenario())


def test_the_gain_comes_before_everything_else() -> None:
    async def scenario() -> None:
        faint = (COMMAND / 20).astype(np.int16)
        async with ears(lambda: pushed(faint, quiet(1), end=True), gain_db=20) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            await it.hearing.transcribe(heard, it.emit)
            assert it.recogniser.heard[0][0] == pytest.approx(0.25, rel=0.05)

    asyncio.run(scenario())


# A microphone that goes away


class Unplugged(PushSource):
    """A live source that is lost when it has said its piece."""

    async def __aenter__(self) -> PushSource:
        self._queue.end(DeviceError("The microphone is gone."))
        return self


def test_a_lost_microphone_ends_the_listening_and_is_tried_again() -> None:
    lost: list[SaysoError] = []
    sources: list[Source] = [Unplugged(), pushed(COMMAND, quiet(1), end=True)]

    async def scenario() -> None:
        async with ears(lambda: sources.pop(0), on_lost=lost.append) as it:
            with pytest.raises(DeviceError, match="is gone"):
                await it.hearing.listen(it.emit)
            assert it.last() == events.ListenEnded("device_lost", 0.0, 0.0)
            assert [error.message for error in lost] == ["The microphone is gone."]
            it.hearing.mark()
            assert isinstance(await it.hearing.listen(it.emit), Utterance)

    asyncio.run(scenario())


# Transcribing


def test_a_rejected_transcript_carries_its_reason() -> None:
    async def scenario() -> None:
        no = Scripted(Rejected("artefact", "It is what the recogniser writes in noise.", "Thanks for watching!"))
        async with ears(PushSource, no) as it:
            found = await it.hearing.transcribe(an_utterance(), it.emit)
            assert found == events.TranscriptRejected(
                "artefact", "It is what the recogniser writes in noise.", "Thanks for watching!"
            )
            assert it.last() == found

    asyncio.run(scenario())


def test_a_missing_model_is_an_error_for_whoever_needs_it() -> None:
    async def scenario() -> None:
        async with ears(PushSource, Scripted(ModelError("No model."))) as it:
            with pytest.raises(ModelError):
                await it.hearing.load()
            with pytest.raises(ModelError):
                await it.hearing.transcribe(an_utterance(), it.emit)
            assert it.published == []

    asyncio.run(scenario())


def test_a_cancelled_transcription_returns_at_once_and_its_result_is_late() -> None:
    slow = Scripted()
    slow.may_answer.clear()

    async def scenario() -> None:
        async with ears(PushSource, slow) as it:
            late = asyncio.Event()
            loop = asyncio.get_running_loop()

            def emit(body: events.Body) -> events.Event:
                event = it.emit(body)
                loop.call_soon_threadsafe(late.set)
                return event

            waiting = asyncio.ensure_future(it.hearing.transcribe(an_utterance(), emit))
            await asyncio.to_thread(slow.began.wait)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            assert it.published == [], "the worker is still busy"
            slow.may_answer.set()
            await late.wait()
            (event,) = it.published
            assert isinstance(event.body, events.TranscriptRejected)
            assert (event.body.reason, event.body.text) == ("late", "Go to the kitchen.")
            assert event.epoch == 7
            assert slow.saw_cancellation

    asyncio.run(scenario())


def test_a_transcription_cancelled_before_its_turn_never_runs() -> None:
    slow = Scripted()
    slow.may_answer.clear()

    async def scenario() -> None:
        async with ears(PushSource, slow) as it:
            first = asyncio.ensure_future(it.hearing.transcribe(an_utterance(), it.emit))
            second = asyncio.ensure_future(it.hearing.transcribe(an_utterance(), it.emit))
            await asyncio.to_thread(slow.began.wait)
            second.cancel()
            await asyncio.gather(second, return_exceptions=True)
            slow.may_answer.set()
            assert isinstance(await first, events.TranscriptFinal)
            await it.hearing.load()  # queues up behind the second
            assert len(slow.heard) == 1
            assert sorted(it.kinds) == ["transcript.final", "transcript.rejected"]

    asyncio.run(scenario())


def test_closing_does_not_wait_for_a_busy_recogniser() -> None:
    slow = Scripted()
    slow.may_answer.clear()

    async def scenario() -> Ears:
        async with ears(PushSource, slow) as it:
            waiting = asyncio.ensure_future(it.hearing.transcribe(an_utterance(), it.emit))
            await asyncio.to_thread(slow.began.wait)
            waiting.cancel()
            await asyncio.gather(waiting, return_exceptions=True)
        return it

    it = asyncio.run(scenario())
    slow.may_answer.set()
    assert it.published == [], "after the end nothing is published"


def test_an_idle_live_source_keeps_the_level_up_to_date() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            assert it.hearing.level == SILENT
            source.push(np.full(round(FRAME_S * RATE), 16384, np.int16).tobytes())
            await settle()
            assert it.hearing.level.rms_db == pytest.approx(-6, abs=0.1)

    asyncio.run(scenario())
