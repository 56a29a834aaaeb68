"""The log: levels, parts, search, following, and the way from an error to its turn."""

from __future__ import annotations

import pytest

from engine import events as ev
from tests.tui import conversation as talk
from tests.tui.desk import Desk, console
from tui.palette.palette import Palette
from tui.screens.turn import TurnScreen
from tui.widgets.log import LogView
from tui.words import strings


def log(desk: Desk) -> LogView:
    return desk.app.main.log_pane


def tell(desk: Desk, *lines: tuple[str, str, str]) -> None:
    for level, source, message in lines:
        desk.engine.publish(ev.Log(level, source, message))  # type: ignore[arg-type]


def messages(desk: Desk) -> list[str]:
    return [line.message for line in log(desk).lines]


async def test_levels_leave_out_what_is_less_serious_and_come_round_again() -> None:
    async with console() as desk:
        tell(desk, ("info", "robot", "one"), ("warning", "camera", "two"), ("error", "voice", "three"))
        await desk.press("5", "v", "v")
        assert messages(desk) == ["two", "three"]
        assert "from warnings" in desk.text
        await desk.press("v")
        assert messages(desk) == ["three"]
        tell(desk, ("info", "robot", "four"), ("error", "robot", "five"))
        await desk.settled()
        assert messages(desk) == ["three", "five"]
        await desk.press("v")
        assert messages(desk) == ["one", "two", "three", "four", "five"]


async def test_a_line_of_the_console_itself_carries_the_time_at_which_it_was_written() -> None:
    async with console() as desk:
        desk.engine.publish(ev.Log("info", "camera", "ready"), after=4.21)
        await desk.settled()
        (ready,) = log(desk).known[-1:]
        began = desk.app.clock()
        desk.app.clock = lambda: began + 20.0
        desk.app.note("info", "no turn to copy")
        await desk.press("5")
        told = log(desk).known[-1]
        assert (told.source, told.message) == ("console", "no turn to copy")
        assert told.t - ready.t == pytest.approx(20.0), "in the clock of the other lines"


async def test_one_part_after_the_other_is_shown_and_then_all() -> None:
    async with console() as desk:
        tell(desk, ("info", "robot", "one"), ("warning", "camera", "two"), ("info", "robot", "three"))
        await desk.press("5", "p")
        assert messages(desk) == ["one", "three"]
        await desk.press("p")
        assert messages(desk) == ["two"]
        await desk.press("v", "v", "v")
        assert messages(desk) == []
        assert "No matches · 0 shows all lines" in desk.text
        await desk.press("v", "p")
        assert messages(desk) == ["one", "two", "three"]
        await desk.press("p", "v", "v", "0")
        assert messages(desk) == ["one", "two", "three"]


async def test_the_frame_names_the_keys_from_the_moment_in_which_the_log_has_the_keyboard_until_it_goes() -> None:
    async with console() as desk:
        tell(desk, ("info", "robot", "one"))
        await desk.settled()
        told: list[str] = []
        entitle = log(desk).entitle

        def noted() -> None:
            entitle()
            told.append(str(log(desk).border_subtitle))

        log(desk).entitle = noted  # type: ignore[method-assign]
        desk.app.main.set_focus(log(desk))
        await desk.pilot.pause()
        assert told
        assert all("v level" in words for words in told)
        told.clear()
        desk.app.main.set_focus(None)
        await desk.pilot.pause()
        assert told
        assert not any(told)


async def test_whoever_scrolled_back_stays_there_is_told_how_many_are_new_and_follows_again_at_the_end() -> None:
    async with console() as desk:
        tell(desk, *(("info", "robot", f"line {number}") for number in range(298)))
        await desk.press("5", "pageup")
        above = [text for text in desk.text.splitlines() if "line 28" in text]
        assert above
        tell(desk, *(("info", "robot", f"more {number}") for number in range(20)))  # 18 old ones are dropped for them
        await desk.settled()
        assert [text for text in desk.text.splitlines() if "line 28" in text] == above
        assert "more" not in desk.text
        assert "20 new" in desk.text
        await desk.press("f")
        assert "more 19" in desk.text
        assert "20 new" not in desk.text
        tell(desk, ("info", "robot", "the newest"))
        await desk.settled()
        assert "the newest" in desk.text


async def test_a_search_leads_to_the_line_even_where_it_was_left_out() -> None:
    async with console() as desk:
        tell(desk, ("info", "robot", "the wheel slipped"), *(("info", "camera", f"line {n}") for n in range(60)))
        await desk.press("5", "v", "v", "s")
        palette = desk.app.screen.query_one(Palette)
        await desk.press(*"slip")
        assert [entry.title for entry in palette.shown] == ["the wheel slipped"]
        await desk.press("enter")
        assert isinstance(desk.app.focused, LogView)
        assert "the wheel slipped" in desk.text
        assert len(messages(desk)) == 61


async def test_from_an_error_one_gets_to_its_turn() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        first, newest = desk.app.shown.model.turns.kept[1], desk.app.shown.model.turns.kept[-1]
        desk.engine.publish(ev.ErrorRaised("path_blocked", "No way leads there.", ""), turn=first.id)
        tell(desk, ("info", "robot", "later"))
        await desk.press("5", "n", "enter")
        assert isinstance(desk.app.screen, TurnScreen)
        assert desk.app.shown.turn is not None
        assert desk.app.shown.turn.id == first.id != newest.id


async def test_a_line_that_belongs_to_no_turn_says_so() -> None:
    async with console() as desk:
        desk.engine.publish(ev.Log("error", "camera", "The camera is gone."), turn=None)
        await desk.press("5", "n", "enter")
        assert not isinstance(desk.app.screen, TurnScreen)
        assert strings.LINE_OF_NO_TURN in desk.text


async def test_a_click_marks_a_line_and_a_second_one_opens_its_turn() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        turn = desk.app.shown.model.turns.kept[0]
        desk.engine.publish(ev.Log("warning", "robot", "slippery"), turn=turn.id)
        await desk.settled()
        rows = desk.text.splitlines()
        y = next(number for number, text in enumerate(rows) if "slippery" in text)
        offset = (rows[y].index("slippery"), y)
        await desk.pilot.click(offset=offset)
        await desk.settled()
        assert not isinstance(desk.app.screen, TurnScreen)
        await desk.pilot.click(offset=offset)
        await desk.settled()
        assert isinstance(desk.app.screen, TurnScreen)
        assert desk.app.shown.turn is not None
        assert desk.app.shown.turn.id == turn.id
