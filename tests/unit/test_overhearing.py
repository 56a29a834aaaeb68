"""A stop is heard without a wake; nothing else is, and nothing waits for it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from config import load
from config.schema import Endpoint, Vad
from engine import events
from engine.asr.recogniser import Decoding, Recogniser, Rejected, RejectReason, Transcript
from engine.audio.endpoint import Utterance
from engine.audio.pipe import PushSource
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Samples, Source
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource, read_wav
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import ModelError
from engine.hearing.hearing import Hearing
from engine.hearing.overhearing import CONFIDENT, DOUBTFUL_LOGPROB, SURE_LOGPROB, Alert, Overhearing
from engine.hearing.speech_watch import SpeechWatch
from engine.hearing.suspicion import AGAIN_FRAMES, ALONE, ALONE_FRAMES, AT_ONCE, NEARLY
from engine.parts.ears import Ears
from engine.parts.loading import Sound
from engine.parts.part import Part
from engine.planner.phrases.stopping import is_stop
from tests.bench.speech import noise
from tests.recogniser import Scripted
from tests.unit.test_whisper import model_folder, recogniser
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
STOP = read_wav(SPEECH / "stop.wav")
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")
LONG = read_wav(SPEECH / "go_to_the_bedroom_then_turn_around.wav")
ENDPOINT = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=2
)
VAD = Vad(backend="auto", gate_mode=3, threshold=0.5)
LATER_S = (ALONE_FRAMES + 1) * FRAME_S
DECODING = Decoding("en", -0.1, 0.02, 1.0, 0.1, 10)


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


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
    """Let the source be read to its end, and whatever was overheard be recognised."""
    for _ in range(100):
        await asyncio.sleep(0)
    await hearing.load()  # queues up behind it


def test_a_stop_is_told_in_the_thread_that_recognised_it() -> None:
    async def scenario() -> None:
        ears = Scripted("No, no, stop! Stop!")
        ears.may_answer.clear()
        async with overhearing(saying(STOP), ears) as (hearing, told):
            await asyncio.to_thread(ears.began.wait, 20)
            for _ in range(200):  # until all of it is heard
                await asyncio.sleep(0)
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
            for _ in range(200):
                await asyncio.sleep(0)
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
            for _ in range(200):
                await asyncio.sleep(0)
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


# What a spotter suspects


class Listening(Scripted):
    """Ears with a suspicion: whether it was settled, and what the recogniser was asked."""

    def __init__(self, *answers: Transcript | Rejected | ModelError | str) -> None:
        super().__init__(*answers)
        self.likelihoods: Sequence[float] = ()
        """One after the other; the last one again and again. Empty: it cannot tell."""
        self.weighed: list[tuple[str, ...]] = []
        self.on_weighing: Callable[[], None] = lambda: None
        self.settled = self.likelier = 0
        self.told: list[str] = []
        self._worker = ThreadPoolExecutor(1)
        self._frames = 0
        self.overhearing = Overhearing(Alert(make_vad(VAD), is_stop, self.told.append), self, self._worker)
        self.overhearing.switch(True)

    @property
    def expected(self) -> list[tuple[str, ...]]:
        """What each quick pass was told to expect."""
        assert all(given.quick for given in self.passes)
        return [given.vocabulary for given in self.passes]

    async def hear(self, sound: Samples) -> None:
        """Take a piece of sound, and let all of it be recognised that is to be."""
        for at in range(0, len(sound) - FRAME_SAMPLES + 1, FRAME_SAMPLES):
            self._frames += 1
            self.overhearing.push(Frame(sound[at : at + FRAME_SAMPLES], self._frames * FRAME_S))
            await self.rest()

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        self.weighed.append(tuple(texts))
        self.on_weighing()
        count = len(self.likelihoods)
        return self.likelihoods[min(len(self.weighed), count) - 1] if count else None

    def suspect(self, phrase: str = "stop", *, sure: bool = True) -> None:
        def settled() -> None:
            self.settled += 1

        def likelier() -> None:
            self.likelier += 1

        self.overhearing.suspect(phrase, settled, likelier, sure=sure)

    async def rest(self) -> None:
        """Until nothing is being recognised, unless it may not be answered."""
        while self.overhearing.busy and self.may_answer.is_set():
            await asyncio.get_running_loop().run_in_executor(self._worker, lambda: None)
            await asyncio.sleep(0)

    @property
    def hinted(self) -> int:
        """How often the recogniser was told what to expect."""
        return self.expected.count(("stop",))


def suspecting(
    scenario: Callable[[Listening], Awaitable[None]], *answers: Transcript | Rejected | ModelError | str
) -> None:
    """Run a scenario in which the recogniser has these answers, the last one for ever."""

    async def main() -> None:
        ears = Listening(*answers)
        try:
            await scenario(ears)
        finally:
            ears.may_answer.set()
            ears._worker.shutdown()

    asyncio.run(main())


def test_a_suspicion_is_looked_into_at_once_and_the_recogniser_told_what_to_expect() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        assert ears.expected == [], "nobody has said anything"
        ears.suspect()
        await ears.rest()
        assert ears.expected == [("stop",)]
        assert ears.passes[0].seconds == pytest.approx(1.5, abs=FRAME_S)
        assert ears.told == ["Stop."]
        assert ears.settled == 1

    suspecting(scenario, "Stop.")


def test_two_suspicions_at_once_are_looked_into_together() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.overhearing.suspect("停", lambda: None, lambda: None, sure=False)
        ears.may_answer.set()
        await ears.rest()
        assert ears.settled == 0
        await ears.hear(quiet(LATER_S))
        assert ears.expected == [("stop",), ("stop", "停")]
        assert ears.told == ["停。"]
        assert ears.settled == 1

    suspecting(scenario, "Shop.", "停。")


# What is so short that its likelihood counts


@pytest.mark.parametrize(
    ("likelihoods", "looks", "stops"),
    [
        ((AT_ONCE + 0.1,), 1, True),
        ((AT_ONCE - 0.1, ALONE + 0.1), 2, True),
        ((AT_ONCE - 0.1, NEARLY - 0.1), 2, False),
    ],
    ids=["certain at once", "alone", "the beginning of more"],
)
def test_a_short_stop_counts_at_once_when_it_is_certain_and_later_when_it_was_all(
    likelihoods: tuple[float, ...], looks: int, stops: bool
) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = likelihoods
        await ears.hear(quiet(2))
        ears.suspect("停", sure=True)
        await ears.rest()
        assert len(ears.weighed) == 1
        assert ears.settled == (looks == 1)
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == looks
        assert ears.told == (["停"] if stops else [])
        assert ears.settled == 1
        assert ears.expected == []  # nobody was asked for a text

    suspecting(scenario, "Nobody asks.")


@pytest.mark.parametrize(("likelihood", "stops"), [(ALONE + 0.1, True), (NEARLY - 0.1, False)])
def test_a_doubtful_short_stop_is_looked_for_once_when_it_shows_whether_it_was_all(
    likelihood: float, stops: bool
) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (likelihood,)
        await ears.hear(quiet(2))
        ears.suspect("停", sure=False)
        await ears.rest()
        assert ears.weighed == []
        assert ears.settled == 0
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == 1
        assert ears.told == (["停"] if stops else [])
        assert (ears.settled, ears.likelier) == (1, 0)

    suspecting(scenario, "Nobody asks.")


@pytest.mark.parametrize(("second", "stops"), [(NEARLY + 0.1, True), (NEARLY - 0.1, False)])
def test_what_is_nearly_a_short_stop_is_one_when_it_is_so_again(second: float, stops: bool) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (ALONE - 0.1, second)
        await ears.hear(quiet(2))
        ears.suspect("停", sure=False)
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == 1
        assert (ears.told, ears.settled, ears.likelier) == ([], 0, 1)
        await ears.hear(quiet(AGAIN_FRAMES * FRAME_S))
        assert len(ears.weighed) == 2
        assert ears.told == (["停"] if stops else [])
        assert (ears.settled, ears.likelier) == (1, 1)
        await ears.hear(quiet(1))
        assert len(ears.weighed) == 2

    suspecting(scenario, "Nobody asks.")


def test_what_a_pause_asks_for_waits_for_the_second_look_as_well() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (NEARLY + 0.1, NEARLY - 0.1)
        sound = np.concatenate((quiet(1), STOP, quiet(2)))
        while not ears.passes:  # as much as a stop was said; the pause comes next
            await ears.hear(sound[:FRAME_SAMPLES])
            sound = sound[FRAME_SAMPLES:]
        ears.suspect("停", sure=False)
        await ears.hear(sound[: (ALONE_FRAMES + AGAIN_FRAMES - 1) * FRAME_SAMPLES])
        assert (len(ears.weighed), len(ears.passes)) == (1, 1)
        await ears.hear(quiet(1))
        assert len(ears.weighed) == 2
        assert ears.told == ["站住。"]
        assert ears.settled == 1

    suspecting(scenario, "听", "站住。")


@pytest.mark.parametrize("alone", [True, False])
def test_what_a_pause_asks_for_waits_for_the_look_at_a_short_stop_and_is_not_lost(alone: bool) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (ALONE + 0.1 if alone else NEARLY - 0.1,)
        await ears.hear(quiet(1))
        for at in range(0, len(STOP), FRAME_SAMPLES):
            await ears.hear(STOP[at : at + FRAME_SAMPLES])
            if len(ears.passes) == 1:  # as much as a stop was said; the pause comes next
                break
        ears.suspect("停", sure=False)
        await ears.hear(STOP[at + FRAME_SAMPLES :][: (ALONE_FRAMES - 1) * FRAME_SAMPLES])
        assert ears.weighed == []
        assert len(ears.passes) == 1
        await ears.hear(quiet(2 * FRAME_S))
        assert len(ears.weighed) == 1
        assert ears.told == (["停"] if alone else ["站住。"])
        assert len(ears.passes) == (1 if alone else 2)
        assert ears.settled == 1

    suspecting(scenario, "听", "站住。")


def test_beside_a_short_stop_another_one_is_looked_for_as_ever() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (-9.0,)
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.suspect("停")
        ears.may_answer.set()
        await ears.rest()
        assert ears.expected == [("stop",), ("stop",)]
        assert ears.told == ["Stop."]

    suspecting(scenario, "Shop.", "Stop.")


def test_a_likelihood_that_nobody_needs_any_more_is_no_stop() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (0.0,)
        ears.on_weighing = ears.overhearing.drop
        await ears.hear(quiet(2))
        ears.suspect("停")
        await ears.rest()
        assert ears.told == []
        assert ears.settled == 1

    suspecting(scenario, "Nobody asks.")


def test_without_a_suspicion_the_recogniser_is_told_nothing() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), COMMAND, quiet(1))))
        assert set(ears.expected) == {()}

    suspecting(scenario, "Go to the kitchen.")


def test_a_suspicion_that_is_not_confirmed_is_settled_once_when_nobody_talks_on() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect()
        await ears.rest()
        assert ears.settled == 1
        await ears.hear(quiet(1))
        assert (ears.hinted, ears.settled, ears.told) == (1, 1, [])

    suspecting(scenario, "Shop.")


def test_somebody_who_talks_on_is_listened_to_once_more_within_a_third_of_a_second() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), LONG[: RATE // 2 * 3])))
        ears.suspect()
        await ears.rest()
        assert (ears.hinted, ears.settled) == (1, 0)
        await ears.hear(LONG[RATE // 2 * 3 :][: round(0.32 * RATE)])
        assert (ears.hinted, ears.settled) == (2, 1)
        assert ears.told == []

    suspecting(scenario, "go to the")


def test_the_second_look_may_find_what_the_first_did_not() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), LONG[: RATE // 5])))
        ears.suspect()
        await ears.rest()
        await ears.hear(LONG[RATE // 5 :][: round(0.4 * RATE)])
        assert ears.told == ["Stop!"]
        assert ears.settled == 1

    suspecting(scenario, "st", "Stop!")


@pytest.mark.parametrize(
    "doubtful",
    [
        Transcript("Stop.", 0.4, replace(DECODING, avg_logprob=DOUBTFUL_LOGPROB - 0.05)),
        Rejected("low_confidence", "…", "Stop.", DECODING),
        Rejected("no_speech", "…", "Stop.", DECODING),
    ],
    ids=["unlikely", "low confidence", "no speech"],
)
def test_who_was_told_to_expect_a_doubtful_stop_must_be_sure_of_it(doubtful: Transcript | Rejected) -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect(sure=False)
        await ears.rest()
        assert ears.told == []
        assert ears.settled == 1

    suspecting(scenario, doubtful)


@pytest.mark.parametrize(("logprob", "stops"), [(SURE_LOGPROB + 0.05, True), (SURE_LOGPROB - 0.05, False)])
def test_of_what_the_spotter_is_sure_the_recogniser_need_not_be(logprob: float, stops: bool) -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect(sure=True)
        await ears.rest()
        assert ears.told == ["Stop."] * stops
        assert ears.settled == 1

    suspecting(scenario, Transcript("Stop.", 0.4, replace(DECODING, avg_logprob=logprob)))


def test_a_recogniser_that_fails_leaves_a_suspicion_unsettled() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect()
        await ears.rest()
        assert ears.settled == 0
        ears.suspect()
        await ears.rest()
        assert ears.settled == 1, "the next one is another one"

    suspecting(scenario, ModelError("It has ended."), "Shop.")


def test_a_suspicion_of_what_is_forgotten_is_settled() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.overhearing.switch(False)
        assert ears.settled == 1
        ears.may_answer.set()
        await ears.rest()
        assert (ears.settled, ears.told) == (1, [])

    suspecting(scenario, "Stop.")


def test_nobody_is_suspected_while_it_is_off() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.overhearing.switch(False)
        assert not ears.overhearing.usable
        ears.suspect()
        assert ears.settled == 1
        assert ears.expected == []

    suspecting(scenario, "Stop.")


def test_a_word_that_is_suspected_twice_has_one_answer() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.suspect()
        ears.may_answer.set()
        await ears.rest()
        assert ears.settled == 1

    suspecting(scenario, "Shop.")


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
