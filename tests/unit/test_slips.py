"""What small models get wrong and the words of the request set right, and what they leave out, in the flat's words."""

from __future__ import annotations

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import ActionCall, Quantity, parse_calls
from engine.planner.build import build_registry
from engine.planner.stages.omissions import left_out
from engine.planner.stages.slips import mended
from engine.planner.worlds.house import build_vocabulary
from engine.skills.registry import NOT_SAID

SETTINGS = at_home(load(environ={}))
VOCABULARY = build_vocabulary(SETTINGS)
REGISTRY = build_registry(SETTINGS)


@pytest.mark.parametrize(
    ("text", "proposed", "meant"),
    [
        ("spin round anticlockwise", "move_right(360)", "move_left(360)"),
        ("swivel clockwise", "move_left(90)", "move_right(90)"),
        ("shuffle a bit to your left, 0.3 m", "move_sideways(-0.3)", "move_sideways(0.3)"),
        ("顺时针转九十度", "move_left(90)", "move_right(90)"),
        ("drive up to the blue mug", "navigation(blue mug)", "navigate_to_object(blue mug)"),
        ("is anything lying on the coffee table", "seewhat()", "navigation(coffee table); seewhat()"),
        ("have a nose round the study", "seewhat()", "scan_room(study)"),
        ("the bedroom is a mess", f"tidy({NOT_SAID}, bin)", "clean_room(bedroom)"),
        ("fetch me the bottle", "pick_object(bottle); putdown()", "carry(bottle, zero)"),
        ("fetch me the bottle from the stool", "navigation(stool); pick_object(bottle)", "carry(bottle, zero, stool)"),
        ("follow the blue line and shove things aside", "follow_line(blue); follow_line_clear()",
         "follow_line_clear(blue)"),
        ("go home and charge", "navigation(charging dock); navigation(charging dock)", "navigation(charging dock)"),
    ],
)  # fmt: skip
def test_a_slip_is_mended(text: str, proposed: str, meant: str) -> None:
    assert mended(parse_calls(proposed), text, VOCABULARY) == parse_calls(meant)


@pytest.mark.parametrize(
    ("text", "proposed"),
    [
        ("turn left and then right", "move_left(90); move_right(90)"),
        ("turn left and then back again", "move_left(90); move_right(90)"),
        ("turn right now", "move_left(90)"),
        ("pick up the red box", "pick_object(red box)"),
        ("what is in front of you", "seewhat()"),
        ("look at the sofa and then at the desk", "seewhat()"),
        ("put all red things on the desk", "tidy(red, desk)"),
        ("go to the kitchen, bring me the bottle", "navigation(A); carry(bottle, zero)"),
        ("go to the moon", "navigation(moon)"),
    ],
)
def test_what_may_be_right_is_left_alone(text: str, proposed: str) -> None:
    assert mended(parse_calls(proposed), text, VOCABULARY) == parse_calls(proposed)


def omitted(text: str, planned: str) -> str:
    actions = [REGISTRY.resolve(call) for call in parse_calls(planned)]
    return left_out(actions, text, VOCABULARY)


@pytest.mark.parametrize(
    ("text", "planned", "missing"),
    [
        ("start in the living room and finish up at the dock", "navigation(living room)", "dock"),
        ("grab the white cup and the red box", "pick_object(white cup)", "red box"),
        ("roam about in the kitchen", "scan_room()", "kitchen"),
    ],
)
def test_what_a_plan_has_nothing_of_is_found(text: str, planned: str, missing: str) -> None:
    assert omitted(text, planned) == missing


@pytest.mark.parametrize(
    ("text", "planned"),
    [
        ("back it up a yard and then face the other way", "move_forward(-0.9); move_left(180)"),
        ("the white cup belongs on the coffee table", "pick_object(white cup); place_object(coffee table)"),
        ("the bottle is rubbish, in the bin with it", "pick_object(bottle); place_in_bin()"),
        ("take the red cube to the kitchen door", "carry(red box, kitchen door)"),
        ("could you bring me that mug", "carry(cup, zero)"),
        ("pick it up off the floor", "pick_object(red box)"),
    ],
)
def test_a_whole_plan_leaves_nothing_out(text: str, planned: str) -> None:
    assert omitted(text, planned) == ""


def test_an_action_of_nobody_is_no_slip() -> None:
    calls = (ActionCall("fly", ("moon",)),)
    assert mended(calls, "fly to the moon", VOCABULARY) == calls


@pytest.mark.parametrize(
    ("text", "only_taken"),
    [
        ("grab the red box", True),
        ("take the one red box there is", True),
        ("take the red box somewhere else", False),
        ("put the red box", False),
        ("把红盒子拿起来", True),
        ("把红盒子拿到那边", False),
    ],
)
def test_who_takes_a_thing_and_names_no_place_only_picks_it_up(text: str, only_taken: bool) -> None:
    carried = (ActionCall("carry", ("red box", NOT_SAID)),)

    assert mended(carried, text, VOCABULARY) == ((ActionCall("pick_object", ("red box",)),) if only_taken else carried)


@pytest.mark.parametrize(
    ("text", "quarter"),
    [("would you be a dear and turn left", True), ("turn left some more", False), ("turn left by that angle", False)],
)
def test_a_turn_to_a_side_is_a_quarter_unless_an_amount_is_spoken_of(text: str, quarter: bool) -> None:
    turned = (ActionCall("move_left", (NOT_SAID,)),)

    assert mended(turned, text, VOCABULARY) == (
        (ActionCall("move_left", (Quantity(90, "deg"),)),) if quarter else turned
    )
