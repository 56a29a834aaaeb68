"""What refers to the plan before, in both languages, with the real templates: repeated, larger, mirrored, at another
pace; and what says something of its own is left to others."""

from __future__ import annotations

import asyncio

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import Happened, NoPlan, PlanRequest, Said
from tests.history import planned, ran

PLANNER = build_planner(at_home(load(environ={})), reader=False)


def after(done: str, text: str, failed: str = "") -> str | NoPlan:
    """The plan for ``text`` after the actions ``done`` and the one that ``failed``."""
    actions = [action for action in f"{done};{failed}".split(";") if action]
    happened: list[Happened] = [Said("something"), planned(*actions, "finishtask()")]
    happened += [ran(action, message="Done.") for action in actions if action != failed]
    if failed:
        happened.append(ran(failed, "failed", "It slipped."))
    found = asyncio.run(PLANNER.plan(PlanRequest(text, tuple(happened))))
    return found if isinstance(found, NoPlan) else "; ".join(map(str, found.actions))


@pytest.mark.parametrize(
    "text",
    [
        "again", "do it again", "once more please", "one more time", "Try again.", "could you do that again",
        "repeat that", "the same thing again", "再来一次", "再做一遍", "重复刚才的动作", "再试一次吧",
    ],
)  # fmt: skip
def test_all_of_it_is_done_again(text: str) -> None:
    assert after("move_left(45, 1);beep(0.2)", text) == "move_left(45, 1); beep(0.2)"
    assert after("carry(red box, A, )", text) == "carry(red box, A, )"


@pytest.mark.parametrize(
    ("text", "times"),
    [("do that two more times", 2), ("again three times", 3), ("repeat that twice", 2), ("再来两次", 2)],
)
def test_several_times(text: str, times: int) -> None:
    assert after("beep(0.2)", text) == "; ".join(["beep(0.2)"] * times)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("twice as far this time", "move_forward(1, 0.3)"),
        ("go three times as far", "move_forward(1.5, 0.3)"),
        ("half the distance", "move_forward(0.25, 0.3)"),
        ("double that", "move_forward(1, 0.3)"),
        ("the same but half as far", "move_forward(0.25, 0.3)"),
        ("走两倍远", "move_forward(1, 0.3)"),
        ("这次走一半", "move_forward(0.25, 0.3)"),
        ("the other way", "move_forward(-0.5, 0.3)"),
        ("the same backwards", "move_forward(-0.5, 0.3)"),
        ("反方向再来一次", "move_forward(-0.5, 0.3)"),
        ("the same again, but faster", "move_forward(0.5, 0.5)"),
        ("do it again slowly", "move_forward(0.5, 0.1)"),
    ],
)
def test_with_a_change(text: str, expected: str) -> None:
    assert after("move_forward(0.5, 0.3)", text) == expected


def test_a_side_that_is_said_is_the_side_whatever_it_was() -> None:
    assert after("move_left(45, 1)", "the same again but to the right") == "move_right(45, 1)"
    assert after("move_right(45, 1)", "the same again but to the right") == "move_right(45, 1)"
    assert after("move_left(45, 2)", "turn the other way") == "move_right(45, 2)"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("the same with the blue one", "carry(blue box, A, )"),
        ("the white cup too", "carry(white cup, A, )"),
        ("what about the ball", "carry(ball, A, )"),
        ("again but to the study", "carry(red box, D, )"),
        ("蓝色的杯子也是", "carry(blue cup, A, )"),
    ],
)
def test_with_another_thing_or_place(text: str, expected: str) -> None:
    assert after("carry(red box, A, )", text) == expected


def test_of_a_plan_that_failed_only_what_was_not_done_is_tried_again() -> None:
    assert after("navigation(A);beep(0.2)", "try again", failed="pick_object(red box)") == "pick_object(red box)"


def test_within_a_sentence_it_refers_to_what_was_said_before_it() -> None:
    assert (
        after("beep(0.2)", "turn left 30 degrees, then the same to the right") == "move_left(30, 1); move_right(30, 1)"
    )


@pytest.mark.parametrize(
    "text", ["again but in the kitchen", "do it", "twice as far", "the other way", "more", "faster", "the box too"]
)
def test_what_has_nothing_to_change_or_says_more_than_that_is_no_reference(text: str) -> None:
    assert isinstance(after("navigation(A)", text), NoPlan)


def test_without_a_plan_before_there_is_nothing_to_repeat() -> None:
    found = asyncio.run(PLANNER.plan(PlanRequest("do it again")))
    assert not isinstance(found, Plan)


@pytest.mark.parametrize(
    ("done", "text", "expected"),
    [
        ("locate(ball)", "pick it up", "pick_object(ball)"),
        ("locate(ball)", "put it on the desk", "pick_object(ball); place_object(desk)"),
        ("pick_object(red box)", "put it on the desk", "place_object(desk)"),
        ("pick_object(red box)", "put it down", "putdown()"),
        ("pick_object(red box)", "bring it to the kitchen", "carry(red box, A, )"),
        ("navigation(A);locate(ball)", "go to it", "navigate_to_object(ball)"),
    ],
)
def test_it_is_the_thing_that_the_plan_before_was_about(done: str, text: str, expected: str) -> None:
    assert after(done, text) == expected


def test_nothing_is_meant_by_it_where_no_thing_was_spoken_of() -> None:
    assert isinstance(after("navigation(A)", "pick it up"), NoPlan)
