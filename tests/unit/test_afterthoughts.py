"""What belongs to a request of those words that come right after it."""

from __future__ import annotations

import asyncio

import pytest

import config
from engine.hearing.readings import Afterthought
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import PlanRequest

PLANNER = build_planner(at_home(config.load(environ={})))


def after(first: str, rest: str) -> Afterthought | None:
    return PLANNER.afterthought(first, f"{first} {rest}" if first.isascii() else first + rest)


@pytest.mark.parametrize(
    ("first", "rest"),
    [
        ("Go to the kitchen.", "And wave."),
        ("go to the kitchen", "Then dance!"),
        ("Go to the kitchen.", "then to the bedroom"),
        ("Move forward one metre.", "Turn left."),
        ("Turn left 90 degrees.", "and turn right 45 degrees"),
        ("Pick up the red box.", "put it on the table"),
        ("Pick up the red box.", "and bring it to me"),
        ("去厨房。", "然后跳舞"),
        ("向前走一米。", "然后左转"),
    ],
)
def test_a_command_of_its_own_is_done_after_the_first(first: str, rest: str) -> None:
    assert after(first, rest) == Afterthought(rest, adds=True)


@pytest.mark.parametrize(
    ("first", "rest"),
    [
        ("Raise your arm.", "and lower it again"),
        ("Wave.", "twice"),
        ("举起手臂。", "再放下"),
    ],
)
def test_what_cannot_stand_alone_makes_another_request_of_both(first: str, rest: str) -> None:
    found = after(first, rest)
    assert found is not None
    assert (found.text.startswith(first), found.text.endswith(rest), found.adds) == (True, True, False)


@pytest.mark.parametrize(
    ("first", "rest", "done"),
    [
        ("Go to the kitchen.", "No, to the bedroom.", "navigation(C)"),
        ("Go to the kitchen.", "Sorry, the bedroom.", "navigation(C)"),
        ("Pick up the red box.", "No, the blue one.", "pick_object(blue box)"),
        ("Move forward one metre.", "Sorry, back one metre.", "move_forward(-1, 0.3)"),
        ("去厨房。", "不对，去卧室", "navigation(C)"),
    ],
)
def test_a_correction_takes_the_place_of_the_first(first: str, rest: str, done: str) -> None:
    found = after(first, rest)
    assert found is not None
    assert not found.adds
    plan = asyncio.run(PLANNER.plan(PlanRequest(found.text)))
    assert isinstance(plan, Plan)
    assert "; ".join(map(str, plan.actions)) == done


@pytest.mark.parametrize("rest", ["Never mind.", "Forget it.", "No, don't.", "Actually no."])
def test_what_takes_the_first_back_leaves_nothing_to_be_done(rest: str) -> None:
    found = after("Go to the kitchen.", rest)
    assert found == Afterthought(f"Go to the kitchen. {rest}", adds=False)
    plan = asyncio.run(PLANNER.plan(PlanRequest(found.text)))
    assert isinstance(plan, Plan)
    assert plan.actions == ()


@pytest.mark.parametrize("rest", ["and then tell me a joke about cats", "go to the casino"])
def test_what_is_more_than_phrases_know_is_answered(rest: str) -> None:
    assert after("Go to the kitchen.", rest) == Afterthought(rest, adds=True, clear=False)


@pytest.mark.parametrize(
    ("first", "rest"),
    [
        ("Go to the kitchen.", ""),
        ("Go to the kitchen.", "please"),
        ("Go to the kitchen.", "Thank you."),
        ("Go to the kitchen.", "Sorry."),
        ("Go to the kitchen.", "No rush."),
        ("Go to the kitchen.", "Go to the kitchen."),
        ("Go to the kitchen.", "and then"),
        ("Go to the kitchen.", "Did you see the match?"),
        ("Go to the kitchen.", "ten of clubs"),
        ("Go to the kitchen.", "Stop."),
        ("Turn left 45 degrees.", "and then right"),  # by how much it has turned by now, nobody knows
        ("Tell me a joke.", "and wave"),
        ("去厨房。", "谢谢"),
    ],
)
def test_all_else_is_none_of_it(first: str, rest: str) -> None:
    assert after(first, rest) is None


def test_what_was_understood_differently_the_second_time_adds_nothing() -> None:
    assert PLANNER.afterthought("Go to the kitchen.", "Go to the bedroom and wave.") is None
