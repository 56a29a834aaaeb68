"""What a sound may have been besides the likeliest, and which of those readings is taken."""

from __future__ import annotations

import numpy as np
import pytest

from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.audio.source import RATE
from engine.hearing.readings import sensible
from engine.planner.completeness import completeness
from engine.planner.phrases.phrases import PhrasePlanner
from tests.bench.speech import mixed
from tests.unit.test_phrases_things import PLANNER as PHRASES
from tests.unit.test_whisper import NOUNS, recogniser, spoken

DECODING = Decoding("en", -0.4, 0.02, 1.4, 0.2, 10.0)


def read(text: str, *others: str, phrases: PhrasePlanner = PHRASES) -> str:
    found = sensible(Transcript(text, 0.7, DECODING, others), lambda said: completeness(said, phrases))
    return found.text


def test_what_makes_no_sense_is_read_as_the_likeliest_command_that_it_may_have_been() -> None:
    assert read("pick us red box", "pick us the red box", "pick up the red box", "pick up the blue box") == (
        "pick up the red box"
    )
    assert read("front, back,", "come back") == "come back"


def test_a_command_is_what_it_is() -> None:
    assert read("Go to the kitchen.", "Go to the study.") == "Go to the kitchen."


@pytest.mark.parametrize("beginning", ["Go to the", "Bring me the", "Put it in", "Go forward two"])
def test_the_beginning_of_a_sentence_is_not_brought_to_an_end_that_nobody_has_said(beginning: str) -> None:
    assert read(beginning, "Go to the bin.", "Put it in the bin.", "Go forward 2 metres.") == beginning


def test_what_only_goes_on_longer_is_no_other_reading() -> None:
    assert read("go back", "go back home", "go back to the start") == "go back"


def test_no_number_is_taken_that_may_have_been_another_one() -> None:
    assert read("go forward 10 minutes", "go forward 10 metres") == "go forward 10 metres"
    assert read("go forward ten minutes", "go forward 2 metres") == "go forward ten minutes"
    assert read("turn luck 19 degrees", "turn left 19 degrees") == "turn luck 19 degrees"


@pytest.mark.parametrize("invented", ["Let's try and clean up here.", "Let us go to the kitchen."])
def test_what_people_say_to_each_other_has_to_be_what_was_heard(invented: str) -> None:
    assert read("let's clean clean off here", invented) == "let's clean clean off here"
    assert read("let's clean clean off here", invented, "come back") == "come back"
    assert read(invented, "come back") == invented


def test_what_was_not_let_through_has_no_readings() -> None:
    rejected = Rejected("low_confidence", "Too uncertain.", "go to the", DECODING)
    assert sensible(rejected, lambda said: "complete") is rejected


@pytest.mark.model
def test_a_thorough_look_tells_what_else_a_short_sound_may_have_been_and_a_quick_one_does_not() -> None:
    others: list[str] = []
    for name in ("raise_your_arm.wav", "turn_left_ninety_degrees.wav", "where_are_you.wav"):
        command = (spoken(name) * 32767).astype(np.int16)
        noise = np.random.default_rng(3).normal(0, 1000, len(command)).astype(np.int16)
        sound = mixed(command, noise, 3.0) * np.float32(1 / 32768)
        quick, thorough = (recogniser().transcribe(sound, NOUNS, quick=quick) for quick in (True, False))
        if isinstance(quick, Transcript) and isinstance(thorough, Transcript):
            assert (quick.decoding.only_reading, thorough.decoding.only_reading) == (True, False)
            assert quick.others == ()
            assert thorough.text not in thorough.others
            others += thorough.others
    assert others


@pytest.mark.model
def test_silence_and_noise_have_no_readings() -> None:
    random = np.random.default_rng(5)
    for level in (0.0001, 0.01, 0.1):
        found = recogniser().transcribe(random.normal(0, level, 2 * RATE).astype(np.float32), NOUNS)
        assert isinstance(found, Rejected), found
