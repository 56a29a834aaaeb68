"""What a model left blank is filled with what was said, where that can only be one thing."""

from __future__ import annotations

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import PlanError, parse_calls
from engine.planner.build import build_registry
from engine.planner.stages.blanks import filled
from engine.planner.worlds.house import build_vocabulary
from engine.skills.registry import NOT_SAID

SETTINGS = at_home(load(environ={}))
REGISTRY = build_registry(SETTINGS)
VOCABULARY = build_vocabulary(SETTINGS)


def after(text: str, proposed: str) -> str:
    calls = filled(parse_calls(proposed.replace("?", NOT_SAID)), text, REGISTRY, VOCABULARY)
    try:
        return "; ".join(str(REGISTRY.resolve(call)) for call in calls)
    except PlanError:
        return "asks"


@pytest.mark.parametrize(
    ("text", "proposed", "meant"),
    [
        ("the yellow box goes next to the sofa", "pick_object(yellow box); place_object(?)",
         "pick_object(yellow box); place_object(sofa)"),
        ("off you trot to the study", "navigation(?)", "navigation(D)"),
        ("drive half a metre and then another metre", "move_forward(0.5); move_forward(?)",
         "move_forward(0.5, 0.3); move_forward(1, 0.3)"),
        ("another 30 degrees please", "move_left(?)", "move_left(30, 1)"),
        ("the red box would look nice on the desk", "pick_object(?); place_object(desk)",
         "pick_object(red box); place_object(desk)"),
    ],
)  # fmt: skip
def test_the_only_word_that_can_be_meant_is_taken(text: str, proposed: str, meant: str) -> None:
    assert after(text, proposed) == meant


@pytest.mark.parametrize(
    ("text", "proposed"),
    [
        ("go there", "navigation(?)"),
        ("go to the study or the kitchen", "navigation(?)"),
        ("drive a bit", "move_forward(?)"),
        ("pick that up", "pick_object(?)"),
        ("take the red box there", "carry(red box, ?)"),
        ("the desk, put it there", "pick_object(?); place_object(desk)"),
    ],
)
def test_what_was_not_said_or_may_be_several_stays_blank(text: str, proposed: str) -> None:
    assert after(text, proposed) == "asks"
