"""What is recognised before a speaker has ended, and when a turn ends by it. Sound comes in its own, virtual time."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config import load
from config.schema import Vad
from engine import events
from engine.asr.recogniser import Decoding, Recogniser, Rejected, Transcript
from engine.asr.transcription import Found, Transcription
from engine.audio.endpoint import Ended, Endpointer, Utterance
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Framer, Samples
from engine.audio.vad import VadResult, make_vad
from engine.audio.wav import read_wav
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import ModelError
from engine.hearing.ahead import CAUTION, DecodingAhead
from engine.hearing.hearing import Hearing, NothingHeard
from engine.hearing.readings import Completeness
from engine.hearing.transcriber import Transcriber
from engine.parts.loading import at_home, vocabulary
from engine.planner.build import build_planner
from tests.bench.speech import speech_bounds
from tests.recogniser import SURE, Scripted
from tests.unit.test_whisper import recogniser as whisper
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
ENDPOINT = load().endpoint
DOUBTFUL = Decoding("en", -0.8, 0.02, 1.4, 0.2, 10, doubtful=True)


def recorded(name: str) -> Samples:
    """A recording without the silence around it."""
    samples = read_wav(SPEECH / name)
    begin, end = speech_bounds(samples)
    return samples[round(begin * RATE) : round(end * RATE)]


KITCHEN = recorded("go_to_the_kitchen.wav")


class Paced:
    """A live source that speaks in its own time, and goes on with silence."""

    name = "somebody"
    live = True
    warnings: tuple[str, ...] = ()

    def __init__(self, *sounds: Samples) -> None:
        framer = Framer()
        self._frames = [*framer.push(np.concatenate((quiet(0.5), *sounds))), *framer.flush()]
        self._given = 0

    async def __aenter__(self) -> Paced:
        return self

    async def __aexit__(self, *error: object) -> None: ...

    def __aiter__(self) -> Paced:
        return self

    async def __anext__(self) -> Frame:
        await asyncio.sleep(FRAME_S)
        self._given += 1
        if self._given <= len(self._frames):
            return self._frames[self._given - 1]
        return Frame(quiet(FRAME_S), self._given * FRAME_S)


class Listening:
    """A hearing, what it published, and when (s)."""

    def __init__(self, hearing: Hearing) -> None:
        self.hearing = hearing
        self.published: list[tuple[float, events.Body]] = []
        bus = Bus(SystemClock())
        loop = asyncio.get_running_loop()
        bus.subscribe(lambda event: self.published.append((loop.time(), event.body)))
        self.emit = bus.bound(turn=None, epoch=1)

    def of(self, kind: type[Any]) -> list[Any]:
        return [body for _, body in self.published if isinstance(body, kind)]

    async def hear(self) -> tuple[float, events.TranscriptFinal | events.TranscriptRejected]:
        """How long somebody was silent before the turn ended, s, and what was understood."""
        heard = await self.hearing.listen(self.emit)
        assert isinstance(heard, Utterance)
        [(_, ended)] = [(at, body) for at, body in self.published if isinstance(body, events.ListenEnded)]
        assert ended.reason == "silence"
        quiet_since = max(at for at, body in self.published if isinstance(body, events.ListenLevel) and loud(body))
        ended_at = self.published[-1][0]
        return ended_at - quiet_since, await self.hearing.transcribe(heard, self.emit)


@asynccontextmanager
async def listening(
    recogniser: Recogniser, *sounds: Samples, judge: Callable[[str], Completeness] = lambda text: "unknown", **more: Any
) -> AsyncIterator[Listening]:
    vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    async with Hearing(lambda: Paced(*sounds), vad, ENDPOINT, recogniser, judge=judge, **more) as hearing:
        yield Listening(hearing)


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


def loud(level: events.ListenLevel) -> bool:
    return level.peak_db > -40


def verdict(found: Completeness) -> Callable[[str], Completeness]:
    return lambda text: found


# When a turn ends


@pytest.mark.parametrize(
    ("found", "silence_s"),
    [("complete", ENDPOINT.complete_s), ("unknown", ENDPOINT.silence_s), ("incomplete", ENDPOINT.incomplete_s)],
)
def test_what_was_said_decides_how_much_silence_ends_a_turn(found: Completeness, silence_s: float) -> None:
    async def scenario() -> None:
        async with listening(Scripted("Go to the kitchen."), KITCHEN, judge=verdict(found)) as it:
            silent, final = await it.hear()
            assert silent == pytest.approx(silence_s, abs=0.25)  # levels are published ten times a second
            assert final.text == "Go to the kitchen."

    run(scenario())


def test_a_pass_that_ends_after_the_silence_ends_the_turn_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    pass_s = 10.375 * FRAME_S

    async def passed(transcription: Transcription) -> Found:
        await asyncio.sleep(pass_s)
        return transcription.run()

    async def scenario() -> None:
        start = lambda _, transcription: asyncio.ensure_future(passed(transcription))  # noqa: E731
        monkeypatch.setattr(Transcriber, "start", start)
        async with listening(Scripted("Go to the kitchen."), KITCHEN, partials=False, judge=verdict("complete")) as it:
            _, final = await it.hear()
            assert final.text == "Go to the kitchen."
            [ended_at] = [at for at, body in it.published if isinstance(body, events.ListenEnded)]
            assert ended_at / FRAME_S % 1 == pytest.approx(0.375, abs=0.01), "between two frames"

    run(scenario())


def test_a_command_that_was_hardly_understood_may_be_the_beginning_of_another() -> None:
    async def scenario() -> None:
        scripted = Scripted(Transcript("Go back.", 0.6, SURE))
        async with listening(scripted, KITCHEN, judge=verdict("complete")) as it:
            silent, _ = await it.hear()
            usual = ENDPOINT.silence_s - CAUTION * (ENDPOINT.silence_s - ENDPOINT.complete_s)
            assert ENDPOINT.complete_s < usual < ENDPOINT.silence_s
            assert silent == pytest.approx(usual, abs=0.12)

    run(scenario())


def test_what_made_no_sense_is_looked_at_again_for_another_reading() -> None:
    once = Transcript("Pick us red box.", 0.8, replace(SURE, only_reading=True))
    twice = Transcript("Pick us red box.", 0.8, SURE, ("Pick us the red box.", "Pick up the red box."))

    async def scenario() -> None:
        scripted = Scripted(once, twice)
        known: Callable[[str], Completeness] = lambda text: "complete" if "up" in text else "unknown"  # noqa: E731
        async with listening(scripted, KITCHEN, partials=False, judge=known) as it:
            _, final = await it.hear()
            assert final.text == "Pick up the red box."
            assert [given.quick for given in scripted.passes] == [True, False]

    run(scenario())


def test_a_pause_after_an_unfinished_sentence_does_not_cut_it_off() -> None:
    async def scenario(found: Completeness) -> float:
        scripted = Scripted("Go to the.")
        async with listening(scripted, KITCHEN, quiet(0.9), KITCHEN, judge=verdict(found)) as it:
            await it.hear()
            [ended] = it.of(events.ListenEnded)
            return float(ended.audio_s)

    once = len(KITCHEN) / RATE
    assert run(scenario("unknown")) < once + 0.9
    assert run(scenario("incomplete")) > 2 * once + 0.9


@pytest.mark.parametrize(
    ("answer", "ends"),
    [
        (Transcript("Resume them.", 0.4, SURE), False),
        (Transcript("Resume them.", 0.65, SURE), False),
        (Rejected("low_confidence", "Too uncertain.", "Resume them."), False),
        (Rejected("no_speech", "Hardly a voice.", "fridge,"), False),
        (Rejected("artefact", "It is no speech.", "you"), True),
        (Transcript("Resume them.", 0.8, SURE), True),
    ],
)
def test_what_was_hardly_understood_may_be_half_of_a_sentence(answer: Transcript | Rejected, ends: bool) -> None:
    async def scenario() -> None:
        async with listening(Scripted(answer), KITCHEN, quiet(0.9), KITCHEN, partials=False) as it:
            await it.hearing.listen(it.emit)
            [ended] = it.of(events.ListenEnded)
            assert (ended.audio_s < len(KITCHEN) / RATE + 0.9) == ends

    run(scenario())


def test_a_verdict_on_one_pause_says_nothing_about_the_next() -> None:
    verdicts: list[Completeness] = ["incomplete", "unknown"]

    async def scenario() -> None:
        said = Scripted("Go to the.", "Go to the kitchen")
        judge = lambda text: verdicts[text.endswith("kitchen")]  # noqa: E731
        async with listening(said, KITCHEN, quiet(0.9), KITCHEN, judge=judge, partials=False) as it:
            silent, _ = await it.hear()
            assert silent == pytest.approx(ENDPOINT.silence_s, abs=0.25)

    run(scenario())


@pytest.mark.parametrize("answer", [Rejected("artefact", "It is no speech.", "Thank you."), ModelError("It broke.")])
def test_what_is_no_command_ends_no_turn_early(answer: Rejected | ModelError) -> None:
    async def scenario() -> None:
        async with listening(Scripted(answer), KITCHEN, judge=verdict("complete")) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.duration > len(KITCHEN) / RATE - 0.4
            assert asyncio.get_running_loop().time() > 0.5 + len(KITCHEN) / RATE + ENDPOINT.silence_s - 0.4
            if isinstance(answer, ModelError):
                with pytest.raises(ModelError):
                    await it.hearing.transcribe(heard, it.emit)
            else:
                assert isinstance(await it.hearing.transcribe(heard, it.emit), events.TranscriptRejected)

    run(scenario())


class Slow:
    """Decoding ahead over frames of silence and speech, with a recogniser that answers when it is told to."""

    def __init__(self, *answers: Transcript, judge: Callable[[str], Completeness], partials: bool = False) -> None:
        self.asked: list[tuple[Transcription, asyncio.Future[Found]]] = []
        self.quick: list[bool] = []
        self.ended_at: int | None = None  # frames
        self._answers = list(answers)
        self._frames = 0
        self._endpointer = Endpointer(ENDPOINT)
        emit = Bus(SystemClock()).bound(turn=None, epoch=1)
        self._ahead = DecodingAhead(self._recognise, self._start, ENDPOINT, judge, emit, partials=partials)

    def hear(self, frames: int, *, speech: bool, probability: float | None = None) -> None:
        for _ in range(frames):
            if self.ended_at is not None:
                return
            self._frames += 1
            frame = Frame(np.zeros(FRAME_SAMPLES, np.int16), self._frames * FRAME_S)
            heard = float(speech) if probability is None else probability
            self._ahead.advise(self._endpointer)
            if isinstance(self._endpointer.push(frame, VadResult(heard, speech)), Ended):
                self.ended_at = self._frames
            else:
                self._ahead.follow(self._endpointer)

    async def answer(self) -> None:
        """The oldest pass comes to its end."""
        transcription, future = self.asked.pop(0)
        future.set_result(transcription.run())
        await asyncio.sleep(0)

    def _recognise(self, samples: Samples, cancelled: Callable[[], bool], quick: bool) -> Transcript:
        self.quick.append(quick)
        return self._answers.pop(0)

    def _start(self, transcription: Transcription) -> asyncio.Future[Found]:
        future: asyncio.Future[Found] = asyncio.get_running_loop().create_future()
        self.asked.append((transcription, future))
        return future


@pytest.mark.parametrize(
    ("understood", "found"), [("Go to", "incomplete"), ("Go there", "unknown"), ("Go to the kitchen.", "complete")]
)
def test_a_pause_lasts_while_nobody_knows_what_was_said(understood: str, found: Completeness) -> None:
    async def scenario() -> None:
        unsure = Transcript("Go to the kit", 0.4, DOUBTFUL)
        judge = lambda text: found if text == understood else "unknown"  # noqa: E731
        it = Slow(unsure, Transcript(understood, 0.8, SURE), judge=judge)
        it.hear(30, speech=True)
        it.hear(8, speech=False)
        await it.answer()
        usual = math.ceil(ENDPOINT.silence_s / FRAME_S)
        it.hear(usual, speech=False)
        assert it.ended_at is None, "the usual silence is over, but nothing could be done yet"
        await it.answer()
        assert it.quick == [True, False]
        it.hear(1, speech=False)
        assert (it.ended_at is None) == (found == "incomplete")
        it.hear(100, speech=False)
        assert it.ended_at is not None
        assert it.ended_at <= 30 + math.ceil(ENDPOINT.incomplete_s / FRAME_S), "and never longer than that"

    run(scenario())


@pytest.mark.parametrize(("found", "passes"), [("complete", 1), ("unknown", 2)])
def test_a_burst_of_sound_after_a_command_is_its_last_consonant(found: Completeness, passes: int) -> None:
    async def scenario() -> None:
        it = Slow(*[Transcript("Pick up the red box.", 0.8, SURE)] * 2, judge=verdict(found))
        it.hear(20, speech=True)
        it.hear(2, speech=False)
        transcription, future = it.asked.pop(0)
        begun = transcription.run()
        it.hear(3, speech=True)
        it.hear(3, speech=False)
        assert not it.asked
        future.set_result(begun)
        await asyncio.sleep(0)
        it.hear(1, speech=False)
        assert len(it.asked) == passes - 1, "what is no command without the burst is looked at with it"
        it.hear(20, speech=False)
        assert (it.ended_at is not None) == (found == "complete")

    run(scenario())


def test_what_is_overtaken_before_it_has_begun_never_runs_and_what_has_begun_still_counts() -> None:
    async def scenario() -> None:
        sure = [Transcript("Go to the kitchen.", 0.8, SURE)] * 2
        it = Slow(*sure, judge=verdict("complete"))
        it.hear(20, speech=True)
        it.hear(3, speech=False)
        transcription, future = it.asked.pop(0)
        found = transcription.run()  # it has begun, and is not answered yet
        it.hear(5, speech=True)
        it.hear(3, speech=False)
        it.hear(5, speech=True)
        future.set_result(found)
        await asyncio.sleep(0)
        await it.answer()
        assert len(it.quick) == 1, "the pass of the second pause was dropped while it waited"
        it.hear(2, speech=True)
        await it.answer()
        assert it.ended_at is None
        it.hear(1, speech=True)
        assert it.ended_at is not None, "the first pass and the last agree"

    run(scenario())


# Voices that a detector hears in noise


BABBLE = np.concatenate([KITCHEN] * 3)
"""What a detector of voices takes for somebody who talks on."""


def test_a_complete_command_to_which_nothing_is_added_ends_its_turn_though_a_voice_is_heard() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the", "Go to the kitchen.", "go to the kitchen", "Never mind.")
        judge = lambda text: "complete" if text.endswith(("kitchen.", "kitchen")) else "incomplete"  # noqa: E731
        async with listening(scripted, BABBLE, judge=judge) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            final = await it.hearing.transcribe(heard, it.emit)
            assert final.text == "go to the kitchen"
            assert heard.duration < len(BABBLE) / RATE
            _, found, confirmed = scripted.passes
            assert confirmed.quick
            assert confirmed.seconds - found.seconds > 0.4

    run(scenario())


@pytest.mark.parametrize("found", ["unknown", "incomplete"])
def test_what_is_no_complete_command_ends_a_little_later_than_in_silence_though_a_voice_is_heard(
    found: Completeness,
) -> None:
    async def scenario() -> None:
        async with listening(Scripted("Turn left."), *[KITCHEN] * 8, judge=verdict(found)) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            silence_s = ENDPOINT.silence_s if found == "unknown" else ENDPOINT.incomplete_s
            assert silence_s < heard.duration < silence_s + 3.0 < 8 * len(KITCHEN) / RATE
            first, *_, last = it.hearing._recogniser.passes  # type: ignore[attr-defined]
            assert last.seconds - first.seconds > silence_s + 0.25

    run(scenario())


def test_sound_without_words_ends_no_turn_though_it_lasts() -> None:
    async def scenario() -> None:
        scripted = Scripted(Rejected("low_confidence", "Too uncertain.", "Mm.", SURE))
        async with listening(scripted, *[KITCHEN] * 5) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.duration > 5 * len(KITCHEN) / RATE - 0.3

    run(scenario())


@pytest.mark.parametrize("then", ["Go to the kitchen and", "Go to the kitchen counter."])
def test_a_complete_command_that_goes_on_is_heard_to_its_end(then: str) -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.", then, "Go to the kitchen.", then)
        judge = lambda text: "incomplete" if text.endswith("and") else "complete"  # noqa: E731
        async with listening(scripted, np.concatenate((KITCHEN, KITCHEN)), judge=judge) as it:
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.duration > 2 * len(KITCHEN) / RATE - 0.2

    run(scenario())


def test_a_command_is_as_complete_with_a_comma_more() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen", "go to the kitchen,")
        judge = lambda text: "unknown" if text.endswith(",") else "complete"  # noqa: E731
        async with listening(scripted, KITCHEN, quiet(0.2), KITCHEN[: RATE // 5], judge=judge, partials=False) as it:
            silent, final = await it.hear()
            assert final.text == "go to the kitchen,"
            assert len(scripted.passes) == 2
            assert silent < ENDPOINT.silence_s - 0.05

    run(scenario())


# What is recognised, and how often


def test_a_pass_begins_when_a_voice_fades_and_serves_the_pause_that_follows() -> None:
    async def scenario() -> None:
        it = Slow(Transcript("Go to the kitchen.", 0.8, SURE), judge=verdict("complete"), partials=True)
        it.hear(20, speech=True)
        it.hear(3, speech=True, probability=0.6)
        assert len(it.asked) == 1
        it.hear(3, speech=False)
        assert len(it.asked) == 1
        await it.answer()
        it.hear(20, speech=False)
        assert it.ended_at == 20 + math.ceil(ENDPOINT.complete_s / FRAME_S), "the voice was at its end by then"

    run(scenario())


def test_a_pass_that_began_within_a_word_is_given_up_and_never_the_transcript() -> None:
    async def scenario() -> None:
        answers = (Transcript(text, 0.8, SURE) for text in ("Go to the bed.", "Go to the bedroom."))
        it = Slow(*answers, judge=verdict("complete"), partials=True)
        it.hear(20, speech=True)
        it.hear(2, speech=True, probability=0.6)
        within = it.asked[0][0]
        it.hear(3, speech=True)
        assert within.is_cancelled
        it.hear(2, speech=False)
        assert len(it.asked) == 2
        await it.answer()
        it.hear(20, speech=False)
        assert it.ended_at is None, "nobody knows yet what was said"
        await it.answer()
        it.hear(1, speech=False)
        assert it.ended_at is not None

    run(scenario())


def test_a_voice_that_fades_and_does_not_end_is_listened_to_again_and_its_command_confirmed() -> None:
    async def scenario() -> None:
        answers = (Transcript("Go to the kitchen.", 0.8, SURE) for _ in range(2))
        it = Slow(*answers, judge=verdict("complete"), partials=True)
        it.hear(20, speech=True)
        it.hear(5, speech=True, probability=0.6)
        await it.answer()
        it.hear(12, speech=True, probability=0.6)
        assert len(it.asked) == 1
        await it.answer()
        it.hear(1, speech=True, probability=0.6)
        assert it.ended_at is not None

    run(scenario())


@pytest.mark.parametrize("partials", [False, True])
def test_a_voice_that_begins_is_not_one_that_fades_and_who_is_asked_once_is_asked_at_the_pause(partials: bool) -> None:
    async def scenario() -> None:
        it = Slow(judge=verdict("complete"), partials=partials)
        it.hear(6, speech=True, probability=0.6)
        it.hear(20, speech=True)
        assert it.asked == []
        it.hear(1, speech=True, probability=0.6)
        assert len(it.asked) == partials

    run(scenario())


def test_the_pass_of_the_last_pause_is_the_transcript() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.")
        async with listening(scripted, KITCHEN, partials=False) as it:
            _, final = await it.hear()
            assert isinstance(final, events.TranscriptFinal)
            [given] = scripted.passes
            assert given.quick
            assert given.seconds > 1

    run(scenario())


def test_a_doubtful_quick_pass_is_followed_by_a_thorough_one() -> None:
    async def scenario() -> None:
        scripted = Scripted(Transcript("Go to the kitten.", 0.4, DOUBTFUL), "Go to the kitchen.")
        async with listening(scripted, KITCHEN, partials=False) as it:
            _, final = await it.hear()
            assert final.text == "Go to the kitchen."
            assert [given.quick for given in scripted.passes] == [True, False]

    run(scenario())


@pytest.mark.parametrize(("text", "passes"), [("Go to the kitchen.", 1), ("Turn left 19 degrees.", 2)])
def test_a_doubtful_command_is_believed_to_the_letter_but_not_its_numbers(text: str, passes: int) -> None:
    async def scenario() -> None:
        scripted = Scripted(Transcript(text, 0.4, DOUBTFUL), "Turn left 90 degrees.")
        async with listening(scripted, KITCHEN, partials=False, judge=verdict("complete")) as it:
            await it.hear()
            assert len(scripted.passes) == passes

    run(scenario())


def test_a_turn_that_ends_after_a_doubtful_pass_waits_for_the_thorough_one() -> None:
    async def scenario() -> None:
        scripted = Scripted(Transcript("Go to the kitten.", 0.4, DOUBTFUL), "Go to the kitchen.")
        scripted.may_answer.clear()
        async with listening(scripted, KITCHEN, partials=False) as it:
            threading.Timer(0.1, scripted.may_answer.set).start()  # the loop's own time stands still meanwhile
            _, final = await it.hear()
            assert final.text == "Go to the kitchen."

    run(scenario())


def test_words_are_shown_while_somebody_talks_and_none_after_the_end() -> None:
    async def scenario() -> None:
        said = Scripted("Go to", "Go to the kit", "Go to the kitchen and", "Go to the kitchen and wait.")
        async with listening(said, KITCHEN, KITCHEN, KITCHEN) as it:
            await it.hear()
            shown = [(partial.text, partial.stable_words) for partial in it.of(events.TranscriptPartial)]
            assert shown[:3] == [("Go to", 0), ("Go to the kit", 2), ("Go to the kitchen and", 3)]
            kinds = [type(body) for _, body in it.published]
            assert events.TranscriptPartial not in kinds[kinds.index(events.ListenEnded) :]

    run(scenario())


def test_without_partials_nothing_is_recognised_before_the_first_pause() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.")
        async with listening(scripted, KITCHEN, KITCHEN, KITCHEN, partials=False) as it:
            await it.hear()
            assert all(given.seconds > len(KITCHEN) / RATE for given in scripted.passes)

    run(scenario())


# What is overtaken


def test_a_listener_who_leaves_takes_what_is_being_recognised_along() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.")
        async with listening(scripted, KITCHEN, judge=verdict("complete")) as it:
            scripted.may_answer.clear()
            work = asyncio.create_task(it.hearing.listen(it.emit))
            await asyncio.to_thread(scripted.began.wait, 20)
            work.cancel()
            await asyncio.gather(work, return_exceptions=True)
            scripted.may_answer.set()
            await it.hearing.load()  # queues up behind it
            assert scripted.cancelled[-1]
            assert not it.of(events.TranscriptPartial)
            assert not it.of(events.TranscriptFinal)
            assert not it.of(events.TranscriptRejected), "nobody had asked for a transcript yet"

    asyncio.run(scenario())


def test_a_transcript_that_is_cancelled_while_it_is_decoded_ahead_is_late() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.")
        async with listening(scripted, KITCHEN, partials=False) as it:
            scripted.may_answer.clear()
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            work = asyncio.create_task(it.hearing.transcribe(heard, it.emit))
            await asyncio.sleep(0)
            work.cancel()
            await asyncio.gather(work, return_exceptions=True)
            scripted.may_answer.set()
            await it.hearing.load()
            [late] = it.of(events.TranscriptRejected)
            assert (late.reason, late.text) == ("late", "Go to the kitchen.")
            assert not it.of(events.TranscriptFinal)

    asyncio.run(scenario())


def test_the_next_listener_is_not_told_what_the_last_one_heard() -> None:
    async def scenario() -> None:
        scripted = Scripted("Go to the kitchen.", "Turn left.")
        async with listening(scripted, KITCHEN, quiet(2), KITCHEN, partials=False) as it:
            first = await it.hearing.listen(it.emit)
            second = await it.hearing.listen(it.emit)
            assert isinstance(first, Utterance)
            assert isinstance(second, Utterance)
            assert (await it.hearing.transcribe(second, it.emit)).text == "Turn left."
            assert len(scripted.passes) == 2

    run(scenario())


NOTHING = Rejected("no_speech", "Nothing was said after “hey jarvis”.", "", SURE)


async def woken(it: Listening) -> None:
    """In the midst of the first words, which are those of the phrase."""
    await asyncio.sleep(1.0)
    it.hearing.mark(0.0, "hey jarvis")


@pytest.mark.parametrize("pause_s", [0.9, 3.0])
def test_who_says_the_wake_word_and_pauses_is_still_listened_to(pause_s: float) -> None:
    async def scenario() -> None:
        scripted = Scripted(NOTHING, "Go to the kitchen.")
        async with listening(scripted, KITCHEN, quiet(pause_s), KITCHEN, partials=False) as it:
            await woken(it)
            _, final = await it.hear()
            assert final.text == "Go to the kitchen."
            assert [given.lead is not None for given in scripted.passes] == [True, False]
            assert scripted.passes[1].seconds < len(KITCHEN) / RATE + 1, "without what was said before the pause"

    run(scenario())


def test_who_says_the_wake_word_and_no_more_is_waited_for_as_long_as_who_says_nothing() -> None:
    async def scenario() -> None:
        async with listening(Scripted(NOTHING), KITCHEN) as it:
            await woken(it)
            began = asyncio.get_running_loop().time()
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, NothingHeard)
            assert heard.reason == "no_speech"
            assert asyncio.get_running_loop().time() - began == pytest.approx(ENDPOINT.no_speech_s, abs=0.2)

    run(scenario())


def test_a_request_of_which_no_word_was_understood_is_turned_down() -> None:
    async def scenario() -> None:
        async with listening(Scripted(NOTHING), KITCHEN) as it:
            _, final = await it.hear()
            assert isinstance(final, events.TranscriptRejected)

    run(scenario())


def test_whoever_still_listens_while_the_recogniser_closes_gets_an_error_and_no_fault() -> None:
    async def scenario() -> None:
        async with listening(Scripted("Go to the kitchen."), KITCHEN) as it:
            pass
        with pytest.raises(ModelError, match="has been closed"):
            await it.hearing.transcribe(Utterance(KITCHEN, 0.0, 1.0, 1.0), it.emit)

    run(scenario())


# With the real recogniser


@pytest.mark.model
def test_a_real_command_is_understood_from_the_pause_after_it_and_ends_its_turn_early() -> None:
    settings = at_home(load())
    judge = build_planner(settings).completeness

    async def scenario() -> None:
        sound = read_wav(SPEECH / "go_to_the_kitchen.wav")  # one that is cut at its last sound hangs in the air
        async with listening(whisper(), sound, judge=judge, vocabulary=vocabulary(settings)) as it:
            silent, final = await it.hear()
            assert isinstance(final, events.TranscriptFinal)
            assert final.text.casefold().strip(".,") == "go to the kitchen"
            assert silent < ENDPOINT.silence_s
            shown = it.of(events.TranscriptPartial)
            assert shown[-1].text == final.text

    run(scenario())


@pytest.mark.model
def test_a_real_command_with_a_pause_in_it_is_heard_to_its_end() -> None:
    settings = at_home(load())
    judge = build_planner(settings).completeness
    words = recorded("move_forward_one_metre.wav")
    half = quietest(words, 0.45, 0.75)

    async def scenario() -> None:
        async with listening(whisper(), words[:half], quiet(0.7), words[half:], judge=judge) as it:
            _, final = await it.hear()
            assert "met" in final.text.casefold().split()[-1]

    run(scenario())


def quietest(samples: Samples, begin: float, end: float) -> int:
    """Where to cut: the quietest 20 ms in that part of the recording."""
    window = RATE // 50
    power = (samples[: len(samples) // window * window].astype(float).reshape(-1, window) ** 2).mean(axis=1)
    first, last = round(begin * len(power)), round(end * len(power))
    return int(first + np.argmin(power[first:last])) * window
