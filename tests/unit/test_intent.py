"""Every plan is also told as an intent: an action, a target, where to, and what is unclear."""

from __future__ import annotations

import json

import msgspec
import pytest

from config import load
from engine.errors import ExitCode
from engine.events import ClarificationAsked, PlanMade, PlanRejected, RefusalMade
from engine.plan import Plan, parse_calls
from engine.planner.build import build_registry
from engine.planner.intent import intent_of, with_intent
from engine.planner.request import NoPlan

SETTINGS = load(environ={})
REGISTRY = build_registry(SETTINGS)
NAMES = {symbol: place.name for symbol, place in SETTINGS.places.items()}


def plan(written: str) -> Plan:
    actions = tuple(REGISTRY.resolve(call) for call in parse_calls(written))
    return Plan("what was said", actions, "all right", "phrases")


@pytest.mark.parametrize(
    ("written", "action", "target", "secondary", "goal"),
    [
        ("pick_object(red box)", "pick_up", "red box", None, "pick_up_red_box"),
        ("navigation(A)", "navigate", "kitchen", None, "navigate_to_kitchen"),
        ("clean_room(kitchen)", "clean_room", "kitchen", None, "clean_room_kitchen"),
        ("clean_room()", "clean_room", None, None, "clean_room"),
        ("pick_object(cup); place_object(coffee table)", "place", "cup", "coffee table", "place_cup_on_coffee_table"),
        ("pick_object(cup); place_in_bin()", "place", "cup", "bin", "place_cup_in_bin"),
        ("pick_object(cup); navigation(A); putdown()", "place", "cup", "kitchen", "place_cup_on_kitchen"),
        ("carry(blue cup, A)", "bring", "blue cup", "kitchen", "bring_blue_cup_to_kitchen"),
        ("navigation(A); seewhat(); carry(cup, zero)", "bring", "cup", "zero", "bring_cup_to_zero"),
        ("locate(ball); navigate_to_object(ball)", "approach", "ball", None, "approach_ball"),
        ("move_left(90); beep()", "beep", None, None, "beep"),
        ("move_forward(1); navigation(B); beep()", "navigate", "living room", None, "navigate_to_living_room"),
        ("patrol('A,B')", "patrol", "kitchen, living room", None, "patrol_kitchen_living_room"),
        ("apriltag_follow()", "follow", None, None, "follow"),
        ("apriltag_sort(3)", "sort", "3", None, "sort_3"),
        ("tidy(red, stool)", "tidy", "red", "stool", "tidy_red_on_stool"),
        ("finish_dialogue()", "end_task", None, None, "end_task"),
        ("dance()", "dance", None, None, "dance"),
    ],
)
def test_the_action_that_the_others_serve_names_the_intent(
    written: str, action: str, target: str | None, secondary: str | None, goal: str
) -> None:
    intent = intent_of(plan(written), NAMES)
    assert (intent.action, intent.target, intent.secondary_location, intent.goal) == (action, target, secondary, goal)
    assert intent.ambiguity is None
    assert intent.clarification_question is None


@pytest.mark.parametrize(
    ("written", "steps"),
    [
        ("pick_object(red box)", ("locate", "navigate", "grasp", "lift")),
        ("navigation(A)", ("plan_path", "execute", "confirm_arrival")),
        (
            "clean_room()",
            ("scan_room", "identify_dirty_objects", "navigate_to_object", "pick_object", "place_in_bin"),
        ),
        ("move_forward(1); beep()", ("move_forward", "beep")),
        ("navigation(A); beep()", ("plan_path", "execute", "confirm_arrival", "beep")),
    ],
)
def test_the_steps_are_those_that_the_skills_go_through(written: str, steps: tuple[str, ...]) -> None:
    assert intent_of(plan(written)).steps == steps


def test_every_skill_can_be_told_as_an_intent() -> None:
    for skill in REGISTRY:
        values = {"place": "A", "places": "A", "object": "cup", "surface": "stool", "room": "kitchen", "colour": "red",
                  "thing_colour": "red", "sentence": "hello", "person": "William", "people": "William"}  # fmt: skip
        arguments = ", ".join(
            f"{p.low:g}" if p.low is not None else f"'{values[p.word or 'sentence']}'" for p in skill.parameters
        )
        intent = intent_of(plan(f"{skill.name}({arguments})"), NAMES)
        assert intent.action
        assert intent.steps
        assert intent.goal.isidentifier()


def test_a_place_without_a_known_name_is_told_by_its_symbol() -> None:
    assert intent_of(plan("navigation(A)")).target == "A"


def test_a_plan_without_actions_is_an_answer() -> None:
    assert intent_of(Plan("how are you", (), "Fine.", "local")).action == "respond"


@pytest.mark.parametrize(
    ("text", "action", "target", "ambiguity"),
    [
        ("pick up the thing", "pick_up", "thing", "target"),
        ("pick up the box", "pick_up", "box", "target"),
        ("pick it up", "pick_up", None, "target"),
        ("bring the cup over there", "bring", "cup", "target"),
        ("bring the cup", "bring", "cup", "location"),
        ("put the red box away", "place", "red box", "location"),
        ("go there", "navigate", None, "location"),
        ("go forward", "move", None, "amount"),
        ("turn", "turn", None, "amount"),
        ("把那个东西拿起来", "pick_up", None, "target"),
        ("hmm", "clarify", None, "request"),
    ],
)
def test_a_question_is_told_with_what_is_known_and_what_is_not(
    text: str, action: str, target: str | None, ambiguity: str
) -> None:
    intent = intent_of(NoPlan(text, "unclear", "Which one?", ExitCode.CLARIFY))
    assert (intent.action, intent.target, intent.ambiguity) == (action, target, ambiguity)
    assert intent.clarification_question == "Which one?"
    assert intent.goal == "ask_for_clarification"
    assert intent.steps == ()


def test_what_is_refused_or_not_understood_is_no_action() -> None:
    assert intent_of(NoPlan("hit the cat", "refused_harm", "No.", ExitCode.REFUSED)).action == "refuse"
    assert intent_of(NoPlan("blah", "not_understood", "What?")).action == "error"


def test_events_carry_the_intent_where_they_have_a_field_for_it() -> None:
    made = with_intent(plan("navigation(A)"), NAMES)
    assert isinstance(made, PlanMade)
    assert made.intent is not None
    assert made.intent.target == "kitchen"
    asked = with_intent(NoPlan("pick up the thing", "unclear", "Which thing?", ExitCode.CLARIFY))
    assert isinstance(asked, ClarificationAsked)
    assert asked.intent is not None
    assert asked.intent.clarification_question == "Which thing?"
    assert isinstance(with_intent(NoPlan("x", "refused_harm", "No.", ExitCode.REFUSED)), RefusalMade)
    assert isinstance(with_intent(NoPlan("x", "not_understood", "What?")), PlanRejected)


def test_an_intent_is_json_with_the_fields_of_the_older_system() -> None:
    encoded = json.loads(msgspec.json.encode(intent_of(plan("carry(blue cup, A)"), NAMES)))
    assert encoded == {
        "action": "bring",
        "target": "blue cup",
        "secondary_location": "kitchen",
        "ambiguity": None,
        "clarification_question": None,
        "goal": "bring_blue_cup_to_kitchen",
        "steps": ["locate", "navigate", "grasp", "lift", "navigate", "place"],
    }
