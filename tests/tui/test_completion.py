"""What is suggested while one types, and how one takes it."""

from __future__ import annotations

import pytest

from engine.commands import Say
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.scripted import ScriptedEngine
from tui.widgets.ask import Ask
from tui.widgets.completion import Completion

HOUSE = Completion(
    ("kitchen", "living room", "coffee table", "table", "table 2", "red box", "厨房", "客厅", "床头柜"),
    ("turn left 90 degrees", "go to the ", "向左转90度"),
)


@pytest.mark.parametrize(
    ("typed", "rest"),
    [
        ("tu", "rn left 90 degrees"),
        ("Tur", "n left 90 degrees"),
        ("go to the ki", "tchen"),
        ("bring the red", " box"),
        ("bring the red box to the living r", "oom"),
        ("put it on the coffee t", "able"),
        ("去厨", "房"),
        ("去客", "厅"),
        ("把它放在床头", "柜"),
        ("向", "左转90度"),
        ("", ""),
        ("   ", ""),
        ("t", ""),
        ("put it on the table", ""),
        ("go to the kitchen", ""),
        ("say xylophone", ""),
        ("a" * 2000 + " ki", "tchen"),
    ],
)
def test_a_line_is_continued(typed: str, rest: str) -> None:
    assert HOUSE.rest(typed) == rest


def test_what_was_asked_before_is_likelier_and_the_newest_most() -> None:
    assert HOUSE.rest("tu", ["turn around", "turn right"]) == "rn right"
    assert HOUSE.rest("turn right", ["turn right"]) == ""


def test_names_of_the_house_are_known_in_both_languages() -> None:
    words = Completion(offer().words)
    assert words.rest("go to the kit") == "chen"
    assert words.rest("到书") in ("房", "桌", "架", "柜")
    assert words.rest("pick up the white") == " cup"
    assert words.rest("put it on the side") == words.rest("put it on the side", ())


async def typing(desk: Desk, keys: str) -> Ask:
    line = desk.app.screen.query_one(Ask)
    await desk.press("slash", *("space" if key == " " else key for key in keys))
    await desk.until(lambda: line.value == keys)
    return line


def engine_of_the_house() -> ScriptedEngine:
    engine = ScriptedEngine()
    engine.offers = offer()
    return engine


@pytest.mark.parametrize("key", ["right", "tab"])
async def test_a_suggestion_is_shown_and_taken_by_right_and_tab(key: str) -> None:
    async with console(engine_of_the_house()) as desk:
        line = await typing(desk, "go to the kit")
        await desk.until(lambda: "go to the kitchen" in desk.text)
        assert line.value == "go to the kit"
        await desk.press(key)
        assert line.value == "go to the kitchen"
        assert line.has_focus
        await desk.press("enter")
        assert desk.engine.sent == [Say("go to the kitchen")]


async def test_a_suggestion_that_nobody_takes_is_not_sent() -> None:
    async with console(engine_of_the_house()) as desk:
        await typing(desk, "go to the kit")
        await desk.until(lambda: "go to the kitchen" in desk.text)
        await desk.press("enter")
        assert desk.engine.sent == [Say("go to the kit")]


async def test_tab_does_not_leave_the_line() -> None:
    async with console(engine_of_the_house()) as desk:
        line = await typing(desk, "xyz")
        await desk.press("tab")
        assert line.has_focus
        assert line.value == "xyz"


async def test_names_are_completed_before_the_engine_has_started_only_as_phrases() -> None:
    async with console(ScriptedEngine()) as desk:
        await typing(desk, "turn l")
        await desk.until(lambda: "turn left 90 degrees" in desk.text)
