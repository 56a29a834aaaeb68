"""Who looks at older lines of the conversation stays there and is told how many are new; whoever asks for something
sees the end again."""

from __future__ import annotations

import pytest
from textual.content import Content
from textual.widget import Widget

from engine import events as ev
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.widgets.conversation import Conversation
from tui.widgets.timeline import Timeline


def says(desk: Desk, *texts: str) -> None:
    for text in texts:
        desk.engine.publish(ev.SpeechStarted(text, False))


def foot(pane: Widget) -> str:
    return Content.from_markup(pane.border_subtitle or "").plain


async def scrolled_back(desk: Desk) -> Conversation:
    says(desk, *(f"sentence {number:02}" for number in range(40)))
    await desk.press("pageup")
    assert "sentence 39" not in desk.text
    return desk.app.main.query_one(Conversation)


@pytest.mark.parametrize("size", [(60, 20), (80, 24), (120, 40)])
async def test_what_others_say_is_counted_below_and_end_leads_there(size: tuple[int, int]) -> None:
    async with console(size=size, in_line=True) as desk:
        pane = await scrolled_back(desk)
        before = desk.text
        says(desk, "one more", "and another")
        await desk.settled()
        assert "one more" not in desk.text
        assert [line for line in before.splitlines() if "sentence" in line] == [
            line for line in desk.text.splitlines() if "sentence" in line
        ]
        assert foot(pane) == "2 new · end shows them"
        assert "2 new · end shows them" in desk.text
        await desk.press("end")
        assert "and another" in desk.text
        assert foot(pane) == ""
        says(desk, "the newest")
        await desk.settled()
        assert "the newest" in desk.text


async def test_what_a_larger_size_shows_is_not_new() -> None:
    async with console(size=(120, 20), in_line=True) as desk:
        says(desk, *(f"sentence {number:02}" for number in range(20)))
        await desk.press("pageup")
        says(desk, "one more")
        await desk.settled()
        pane = desk.app.main.query_one(Conversation)
        assert foot(pane) == "1 new · end shows them"
        await desk.pilot.resize_terminal(120, 55)
        await desk.settled()
        assert "one more" in desk.text
        assert foot(pane) == ""


async def test_a_click_on_the_mark_leads_there() -> None:
    async with console(size=(80, 24), in_line=True) as desk:
        pane = await scrolled_back(desk)
        says(desk, "one more")
        await desk.settled()
        row = next(y for y, line in enumerate(desk.text.splitlines()) if "1 new" in line)
        await desk.pilot.click(offset=(desk.text.splitlines()[row].index("1 new"), row))
        await desk.settled()
        assert "one more" in desk.text
        assert foot(pane) == ""


async def test_the_key_is_named_only_where_it_acts() -> None:
    async with console(in_line=True) as desk:
        pane = await scrolled_back(desk)
        says(desk, "one more")
        await desk.press(*"go")
        assert foot(pane) == "1 new", "end goes to the end of the text"
        await desk.press("home", "end")
        assert desk.app.main.line.cursor_position == 2
        assert "one more" not in desk.text
        await desk.press("ctrl+g")
        assert foot(pane) == "1 new · end shows them"


@pytest.mark.parametrize(
    "ask", [[*"beep", "enter"], ["ctrl+g", "k"], ["ctrl+g", "space"]], ids=["line", "offer", "wake"]
)
async def test_whoever_asks_for_something_sees_the_end_again(ask: list[str]) -> None:
    async with console(size=(80, 24), in_line=True) as desk:
        pane = await scrolled_back(desk)
        desk.engine.publish(ev.OffersMade("T1", "T1", "T1", "T1"), turn=None)
        says(desk, "one more")
        await desk.press(*ask)
        assert "one more" in desk.text
        assert foot(pane) == ""
        says(desk, "the answer")
        await desk.settled()
        assert "the answer" in desk.text


async def test_a_line_that_is_only_rewritten_is_not_new() -> None:
    async with console(size=(80, 24), in_line=True) as desk:
        pane = await scrolled_back(desk)
        desk.engine.publish(ev.SpeechEnded("sentence 39", "sentence", "interrupted"))
        await desk.settled()
        assert foot(pane) == ""
        says(desk, "one more")
        await desk.settled()
        assert foot(pane).startswith("1 new")


async def test_a_click_on_the_mark_of_the_turns_leads_to_the_newest() -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        await desk.press("left_square_bracket")
        desk.app.drawing.browsed = desk.app.drawing.model.turns.kept[0].id
        for number in range(2):
            desk.engine.publish(ev.StateChanged("IDLE", "PLANNING", "x"), turn=f"N{number}")
        desk.app.redraw()
        await desk.settled()
        pane = desk.app.main.query_one(Timeline)
        assert foot(pane).startswith("2 new")
        row = next(y for y, line in enumerate(desk.text.splitlines()) if "2 new" in line)
        await desk.pilot.click(offset=(desk.text.splitlines()[row].index("2 new"), row))
        await desk.settled()
        assert desk.app.drawing.browsed is None
        assert not foot(pane).startswith("2 new")
