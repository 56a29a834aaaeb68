"""Where a robot looks first when what it is asked depends on something."""

from __future__ import annotations

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import parse_calls
from engine.planner.readings.first_look import first_look
from engine.planner.worlds.house import build_vocabulary

VOCABULARY = build_vocabulary(at_home(load(environ={})))


@pytest.mark.parametrize(
    ("text", "look"),
    [
        ("go find out if block one is still on the workbench and if it isn't make your light yellow", "workbench"),
        ("check that nobody's in the bedroom and if it's empty turn your light red", "bedroom"),
        ("look for the ball in the living room and if it isn't there try the bedroom", "living room"),
        ("check the hall and if someone's about give them a clap else off you go to the dock", "hall"),
        ("take the cup to the sofa if it is on the stool", "stool"),
        ("unless there's something on the stool already put the green box on it", "stool"),
        ("count what's on the coffee table and beep if it's more than two things", "coffee table"),
        ("if there are at least three cups in the kitchen bring one here", "kitchen"),
        ("if there is an apple on the desk in the kitchen bring it to me", "desk"),
        ("go to the kitchen if there are two boxes on the stool", "stool"),
        ("如果厨房里有人就回来", "厨房"),
        ("如果厨房里有三个杯子就拿一个来", "厨房"),
        ("去看一下床头柜上有没有杯子，有的话拿到厨房去", "床头柜"),
    ],
)
def test_it_is_the_place_that_the_condition_is_about(text: str, look: str) -> None:
    rooms = {"bedroom", "living room", "hall", "kitchen", "厨房"}
    expected = f"scan_room({look})" if look in rooms else f"navigation({look}); seewhat()"
    assert first_look(text, VOCABULARY) == parse_calls(expected)


@pytest.mark.parametrize(
    "text",
    [
        "if you are tired go to the dock",
        "go to the kitchen if you are tired",
        "bring the cup to the kitchen if it's late",
        "if it's raining go to the kitchen",
        "if the battery is low go to the kitchen",
        "if there was a cup on the table bring it",
        "if I were you I'd go to the kitchen",
        "what if there is a cat on the sofa",
        "dance as if there is nobody in the kitchen",
        "ask Tom if there is a cup on the table, then come back",
        "bring it even if it is in the kitchen",
        "go to the kitchen, otherwise to the hall",
        "go to the kitchen",
        "if so beep",
        "",
        "如果累了就休息",
        "如果下雨就去厨房",
        "如果我在厨房就过来",
        "有没有办法去厨房",
    ],
)
def test_without_such_a_place_or_where_a_look_tells_nothing_there_is_no_first_look(text: str) -> None:
    assert first_look(text, VOCABULARY) == ()
