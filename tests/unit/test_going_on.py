"""Somebody goes on whose turn was ended in the middle of a sentence."""

from __future__ import annotations

import asyncio
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
from engine.hearing.readings import Completeness
from tests.recogniser import SURE, Scripted
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
