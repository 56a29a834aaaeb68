"""A word that a model put into another kind of word's slot is served by what it is."""

from __future__ import annotations

import pytest

from engine.plan import parse_calls
from engine.planner.stages.slots import by_kind
from tests.unit.test_slips import VOCABULARY


@pytest.mark.parametrize(
    ("proposed", "served"),
    [
        ("navigation(blue mug)", "navigate_to_object(blue mug)"),
        ("navigation(armchair)", "navigation(living room)"),
        ("navigate_to_object(desk)", "navigation(desk)"),
        ("locate(kitchen)", "scan_room(kitchen)"),
        ("locate(coffee table)", "navigation(coffee table); seewhat()"),
        ("scan_room(desk)", "navigation(desk); seewhat()"),
        ("scan_room(red box)", "locate(red box)"),
        ("carry(kitchen, red box)", "carry(red box, kitchen)"),
        ("carry(red box, armchair)", "pick_object(red box); place_object(armchair)"),
    ],
)
def test_what_a_word_is_decides_which_skill_serves(proposed: str, served: str) -> None:
    assert by_kind(parse_calls(proposed), VOCABULARY) == parse_calls(served)


@pytest.mark.parametrize(
    "proposed",
    ["navigation(kitchen)", "navigation(moon)", "locate(red box)", "scan_room(kitchen)", "carry(moon, mars)"],
)
def test_what_fits_or_is_unknown_stays_as_it_is(proposed: str) -> None:
    assert by_kind(parse_calls(proposed), VOCABULARY) == parse_calls(proposed)
