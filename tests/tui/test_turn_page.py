"""Turns on the screen: what one sees of them, and the keys to look at them."""

from __future__ import annotations

import msgspec
import pytest
from rich.cells import cell_len

from engine import events as ev
from engine.commands import Interrupt, Wake
from tests.tui import conversation as talk
from tests.tui import scripted
from tests.tui.conversation import Scene
from tests.tui.desk import console
from tests.tui.scripted import Step
from tui.screens.console import ConsoleScreen
from tui.screens.turn import TurnScreen
from tui.widgets.timeline import Head, Timeline

BACK, ON = "left_square_bracket", "right_square_bracket"


async def test_the_newest_turn_is_on_the_screen_with_its_stages_and_the_wait() -> None:
    async with console() as desk:
        assert "The time that each stage of a request takes appears here." in desk.text
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        for words in (
            "▸      plan",
            "2100 ms",
            "4552 ms to motion",
            "endpoint",
            "recognise",
            "decide",
            "[ browse · enter opens",
        ):
            assert words in desk.text


async def test_brackets_browse_the_turns_and_come_back_to_the_newest() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        seen = []
        for key in (BACK, BACK, ON, ON, ON, *[BACK] * 9):
            await desk.press(key)
            heads = [item for item in desk.app.query_one(Timeline).items if isinstance(item, Head) and item.shown]
            seen.append(heads[0].number)
        assert seen == [5, 4, 5, 6, 6, 5, 4, 3, 2, 1, 1, 1, 1, 1]
        assert "Go to the kitchen." in desk.text.rsplit("Turns", 1)[1]


async def test_a_turn_that_is_looked_at_stays_while_others_come_and_the_newest_is_followed() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL[:3])
        await desk.settled()
        await desk.press(BACK)
        talk.play(desk.engine, [talk.UNHEARD])
        await desk.settled()
        await desk.press("enter")
        assert "Turn 2 of 4" in desk.text
        await desk.press(ON, ON, "enter")
        talk.play(desk.engine, [talk.NOBODY])
        await desk.settled()
        await desk.press("enter")
        assert "Turn 5 of 5" in desk.text


async def test_enter_shows_the_whole_turn_and_enter_comes_back() -> None:
    async with console(size=(120, 70)) as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        await desk.press("enter")
        assert isinstance(desk.app.screen, TurnScreen)
        for words in (
            "I am hungry, bring me the red box and turn around.", "■ interrupted", "2.3 s of speech", "woken by key",
            "confidence 91 %", "by the local model", "Carry it to the kitchen.", "says “I bring it.”",
            "▸ the plan as JSON", "cancelled", "holding the red box", "not started", "cut off after “On my”",
            "interrupted while acting: the stop key",
            "to motion", "from the end of speech",
            "▸ asked  local  decision · qwen2.5-coder-1.5b", "402 → 27 tokens · 1.46 s",
            "execution · qwen2.5-coder-1.5b · again", "3168 → 31 tokens · 0.92 s",
        ):  # fmt: skip
            assert words in desk.text
        await desk.press("enter")
        assert isinstance(desk.app.screen, ConsoleScreen)


async def test_the_plan_as_json_is_unfolded_and_folded_by_its_key() -> None:
    async with console(size=(120, 90)) as desk:
        talk.play(desk.engine, [talk.SPOKEN])
        await desk.settled()
        await desk.press("enter")
        assert '"navigate_to_kitchen"' not in desk.text
        await desk.press("j")
        assert '"navigate_to_kitchen"' in desk.text
        assert "▾ the plan as JSON" in desk.text
        await desk.press("j")
        assert '"navigate_to_kitchen"' not in desk.text


async def test_the_same_key_unfolds_what_models_were_told_and_what_they_wrote() -> None:
    async with console(size=(120, 140)) as desk:
        talk.play(desk.engine, [talk.BY_MODEL])
        await desk.settled()
        await desk.press("enter")
        assert "You left out" not in desk.text
        await desk.press("j")
        for words in (
            "▾ asked  local",
            "fixed beginning, 9812 characters (SHA-256 a81d44e07b6c2f95…)",
            "Request: I am hungry",
            '{"action": ["pick_object(red box)", "carry(A)"]}',
            "You left out: “turn around”",
            "reply",
        ):
            assert words in desk.text
        await desk.press("j")
        assert "You left out" not in desk.text


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"reply": "", "error_code": "model_unreachable", "error": "local cannot be reached."}, "✗ model_unreachable"),
        ({"reply": '{"act', "cancelled": True}, "■ cancelled"),
        ({"cut_off": True}, "cut off"),
    ],
)
async def test_what_became_of_a_call_is_told_in_its_line(changes: dict[str, object], told: str) -> None:
    async with console(size=(120, 60)) as desk:
        desk.engine.publish(talk.typed("bring me something"))
        desk.engine.publish(msgspec.structs.replace(talk.ACTIONS, **changes))
        await desk.settled()
        await desk.press("enter")
        (line,) = [line for line in desk.text.splitlines() if "▸ asked" in line]
        assert told in line
        assert str(changes.get("error", "")) in desk.text


async def test_the_page_follows_its_turn_while_it_goes_on() -> None:
    async with console(size=(120, 60)) as desk:
        await desk.press("enter")
        assert "There has been no turn yet." in desk.text
        talk.play(desk.engine, [Scene("T1", 2, talk.SPOKEN.steps[:-9])])
        await desk.settled()
        assert "◌ in progress" in desk.text
        talk.play(desk.engine, [Scene("T1", 2, talk.SPOKEN.steps[-9:])])
        await desk.settled()
        assert "✓ done" in desk.text


async def test_the_page_scrolls_and_begins_at_its_top_for_another_turn() -> None:
    async with console(size=(80, 24)) as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        await desk.press("enter")
        assert "I am hungry" in desk.text
        await desk.press("pagedown", "pagedown")
        assert "I am hungry" not in desk.text
        await desk.press("up", "down", "pageup", "pageup")
        assert "I am hungry" in desk.text
        await desk.press("pagedown", "pagedown", BACK)
        assert "Sound" in desk.text


@pytest.mark.parametrize("size", [(60, 16), (80, 24), (250, 70)])
async def test_every_line_of_the_page_is_as_wide_as_the_terminal(size: tuple[int, int]) -> None:
    chinese = Scene("T1", 2, (Step(0.0, talk.typed("去厨房，然后向左转九十度，再告诉我你看到了什么。" * 3)),))
    async with console(size=size) as desk:
        talk.play(desk.engine, [talk.BY_MODEL, chinese])
        await desk.settled()
        await desk.press("enter", "j", BACK)
        assert {cell_len(line) for line in desk.text.splitlines()} == {size[0]}
        await desk.press(ON)
        assert {cell_len(line) for line in desk.text.splitlines()} == {size[0]}


async def test_keys_that_stop_and_wake_work_on_the_page() -> None:
    async with console() as desk:
        talk.play(desk.engine, [talk.SPOKEN])
        await desk.settled()
        await desk.press("enter", "space", "escape")
        assert desk.engine.sent == [Wake("key"), Interrupt()]
        assert isinstance(desk.app.screen, TurnScreen)


async def test_on_a_small_terminal_t_shows_the_turns_and_browsing_does_too() -> None:
    async with console(size=(80, 24)) as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        assert "to motion" not in desk.text
        await desk.press("t")
        assert "4552 ms to motion" in desk.text
        await desk.press("l")
        assert "to motion" not in desk.text
        assert "ready: whisper-base" in desk.text
        await desk.press("l", BACK)
        assert "recognise" in desk.text
        await desk.press("t")
        assert "Conversation" in desk.text


async def test_a_click_on_a_turn_opens_it() -> None:
    async with console(size=(80, 24)) as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        await desk.press("t")
        row = next(number for number, line in enumerate(desk.text.splitlines()) if "goat the kitten" in line)
        await desk.pilot.click(offset=(20, row + 2))
        await desk.until(lambda: "Turn 4 of 6" in desk.text)


async def test_a_page_that_stands_still_is_not_drawn_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        await desk.press("enter")
        await desk.until(lambda: not desk.app.drawing.ticking)
        await desk.picture()
        drawn: list[object] = []
        monkeypatch.setattr(desk.app, "_display", lambda *arguments: drawn.append(arguments))
        assert isinstance(desk.app.screen, TurnScreen)
        desk.app.screen.show(desk.app.shown)
        await desk.pilot.pause()
        assert drawn == []


async def test_what_happens_beneath_the_page_has_it_not_drawn_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await desk.press("enter")
        await desk.picture()
        drawn: list[str] = []
        monkeypatch.setattr(desk.app, "_display", lambda screen, update: drawn.append(type(update).__name__))
        for number in range(3):
            desk.engine.publish(ev.ActionProgress("a2", "navigation", 0.5 + number / 10, str(number)), after=0.6)
            await desk.settled()
            await desk.pilot.pause()
        assert drawn
        assert set(drawn) == {"ChopsUpdate"}
        monkeypatch.undo()
        await desk.press("enter")
        assert "Go to the kitchen  2" in desk.text


async def test_brackets_that_are_typed_are_brackets() -> None:
    async with console() as desk:
        await desk.press("slash", "t", BACK, ON)
        assert desk.app.screen.query_one("Ask").value == "t[]"  # type: ignore[attr-defined]


async def test_markup_in_a_turn_is_only_text() -> None:
    async with console(size=(120, 60)) as desk:
        text = "[red]stop[/red]"
        desk.engine.publish(talk.typed(text))
        desk.engine.publish(ev.PlanMade(text, (text,), (), text, "local"))
        await desk.settled()
        await desk.press("enter", "j")
        assert desk.text.count(text) >= 5


async def test_turns_that_begin_while_somebody_looks_at_another_one_are_counted() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL[:3])
        await desk.press(BACK)
        assert "new ·" not in desk.text
        talk.play(desk.engine, talk.ALL[3:5])
        await desk.settled()
        assert "2 new · [ ] browse" in desk.text
        await desk.press(*[ON] * 3)
        assert desk.app.shown.turn is None
        assert "new ·" not in desk.text


@pytest.mark.parametrize("keys", [("space",), ("slash", *"beep", "enter"), ("m", "tab", "enter", "enter")])
async def test_who_asks_for_something_follows_the_newest_turn_again(keys: tuple[str, ...]) -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.press(BACK)
        assert desk.app.shown.turn is not None
        await desk.press(*keys)
        assert desk.app.shown.turn is None


async def test_a_turn_on_a_page_stays_there_while_somebody_wakes_the_robot() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.press(BACK, "enter", "space")
        assert desk.app.shown.turn is not None


async def test_a_click_on_the_newest_turn_follows_it() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        await desk.pilot.click(Timeline, offset=(10, 1))
        await desk.press("enter")
        assert desk.app.shown.turn is None
