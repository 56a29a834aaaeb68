"""What a form composes is planned as exactly the action that the form was about, in any language."""

from __future__ import annotations

import asyncio
from functools import cache

import pytest

from config import load
from config.schema import Settings
from engine.plan import Plan
from engine.planner.build import build_planner, build_registry
from engine.planner.planner import Planner, PlanRequest
from engine.skills.library import LIBRARY
from engine.skills.registry import Parameter, Skill
from tests.tui.house import offer
from tui.palette.arguments import NotRight, blanks, value_of
from tui.palette.calls import Values, as_written

WORDS = {
    "place": "study", "places": "study, kitchen", "object": "red box", "surface": "desk", "room": "kitchen",
    "thing_colour": "red", "colour": "green", "sentence": "hello there", "person": "William", "people": "William",
}  # fmt: skip
NUMBERS = {"m": 0.8, "deg": 45.0, "s": 3.0, "m/s": 0.4, "rad/s": 0.5, "": 2.0}
MEANT = {"place": "D", "places": "D,A"}


@cache
def settings() -> Settings:
    return load()


@cache
def planner() -> Planner:
    return build_planner(settings(), build_registry(settings()))


def planned(text: str) -> list[tuple[str, dict[str, float | str]]]:
    found = asyncio.run(planner().plan(PlanRequest(text)))
    assert isinstance(found, Plan), (text, found)
    return [(action.name, dict(action.args)) for action in found.actions]


def value(parameter: Parameter) -> float | str:
    return WORDS[parameter.word] if parameter.word else NUMBERS[parameter.unit]


def meant(skill: Skill, values: Values) -> dict[str, float | str]:
    """What the action has for these values: names as the registry resolves them, and the usual for what is left out."""
    found: dict[str, float | str] = {}
    for parameter in skill.parameters:
        given = values.get(parameter.name, parameter.default)
        assert given is not None
        found[parameter.name] = MEANT.get(parameter.word or "", given) if parameter.name in values else given
    return found


@pytest.mark.parametrize("skill", LIBRARY, ids=lambda skill: skill.name)
@pytest.mark.parametrize("all_of_them", [False, True], ids=["least", "all"])
def test_what_a_form_writes_is_what_the_form_is_about(skill: Skill, all_of_them: bool) -> None:
    values = {p.name: value(p) for p in skill.parameters if all_of_them or p.default is None}
    assert planned(as_written(skill, values)) == [(skill.name, meant(skill, values))]


def test_a_negative_distance_goes_the_other_way() -> None:
    [forward] = [skill for skill in LIBRARY if skill.name == "move_forward"]
    assert planned(as_written(forward, {"distance": -0.5}))[0][1]["distance"] == -0.5


def test_the_remembered_place_and_a_chinese_one_can_be_gone_to() -> None:
    [skill] = [skill for skill in LIBRARY if skill.name == "navigation"]
    assert planned(as_written(skill, {"place": "zero"})) == [("navigation", {"place": "zero"})]
    assert planned(as_written(skill, {"place": "厨房"})) == [("navigation", {"place": "A"})]


def test_what_somebody_has_to_be_told_may_hold_marks() -> None:
    [skill] = [skill for skill in LIBRARY if skill.name == "say"]
    text = 'mind the step (the "low" one), it\'s \\ wet'
    assert planned(as_written(skill, {"text": text})) == [("say", {"text": text})]


# Arguments


def blank_of(skill: str, name: str):  # type: ignore[no-untyped-def]
    [found] = [one for one in LIBRARY if one.name == skill]
    return next(blank for blank in blanks(found, offer()) if blank.name == name)


def test_a_blank_says_unit_limits_and_the_usual_value() -> None:
    speed = blank_of("move_forward", "speed")
    assert (speed.unit, speed.usual, speed.limits, speed.required) == ("m/s", "0.3", "0.02 to 1", False)
    distance = blank_of("move_forward", "distance")
    assert (distance.unit, distance.usual, distance.required) == ("m", "", True)


def test_a_blank_for_a_place_or_a_thing_lists_those_of_the_house() -> None:
    assert "kitchen" in blank_of("navigation", "place").choices
    assert "red box" in blank_of("pick_object", "object").choices
    assert "desk" in blank_of("place_object", "surface").choices
    assert blank_of("light", "color").choices[:2] == ("off", "white")
    assert "bedroom" in blank_of("clean_room", "room").choices


def test_things_that_lie_about_come_first() -> None:
    [skill] = [one for one in LIBRARY if one.name == "pick_object"]
    [blank] = blanks(skill, offer(), ("green cup",))
    assert blank.choices[0] == "green cup"


@pytest.mark.parametrize(
    ("written", "read"), [("0.5", 0.5), ("50 cm", 0.5), ("50cm", 0.5), ("-1", -1.0), ("0,5", 0.5), (".5 m", 0.5)]
)
def test_a_number_is_read_in_the_unit_of_its_parameter(written: str, read: float) -> None:
    assert value_of(blank_of("move_forward", "distance"), written) == pytest.approx(read)


@pytest.mark.parametrize(
    ("skill", "name", "written", "complaint"),
    [
        ("move_forward", "distance", "", "missing"),
        ("move_forward", "distance", "far", "a number"),
        ("move_forward", "distance", "nan", "a number"),
        ("move_forward", "distance", "3 s", "cannot be converted"),
        ("move_forward", "distance", "80", "-50 to 50 m"),
        ("move_forward", "speed", "9", "0.02 to 1 m/s"),
        ("navigation", "place", "  ", "missing"),
    ],
)
def test_what_cannot_be_an_argument_is_said(skill: str, name: str, written: str, complaint: str) -> None:
    with pytest.raises(NotRight, match=complaint):
        value_of(blank_of(skill, name), written)


def test_nothing_written_is_the_usual_value() -> None:
    assert value_of(blank_of("move_forward", "speed"), "") is None
