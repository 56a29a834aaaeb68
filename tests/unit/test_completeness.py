"""Whether somebody who pauses has said all."""

from __future__ import annotations

import functools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from engine.hearing.readings import Completeness
from engine.parts.loading import at_home
from engine.planner.build import build_planner
from engine.planner.planner import Planner


@functools.cache
def planner() -> Planner:
    return build_planner(at_home(load()))


def judged(text: str) -> Completeness:
    return planner().completeness(text)


@pytest.mark.parametrize(
    "text",
    [
        "Go to the kitchen.",
        "Turn left 90 degrees.",
        "turn around",
        "Pick up the red box.",
        "Stop.",
        "stop",
        "That's all.",
        "What do you see?",
        "Go forward 2 metres, then turn right 45 degrees.",
        "去厨房",
        "前进两米。",
        "停",
        "看看前面有什么",
    ],
)
def test_a_command_as_it_stands_is_complete(text: str) -> None:
    assert judged(text) == "complete"


@pytest.mark.parametrize(
    "text",
    [
        "Go to the.",
        "Go to the kitchen and",
        "Go to the kitchen, then.",
        "Go to the kitchen...",
        "go forward",
        "Go forward 2.",
        "Drive forward two",
        "move forward half a",
        "Pick up the",
        "Bring me the red box to",
        "Is there a box in the",
        "Put it on the table with",
        "um",
        "uhhm",
        "Turn right 45",
        "turn left 90.",
        "左转90",
        "wait 5",
        "pick up",
        "Open.",
        "um, find",
        "Go to the kitchen and turn",
        "open the door,",
        "去",
        "去厨房然后",
        "去厨房，然后",
        "把",
        "前进",
        "把红色盒子放到",
    ],
)
def test_the_beginning_of_a_command_is_incomplete(text: str) -> None:
    assert judged(text) == "incomplete"


@pytest.mark.parametrize(
    "text",
    [
        "Go to the kitchen,",
        "Turn left",
        "Go back.",
        "Say hello",
        "向左转",
        "Make me happy.",
        "Go to the moon",
        "",
    ],
)
def test_what_may_go_on_or_is_no_command_known_here_is_waited_for_as_usual(text: str) -> None:
    assert judged(text) == "unknown"


@given(st.text(max_size=200))
def test_no_text_is_too_odd_to_be_judged(text: str) -> None:
    assert judged(text) in ("complete", "incomplete", "unknown")
