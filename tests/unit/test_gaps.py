"""What a request leaves open is found in its words, and what only looks so is not asked about."""

from __future__ import annotations

import asyncio

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load
from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.gaps.kinds import NOTHING, Known
from engine.planner.gaps.left_open import LeftOpen
from engine.planner.planner import NoPlan, PlanRequest
from engine.planner.text.language import language_of
from engine.planner.worlds.house import build_vocabulary

SETTINGS = at_home(load(environ={}))
LEFT_OPEN = LeftOpen(build_vocabulary(SETTINGS))
TWO_CUPS = ("white cup on the stool", "blue cup on the bedside table")
TWO_BOXES = ("red box on the coffee table", "blue box on the coffee table")


@pytest.mark.parametrize(
    ("text", "gap"),
    [
        ("Take something to the study.", "which_thing"),
        ("Would you go and fetch one for my sister?", "which_thing"),
        ("Could you kindly bring to the kitchen?", "which_thing"),
        ("Drop the bottle off.", "where_put"),
        ("Take the bottle to the other room.", "where_put"),
        ("Leave the ball where I showed you.", "where_put"),
        ("Meet me there at once.", "where"),
        ("Go in there and have a look round.", "where"),
        ("turn by thirty degrees", "which_way"),
        ("Turn left right.", "which_way"),
        ("Go forward backwards one metre.", "which_way"),
        ("Remove the blocks that are taller.", "how_high"),
        ("Make your light the colour that I like.", "which_colour"),
        ("The usual, please.", "what_do"),
        ("sort it out will you", "what_do"),
        ("Same as last time.", "what_do"),
        ("Take the blue cup from the", "unfinished"),
        ("Both of them, to the kitchen.", "which_thing"),
        ("再来一次", "what_do"),
        ("给他送过去", "which_thing"),
        ("你去那儿等我", "where"),
        ("转三十度", "which_way"),
        ("把球放到", "where_put"),
    ],
)
def test_a_gap_is_found_in_the_shape_of_a_request(text: str, gap: str) -> None:
    found = LEFT_OPEN.of(text, language_of(text))

    assert found is not None
    assert found.gap == gap


@pytest.mark.parametrize(
    "text",
    [
        "turn left right away",
        "turn left, then right there beep",
        "roll forward one metre and back",
        "put your arm up",
        "take a seat next to the sofa",
        "bring me that newspaper",
        "bring me something to drink",
        "I am carrying a QR code, please follow it.",
        "go to the kitchen and wait there",
        "put the ball on the desk and leave it there",
        "take the bottle to the desk",
        "what is it made of",
        "carry on",
        "turn thirty degrees to the left",
        "remove the blocks that are taller than six centimetres",
        "make your light the colour red",
        "move closer to the red box",
        "bring me any box, I don't mind which",
        "put the two cups on the counter",
        "把红色的盒子放到桌子上",
        "左转三十度",
    ],
)
def test_what_names_all_it_needs_is_not_asked_about(text: str) -> None:
    assert LEFT_OPEN.of(text, language_of(text)) is None


def test_what_something_was_said_before_is_not_asked_about() -> None:
    assert LEFT_OPEN.of("Take something else to the study.", "en", Known(said=True)) is None
    assert LEFT_OPEN.of("Again!", "en", Known(said=True)) is None


@pytest.mark.parametrize(
    ("text", "seen", "names"),
    [
        ("Take the mug to the counter for me.", TWO_CUPS, ("white cup", "blue cup")),
        ("There's a box on the coffee table that I'd like over on the bed.", TWO_BOXES, ("red box", "blue box")),
        ("My tea's in the cup, so be careful bringing it.", TWO_CUPS, ("white cup", "blue cup")),
        ("the cup on the left please", TWO_CUPS, ("white cup", "blue cup")),
        ("I want the red box, or was it the blue box?", (), ("red box", "blue box")),
        ("Bring the cup that's on the stool over to the counter.", TWO_CUPS, ()),
        ("Pick up the cup next to the bottle.", (*TWO_CUPS, "bottle on the stool"), ()),
        ("Get the cup, the blue one.", TWO_CUPS, ()),
    ],
)
def test_of_several_things_the_one_that_is_where_it_was_said_to_be_is_meant(
    text: str, seen: tuple[str, ...], names: tuple[str, ...]
) -> None:
    found = LEFT_OPEN.of(text, "en", Known(seen=seen))

    assert (found.names if found is not None else ()) == names


def test_the_other_one_is_not_the_one_that_is_held() -> None:
    found = LEFT_OPEN.of("Put this down and get me the other box.", "en", Known(holding="green box"))

    assert found is not None
    assert found.names == ("red box", "blue box", "yellow box")
    assert LEFT_OPEN.of("I want the box in the kitchen.", "en", Known(holding="green box")) is None


def test_a_piece_of_furniture_that_the_house_has_several_of_is_asked_about() -> None:
    found = LEFT_OPEN.of("Go to the chair by the table.", "en")

    assert found is not None
    assert "south chair" in found.question


def plan(text: str, **known: object) -> Plan | NoPlan:
    return asyncio.run(build_planner(SETTINGS).plan(PlanRequest(text, **known)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "text",
    ["Turn left right.", "Go in there and have a look round.", "Drop them off at the desk.", "The usual, please."],
)
def test_a_gap_is_asked_about_also_where_phrases_make_something_of_the_words(text: str) -> None:
    found = plan(text)

    assert isinstance(found, NoPlan)
    assert found.exit_code is ExitCode.CLARIFY
    assert found.answer.endswith(("?", "."))


def test_the_cup_that_was_seen_where_it_is_said_to_be_is_taken_without_a_question() -> None:
    found = plan("Bring the cup that's on the stool over to the counter.", seen=TWO_CUPS)

    assert isinstance(found, Plan)
    assert [str(action.args["object"]) for action in found.actions if "object" in action.args] == ["white cup"]


@settings(deadline=None, max_examples=100)
@given(st.text(max_size=60), st.sampled_from(["en", "zh"]))
def test_any_text_is_judged_without_an_error(text: str, language: str) -> None:
    LEFT_OPEN.of(text, language, NOTHING)  # type: ignore[arg-type]
