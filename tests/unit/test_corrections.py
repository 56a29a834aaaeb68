"""People take back what they have just said; only what they mean in the end is done."""

from __future__ import annotations

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.readings.corrections import LONGEST, corrected
from engine.planner.request import NoPlan, PlanRequest

PLANNER = build_planner(at_home(load(environ={})))


def planned(text: str) -> str | NoPlan:
    found = asyncio.run(PLANNER.plan(PlanRequest(text)))
    return "; ".join(map(str, found.actions)) if isinstance(found, Plan) else found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("turn ninety to the right no sorry to the left", "move_left(90, 1)"),
        ("go to the kitchen no wait the bedroom", "navigation(C)"),
        ("Go to the kitchen, I mean the bedroom.", "navigation(C)"),
        ("go forward one metre, actually two metres", "move_forward(2, 0.3)"),
        ("turn left 90 degrees no make that 45", "move_left(45, 1)"),
        ("go to the kitchen, no, the bedroom I mean", "navigation(C)"),
        ("move forward 1 metre, sorry, back 1 metre", "move_forward(-1, 0.3)"),
        ("Move forward one metre. Sorry, back one metre.", "move_forward(-1, 0.3)"),
        ("go to the kitchen and then the bedroom, no, the study", "navigation(A); navigation(D)"),
        ("go to the kitchen no wait go to the bedroom no the study", "navigation(D)"),
        ("bring me the red box, no, the blue one", "carry(blue box, zero, )"),
        ("pick up the red uh no the blue cup", "pick_object(blue cup)"),
        ("去厨房，不对，去卧室", "navigation(C)"),
        ("左转九十度，不是，右转", "move_right(90, 1)"),
        ("把红色的盒子，不对，蓝色的盒子放进垃圾桶", "pick_object(blue box); place_in_bin()"),
    ],
)
def test_the_newest_word_counts(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(("text", "said"), [("say no sorry", "no sorry"), ("say I mean it", "I mean it")])
def test_what_is_to_be_said_is_no_correction(text: str, said: str) -> None:
    assert planned(text) == f"say({said})"


def test_what_follows_no_correction_is_not_done() -> None:
    assert isinstance(planned("go to the kitchen uh the moon"), NoPlan)


@given(st.text(max_size=LONGEST + 50), st.sampled_from(["en", "zh"]))
def test_any_text_has_a_bounded_number_of_readings(text: str, language: str) -> None:
    assert sum(1 for _ in corrected(text, "zh" if language == "zh" else "en")) <= LONGEST**2
