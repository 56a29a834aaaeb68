"""The end of a long task reaches people who look at something else, and files that were written can be opened."""

from __future__ import annotations

from pathlib import Path

import pytest
from textual import events
from textual.content import Content
from textual.style import Style
from textual.visual import Visual

from engine import events as ev
from engine.commands import EndTask, Interrupt, Quit, Wake
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.cli import build_parser
from tui.commands.settings import overrides
from tui.messages import Told
from tui.rooms.alerting import LONG_S, notification
from tui.words.links import marked_up

STYLE = Style()


class Written:
    """What is written to a terminal."""

    def __init__(self, desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
        self.sequences: list[str] = []
        assert desk.app.terminal is not None
        monkeypatch.setattr(desk.app.terminal, "write", self.sequences.append)
        monkeypatch.setattr(desk.app, "bell", lambda: self.sequences.append("\a"))


async def task(desk: Desk, seconds: float) -> None:
    """One that takes so long, in event time."""
    desk.engine.play(scripted.acting())
    await desk.settled()
    result = ev.TurnResult(0, "done", "I am at the kitchen.")
    desk.engine.publish(ev.ActionFinished("a2", "navigation", {}, "ok", None, "", 1.0), after=seconds)
    desk.engine.publish(ev.StateChanged("ACTING", "WAITING", "done", result))
    await desk.until(lambda: not desk.app.drawing.model.busy)
    await desk.settled()


async def test_the_end_of_a_long_task_is_told_on_the_desktop_and_rings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    async with console() as desk:
        written = Written(desk, monkeypatch)
        await task(desk, LONG_S + 1)
        assert [one for one in written.sequences if one == "\a" or "]9;" in one] == [
            "\x1b]9;sayso: Go to the kitchen and turn left 90 degrees: done: I am at the kitchen.\x07",
            "\a",
        ]


async def test_a_short_one_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        written = Written(desk, monkeypatch)
        await task(desk, 1.0)
        assert "\a" not in written.sequences


@pytest.mark.parametrize(("reports", "told"), [((), True), ((events.AppBlur,), True), ((events.AppFocus,), False)])
async def test_a_terminal_that_has_the_keyboard_is_not_disturbed(
    reports: tuple[type[events.Event], ...], told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with console() as desk:
        written = Written(desk, monkeypatch)
        for report in reports:
            desk.app.post_message(report())
        await task(desk, LONG_S + 1)
        assert ("\a" in written.sequences) is told


async def test_it_can_be_switched_off(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        written = Written(desk, monkeypatch)
        desk.app.dress("sayso-dark", 30, notify="off")
        await task(desk, LONG_S + 1)
        assert "\a" not in written.sequences


@pytest.mark.parametrize(
    ("term", "sequence"),
    [("rxvt-unicode", "\x1b]777;notify;sayso;a, b\x07"), ("xterm-kitty", "\x1b]9;sayso: a, b\x07")],
)
def test_a_terminal_gets_the_sequence_that_it_knows(term: str, sequence: str) -> None:
    assert notification("a; b", {"TERM": term}) == sequence


# Links


async def test_a_file_that_was_written_is_a_link() -> None:
    async with console() as desk:
        desk.app.post_message(Told("saved in /home/me/a [b] c", file="/home/me/a [b] c"))
        await desk.until(lambda: desk.app._notifications)
        [told] = desk.app._notifications
        assert told.markup, "else its address would be read"
        words = Content.from_markup(told.message)
        assert words.plain == "saved in /home/me/a [b] c"
        sent = "".join(strip.render(desk.app.console) for strip in Visual.to_strips(desk.app.main, words, 60, 1, STYLE))
        assert "\x1b]8;" in sent
        assert "file://" in sent
        assert "/home/me/a%20%5Bb%5D%20c\x1b\\" in sent
        assert "saved in /home/me/a [b] c" in desk.app.drawing.model.log[-1].message


def test_words_without_a_file_have_no_link_and_no_markup() -> None:
    assert marked_up("[red]no", "") == "\\[red]no"


# The theme


def test_a_theme_can_be_given_on_the_command_line() -> None:
    arguments = build_parser().parse_args(["--theme", "nord"])
    assert "console.theme=nord" in overrides(arguments)


# The mouse in the status line


def place_of(desk: Desk, words: str) -> tuple[int, int]:
    return desk.text.splitlines()[0].index(words) + 1, 0


async def test_a_click_on_a_key_in_the_status_line_does_what_the_key_does() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        for words in ("space wake", "e end", "esc stop"):
            await desk.pilot.click(offset=place_of(desk, words))
        assert desk.engine.sent == [Wake("key"), EndTask(), Interrupt()]
        await desk.pilot.click(offset=place_of(desk, "/ type"))
        await desk.settled()
        assert desk.app.main.line.has_focus
        await desk.pilot.click(offset=place_of(desk, "space wake"))
        await desk.settled()
        assert desk.app.main.line.has_focus, "the line keeps the keyboard"
        assert desk.engine.sent[3:] == [Wake("key")]


async def test_a_click_goes_back_from_a_page_and_never_quits_a_running_task_at_once(tmp_path: Path) -> None:
    async with console(in_line=True) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("question_mark")
        await desk.pilot.click(offset=place_of(desk, "⌫ back"))
        await desk.settled()
        assert desk.app.screen is desk.app.main
        await desk.pilot.click(offset=place_of(desk, "ctrl+c quit"))
        await desk.settled()
        assert Quit() not in desk.engine.sent
        assert "again quits" in desk.text
