"""Somebody goes on whose turn was ended in the middle of a sentence."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Literal

import pytest

from config.schema import Vad
from engine import events
from engine.asr.recogniser import Rejected, Transcript
from engine.audio.endpoint import Utterance
from engine.audio.source import RATE
from engine.audio.vad import make_vad
from engine.bus import Bus
from engine.clock import SystemClock
from engine.hearing.ahead import CERTAIN
from engine.hearing.hearing import Hearing
from engine.hearing.readings import Afterthought, Completeness
from tests.recogniser import SURE, Given, Scripted
from tests.unit.test_ahead import ENDPOINT, Paced, quiet, recorded
from tests.virtual_time import run

FIRST, SECOND = recorded("raise_your_arm.wav"), recorded("go_to_the_kitchen.wav")
BOTH_S = (len(FIRST) + len(SECOND)) / RATE


def by_length(first: Transcript | Rejected, whole: str) -> Scripted:
    """A recogniser that understands ``whole`` once it gets the sound of both pieces, and finds ``first`` before."""
    return Scripted(lambda given: whole if given.seconds >= BOTH_S - 0.1 else first)


def judge(text: str) -> Completeness:
    return "incomplete" if text.endswith("the") else "unknown" if text.endswith("...") else "complete"


async def said(
    first: str | Rejected, silence_s: float, *, confidence: float = 0.9, woken: bool = False
) -> tuple[list[float], list[str]]:
    """How long ago somebody went on, each time that was told, and what was understood. The pause between the two pieces
    ends the first turn, and lasts ``silence_s`` longer; ``woken``: the next turn begins with a wake."""
    found = first if isinstance(first, Rejected) else Transcript(first, confidence, SURE)
    ago: list[float] = []
    ears: list[Hearing] = []
    goes_on = asyncio.Event()

    def on_going_on(ago_s: float) -> None:
        ago.append(ago_s)
        ears[0].mark(ago_s)
        goes_on.set()

    ends = {"incomplete": ENDPOINT.incomplete_s, "unknown": ENDPOINT.silence_s, "complete": ENDPOINT.complete_s}
    clear = isinstance(found, Transcript) and found.confidence >= CERTAIN
    ended_by = ends[judge(found.text)] if clear else ENDPOINT.incomplete_s
    sound = Paced(FIRST, quiet(ended_by + silence_s), SECOND)
    vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    recogniser = by_length(found, "Go to the kitchen.")
    emit = Bus(SystemClock()).bound(turn=None, epoch=1)
    async with Hearing(lambda: sound, vad, ENDPOINT, recogniser, judge=judge, on_going_on=on_going_on) as hearing:
        ears.append(hearing)
        understood = []
        for turn in range(2):
            heard = await hearing.listen(emit)
            assert isinstance(heard, Utterance)
            final = await hearing.transcribe(heard, emit)
            understood.append(final.text if isinstance(final, events.TranscriptFinal) else final.reason)
            if turn == 0:
                if woken:
                    hearing.mark()
                else:
                    try:
                        await asyncio.wait_for(goes_on.wait(), 8)
                    except TimeoutError:
                        return ago, understood
    return ago, understood


@pytest.mark.parametrize("silence_s", [0.3, 1.0])
def test_both_pieces_of_a_sentence_that_was_cut_are_one_request(silence_s: float) -> None:
    ago, understood = run(said("Go to the", silence_s))
    assert understood == ["Go to the", "Go to the kitchen."]
    assert len(ago) == 1
    assert 0 < ago[0] <= 1


@pytest.mark.parametrize("reason", ["low_confidence", "no_speech"])
def test_both_pieces_are_one_request_though_the_first_was_not_understood_alone(
    reason: Literal["low_confidence", "no_speech"],
) -> None:
    ago, understood = run(said(Rejected(reason, "No words were understood."), 0.5))
    assert understood == [reason, "Go to the kitchen."]
    assert len(ago) == 1


@pytest.mark.parametrize(("confidence", "goes_on"), [(0.6, True), (0.9, False)])
def test_what_makes_no_sense_is_waited_for_where_it_was_hardly_understood(confidence: float, goes_on: bool) -> None:
    ago, understood = run(said("Cup on the...", 0.5, confidence=confidence))
    assert bool(ago) == goes_on
    assert understood == ["Cup on the...", *(["Go to the kitchen."] if goes_on else [])]


def test_whoever_goes_on_too_late_makes_another_request_which_needs_a_wake() -> None:
    assert run(said("Go to the", 2.5)) == ([], ["Go to the"])


def test_after_a_command_that_was_complete_nobody_is_waited_for() -> None:
    assert run(said("Raise your arm.", 0.5)) == ([], ["Raise your arm."])


def test_a_wake_begins_a_request_of_its_own() -> None:
    _, understood = run(said("Go to the", 0.8, woken=True))
    assert understood == ["Go to the", "Go to the"]  # the recogniser got the second piece alone


# After a request that was complete


ADDED = Afterthought("Go to the kitchen.", adds=True)


@dataclass
class Told:
    """Somebody who said "Raise your arm." and went on, and what was told of that."""

    hearing: Hearing
    recogniser: Scripted
    more: list[tuple[str, bool]] = field(default_factory=list)
    compared: list[tuple[str, str]] = field(default_factory=list)
    went_on: list[float] = field(default_factory=list)

    async def settle(self) -> None:
        """Let all be said, in virtual time, and understood."""
        await asyncio.sleep(6)
        await asyncio.get_running_loop().run_in_executor(self.hearing._transcriber.thread, lambda: None)
        await asyncio.sleep(0.01)


async def adds(
    pause_s: float,
    *,
    found: Afterthought | None = ADDED,
    whole: Transcript | Rejected | None = None,
    meanwhile: str = "",
) -> Told:
    """What is told of somebody who goes on after a complete command, ``pause_s`` after its last word."""
    vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    sound = Paced(FIRST, quiet(pause_s), SECOND, quiet(2))
    first = Transcript("Raise your arm.", 0.9, SURE)
    both = whole or "Raise your arm. Go to the kitchen."
    told: list[Told] = []

    def answer(given: Given) -> str | Transcript | Rejected:
        if given.seconds < BOTH_S - 0.1:
            return first
        if meanwhile == "stop":
            told[0].hearing.suspect("stop", lambda: None, lambda: None, sure=True)
        return both

    recogniser = Scripted(answer)

    def notice(first: str, whole: str) -> Afterthought | None:
        told[0].compared.append((first, whole))
        return found

    emit = Bus(SystemClock()).bound(turn=None, epoch=1)
    beside = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    async with Hearing(
        lambda: sound,
        vad,
        ENDPOINT,
        recogniser,
        judge=judge,
        notice=notice,
        on_going_on=lambda ago: went_on(ago),
        beside=beside,
    ) as hearing:
        it = Told(hearing, recogniser)
        told.append(it)
        went_on = it.went_on.append
        heard = await hearing.listen(emit)
        assert isinstance(heard, Utterance)
        await hearing.transcribe(heard, emit, lambda final, adds: it.more.append((final.text, adds)))
        if meanwhile == "wake":
            hearing.mark()
            listening = asyncio.create_task(hearing.listen(emit))
            await it.settle()
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
        else:
            await it.settle()
        return it


@pytest.mark.parametrize("pause_s", [0.45, 0.8])
def test_what_is_added_to_a_complete_request_is_told_when_it_has_been_said(pause_s: float) -> None:
    it = run(adds(pause_s))
    assert it.compared == [("Raise your arm.", "Raise your arm. Go to the kitchen.")]
    assert it.more == [("Go to the kitchen.", True)]
    assert it.went_on == [], "nothing is given up for it"


def test_what_does_not_belong_to_the_request_is_not_told() -> None:
    it = run(adds(0.45, found=None))
    assert it.compared
    assert it.more == []


@pytest.mark.parametrize(("confidence", "clear", "told"), [(0.6, True, True), (0.6, False, False), (0.9, False, True)])
def test_what_is_no_command_has_to_be_heard_well(confidence: float, clear: bool, told: bool) -> None:
    whole = Transcript("Raise your arm. And then sing.", confidence, SURE)
    it = run(adds(0.45, found=Afterthought("And then sing.", adds=True, clear=clear), whole=whole))
    assert bool(it.more) == told


def test_what_is_not_understood_is_compared_with_nothing() -> None:
    it = run(adds(0.45, whole=Rejected("low_confidence", "No words were understood.")))
    assert (it.compared, it.more) == ([], [])


def test_whoever_goes_on_later_is_not_heard() -> None:
    it = run(adds(1.5))
    assert (it.compared, it.more) == ([], [])


def test_a_wake_begins_a_request_to_which_nothing_is_added() -> None:
    assert run(adds(0.45, meanwhile="wake")).more == []


def test_the_recogniser_is_given_up_for_a_stop_that_is_suspected() -> None:
    it = run(adds(0.45, meanwhile="stop"))
    assert (it.compared, it.more) == ([], [])
    assert len(it.recogniser.passes) > 1
