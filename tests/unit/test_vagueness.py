"""Words that leave a thing or a place to guessing are told from those that name one."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.planner.grounding.vagueness import vague


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("pick up the thing", True),
        ("bring me that stuff", True),
        ("put the object down over there", True),
        ("grab something", True),
        ("could you get me one of those things", True),
        ("go over there", True),
        ("bring the cup over there", True),
        ("drive somewhere", True),
        ("拿起那个东西", True),
        ("把那个东西给我", True),
        ("去那边", True),
        ("take this over there", True),
        ("hold this", True),
        ("put something on the desk", True),
        ("put the light on and hold it", False),
        ("pick up the red thing", False),
        ("pick up the thing that is on the table", False),
        ("bring me something to drink", False),
        ("tell me something about the objects that you see", False),
        ("put all the things into the bin", False),
        ("go to the kitchen and put the cup there", False),
        ("pick up the box", False),
        ("is there something on the table", False),
        ("把红色的东西拿起来", False),
        ("去厨房", False),
        ("", False),
    ],
)
def test_vague_words_leave_things_and_places_to_guessing(text: str, expected: bool) -> None:
    assert vague(text) is expected


@settings(deadline=None, max_examples=100)
@given(st.text(max_size=60))
def test_any_text_is_judged_without_an_error(text: str) -> None:
    vague(text)
