"""What a form composes is understood by phrases, as exactly the action that the form was about."""

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
from tui.palette.requests import Values, is_plain, request

FOR_MODELS = {"grasp_obj", "track", "get_dist", "ask_user", "finishtask"}
"""Skills that nobody asks for: they need a pixel, or belong to a plan."""
AFTER_PICKING = {"place_object", "place_in_bin"}
"""What is only understood while something is held."""
WORDS = {
    "place": "study", "places": "study, kitchen", "object": "red box", "surface": "desk", "room": "kitchen",
    "thing_colour": "red", "colour": "green", "sentence": "hello there",
}  # fmt: skip
NUMBERS = {"m": 0.8, "deg": 45.0, "s": 3.0, "m/s": 0.4, "rad/s": 0.5, "": 2.0}
MEANT = {"place": "D", "places": "D,A"}


@cache
def settings() -> Settings:
    return load()


@cache
def planner() -> Planner:
    return build_planner(settings(), build_registry(settings()))


def planned(text: str, *, holding: bool = False) -> list[tuple[str, dict[str, float | str]]]:
    found = asyncio.run(planner().plan(PlanRequest(text, holding=holding)))
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


ASKED = [skill for skill in LIBRARY if skill.name not in FOR_MODELS | {"set_cmdvel"}]


@pytest.mark.parametrize("skill", ASKED, ids=lambda skill: skill.name)
@pytest.mark.parametrize("all_of_them", [False, True], ids=["least", "all"])
def test_what_a_form_says_means_what_the_form_is_about(skill: Skill, all_of_them: bool) -> None:
    values = {p.name: value(p) for p in skill.parameters if all_of_them or p.default is None}
    text = request(skill, values)
    assert is_plain(skill, text)
    expected = [(skill.name, meant(skill, values))]
    if skill.name == "place_in_bin":
        assert planned(text, holding=True)[0][0] in ("place_in_bin", "place_object")
        return
    assert planned(text, holding=skill.name in AFTER_PICKING) == expected


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (
            {"linear_x": 0.2, "linear_y": 0.0, "angular_z": 0.0, "duration": 2.0},
            "move forward at 0.2 m/s for 2 seconds",
        ),
        ({"linear_x": -0.2, "linear_y": 0.0, "angular_z": 0.0, "duration": 2.0}, "move back at 0.2 m/s for 2 seconds"),
        ({"linear_x": 0.0, "linear_y": -0.2, "angular_z": 0.0, "duration": 2.0}, "move right at 0.2 m/s for 2 seconds"),
        ({"linear_x": 0.0, "linear_y": 0.0, "angular_z": 0.5, "duration": 2.0}, "turn left at 0.5 rad/s for 2 seconds"),
    ],
)
def test_a_velocity_along_one_axis_has_words(values: Values, text: str) -> None:
    skill = next(skill for skill in LIBRARY if skill.name == "set_cmdvel")
    assert request(skill, values) == text
    assert planned(text) == [("set_cmdvel", values)]


def test_a_negative_distance_goes_the_other_way() -> None:
    [forward] = [skill for skill in LIBRARY if skill.name == "move_forward"]
    [sideways] = [skill for skill in LIBRARY if skill.name == "move_sideways"]
    assert planned(request(forward, {"distance": -0.5}))[0][1]["distance"] == -0.5
    assert planned(request(sideways, {"distance": -0.5}))[0][1]["distance"] == -0.5


def test_the_remembered_place_and_a_chinese_one_can_be_gone_to() -> None:
    [skill] = [skill for skill in LIBRARY if skill.name == "navigation"]
    assert planned(request(skill, {"place": "zero"})) == [("navigation", {"place": "zero"})]
    assert planned(request(skill, {"place": "厨房"})) == [("navigation", {"place": "A"})]


def test_what_has_no_words_is_written_as_a_model_writes_it() -> None:
    [skill] = [skill for skill in LIBRARY if skill.name == "get_dist"]
    text = request(skill, {"x": 80.0, "y": 60.0})
    assert text == "get_dist(x=80, y=60)"
    assert not is_plain(skill, text)


def test_every_skill_of_the_library_has_words_but_for_those_of_models() -> None:
    bare = {
        skill.name
        for skill in LIBRARY
        if not is_plain(skill, request(skill, {p.name: value(p) for p in skill.parameters}))
    }
    assert bare - {"set_cmdvel"} == FOR_MODELS  # a velocity in all directions at once has none


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
