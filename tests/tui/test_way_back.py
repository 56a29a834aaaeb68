"""One way back that never stops, and one way to stop that is never a way back, wherever the keyboard is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from msgspec import structs
from textual import events
from textual.keys import key_to_character

from config.changing import Layers
from engine import events as ev
from engine.commands import Drive, EndTask, Interrupt, Quit, Say, Wake
from engine.handle import PartName, PartStatus
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.screens.doctor import DoctorScreen
from tui.screens.help import HelpScreen
from tui.screens.settings import SettingsScreen
from tui.screens.turn import TurnScreen
from tui.widgets.by_hand import ByHand
from tui.widgets.floor_view import FloorView
from tui.words import strings


@dataclass(frozen=True, slots=True)
class Place:
    """Where the keyboard can be: these keys lead there, and going back undoes the last ``undone`` of them."""

    keys: tuple[str, ...]
    undone: int = 1
    written: bool = False
    """Something is written there, which backspace takes away: the other key goes back."""
    size: tuple[int, int] = (120, 40)


FORM = ("ctrl+p", *"carry", "enter")
PLACES = {
    "the line": Place(("slash",)),
    "the line with a request": Place(("slash", *"go home"), undone=8, written=True),
    "a pane": Place(("3",)),
    "the map": Place(("m",)),
    "the map, closer": Place(("m", "plus", "right"), undone=3),
    "driving by hand": Place(("g",)),
    "driving by hand, faster": Place(("g", "plus"), undone=2),
    "a pane with all the room": Place(("1", "z")),
    "the map with all the room": Place(("4", "z")),
    "the log in place of others": Place(("l",), size=(80, 24)),
    "the turns in place of others": Place(("t",), size=(80, 24)),
    "a pane in place of others": Place(("5",), size=(60, 20)),
    "the palette": Place(("ctrl+p",)),
    "the palette with words": Place(("ctrl+p", *"kit"), undone=4, written=True),
    "earlier requests": Place(("ctrl+r",)),
    "a form": Place(FORM, undone=len(FORM)),
    "a form with words": Place((*FORM, *"red"), undone=len(FORM) + 3, written=True),
    "help": Place(("question_mark",)),
    "a turn": Place(("enter",)),
    "a turn, unfolded": Place(("enter", "j"), undone=2),
    "the doctor": Place(("d",)),
    "the settings": Place(("o",)),
    "a value of the settings": Place(("o", *["down"] * 2, "enter"), written=True),
    "help over a turn": Place(("enter", "question_mark")),
    "help on a small terminal": Place(("question_mark",), size=(60, 20)),
    "the palette on a small terminal": Place(("ctrl+p",), size=(60, 20)),
}


class Nobody:
    """Examines nothing."""

    def examine(self, parts: object, begins: object) -> tuple[()]:
        return ()


def engine() -> ScriptedEngine:
    made = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    made.offers = offer()
    return made


def dressed(desk: Desk, folder: Path) -> None:
    """What pages of this machine show."""
    desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=folder))
    desk.app.examining.know(lambda: Nobody())  # type: ignore[arg-type, return-value]


def where(desk: Desk) -> tuple[object, ...]:
    """What is open, and where the keyboard is."""
    main = desk.app.main
    panels = [type(widget).__name__ for widget in main.query("Palette, Form")]
    pages = list(map(type, desk.app.screen_stack))
    return pages, panels, desk.app.focused, sorted(main.classes), main.line.value


async def go(desk: Desk, keys: tuple[str, ...]) -> None:
    for key in keys:
        await desk.press({" ": "space"}.get(key, key))
        if isinstance(page := desk.app.screen, SettingsScreen):
            await desk.until(lambda: page.meant is not None)


@pytest.mark.parametrize("name", PLACES)
async def test_esc_stops_the_robot_and_changes_nothing_else(name: str, tmp_path: Path) -> None:
    place = PLACES[name]
    async with console(engine(), size=place.size) as desk:
        dressed(desk, tmp_path)
        desk.engine.play(scripted.acting())
        await go(desk, place.keys)
        before, seen = where(desk), await desk.picture()
        desk.engine.sent.clear()
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]
        assert where(desk) == before
        assert await desk.picture() == seen
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt(), Interrupt()], "it is never dead"
        assert "esc stop" in seen.replace("&#160;", " ")
        own = desk.app.screen is not desk.app.main or desk.app.main.panel or "hand" in name or name == "the line"
        if own:  # there, what has the keyboard says so itself
            key = "ctrl+g" if place.written else "⌫"
            assert f"{key} back · esc stops" in desk.text


@pytest.mark.parametrize("name", PLACES)
async def test_the_way_back_goes_one_step_and_stops_nothing(name: str, tmp_path: Path) -> None:
    place = PLACES[name]
    async with console(engine(), size=place.size) as desk:
        dressed(desk, tmp_path)
        desk.engine.play(scripted.acting())
        await go(desk, place.keys[: -place.undone])
        for key in ("backspace", "ctrl+g"):
            before = where(desk)
            await go(desk, place.keys[-place.undone :])
            there = where(desk)
            assert there != before
            await desk.press(key)
            if place.written and key == "backspace":
                assert where(desk)[:4] == there[:4], "it takes away what is written"
                await desk.press("ctrl+g")
            desk.app.main.line.value = ""
            assert where(desk)[:4] == before[:4]
            assert desk.engine.sent == []


@pytest.mark.parametrize("keys", [("m", "4"), ("o",), ("d",), ("enter",), ("question_mark",), ("ctrl+p",), ("ctrl+r",)])
async def test_the_key_that_opened_it_closes_it(keys: tuple[str, ...], tmp_path: Path) -> None:
    async with console(engine()) as desk:
        dressed(desk, tmp_path)
        before = where(desk)
        await go(desk, keys[:1])
        assert where(desk) != before
        await go(desk, keys[:1])
        assert where(desk) == before
        assert desk.engine.sent == []


@pytest.mark.parametrize(("key", "page"), [("o", SettingsScreen), ("d", DoctorScreen), ("enter", TurnScreen)])
async def test_q_leaves_a_page_and_quits_only_from_the_main_screen(key: str, page: type, tmp_path: Path) -> None:
    async with console(engine()) as desk:
        dressed(desk, tmp_path)
        await go(desk, (key,))
        assert isinstance(desk.app.screen, page)
        await desk.press("q")
        assert desk.app.screen is desk.app.main
        assert desk.engine.sent == []


async def test_help_opens_over_a_page_and_the_way_back_leads_to_it() -> None:
    async with console(engine()) as desk:
        desk.engine.play(scripted.done())
        await desk.press("enter", "question_mark")
        assert isinstance(desk.app.screen, HelpScreen)
        await desk.press("ctrl+g")
        assert isinstance(desk.app.screen, TurnScreen)
        await desk.press("ctrl+g")
        assert desk.app.screen is desk.app.main


# Nothing to stop, nothing to go back from


def stopped(state: ev.State) -> ev.InterruptRaised:
    return ev.InterruptRaised("interrupt", "interrupt", state)


@pytest.mark.parametrize("keys", [(), ("slash",), ("ctrl+p",), ("question_mark",), ("enter",)])
async def test_esc_says_that_there_is_nothing_to_stop_and_names_the_way_back(keys: tuple[str, ...]) -> None:
    async with console(engine()) as desk:
        desk.engine.on_command = lambda command: desk.engine.publish(stopped("IDLE"), turn=None)
        await desk.press(*keys)
        await desk.press("escape")
        await desk.until(lambda: "Nothing to stop" in desk.text.splitlines()[0])
        assert ("· ⌫ goes back" in desk.text.splitlines()[0]) is bool(keys), "where there is something to go back from"
        assert desk.engine.sent == [Interrupt()]


async def test_esc_does_not_say_so_when_the_engine_stopped_something_that_is_over_on_the_screen() -> None:
    async with console(engine()) as desk:
        desk.engine.on_command = lambda command: desk.engine.publish(stopped("ACTING"))
        await desk.press("escape")
        assert "Nothing to stop" not in desk.text


async def test_esc_does_not_say_so_when_the_robot_moved_without_a_task() -> None:
    async with console(engine()) as desk:
        desk.engine.robot = robot_at(0.0, 0.0, 0.0, speed=0.2)
        desk.app.redraw()
        await desk.until(lambda: desk.app.shown.robot == desk.engine.robot)
        desk.engine.on_command = lambda command: desk.engine.publish(stopped("IDLE"), turn=None)
        await desk.press("escape")
        assert "Nothing to stop" not in desk.text


async def test_a_stop_that_somebody_else_asked_for_is_no_answer_to_a_key() -> None:
    async with console(engine()) as desk:
        desk.engine.publish(stopped("IDLE"))
        await desk.settled()
        assert "Nothing to stop" not in desk.text


@pytest.mark.parametrize("key", ["question_mark", "enter", "slash", "3", "m"])
@pytest.mark.parametrize(("said_by", "words"), [("backspace", "Nothing to go back"), ("escape", "Nothing to stop")])
async def test_what_is_said_about_the_way_back_goes_when_the_keyboard_goes_elsewhere(
    said_by: str, words: str, key: str
) -> None:
    async with console(engine()) as desk:
        desk.engine.on_command = lambda command: desk.engine.publish(stopped("IDLE"), turn=None)
        await desk.press(said_by)
        assert words in desk.text
        await desk.press(key)
        assert words not in desk.text


async def test_where_there_is_no_way_back_that_is_said() -> None:
    async with console(engine()) as desk:
        await desk.press("backspace")
        assert "Nothing to go back from · / goes to the line" in desk.text
        assert desk.engine.sent == []


# Questions


async def test_esc_takes_back_the_question_of_the_map() -> None:
    async with console(engine()) as desk:
        await desk.press("m", "tab", "enter")
        assert "Go to" in desk.text
        await desk.press("escape")
        assert isinstance(desk.app.focused, FloorView)
        assert "Go to" not in desk.text
        await desk.press("enter")
        assert desk.engine.sent == [Interrupt()], "enter asks again, and does not answer"


@pytest.mark.parametrize("key", ["escape", "backspace", "ctrl+g"])
async def test_the_question_whether_to_quit_is_taken_back(key: str) -> None:
    async with console(engine()) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("q")
        assert "q again quits" in desk.text
        before = where(desk)
        await desk.press(key)
        assert "again quits" not in desk.text
        assert where(desk) == before


@pytest.mark.parametrize("key", ["question_mark", "o", "enter", "ctrl+p"])
async def test_what_is_opened_takes_the_question_whether_to_quit_back(key: str) -> None:
    async with console(engine()) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("q", key)
        assert "again quits" not in desk.text
        await desk.press("ctrl+g")
        assert desk.app.screen is desk.app.main
        assert "again quits" not in desk.text
        assert Quit() not in desk.engine.sent


# Driving by hand


async def test_esc_stops_a_hand_and_leaves_it_its_keys() -> None:
    async with console(engine()) as desk:
        await desk.press("g", "up", "escape", "up")
        assert desk.engine.sent == [Drive(0.2, 0.0, 0.0), Interrupt(), Drive(0.2, 0.0, 0.0)]
        await desk.press("backspace", "up")
        assert len(desk.engine.sent) == 3, "whoever went back drives no more"


async def test_who_looks_at_another_page_or_window_drives_no_more() -> None:
    async with console(engine()) as desk:
        await desk.press("g", "question_mark", "ctrl+g", "up", "w")
        assert desk.engine.sent == []
        assert not desk.app.main.query_one(ByHand).display
        await desk.press("g")
        for event in (events.AppBlur(), events.AppFocus()):
            desk.app.post_message(event)
            await desk.settled()
        await desk.press("up", "w")
        assert desk.engine.sent == []
        assert not desk.app.main.query_one(ByHand).display


# A key that is held down


async def test_a_backspace_that_is_held_down_clears_the_line_and_does_not_leave_it() -> None:
    async with console(engine(), in_line=True) as desk:
        await desk.press(*"no", *["backspace"] * 9, *"go", "enter")
        assert desk.engine.sent == [Say("go")]
        await desk.press("backspace", "space")
        assert desk.app.focused is None, "in a line in which nothing was written it goes back"
        assert desk.engine.sent[1:] == [Wake("key")]


async def test_a_backspace_after_a_pause_leaves_the_line_that_was_emptied_by_backspaces() -> None:
    async with console(engine(), in_line=True) as desk:
        await desk.press(*"a", "backspace")
        assert "⌫ back" in desk.text.splitlines()[-1]
        desk.app.clock = lambda: 1.0
        await desk.press("backspace")
        assert desk.app.focused is None


async def test_a_backspace_that_is_held_down_in_a_panel_does_not_close_it() -> None:
    async with console(engine()) as desk:
        await desk.press("ctrl+p", *"kit", *["backspace"] * 9, *"bed", "enter")
        assert desk.engine.sent == [Say("go to the bedroom")]


def post(desk: Desk, *keys: str) -> None:
    """As a slow line delivers them: all at once."""
    for key in keys:
        desk.app.post_message(events.Key(key, key_to_character(key)))


async def test_what_follows_the_key_that_goes_back_at_once_goes_where_the_keyboard_is_then() -> None:
    async with console(engine(), in_line=True) as desk:
        post(desk, *"go", "ctrl+g", "e")
        await desk.settled()
        assert desk.app.main.line.value == "go"
        assert desk.engine.sent == [EndTask()]
        await desk.press("slash", "ctrl+u", "question_mark")
        for key in ("backspace", "ctrl+g"):
            post(desk, key, *"ego")
            await desk.settled()
            assert desk.app.main.line.value == "ego"
            assert desk.engine.sent == [EndTask()], "no letter is a key where the line has the keyboard again"
            await desk.press("ctrl+u", "question_mark")


@pytest.mark.parametrize("key", ["backspace", "tab", "ctrl+g"])
async def test_what_follows_a_key_that_leaves_the_line_at_once_is_a_key(key: str) -> None:
    async with console(engine(), in_line=True) as desk:
        post(desk, key, "e", "l", "slash", *"go", "enter", key, "e")
        await desk.settled()
        assert desk.engine.sent == [EndTask(), Say("go"), EndTask()]
        assert desk.app.main.line.value == ""


async def test_requests_that_arrive_at_once_are_kept_one_by_one() -> None:
    async with console(engine(), in_line=True) as desk:
        post(desk, *"ab", "enter", *"cd", "enter", "up", "backspace", "e", "enter", "space", *"f")
        await desk.settled()
        assert desk.engine.sent == [Say("ab"), Say("cd"), Say("ce"), Wake("key")]
        assert desk.app.main.line.value == "f"


async def test_a_letter_that_was_dealt_out_before_the_line_got_the_keyboard_is_text() -> None:
    async with console(engine()) as desk:
        await desk.press("6")
        post(desk, "tab", *"ego")
        await desk.settled()
        assert desk.app.main.line.value == "ego"
        assert desk.engine.sent == []


# Where the keyboard comes back to


@pytest.mark.parametrize("keys", [("slash", *"go"), ("2",), ()])
@pytest.mark.parametrize("panel", ["ctrl+p", "ctrl+r"])
async def test_a_panel_gives_the_keyboard_back_to_where_it_was(keys: tuple[str, ...], panel: str) -> None:
    async with console(engine()) as desk:
        await desk.press(*keys)
        before = where(desk)
        await desk.press(panel, "ctrl+g")
        assert where(desk) == before


async def test_the_line_has_the_keyboard_again_once_a_tiny_terminal_has_grown() -> None:
    async with console(engine(), in_line=True) as desk:
        await desk.press(*"go")
        await desk.pilot.resize_terminal(40, 10)
        await desk.press("space")
        assert desk.engine.sent == [Wake("key")], "where no line is seen, keys are keys"
        await desk.pilot.resize_terminal(80, 24)
        await desk.press(*"on", "enter")
        assert desk.engine.sent[1:] == [Say("goon")]


async def test_a_pressed_emergency_stop_does_not_hide_the_keys_of_a_page() -> None:
    async with console(engine()) as desk:
        await desk.press("question_mark")
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        desk.app.redraw()
        await desk.until(lambda: "E-STOP" in desk.text)
        assert "⌫ back · esc stops" in desk.text


# What failed

LOST = ev.ErrorRaised("skill_crashed", "The skill beep has a fault.", "Please report it.")


@pytest.mark.parametrize("fatal", [False, True])
@pytest.mark.parametrize("way", ["backspace", "ctrl+g", "click"])
async def test_what_is_told_of_a_failure_goes_away_by_every_way_back(way: str, *, fatal: bool) -> None:
    async with console(engine(), in_line=True) as desk:
        desk.engine.publish(structs.replace(LOST, fatal=fatal))
        await desk.settled()
        assert "⌫ back · esc stops" in desk.text
        if way == "click":
            row = next(y for y, line in enumerate(desk.text.splitlines()) if LOST.message in line)
            await desk.pilot.click(offset=(6, row))
        else:
            await desk.press(way)
        await desk.settled()
        assert "Please report it" not in desk.text
        assert desk.app.main.line.has_focus, "one step"
        assert not desk.app.main.has_class("-trouble")
        desk.engine.publish(structs.replace(LOST, fatal=fatal))
        await desk.settled()
        assert ("Please report it" in desk.text) is not fatal, "once more; after the end nothing tells more than that"


async def test_with_words_in_the_line_the_failure_names_the_key_that_goes_back_then() -> None:
    async with console(engine(), in_line=True) as desk:
        await desk.press(*"go")
        desk.engine.publish(LOST)
        await desk.settled()
        assert "ctrl+g back · esc stops" in desk.text
        await desk.press("ctrl+g")
        assert desk.app.main.line.value == "go"
        assert "Please report it" not in desk.text


@pytest.mark.parametrize("part", ["microphone", "recogniser"])
@pytest.mark.parametrize("in_line", [True, False])
async def test_where_nobody_can_be_heard_waking_is_not_offered_and_its_key_stops_nothing(
    part: PartName, *, in_line: bool
) -> None:
    deaf = engine()
    deaf.parts = tuple(PartStatus(one.name, "missing" if one.name == part else "ready") for one in deaf.parts)
    async with console(deaf, size=(120, 40), in_line=in_line) as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert "wake" not in desk.text.splitlines()[0]
        await desk.press("space")
        assert desk.engine.sent == []
        assert strings.DEAF[part] in desk.text
        deaf.parts = scripted.PARTS_READY
        desk.engine.publish(ev.Log("info", part, "ready"))
        await desk.settled()
        await desk.until(lambda: "space wake" in desk.text.splitlines()[0] or desk.app.keeping.forget())  # type: ignore[func-returns-value]
        await desk.press("space")
        assert desk.engine.sent == [Wake("key")]
