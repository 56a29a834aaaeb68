"""The console on one line, for a small pane beside other work."""

from __future__ import annotations

import pytest

from engine import events as ev
from engine.commands import Interrupt, Say
from tests.tui import scripted
from tests.tui.desk import console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.keys.keys import EDITING, IN_ONE_LINE, KEYS
from tui.widgets.ask import Ask
from tui.widgets.text_line import is_text

SIZES = [(80, 1), (80, 2), (120, 3), (40, 1)]


def engine() -> ScriptedEngine:
    return ScriptedEngine(robot=robot_at(-1.42, 0.08, 1.5708), floor=flat())


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_a_request_is_typed_sent_and_followed_and_esc_stops_it(size: tuple[int, int]) -> None:
    async with console(engine(), size=size, one_line=True, in_line=True) as desk:
        assert isinstance(desk.app.focused, Ask)
        assert "READY" in desk.text
        await desk.press(*"dance", "enter")
        assert desk.engine.sent == [Say("dance")]
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert "ACTING" in desk.text
        assert "▸ Go" in desk.text
        await desk.press("escape")
        assert desk.engine.sent[-1] == Interrupt()
        assert len(desk.text.splitlines()) == size[1]


async def test_what_is_heard_said_waits_and_fails_is_told_and_where_the_robot_is() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        assert "-1.4 0.1 m 90°" in desk.text
        desk.engine.publish(ev.TranscriptPartial("go to the ki", 3))
        desk.engine.publish(ev.RequestsWaiting(("dance", "nod")))
        await desk.settled()
        assert "“go to the ki…”" in desk.text
        assert "2 waiting" in desk.text
        desk.engine.publish(ev.TranscriptFinal("go to the kitchen", "speech", "", 1.0, 0.0, 0.0, 0.0, 0.0))
        desk.engine.publish(ev.SpeechStarted("Going to the kitchen.", False))
        desk.engine.publish(ev.PlanRejected("go to the kitchen", "No way leads there.", "x"))
        await desk.settled()
        assert "robot: Going to the kitchen." in desk.text
        desk.engine.publish(ev.ErrorRaised("path_blocked", "No way leads there.", ""))
        await desk.settled()
        assert "✗ No way leads there." in desk.text


async def test_the_line_keeps_the_keyboard_so_that_no_letter_is_an_unseen_key() -> None:
    async with console(engine(), size=(100, 3), one_line=True, in_line=True) as desk:
        await desk.press("ctrl+g", "backspace", *"wave")
        assert desk.engine.sent == []
        assert desk.app.main.line.value == "wave"


async def test_a_request_can_be_put_behind_what_runs() -> None:
    async with console(engine(), size=(100, 3), one_line=True, in_line=True) as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await desk.press(*"beep", "ctrl+j")
        assert desk.engine.sent == [Say("beep", wait=True)]


async def test_an_open_question_is_told_as_one() -> None:
    async with console(engine(), size=(100, 3), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))
        await desk.settled()
        assert "ASKING" in desk.text


async def test_what_happens_keeps_its_room_where_there_is_little() -> None:
    async with console(engine(), size=(40, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.SpeechStarted("I am in the kitchen, and nothing is there.", False))
        await desk.settled()
        assert "robot: I am in" in desk.text
        assert "m 90°" not in desk.text


async def test_a_pane_that_is_made_larger_and_smaller_goes_on_as_a_line() -> None:
    async with console(engine(), size=(80, 1), one_line=True, in_line=True) as desk:
        for size in ((120, 40), (80, 2), (60, 1)):
            await desk.pilot.resize_terminal(*size)
            await desk.settled()
            assert "READY" in desk.text
            assert "Conversation" not in desk.text
            assert "too small" not in desk.text


@pytest.mark.parametrize("size", [(80, 1), (80, 3)], ids=str)
async def test_a_key_that_needs_panes_or_pages_says_so(size: tuple[int, int]) -> None:
    async with console(engine(), size=size, one_line=True, in_line=True) as desk:
        needing = [key for key in KEYS if key.id not in IN_ONE_LINE]
        assert {"palette", "recall", "settings", "pane_map", "help", "log", "by_hand"} <= {key.id for key in needing}
        for key in needing:
            for one in key.key.split(","):
                if is_text(one) or one in EDITING:
                    continue
                desk.app.keeping.forget()
                await desk.press(one)
                assert "That needs the whole console." in desk.text, one
                assert desk.app.screen is desk.app.main
        assert desk.engine.sent == []


async def test_in_the_line_too_and_what_is_typed_stays_text() -> None:
    async with console(engine(), size=(80, 2), one_line=True, in_line=True) as desk:
        await desk.press(*"o1")
        assert "That needs" not in desk.text
        assert desk.app.main.line.value == "o1"
        for key in ("ctrl+p", "ctrl+r"):
            desk.app.keeping.forget()
            await desk.press(key)
            assert "That needs the whole console." in desk.text, key


async def test_a_request_that_a_stop_dropped_is_told_with_its_reason() -> None:
    async with console(engine(), size=(80, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "go to the study", "interrupted", "interrupt"), turn=None)
        await desk.settled()
        assert "■ go to the study  never begun: the stop key" in desk.text


async def test_a_question_has_all_the_room_there_is_and_ends_with_an_ellipsis() -> None:
    question = "Shall I go to the kitchen, to the living room, to the bedroom, to the study, or to the hall"
    async with console(engine(), size=(80, 3), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.SpeechStarted(f"{question}?", False))
        await desk.settled()
        shown = " ".join(" ".join(desk.text.splitlines()[:2]).split())
        assert f"robot: {question[:20]}" in shown
        assert f"{question[-30:]}?" in shown, "it goes on below"
        assert "m 90°" in shown
        await desk.pilot.resize_terminal(60, 4)
        await desk.settled()
        assert f"{question[-30:]}?" in " ".join(desk.text.split())
        await desk.pilot.resize_terminal(60, 2)
        await desk.settled()
        assert "robot: Shall I go to the kitchen" in desk.text
        assert "m 90°" not in desk.text, "what is asked goes before where the robot is"
        assert desk.text.splitlines()[0].rstrip().endswith("…")
