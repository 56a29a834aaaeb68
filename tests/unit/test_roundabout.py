"""Requests that go round about, and what has to stay a question although it sounds like them."""

from __future__ import annotations

import asyncio

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import Happened, NoPlan, PlanRequest, Said
from tests import history

PLANNER = build_planner(at_home(load(environ={})), reader=False)


def planned(text: str, *happened: Happened, holding: str = "", seen: tuple[str, ...] = ()) -> str:
    found = asyncio.run(PLANNER.plan(PlanRequest(text, happened, holding=holding, seen=seen)))
    return "; ".join(map(str, found.actions)) if isinstance(found, Plan) else found.code


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("your next stop is the bedroom", "navigation(C)"),
        ("go to the room with the desk in it", "navigation(D)"),
        ("go where I sleep", "navigation(C)"),
        ("amble over to the sofa", "navigation(H)"),
        ("head to the study via the kitchen", "navigation(A); navigation(D)"),
        ("I need your help in the kitchen", "navigation(A)"),
    ],
)
def test_a_journey_need_not_be_ordered_as_one(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "having put the yellow box in the bin, go to the hall",
            "pick_object(yellow box); place_in_bin(); navigation(E)",
        ),
        ("lift your arm, keep it up for three seconds, and let it down", "arm_up(); wait(3); arm_down()"),
        ("in the hall, nod and beep", "navigation(E); arm_nod(); beep(0.2)"),
        ("two things. first go to the hall. second, beep.", "navigation(E); beep(0.2)"),
        ("turn your light green while you drive to the sofa", "light(green); navigation(H)"),
        ("shake for no, then clap", "not_understood"),
    ],
)
def test_steps_are_found_in_clauses_of_any_form(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "point to the kitchen",
        "my brother is in the kitchen",
        "be in the hall when the bell rings",
    ],
)
def test_what_only_names_a_place_is_no_journey_there(text: str) -> None:
    assert planned(text) == "not_understood"


@pytest.mark.parametrize("text", ["I need the light on", "I want my coffee in the morning"])
def test_a_wish_that_is_about_nothing_in_the_house_moves_nothing(text: str) -> None:
    assert planned(text) == "not_understood"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "get the bottle off the workbench, and go into the kitchen",
            "navigation(P); pick_object(bottle); navigation(A)",
        ),
        ("put the red box in the bin and the ball next to it", "not_understood"),
    ],
)
def test_a_thing_goes_from_here_to_there_and_another_one_beside_it(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize("text", ["get off the desk", "drive off the table", "move the table into the wall"])
def test_what_moves_the_robot_over_an_edge_or_things_into_walls_stays_refused(text: str) -> None:
    assert planned(text).startswith("refused_")


def test_furniture_without_a_place_is_offered_by_its_room() -> None:
    asked = asyncio.run(PLANNER.plan(PlanRequest("go to the armchair")))
    assert isinstance(asked, NoPlan)
    happened = (Said("go to the armchair"), asked)
    assert planned("yes please", *happened) == "navigation(B)"


def test_a_thing_is_put_back_only_where_it_was_said_to_be() -> None:
    def after(told: str) -> str:
        done = (Said(told), history.planned("pick_object(white cup)"))
        return planned("put it back where you got it", *done, holding="white cup")

    assert after("pick up the white cup from the stool") == "place_object(stool)"
    assert after("pick up the white cup") == "incomplete"


@pytest.mark.parametrize(
    ("seen", "expected"), [(("red box", "blue box"), "beep(0.2); beep(0.2)"), (("red box",), "arm_nod()")]
)
def test_things_with_names_of_their_own_are_counted(seen: tuple[str, ...], expected: str) -> None:
    text = "if there are two boxes on the coffee table, beep twice, otherwise nod"
    looks = asyncio.run(PLANNER.plan(PlanRequest(text)))
    assert isinstance(looks, Plan)
    assert not looks.finished
    said = (Said(text), looks, history.ran("seewhat()"))
    found = asyncio.run(PLANNER.plan(PlanRequest("", said, sees=seen.__contains__)))
    assert isinstance(found, Plan)
    assert "; ".join(map(str, found.actions)) == expected


def test_nobody_claims_to_count_what_shares_a_name() -> None:
    assert planned("if there are two bottles on the stool, beep") == "uncounted"
