"""Somebody who wants more of what the robot did last, and tells how much by a number."""

from __future__ import annotations

import asyncio

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import NoPlan, PlanRequest, Ran, Said

PLANNER = build_planner(at_home(load(environ={})), reader=False)


def after(first: str, then: str) -> Plan | NoPlan:
    """What ``then`` comes to once ``first`` has been done."""
    done = asyncio.run(PLANNER.plan(PlanRequest(first)))
    assert isinstance(done, Plan)
    said = (Said(first), done, *(Ran(action, "ok") for action in done.actions))
    return asyncio.run(PLANNER.plan(PlanRequest(then, said)))


@pytest.mark.parametrize(
    ("first", "then", "expected"),
    [
        ("turn left 90 degrees", "ten more", "move_left(10, 1)"),
        ("turn left 90 degrees", "and turn another thirty, please", "move_left(30, 1)"),
        ("turn left 90 degrees", "30 degrees more", "move_left(30, 1)"),
        ("go back 20 centimetres", "ten more", "move_forward(-0.1, 0.3)"),
        ("go forward at 0.1 m/s for half a metre", "two more", "move_forward(2, 0.1)"),
        ("wait 5 seconds", "another five", "wait(5)"),
        ("wait 5 seconds", "one more minute", "wait(60)"),
        ("beep three times", "two more", "beep(0.2); beep(0.2)"),
        ("左转九十度", "再来三十", "move_left(30, 1)"),
        ("往前走二十厘米", "还要十", "move_forward(0.1, 0.3)"),
        ("等五秒", "再来五", "wait(5)"),
    ],
)
def test_a_number_is_in_the_unit_that_was_spoken_of(first: str, then: str, expected: str) -> None:
    found = after(first, then)
    assert isinstance(found, Plan)
    assert "; ".join(map(str, found.actions)) == expected


def test_nobody_drives_ten_metres_for_a_number_that_may_mean_centimetres() -> None:
    found = after("go forward 1 metre", "ten more")
    assert isinstance(found, NoPlan)
    assert found.answer.startswith("In which unit?")


@pytest.mark.parametrize(
    ("first", "then"),
    [
        ("go to the kitchen", "ten more"),  # nothing to measure
        ("turn left 90 degrees", "30"),  # it does not say more
        ("wait 5 seconds", "ten more degrees"),  # of something else
        ("pick up the red box", "two more"),
    ],
)
def test_a_number_that_is_more_of_nothing_moves_nothing(first: str, then: str) -> None:
    found = after(first, then)
    assert isinstance(found, NoPlan)
    assert found.code == "not_understood"
