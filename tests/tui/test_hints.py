"""On little room keys are left out as a whole, and the one that stops the robot stays where it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rich.cells import cell_len
from textual.geometry import Region
from textual.widgets import Static

from config.changing import Layers
from engine import events as ev
from engine.commands import Interrupt, Release, Say
from engine.handle import PartStatus
from tests.tui import conversation, scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_READY, ScriptedEngine, flat, robot_at
from tui.keys.keys import ALL_KEYS
from tui.words import strings
from tui.words.hints import JOINT, fitting, hint_line, sentence
from tui.words.language import Language

SIZES = [(60, 16), (64, 20), (70, 24), (80, 24), (120, 40)]
KEYS = "a browses · b opens · c copies · d back · esc stops"


def test_what_does_not_fit_is_left_out_whole_the_last_one_stays() -> None:
    assert fitting(KEYS, 100) == KEYS
    assert fitting(KEYS, 40) == "a browses · b opens · esc stops"
    assert fitting(KEYS, 40, last=2) == "a browses · b opens · d back · esc stops"
    assert fitting(KEYS, 20, last=2) == "d back · esc stops"
    for columns in range(60):
        found = fitting(KEYS, columns)
        assert set(found.split(JOINT)) <= set(KEYS.split(JOINT))
        assert found.endswith("esc stops")
        assert cell_len(found) <= columns or found == "esc stops"


def test_a_hint_stands_there_with_those_of_its_keys_that_act_and_not_at_all_where_none_does() -> None:
    words = "how fast {speed} · {queue_earlier} {queue_later} move · {back} back · {interrupt} stops"
    assert hint_line(words, {"queue_later": "J", "interrupt": "esc"}.get, speed=3) == "how fast 3 · J move · esc stops"
    every = {"queue_earlier": "K", "queue_later": "J", "back": "⌫", "interrupt": "esc"}.get
    assert hint_line(words, every, speed=3) == "how fast 3 · K J move · ⌫ back · esc stops"
    assert hint_line(words, every, 31, last=2, speed=3) == "how fast 3 · ⌫ back · esc stops"


def test_a_sentence_about_a_key_that_does_nothing_is_not_said() -> None:
    assert sentence("Press {wake} and speak.", {"wake": "space"}.get) == "Press space and speak."
    assert sentence("Press {wake} and speak.", {}.get) == ""


def status(desk: Desk) -> str:
    return desk.text.splitlines()[0]


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_the_key_that_stops_stands_in_one_place_in_every_state(size: tuple[int, int], language: Language) -> None:
    stop = {"en": "esc stop", "zh": "esc 停止"}[language]
    async with console(size=size, language=language) as desk:
        columns = set()

        async def look() -> None:
            await desk.settled()
            before, found, _ = status(desk).partition(stop)
            assert found, status(desk)
            columns.add(cell_len(before))
            assert size[0] >= 110 or desk.app.shown.notice or "…" not in status(desk)  # a goal may be cut

        await look()
        for state in strings.STATE_WORDS:
            desk.engine.publish(ev.StateChanged("IDLE", state, "x"))
            await look()
        desk.engine.play(scripted.acting())
        await look()
        await desk.press("q")  # asks whether to quit
        await look()
        desk.engine.parts = (PartStatus("robot", "loading"), *PARTS_READY[1:])
        desk.engine.publish(ev.Log("info", "robot", "x"))
        await look()
        desk.engine.publish(ev.SessionEnded("asked to"))
        await look()
        assert len(columns) == 1


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_a_question_in_the_status_line_has_the_room_of_keys(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("q")
        assert "esc stop" in status(desk)
        assert "A task is running: q again qui" in status(desk)


@pytest.mark.parametrize("size", [(60, 16), (66, 24), (80, 24)], ids=str)
async def test_no_hint_on_a_page_or_in_the_line_is_cut(size: tuple[int, int], tmp_path: Path) -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    async with console(engine, size=size) as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=tmp_path))
        conversation.play(engine, conversation.ALL)
        desk.app.examining.know(lambda: _Nobody())  # type: ignore[arg-type, return-value]
        for keys, last in (
            (("enter",), "⌫ back · esc stops"),
            (("d",), "⌫ back · esc stops"),
            (("o",), "⌫ back · esc stops"),
            (("question_mark",), "⌫ back · esc stops"),
            (("ctrl+p",), "⌫ back · esc stops"),
            (("x",), "ctrl+g back · esc stops"),
            (("ctrl+g", "ctrl+g", "slash"), "⌫ back · esc stops"),
            (("tab", "ctrl+g", "g"), "⌫ back · esc stops"),
        ):
            await desk.press(*keys)
            await desk.settled()
            hinting = [line for line in desk.text.splitlines() if last in line]
            assert hinting, (keys, desk.text)
            assert all("…" not in line for line in hinting), hinting


async def test_the_question_whether_to_quit_says_that_esc_stops_the_task() -> None:
    async with console(keymap={"interrupt": "f2"}) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("q")
        assert "q again quits, f2 stops it" in status(desk)
        await desk.press("f2")
        assert desk.engine.sent == [Interrupt()]
        assert "again" not in status(desk)


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_a_key_stands_in_the_status_line_only_where_it_does_something(size: tuple[int, int]) -> None:
    async with console(size=size, in_line=True) as desk:
        assert "space wake  ? help" in status(desk)
        await desk.press(*"go")
        assert "enter send  ctrl+g back" in status(desk)
        for text in ("space wake", "? help", "tab panes"):
            assert text not in status(desk), "it is text there, or completes"
        await desk.press("backspace", "backspace")
        assert "space wake  ? help" in status(desk)


async def test_the_key_to_help_that_is_shown_while_typing_opens_it() -> None:
    async with console(size=(80, 24), in_line=True) as desk:
        await desk.press(*"go")
        assert "f1 help" in status(desk)
        await desk.press("f1")
        assert strings.HELP_TITLE in desk.text
        await desk.press("f1")
        assert desk.app.main.line.value == "go"


@pytest.mark.parametrize(("hint", "sent", "left"), [("enter send", [Say("beep")], ""), ("↑ earlier", [], "dance")])
async def test_a_click_on_a_key_of_the_line_does_what_the_key_does(hint: str, sent: list[Say], left: str) -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"dance", "enter", *"beep")
        desk.engine.sent.clear()
        await desk.pilot.click(offset=(status(desk).index(hint) + 1, 0))
        await desk.settled()
        assert desk.engine.sent == sent
        assert desk.app.main.line.value == left


async def test_without_a_microphone_no_key_that_wakes_is_shown() -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    engine.parts = tuple(
        PartStatus("microphone", "missing") if part.name == "microphone" else part for part in PARTS_READY
    )
    async with console(engine, in_line=True) as desk:
        assert "space wake" not in status(desk)
        assert "? help" in status(desk)


PRESSED = "nothing moves; {} releases"


@pytest.mark.parametrize(
    ("keys", "keymap", "shown"),
    [
        ((), {}, "ctrl+o"),
        ((*"go",), {}, "ctrl+o"),
        (("ctrl+g",), {}, "ctrl+o"),
        (("ctrl+g", "question_mark"), {}, "ctrl+o"),
        (("ctrl+g", "enter"), {}, "ctrl+o"),
        (("ctrl+p", "x"), {}, "ctrl+o"),
        (("ctrl+g",), {"release": "R"}, "R"),
        ((), {"release": "R"}, "ctrl+g R"),
    ],
    ids=str,
)
async def test_the_emergency_stop_is_released_in_every_state_by_the_key_that_is_shown(
    keys: tuple[str, ...], keymap: dict[str, str], shown: str
) -> None:
    async with console(in_line=True, keymap=keymap) as desk:
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        await desk.press(*keys)
        desk.app.redraw()
        await desk.until(lambda: PRESSED.format(shown) in status(desk))
        await desk.press(*shown.split())
        assert desk.engine.sent == [Release()]


async def test_what_a_release_drops_is_said_before_somebody_releases() -> None:
    async with console(ScriptedEngine(robot=replace(robot_at(0.0, 0.0, 0.0), estop=True))) as desk:
        desk.engine.publish(ev.RequestsWaiting(("nod",), (ev.WaitingRequest("R1", "nod"),)))
        await desk.settled()
        assert "nothing moves; ctrl+o releases and drops what waits" in status(desk)
        desk.engine.publish(ev.RequestsWaiting((), ()))
        await desk.settled()
        assert "drops" not in status(desk)
        desk.engine.publish(ev.ClarificationAsked("Which room?", "go to the room"))
        await desk.settled()
        assert "releases and drops what waits" in status(desk)


async def test_a_click_on_what_the_status_line_says_of_the_emergency_stop_releases_it() -> None:
    async with console(size=(80, 24), in_line=True) as desk:
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        desk.app.redraw()
        await desk.until(lambda: "releases" in status(desk))
        await desk.pilot.click(offset=(status(desk).index("releases"), 0))
        await desk.settled()
        assert desk.engine.sent == [Release()]


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("size", [(60, 16), (80, 24), (120, 40)], ids=str)
async def test_no_key_and_no_sentence_of_the_help_is_cut(size: tuple[int, int], language: Language) -> None:
    async with console(size=size, language=language, keymap={"recall": "ctrl+r,ctrl+t,f12"}) as desk:
        await desk.press("question_mark")
        page = desk.app.screen.query_one("#page")
        drawn: dict[str, set[str]] = {"key": set(), "about": set()}
        for cell in page.query(Static):
            assert cell.region.right <= page.content_region.right
            lines = [strip.text.strip() for strip in cell.render_lines(Region(0, 0, *cell.size))]
            drawn["key" if cell.has_class("key") else "about"].add("".join(lines).replace(" ", ""))
            assert len(lines) == 1 or not cell.has_class("key"), "a key stands on one line"
        assert drawn["key"] >= {key.replace(" ", "") for key in desk.app.listed_keys.values()}
        assert drawn["about"] >= {key.about.replace(" ", "") for key in ALL_KEYS}
        top = ""
        while top != desk.text:
            top = desk.text
            await desk.press("pagedown")
        assert strings.ABOUT_KEYS[ALL_KEYS[-1].id] in desk.text, "its end can be reached"


class _Nobody:
    """Examines nothing."""

    def examine(self, parts: object, begins: object) -> tuple[()]:
        return ()
