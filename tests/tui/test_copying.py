"""``y`` copies what is in sight: the terminal gets it as OSC 52, and the status line says what it was."""

from __future__ import annotations

from base64 import b64decode

import pytest

from engine import events as ev
from engine.commands import Interrupt
from tests.tui import conversation as talk
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.rooms.copying import MAX_BYTES, fitting
from tui.screens.panes import PaneName


async def copied(desk: Desk, monkeypatch: pytest.MonkeyPatch, *keys: str) -> str:
    """What the terminal is told to hold once these keys were pressed."""
    written: list[str] = []
    driver = desk.app._driver
    assert driver is not None
    monkeypatch.setattr(driver, "write", written.append)
    await desk.press(*keys)
    sequences = [text for text in written if text.startswith("\x1b]52;c;")]
    return b64decode(sequences[-1].removeprefix("\x1b]52;c;").removesuffix("\a")).decode() if sequences else ""


async def test_y_copies_the_newest_turn_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.settled()
        text = await copied(desk, monkeypatch, "y")
        assert "recognise" in text
        assert "4552 ms" in text
        assert f"to clipboard: turn · {len(text.splitlines())} lines" in desk.text.splitlines()[0]
        assert "y again: conversation" in desk.text


async def test_the_turn_that_is_looked_at_is_the_one_that_is_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        newest = await copied(desk, monkeypatch, "y", "enter")
        before = await copied(desk, monkeypatch, "left_square_bracket", "left_square_bracket")
        assert before == ""
        desk.app.keeping.forget()
        before = await copied(desk, monkeypatch, "y")
        assert before
        assert before != newest
        assert "to clipboard: turn" in desk.text.splitlines()[0]


async def test_y_again_copies_conversation_plan_actions_and_log_one_after_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.press("y")
        texts = [await copied(desk, monkeypatch, "y") for _ in range(4)]
        for text, words in zip(texts, ("you  ", "Go to", "▸ ", "sayso"), strict=True):
            assert words in text
        assert "to clipboard: log" in desk.text.splitlines()[0]
        assert "y again: turn" in desk.text.splitlines()[0]


async def test_the_log_is_copied_where_it_is_all_that_one_sees(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.publish(ev.Log("warning", "robot", "the wheel slipped"))
        await desk.settled()
        assert "the wheel slipped" in await copied(desk, monkeypatch, "l", "y")


@pytest.mark.parametrize("pane", ["conversation", "plan", "actions", "log"])
async def test_the_pane_with_the_keyboard_is_the_one_that_is_copied(
    pane: PaneName, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        desk.app.action_pane(pane)
        assert await copied(desk, monkeypatch, "y")
        assert f"to clipboard: {pane}" in desk.text.splitlines()[0]


async def test_where_nothing_happened_nothing_is_copied_and_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        assert await copied(desk, monkeypatch, "y") == ""
        assert "no turn to copy" in desk.text.splitlines()[0]


async def test_the_status_line_is_free_again_and_y_begins_anew() -> None:
    async with console() as desk:
        talk.play(desk.engine, talk.ALL)
        await desk.press("y")
        desk.app.keeping.forget()
        await desk.settled()
        assert "copied" not in desk.text.splitlines()[0]
        await desk.press("y")
        assert "to clipboard: turn" in desk.text.splitlines()[0]


async def test_a_y_that_is_typed_is_a_y_and_escape_still_stops() -> None:
    async with console() as desk:
        await desk.press("slash", "y")
        assert desk.app.main.line.value == "y"
        await desk.press("escape", "y")
        assert desk.app.main.line.value == "yy"
        assert desk.engine.sent == [Interrupt()]


def test_of_a_text_that_is_too_long_the_newest_whole_lines_stay() -> None:
    lines = [f"{number} 去厨房" for number in range(20_000)]
    kept = fitting("\n".join(lines)).splitlines()
    assert kept == lines[-len(kept) :]
    assert MAX_BYTES - 100 < len("\n".join(kept).encode()) <= MAX_BYTES


async def test_one_line_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        desk.engine.publish(ev.Log("warning", "robot", "the wheel slipped"))
        await desk.press("5")
        assert len((await copied(desk, monkeypatch, "y")).splitlines()) == 1
        assert "to clipboard: log · 1 line ·" in desk.text.splitlines()[0]


async def test_the_key_that_copies_more_is_named_only_where_it_does() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.press("1", "y")
        assert "y again: plan" in desk.text.splitlines()[0]
        await desk.press("slash")
        assert "to clipboard: conversation" in desk.text.splitlines()[0]
        assert "y again: plan" not in desk.text
        await desk.press("ctrl+g", "question_mark")
        assert "y again: plan" not in desk.text.splitlines()[0]
