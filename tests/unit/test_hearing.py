"""From sound to a transcript, and what happens when somebody changes their mind."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import numpy as np
import pytest
import soundfile

from config.schema import Suppression, Vad
from engine import events
from engine.asr.recogniser import Rejected
from engine.audio.echo import EchoCanceller
from engine.audio.endpoint import Utterance
from engine.audio.level import SILENT
from engine.audio.pipe import PushSource
from engine.audio.ring import CATCH_UP_S, Ring
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, RATE, Frame, Framer, Samples
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource
from engine.errors import ModelError
from engine.hearing.hearing import Hearing, NothingHeard
from tests.bench.speech import hum
from tests.room import BEGUN, Room, Speaker, decibels, mixed, said_in_turn
from tests.room import samples as sampled
from tests.unit.hears import COMMAND, ENDPOINT, SPEECH, Ears, Scripted, all_read, an_utterance, ears, pushed, quiet
from tests.virtual_time import run

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
            given = it.recogniser.passes[0]
            assert (given.vocabulary, given.thread) == (("kitchen",), "recogniser_0")
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
            await all_read()
            source.push(quiet(3).tobytes())
            assert isinstance(await it.hearing.listen(it.emit), NothingHeard)

    asyncio.run(scenario())


def test_sound_since_the_mark_waits_for_a_listener_who_is_late() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            it.hearing.mark()
            source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            await all_read()
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
            await all_read()
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
            await all_read()
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
            assert np.abs(it.recogniser.passes[0].samples).max() == pytest.approx(0.25, rel=0.05)

    asyncio.run(scenario())


@pytest.mark.parametrize("live", [True, False])
def test_noise_is_suppressed_before_anybody_hears_it(live: bool, tmp_path: Path) -> None:
    async def scenario() -> None:
        noisy = np.concatenate((quiet(1.5), COMMAND, quiet(1)))
        noisy += hum(len(noisy) / RATE, 0) // 8
        file = tmp_path / "noisy.wav"
        soundfile.write(file, noisy, RATE)

        async def heard(suppression: Suppression) -> Samples:
            async with ears(
                lambda: pushed(noisy, end=True) if live else WavSource(file, "fast"), suppression=suppression
            ) as it:
                utterance = await it.hearing.listen(it.emit)
                assert isinstance(utterance, Utterance)
                return utterance.samples

        as_it_is, less = await heard("off"), await heard("moderate")
        pause = slice(0, round(0.15 * RATE))  # of the pre-roll
        assert less[pause].std() < as_it_is[pause].std() / 2
        assert np.abs(less).max() > np.abs(as_it_is).max() / 2

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
            assert slow.cancelled[-1]

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
            assert len(slow.passes) == 1
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
            await all_read()
            assert it.hearing.level.rms_db == pytest.approx(-6, abs=0.1)

    asyncio.run(scenario())


# The robot's own voice


class InTheRoom:
    """A microphone of this machine: its frames say when they came."""

    name, live, warnings = "in the room", True, ()

    def __init__(self, samples: Samples) -> None:
        self._frames = iter(Framer().push(samples))

    async def __aenter__(self) -> InTheRoom:
        return self

    async def __aexit__(self, *error: object) -> None: ...

    def __aiter__(self) -> AsyncIterator[Frame]:
        return self

    async def __anext__(self) -> Frame:
        await asyncio.sleep(0)
        frame = next(self._frames, None)
        if frame is None:
            raise StopAsyncIteration
        return Frame(frame.samples, frame.end, BEGUN + frame.end)


class Kept:
    """A listener that remembers."""

    def __init__(self) -> None:
        self.sound: list[Samples] = []

    def push(self, samples: Samples) -> None:
        self.sound.append(samples)

    def reset(self) -> None: ...


@pytest.mark.parametrize("nearby", [True, False])
def test_the_robots_own_voice_is_taken_out_where_its_loudspeaker_is_heard_and_nowhere_else(nearby: bool) -> None:
    played = said_in_turn([COMMAND / 32768] * 8, pause_s=0.2)
    heard = mixed(Room(drift_ppm=0).echo(played))

    async def scenario() -> Samples:
        kept, ended = Kept(), asyncio.Event()
        hearing = Hearing(
            lambda: InTheRoom(heard) if nearby else pushed(heard, end=True),
            make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)),
            ENDPOINT,
            Scripted(),
            gain_db=0,
            on_end=lambda error: ended.set(),
            listener=kept,
            echo=EchoCanceller(Speaker(sampled(played))),
        )
        async with hearing:
            await ended.wait()
        return np.concatenate(kept.sound)

    found = asyncio.run(scenario())
    half, whole = len(found) // 2, len(heard) // 512 * 512
    if nearby:
        assert len(found) == whole
        assert decibels(heard[half:whole], found[half:]) > 8
    else:
        assert np.array_equal(found[:whole], heard[:whole])
