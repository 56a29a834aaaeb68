"""What people say in another order, of several things at once, after some background, or as it was misheard."""

from __future__ import annotations

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.readings.corrections import LONGEST
from engine.planner.readings.order import in_order
from engine.planner.request import NoPlan, PlanRequest

PLANNER = build_planner(at_home(load(environ={})), reader=False)
WHOLE = build_planner(at_home(load(environ={})))
"""With the learned reader."""


def planned(text: str) -> str:
    found = asyncio.run(PLANNER.plan(PlanRequest(text)))
    return "; ".join(map(str, found.actions)) if isinstance(found, Plan) else found.code


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("before going to the kitchen turn around", "move_left(180, 1); navigation(A)"),
        ("wave before you go to the kitchen", "arm_shake(); navigation(A)"),
        ("once you've dropped the ball in the bin go to the sofa", "pick_object(ball); place_in_bin(); navigation(H)"),
        ("go to the kitchen after waving", "arm_shake(); navigation(A)"),
        ("go to the kitchen, but first beep", "beep(0.2); navigation(A)"),
        ("go to the sofa but beep before you set off", "beep(0.2); navigation(H)"),
        ("dont go to the kitchen until youve picked up the ball", "pick_object(ball); navigation(A)"),
        ("on your way to the bedroom pick up the green box", "pick_object(green box); navigation(C)"),
        ("instead of the kitchen go to the study", "navigation(D)"),
        ("leave the bedroom alone and go to the hall", "navigation(E)"),
        ("去厨房之前先转一圈", "move_left(360, 1); navigation(A)"),
        ("把球放进垃圾桶之后去沙发", "pick_object(ball); place_in_bin(); navigation(H)"),
        ("不要去厨房，去书房", "navigation(D)"),
    ],
)
def test_steps_are_done_in_the_order_that_was_meant(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "put the red box, the blue box and the green box on the workbench",
            "pick_object(red box); place_object(workbench); pick_object(blue box); place_object(workbench); "
            "pick_object(green box); place_object(workbench)",
        ),
        (
            "get the bottle and the white cup and put them both on the coffee table",
            "pick_object(bottle); place_object(coffee table); pick_object(white cup); place_object(coffee table)",
        ),
        ("take the cups to the kitchen", "carry(white cup, A, ); carry(blue cup, A, )"),
        (
            "throw both cups away then come back",
            "pick_object(white cup); place_in_bin(); pick_object(blue cup); place_in_bin(); navigation(zero)",
        ),
        (
            "both cups should go to the study, the white one and the blue one",
            "carry(white cup, D, ); carry(blue cup, D, )",
        ),
    ],
)
def test_several_things_are_taken_one_after_the_other(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("that bottle's empty, bin it", "pick_object(bottle); place_in_bin()"),
        ("My wife is in the bedroom, would you mind driving there?", "navigation(C)"),
        ("there should be a bottle in the kitchen grab it", "pick_object(bottle)"),
        ("the green box, leave it in the bedroom", "carry(green box, C, )"),
        ("the ball can live in the bedroom from now on take it there", "carry(ball, C, )"),
        ("my little one lost a ball in the living room, see if you can spot it", "locate(ball)"),
    ],
)
def test_what_is_told_first_says_what_the_request_is_about(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Could you shift 20 centimetres to your left? You're blocking my wheel.", "move_sideways(0.2, 0.25)"),
        ("beep for three seconds so I can hear where you are", "beep(3)"),
        ("bring me the blue cup, would you? I fancy some tea.", "carry(blue cup, zero, )"),
        ("Beep once so I know you heard me, and then bring me the cup.", "ambiguous"),
        ("go to the kitchen, you must not go to the bedroom", "no_order"),
    ],
)
def test_a_reason_behind_a_request_changes_nothing_and_hides_nothing(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "she let him go to the kitchen",
        "the cat can move forward one metre",
        "say before you go",
    ],
)
def test_what_asks_for_nothing_leads_nowhere(text: str) -> None:
    assert planned(text) == "not_understood"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("turn write ninety degrees", "move_right(90, 1)"),
        ("can u go 2 the kitchen pls", "navigation(A)"),
        ("if theres a cup on the stool take it 2 the kitchen", "navigation(L); seewhat()"),
        ("go too the book shelf", "navigation(J)"),
        ("go to the coffeetable", "navigation(G)"),
        ("go to the kitcheeen", "navigation(A)"),
    ],
)
def test_what_was_misheard_is_understood(text: str, expected: str) -> None:
    assert planned(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Go to the doorway of the kitchen.", "navigation(T)"),
        ("proceed to the counter in the kitchen", "navigation(M)"),
        ("Everything that is red, put it on the coffee table.", "tidy(red, coffee table)"),
        ("I'd be much obliged if you went over to the bookshelf.", "navigation(J)"),
        ("could the blue box be taken to the study please", "carry(blue box, D, )"),
        ("Tell everybody in the living room that the food is ready.", "navigation(B); say(the food is ready)"),
        ("去客厅告诉大家开饭了", "navigation(B); say(开饭了)"),
        ("Right, go to the sofa then.", "navigation(H)"),
        ("厨房那边需要你", "navigation(A)"),
        ("get the bottle and the white cup and put them both on the coffee table",
         "carry(bottle, G, ); carry(white cup, G, )"),
        ("I need the red box on the desk.", "carry(red box, N, )"),
    ],
)  # fmt: skip
def test_a_long_way_to_say_something_is_understood(text: str, expected: str) -> None:
    found = asyncio.run(WHOLE.plan(PlanRequest(text)))
    assert isinstance(found, Plan), found
    assert "; ".join(map(str, found.actions)) == expected


@pytest.mark.parametrize("text", ["the kitchen", "red box", "sitting room", "everything that is red"])
def test_a_name_alone_moves_nothing(text: str) -> None:
    assert planned(text) in ("not_understood", "incomplete", "unknown_place")


def test_what_is_left_where_it_is_is_not_put_anywhere() -> None:
    assert planned("there is a mug on the desk, leave the kitchen alone") == "no_order"
    assert planned("my phone is on the bed, leave everything there") == "not_understood"


def test_nothing_is_put_anywhere_that_is_not_held_or_named() -> None:
    assert planned("throw it away") == planned("put it on the stool") == "incomplete"
    held = asyncio.run(PLANNER.plan(PlanRequest("throw it away", holding="red box")))
    assert isinstance(held, Plan)
    assert [action.name for action in held.actions] == ["place_in_bin"]


@pytest.mark.parametrize("text", ["oh never mind", "nah it's fine", "Forget it.", "算了", "不用了，谢谢"])
def test_a_request_that_is_taken_back_ends_there(text: str) -> None:
    asked = PlanRequest(text)
    found = asyncio.run(PLANNER.plan(asked))
    assert isinstance(found, Plan)
    assert not found.actions
    assert found.response


def test_a_name_of_several_pieces_of_furniture_is_asked_about() -> None:
    found = asyncio.run(PLANNER.plan(PlanRequest("go to the chair")))
    assert isinstance(found, NoPlan)
    assert found.answer.startswith("Which chair: ")


@given(st.text(max_size=LONGEST + 50), st.sampled_from(["en", "zh"]))
def test_any_text_has_a_bounded_number_of_readings(text: str, language: str) -> None:
    assert len(list(in_order(text, language))) < 1000  # type: ignore[arg-type]


@pytest.mark.parametrize("text", ["go up the stairs to the bedroom", "go upstairs and fetch the ball"])
def test_what_the_robot_cannot_do_is_no_plan_of_the_reader_either(text: str) -> None:
    assert isinstance(asyncio.run(WHOLE.plan(PlanRequest(text))), NoPlan)
