"""A word that was misheard is taken for the command word that sounds like it, where that is clear and does no harm."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.hearing.near_sounding import distance, heard_as_command
from engine.parts.loading import at_home, vocabulary
from engine.planner.build import build_planner

SETTINGS = at_home(load(environ={}))
PLANNER = build_planner(SETTINGS)
NOUNS = vocabulary(SETTINGS)
DECODING = Decoding("en", -0.5, 0.02, 1.4, 0.2, 10.0)


def understood(text: str, *others: str, confidence: float = 0.6) -> str:
    found = heard_as_command(Transcript(text, confidence, DECODING, others), PLANNER.completeness, NOUNS)
    return found.text


@pytest.mark.parametrize(
    ("heard", "meant"),
    [
        ("I troll the hallway.", "patrol the hallway."),
        ("control the hallway", "patrol the hallway"),
        ("not twice", "nod twice"),
        ("open the breaker", "open the gripper"),
        ("Closed the gripper.", "close the gripper."),
        ("Open the wrapper", "Open the gripper"),
        ("put it in the bean", "put it in the bin"),
        ("go to the kitchin", "go to the kitchen"),
        ("pick up the red fox", "pick up the red box"),
    ],
)
def test_a_word_that_makes_no_sense_is_the_command_word_that_sounds_like_it(heard: str, meant: str) -> None:
    assert understood(heard) == meant


def test_another_reading_may_be_the_one_with_the_misheard_word() -> None:
    assert understood("and trolley all way", "I troll the hallway") == "patrol the hallway"


@pytest.mark.parametrize(
    "heard",
    [
        "turn luck 90 degrees",  # left?
        "turn lift thirty degrees",
        "go forward tin metres",  # ten?
        "turn the light of",
        "move for word one metre",
        "stock",
        "dont follow tree",
        "not follow the line",
        "let's go to the kitchin",
        "go to the",
        "way",
    ],
)
def test_sides_numbers_and_what_is_not_said_to_its_end_are_never_made_up(heard: str) -> None:
    assert understood(heard) == heard


@pytest.mark.parametrize(
    "heard",
    [
        "she turned around",
        "he looks around",
        "call me back",
        "bring me the salt",
        "Good night.",
        "not now",
        "go to the pub",
        "put it in the pan",
    ],
)
def test_what_people_say_to_each_other_is_no_command(heard: str) -> None:
    assert understood(heard) == heard


def test_where_two_words_are_as_near_neither_is_taken() -> None:
    judged = {"go to the bad": "unknown", "go to the bed": "complete", "go to the bud": "complete"}
    found = Transcript("go to the bad", 0.6, DECODING)
    both = heard_as_command(found, lambda text: judged.get(text, "unknown"), ("bed", "bud"))  # type: ignore[arg-type,return-value]
    one = heard_as_command(found, lambda text: judged.get(text, "unknown"), ("bed",))  # type: ignore[arg-type,return-value]
    assert (both.text, one.text) == ("go to the bad", "go to the bed")


def test_what_was_heard_clearly_or_is_a_command_is_left_alone() -> None:
    assert understood("I troll the hallway.", confidence=0.85) == "I troll the hallway."
    assert understood("Go to the kitchen.") == "Go to the kitchen."


def test_what_was_not_let_through_stays_out() -> None:
    rejected = Rejected("low_confidence", "Too uncertain.", "I troll the hallway.", DECODING)
    assert heard_as_command(rejected, PLANNER.completeness, NOUNS) is rejected


def test_spelling_tells_how_words_sound() -> None:
    assert distance("rays", "raise") == 0
    assert distance("blew", "blue") == 0
    assert distance("kitten", "kitchen") < distance("chicken", "kitchen") < distance("bathroom", "kitchen")


@given(st.text(max_size=60))
def test_no_text_is_too_odd(text: str) -> None:
    assert isinstance(understood(text), str)
    assert distance(text, "kitchen") >= 0
