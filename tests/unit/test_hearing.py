"""From sound to a transcript, and what happens when somebody changes their mind."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import soundfile

from config.schema import Endpoint, Suppression, Vad
from engine import events
from engine.asr.recogniser import Rejected, Transcript
from engine.audio.echo import EchoCanceller
from engine.audio.endpoint import Utterance
from engine.audio.gain import Gain
from engine.audio.level import SILENT
from engine.audio.pipe import PushSource
from engine.audio.ring import CATCH_UP_S, Ring
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Framer, Samples, Source
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource, read_wav
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import DeviceError, ModelError, SaysoError
from engine.hearing.hearing import WARN_S, Hearing, NothingHeard
from engine.hearing.transcriber import LIKELY_SAID, SAID
from tests import recogniser
from tests.bench.speech import hum, speech_bounds
from tests.bench.speech import mixed as in_noise
from tests.room import BEGUN, Room, Speaker, decibels, mixed, said_in_turn
from tests.room import samples as sampled
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
ENDPOINT = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=2
)
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


class Scripted(recogniser.Scripted):
    """A recogniser that answers when the test lets it: what a test of timing cannot have from a real one."""

    def __init__(self, answer: Transcript | Rejected | SaysoError | None = None) -> None:
        super().__init__(answer or "Go to the kitchen.")

    def load(self) -> None:
        if isinstance(self.answers[0], ModelError):
            raise self.answers[0]


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
        """Of all events but those that come again and again while somebody speaks."""
        again = ("listen.level", "transcript.partial")
        return [event.kind for event in self.published if event.kind not in again]

    def last(self) -> events.Body:
        return self.published[-1].body

    async def recogniser_is_idle(self) -> None:
        """Wait until the recogniser's thread has done what waits there."""
        await asyncio.get_running_loop().run_in_executor(self.hearing._transcriber.thread, lambda: None)


@asynccontextmanager
async def ears(
    open_source: Callable[[], Source],
    recogniser: Scripted | None = None,
    *,
    suppression: Suppression = "off",
    gain_db: float | Literal["auto"] = 0.0,
    on_end: Callable[[SaysoError | None], None] = lambda error: None,
    warn: Callable[[str], None] = lambda words: None,
) -> AsyncIterator[Ears]:
    recogniser = recogniser or Scripted()
    hearing = Hearing(
        open_source,
        make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)),
        ENDPOINT,
        recogniser,
        vocabulary=("kitchen",),
        suppression=suppression,
        gain_db=gain_db,
        on_end=on_end,
        warn=warn,
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
    for _ in range(300):  # frames, at one a turn of the loop
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


# What was said right before a request

BEFORE = np.arange(RATE, dtype=np.int16)


@pytest.mark.parametrize("cut_s", [0.0, 0.2])
def test_the_recogniser_is_told_of_a_phrase_that_a_request_follows_without_a_pause(cut_s: float) -> None:
    async def scenario() -> None:
        source, cut = PushSource(), round(cut_s * RATE)
        async with ears(lambda: source) as it:
            source.push(np.concatenate((quiet(1), BEFORE, COMMAND[:cut])).tobytes())
            await settle()
            it.hearing.mark(0.0, "hey jarvis")
            source.push(np.concatenate((COMMAND[cut:], quiet(1))).tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            await it.hearing.transcribe(heard, it.emit)
        everything = np.concatenate((quiet(1), BEFORE, COMMAND, quiet(1)))
        marked = (2 * RATE + cut) // FRAME_SAMPLES * FRAME_SAMPLES  # what was heard then, in whole frames
        assert it.recogniser.passes
        for given in it.recogniser.passes:
            assert given.lead is not None
            assert given.lead.text == "hey jarvis"
            whole = np.concatenate((given.lead.samples, (given.samples * 32768).astype(np.int16)))
            start = marked - len(given.lead.samples)
            assert len(given.lead.samples) == 32 * FRAME_SAMPLES, "about a second"
            assert np.array_equal(whole, everything[start : start + len(whole)]), "without a gap"

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("ago_s", "phrase", "pause_s"),
    [(0.0, "hey jarvis", 0.5), (None, "hey jarvis", 0.0), (0.0, "", 0.0), (0.0, "hey " * 99, 0.0)],
)
def test_what_came_before_a_pause_or_is_not_known_is_not_told(ago_s: float | None, phrase: str, pause_s: float) -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            source.push(np.concatenate((quiet(1), BEFORE)).tobytes())
            await settle()
            it.hearing.mark(ago_s, phrase)
            source.push(np.concatenate((quiet(pause_s), COMMAND, quiet(1))).tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            await it.hearing.transcribe(heard, it.emit)
        assert it.recogniser.passes
        assert [given.lead for given in it.recogniser.passes] == [None] * len(it.recogniser.passes)

    asyncio.run(scenario())


def test_a_request_that_follows_a_phrase_in_noise_without_a_pause_is_heard_from_its_beginning() -> None:
    words = read_wav(SPEECH / "raise_your_arm.wav")
    begin, end = (round(at * RATE) for at in speech_bounds(words))
    words = words[begin:end]
    half = round(0.6 * len(words)) // FRAME_SAMPLES * FRAME_SAMPLES  # the phrase ends in the midst of a word
    voice = np.concatenate((quiet(0.96), words, quiet(1)))
    sound = in_noise(voice, np.random.default_rng(1).normal(0, 1000, len(voice)).astype(np.int16), 5.0)
    marked = round(0.96 * RATE) + half

    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            source.push(sound[:marked].tobytes())
            await settle()
            it.hearing.mark(0.0, "hey jarvis")
            source.push(sound[marked:].tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.lead is not None
            assert heard.start == pytest.approx(marked / RATE)

    asyncio.run(scenario())


def test_a_phrase_counts_for_the_listening_that_it_woke_and_for_no_other() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            for phrase in ("hey jarvis", None):
                source.push(np.concatenate((quiet(1), BEFORE)).tobytes())
                await settle()
                if phrase is not None:
                    it.hearing.mark(0.0, phrase)
                source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
                heard = await it.hearing.listen(it.emit)
                assert isinstance(heard, Utterance)
                assert (heard.lead is not None) == (phrase is not None)

    asyncio.run(scenario())


# Whether a phrase was said


@pytest.mark.parametrize(
    ("likelihood", "likely", "said"),
    [
        (SAID + 0.1, False, True),
        (SAID - 0.1, False, False),
        (LIKELY_SAID + 0.1, True, True),
        (LIKELY_SAID - 0.1, True, False),
        (None, True, None),
    ],
)
def test_a_phrase_was_said_where_the_recogniser_finds_it_likely(
    likelihood: float | None, likely: bool, said: bool | None
) -> None:
    async def scenario() -> None:
        answers: list[tuple[bool | None, bool]] = []

        def answer(said: bool | None) -> None:
            answers.append((said, threading.current_thread().name.startswith("recogniser")))

        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = likelihood
            it.hearing.ask("hey jarvis", COMMAND, answer, likely=likely)
            await it.recogniser_is_idle()
        assert answers == [(said, True)]
        assert {"hey jarvis", "Hey Jarvis"} <= set(it.recogniser.weighed[0])
        it.hearing.ask("hey jarvis", COMMAND, answer, likely=likely)  # after the end, and nothing comes of it
        assert len(it.recogniser.weighed) == len(answers) == 1

    asyncio.run(scenario())


def test_nobody_is_asked_about_a_phrase_before_the_recogniser_is_there_nor_while_somebody_is_listened_to() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            it.recogniser.likely = 0.0
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=False)
            assert answers == [None]
            await it.hearing.load()
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await settle()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=False)
            assert answers == [None, None]
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
            await it.recogniser_is_idle()
            assert it.recogniser.weighed == []

    asyncio.run(scenario())


def test_what_nobody_needs_to_know_any_more_is_not_looked_at() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = 0.0
            held = threading.Event()
            it.hearing._transcriber.thread.submit(held.wait)
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await settle()
            held.set()
            await it.recogniser_is_idle()
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
        assert answers == [None]
        assert it.recogniser.weighed == []

    asyncio.run(scenario())


def test_while_somebody_waits_to_be_understood_nobody_is_asked_about_a_phrase() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = 0.0
            it.recogniser.may_answer.clear()
            understanding = asyncio.create_task(it.hearing.transcribe(an_utterance(), it.emit))
            await settle()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            assert answers == [None]
            it.recogniser.may_answer.set()
            await understanding

    asyncio.run(scenario())


def test_a_recogniser_that_fails_cannot_tell() -> None:
    class Failing(Scripted):
        def likelihood(self, *given: object) -> float:
            raise ModelError("The recogniser has died.")

    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource, Failing()) as it:
            await it.hearing.load()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            await it.recogniser_is_idle()
        assert answers == [None]

    asyncio.run(scenario())


# A microphone that goes away


class Unplugged(PushSource):
    """A live source that is lost when it has said its piece."""

    async def __aenter__(self) -> PushSource:
        self._queue.end(DeviceError("The microphone is gone."))
        return self


def test_a_lost_microphone_ends_the_listening_and_another_one_is_heard_in_its_place() -> None:
    ends: list[SaysoError | None] = []

    async def scenario() -> None:
        async with ears(Unplugged, on_end=ends.append) as it:
            with pytest.raises(DeviceError, match="is gone"):
                await it.hearing.listen(it.emit)
            assert it.last() == events.ListenEnded("device_lost", 0.0, 0.0)
            assert [str(error) for error in ends] == ["The microphone is gone."]
            with pytest.raises(DeviceError, match="is gone"):  # as long as nobody brings another one
                await it.hearing.listen(it.emit)
            await it.hearing.hear(pushed(COMMAND, quiet(1), end=True))
            it.hearing.mark()
            assert isinstance(await it.hearing.listen(it.emit), Utterance)

    asyncio.run(scenario())


def test_a_microphone_that_was_never_there_can_still_come() -> None:
    class Absent(PushSource):
        async def __aenter__(self) -> PushSource:
            raise DeviceError("There is no microphone.")

    async def scenario() -> None:
        it = Hearing(Absent, make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)), ENDPOINT, Scripted())
        with pytest.raises(DeviceError):
            await it.__aenter__()
        emit = Bus(SystemClock()).bound(turn=None, epoch=1)
        with pytest.raises(DeviceError, match="no microphone"):
            await it.listen(emit)
        with pytest.raises(DeviceError):
            await it.hear(Absent())
        await it.hear(pushed(COMMAND, quiet(1), end=True))
        assert isinstance(await it.listen(emit), Utterance)
        await it.__aexit__(None, None, None)

    asyncio.run(scenario())


def test_somebody_who_listens_goes_on_with_the_source_that_takes_the_place_of_the_first() -> None:
    async def scenario() -> None:
        ends: list[SaysoError | None] = []
        half = len(COMMAND) // 2
        async with ears(lambda: pushed(quiet(0.3), COMMAND[:half]), on_end=ends.append) as it:
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await settle()
            assert it.kinds == ["listen.started"]
            await it.hearing.hear(pushed(COMMAND[half:], quiet(1), end=True))
            heard = await listening
            assert isinstance(heard, Utterance)
            assert heard.speech_s > 0.6  # either half has less
            assert it.kinds == ["listen.started", "listen.ended"]
            await settle()
            assert ends == [None]  # of the second one: the first was closed by us

    asyncio.run(scenario())


def test_closing_ends_the_listening() -> None:
    async def scenario() -> None:
        async with ears(PushSource) as it:
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await settle()
            assert it.kinds == ["listen.started"]
        heard = await listening
        assert isinstance(heard, NothingHeard)
        assert heard.reason == "source_ended"

    asyncio.run(scenario())


class Overrun(PushSource):
    """A device that loses sound now and then."""

    overruns = 1

    @property
    def warnings(self) -> tuple[str, ...]:
        return (f"The device lost sound {self.overruns} times.",)


def test_lost_sound_is_told_after_the_listening_and_only_once() -> None:
    async def scenario() -> None:
        source = Overrun()
        async with ears(lambda: source) as it:

            async def listened() -> list[str]:
                del it.published[:]
                source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
                await it.hearing.listen(it.emit)
                return [event.body.message for event in it.published if isinstance(event.body, events.Log)]

            assert await listened() == ["The device lost sound 1 times."]
            assert await listened() == []
            source.overruns = 5
            assert await listened() == ["The device lost sound 5 times."]

    asyncio.run(scenario())


def test_what_a_source_loses_while_nobody_listens_is_told_now_and_then() -> None:
    async def scenario() -> None:
        source, told = Overrun(), list[str]()
        async with ears(lambda: source, warn=told.append):
            source.push(quiet(WARN_S - 1).tobytes())
            await settle()
            assert told == []
            for lost in (2, 3):  # both within the next few seconds
                source.overruns = lost
                source.push(quiet(1.5).tobytes())
                await settle()
            assert told == ["The device lost sound 2 times."]

    asyncio.run(scenario())


class Exclusive(PushSource):
    """A device that one can have at a time."""

    taken = False

    async def __aenter__(self) -> Exclusive:
        if Exclusive.taken:
            raise DeviceError("The device is busy.")
        Exclusive.taken = True
        await super().__aenter__()
        return self

    async def __aexit__(self, *error: object) -> None:
        Exclusive.taken = False
        await super().__aexit__(*error)


def test_a_device_that_has_ended_is_let_go_before_it_is_opened_again() -> None:
    async def scenario() -> None:
        ended = asyncio.Event()
        source = Exclusive()
        async with ears(lambda: source, on_end=lambda error: ended.set()) as it:
            source.finish()
            await ended.wait()
            await it.hearing.hear(again := Exclusive())
            again.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            assert isinstance(await it.hearing.listen(it.emit), Utterance)

    asyncio.run(scenario())


def test_much_sound_at_once_holds_nobody_up() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source):
            source.push(quiet(60).tobytes())
            turns, loop = 0, asyncio.get_running_loop()

            def beat() -> None:
                nonlocal turns
                turns += 1
                loop.call_soon(beat)

            beat()
            await settle()
            assert turns > 200

    asyncio.run(scenario())


# The automatic gain


def test_a_guest_is_as_loud_as_it_is_and_the_own_microphone_as_before() -> None:
    async def scenario() -> None:
        async with ears(PushSource, gain_db=20.0) as it:

            async def level() -> float:
                source = it.hearing._source
                assert isinstance(source, PushSource)
                source.push((COMMAND / 30).astype(np.int16)[: RATE // 2].tobytes())
                await settle()
                return it.hearing.level.peak_db

            own = await level()
            await it.hearing.hear(PushSource(), Gain(0.0))
            assert await level() == pytest.approx(own - 20, abs=0.5)
            await it.hearing.hear(PushSource())
            assert await level() == pytest.approx(own, abs=0.1)

    asyncio.run(scenario())


@pytest.mark.parametrize("understood", [True, False])
def test_the_automatic_gain_learns_from_what_was_understood_and_from_nothing_else(understood: bool) -> None:
    async def scenario() -> None:
        answer = None if understood else Rejected("artefact", "It is no speech.", "Thank you.")
        async with ears(PushSource, Scripted(answer), gain_db="auto") as it:
            faint = Utterance((COMMAND / 20).astype(np.int16), 0.0, len(COMMAND) / RATE, 1.0)
            for _ in range(3):
                await it.hearing.transcribe(faint, it.emit)
        said = [event.body.message for event in it.published if isinstance(event.body, events.Log)]
        rises = ["The gain is 3 dB from now on.", "The gain is 6 dB from now on.", "The gain is 9 dB from now on."]
        assert said == (rises if understood else [])

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
            await settle()
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
