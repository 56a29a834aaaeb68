"""The help page: where one is comes first, what is typed is searched for, and nothing is out of reach."""

from __future__ import annotations

from collections import Counter

import pytest

from engine.commands import Interrupt, Wake
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.screens.help import HelpScreen
from tui.words.language import Language


def rows(desk: Desk) -> list[str]:
    """What stands in the page, from top to bottom, also what there is no room for; nothing while it is written anew."""
    cells = desk.app.screen.query("#page .about")
    return [str(cell.render()).strip() for cell in cells if cell.display]


@pytest.mark.parametrize(
    ("keys", "title", "first"),
    [
        (("5",), "While the log has the keyboard", "Show fewer levels"),
        (("6",), "In this pane: Turns", "Look at the turn before."),
        (("m",), "While the map has the keyboard", "Look closer"),
        (("g",), "Driving by hand", "Drive ahead"),
        (("enter",), "On the page of a turn", "Unfold"),
        (("slash",), "In the line", "Send the request"),
        ((), "To begin", "Press space"),
    ],
)
async def test_the_keys_of_where_one_is_come_first(keys: tuple[str, ...], title: str, first: str) -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        await desk.press(*keys, "question_mark")
        listed = rows(desk)
        assert listed[0] == title
        assert any(row.startswith(first) for row in listed[1:10]), listed[:10]
        twice = {row for row, count in Counter(listed).items() if count > 1}
        alike = ("of the map.", "the one before.", "on the map.", "that waits.")  # of two keys, one each way
        assert all(row.endswith(alike) for row in twice), twice


async def test_what_is_typed_is_searched_for_by_key_word_and_name() -> None:
    async with console(size=(80, 24)) as desk:
        await desk.press("question_mark", *"palette")
        assert rows(desk) == ["Outside the line", "Find everything that can be done: type a part of it."]
        await desk.press("ctrl+u", *"ctrl+x")
        assert rows(desk) == ["Outside the line", "The emergency stop: nothing moves until it is released."]
        await desk.press("ctrl+u", *"by", "space", *"hand", "space", *"drive")
        assert any(row.startswith("Drive by hand") for row in rows(desk))
        assert desk.engine.sent == [], "letters and blanks are searched for"
        await desk.press("ctrl+u", *"zzz")
        assert "No matches" in desk.text
        assert rows(desk) == [] or not desk.app.screen.query_one("#page").display
        await desk.press("ctrl+u")
        assert "To begin" in desk.text


async def test_while_nothing_is_typed_keys_that_no_search_begins_with_do_what_they_do() -> None:
    async with console() as desk:
        await desk.press("question_mark", "space", "escape")
        assert desk.engine.sent == [Wake("key"), Interrupt()]
        assert isinstance(desk.app.screen, HelpScreen)
        await desk.press("question_mark")
        assert desk.app.screen is desk.app.main


async def test_its_foot_names_the_key_that_goes_back_from_where_something_is_typed() -> None:
    async with console() as desk:
        await desk.press("question_mark")
        assert "⌫ back · esc stops" in desk.text
        await desk.press("a")
        assert "ctrl+g back · esc stops" in desk.text
        await desk.press("backspace", "backspace")
        assert isinstance(desk.app.screen, HelpScreen), "a run of backspaces clears, and no more"
        await desk.press("a", "ctrl+g")
        assert desk.app.screen is desk.app.main


@pytest.mark.parametrize("language", ["en", "zh"])
async def test_it_scrolls_to_its_end_by_a_line_and_by_a_screenful(language: Language) -> None:
    async with console(size=(80, 24), language=language) as desk:
        await desk.press("question_mark")
        page = desk.app.screen.query_one("#page")
        await desk.press("down", "down", "up")
        assert page.scroll_y == 1
        before = -1.0
        while page.scroll_y != before:
            before = page.scroll_y
            await desk.press("pagedown")
        assert page.scroll_y == page.max_scroll_y > 20


async def test_what_was_typed_stays_when_the_language_changes() -> None:
    async with console() as desk:
        await desk.press("question_mark", *"ctrl+x")
        desk.app.speak("zh")
        await desk.until(lambda: any("急停" in row for row in rows(desk)))
        await desk.settled()
        assert len(rows(desk)) == 2


async def test_keys_for_more_are_named_where_there_is_more() -> None:
    async with console(size=(120, 40)) as desk:
        await desk.press("question_mark")
        assert "page down more" in desk.text
        await desk.press("down")
        assert "page down page up more" in desk.text
        await desk.press(*"emergency")
        assert "more ·" not in desk.text
        assert "ctrl+g back · esc stops" in desk.text


@pytest.mark.parametrize(("size", "named"), [((80, 24), False), ((120, 40), True)])
@pytest.mark.parametrize("key", ["5", "6"])
async def test_a_border_is_named_first_only_where_there_is_one(key: str, size: tuple[int, int], named: bool) -> None:
    async with console(size=size) as desk:
        await desk.press(key, "question_mark")
        first = rows(desk)[: rows(desk).index("To begin")]
        assert any("left panes" in row for row in first) is named, first
