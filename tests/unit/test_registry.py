"""The registry: the only door between text and motion."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema import Place, Position
from engine.errors import ExitCode, PlanError
from engine.plan import Action, parse_call
from engine.skills.context import SkillContext
from engine.skills.library import LIBRARY
from engine.skills.outcome import Result, ok
from engine.skills.places import Places, UnknownPlace
from engine.skills.registry import Distance, OutOfRange, SkillRegistry, UnknownSkill, skill

PLACES = Places(
    {
        "A": Place(name="kitchen", position=Position(x=1, y=2)),
        "B": Place(name="living room", aliases=("lounge",), position=Position(x=3, y=4)),
    }
)
EVERYTHING = frozenset({"base", "arm", "camera", "voice"})
REGISTRY = SkillRegistry(LIBRARY, capabilities=EVERYTHING, vocabulary={"place": PLACES.symbol})


def resolve(text: str) -> Action:
    return REGISTRY.resolve(parse_call(text))


def test_actions_of_the_older_systems_resolve_to_typed_arguments() -> None:
    assert resolve("set_cmdvel(0.5, 0, 0, 2)").args == {
        "linear_x": 0.5,
        "linear_y": 0.0,
        "angular_z": 0.0,
        "duration": 2.0,
    }
    assert resolve("navigation(B)").args == {"place": "B"}
    assert resolve("navigation(zero)").args == {"place": "zero"}
    assert resolve("move_left(30, 1.5)").args == {"angle": 30.0, "angular_speed": 1.5}


@pytest.mark.parametrize(
    ("written", "metres"),
    [("50 cm", 0.5), ("50cm", 0.5), ("0.5 metres", 0.5), ("500 mm", 0.5), ("-2 m", -2.0), ("1", 1.0)],
)
def test_units_are_converted_to_the_parameter_s_own(written: str, metres: float) -> None:
    assert resolve(f"move_forward({written})").args["distance"] == pytest.approx(metres)


def test_radians_become_degrees_where_degrees_are_meant() -> None:
    assert resolve("move_left(1.5707963 rad)").args["angle"] == pytest.approx(90)


def test_defaults_are_filled_in() -> None:
    assert resolve("move_forward(1)").args["speed"] == 0.3


@pytest.mark.parametrize(
    ("written", "complaint"),
    [
        ("fly(1)", "There is no skill 'fly'"),
        ("move_forwards(1)", "did you mean move_forward?"),
        ("move_forward()", "distance is missing"),
        ("move_forward(1, 0.3, 4)", "takes 2 arguments, 3 were given"),
        ("move_forward(1, distance=2)", "distance is given twice"),
        ("move_forward(1, height=2)", "has no argument 'height'"),
        ("move_forward(far)", "is a number in m"),
        ("move_forward(1 deg)", "cannot be converted"),
        ("wait(2 m)", "cannot be converted"),
        ("__class__", "There is no skill"),
        ("run()", "There is no skill"),
    ],
)
def test_a_wrong_action_says_what_is_allowed(written: str, complaint: str) -> None:
    with pytest.raises(PlanError, match=complaint.replace("(", r"\(").replace("?", r"\?")):
        resolve(written)


def test_a_number_beyond_the_limits_is_refused() -> None:
    with pytest.raises(OutOfRange) as refusal:
        resolve("move_forward(1000000)")
    assert refusal.value.exit_code is ExitCode.REFUSED
    assert "-50 to 50 m" in str(refusal.value)


def test_places_are_known_by_symbol_name_and_alias_and_others_are_not() -> None:
    assert [resolve(f"navigation({word})").args["place"] for word in ("b", "Living Room", "the lounge")] == ["B"] * 3
    with pytest.raises(UnknownPlace, match="I know: kitchen, living room"):
        resolve("navigation(moon)")


def test_a_robot_without_an_arm_is_not_offered_skills_of_the_arm() -> None:
    registry = SkillRegistry(LIBRARY, capabilities=frozenset({"base", "voice"}))
    assert "arm_up" not in {skill.name for skill in registry}
    with pytest.raises(UnknownSkill, match="nothing to do arm_up with"):
        registry.resolve(parse_call("arm_up()"))


def test_every_skill_describes_itself_with_units_and_limits() -> None:
    for each in REGISTRY:
        described = each.describe()
        assert described["doc"]
        for parameter in described["parameters"]:
            if parameter["type"] == "number":
                assert parameter["min"] < parameter["max"]
                assert parameter["unit"] or parameter["name"] in {"id", "tag", "most", "x", "y", "x1", "y1", "x2", "y2"}
            else:
                assert parameter["kind"]


def test_a_skill_without_docstring_or_units_cannot_be_registered() -> None:
    async def silent(context: SkillContext, distance: Distance) -> Result:
        return ok()

    async def unitless(context: SkillContext, distance: float) -> Result:
        """Drive."""
        return ok()

    with pytest.raises(TypeError, match="docstring"):
        skill()(silent)
    with pytest.raises(TypeError, match="needs a unit"):
        skill()(unitless)


@given(st.text(max_size=200))
def test_no_text_ever_gets_through_but_as_a_registered_skill(text: str) -> None:
    try:
        action = resolve(text)
    except PlanError:
        return
    assert action.name in {each.name for each in LIBRARY}


@given(st.floats(-50, 50), st.sampled_from([("m", 1.0), ("cm", 100.0), ("mm", 1000.0)]))
def test_a_length_keeps_its_value_in_every_unit(metres: float, unit: tuple[str, float]) -> None:
    name, factor = unit
    try:
        got = resolve(f"move_forward({metres * factor:.6f} {name})").args["distance"]
    except OutOfRange:
        assert math.isclose(abs(metres), 50, abs_tol=1e-5)
    else:
        assert got == pytest.approx(metres, abs=1e-5)
