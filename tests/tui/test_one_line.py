"""The console on one line, for a small pane beside other work."""

from __future__ import annotations

import re
import threading
from dataclasses import replace

import pytest

from engine import events as ev
from engine.commands import Command, Interrupt, Say
from engine.errors import SaysoError
from engine.handle import EngineHandle
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.keys.keys import EDITING, IN_ONE_LINE, KEYS
from tui.rooms.ending import Ending
from tui.shown.watchdog import engine_is_silent
from tui.widgets.ask import Ask
from tui.widgets.text_line import is_text

SIZES = [(80, 1), (80, 2), (120, 3), (40, 1)]


def engine() -> ScriptedEngine:
    return ScriptedEngine(robot=robot_at(-1.42, 0.08, 1.5708), floor=flat())


def pressed() -> ScriptedEngine:
    """With its emergency stop pressed."""
    return ScriptedEngine(robot=replace(robot_at(-1.42, 0.08, 1.5708), estop=True), floor=flat())


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


def driving(engine: ScriptedEngine, progress: str) -> None:
    engine.play(scripted.acting())
    engine.publish(ev.ActionProgress("a2", "navigation", 0.4, progress))


@pytest.mark.parametrize("progress", ["0.9 m to go", "0.9 m to go, then through the kitchen door"])
async def test_how_many_wait_has_its_room_before_how_far_what_runs_has_come(progress: str) -> None:
    async with console(engine(), size=(80, 1), one_line=True, in_line=True) as desk:
        driving(desk.engine, progress)
        await desk.settled()
        assert "▸ Go to the kitchen · 0.9 m" in desk.text
        desk.engine.publish(ev.RequestsWaiting(("beep",)), turn=None)
        await desk.settled()
        assert re.search(r"▸ Go to the kitchen +1 waiting", desk.text)


async def test_how_many_wait_has_its_room_beside_what_runs_that_is_too_long() -> None:
    async with console(engine(), size=(80, 1), one_line=True, in_line=True) as desk:
        driving(desk.engine, "0.9 m to go")
        told = "Put the red cup on the coffee table in the hall"
        desk.engine.publish(ev.ActionStarted("a2", 2, 4, "put", {}, told))
        desk.engine.publish(ev.RequestsWaiting(("beep",)), turn=None)
        await desk.settled()
        assert re.search(r"▸ Put the red cu.*… +1 waiting", desk.text)
        await desk.pilot.resize_terminal(50, 1)
        await desk.settled()
        assert "▸ Put" in desk.text, "half of the row stays for what runs"
        assert "waiting" not in desk.text


async def test_how_far_what_runs_has_come_leaves_before_the_end_of_a_request() -> None:
    async with console(engine(), size=(100, 1), one_line=True, in_line=True) as desk:
        driving(desk.engine, "0.9 m to go")
        over(desk.engine, "R2", "flurb", "failed", UNKNOWN, "T9")
        await desk.settled()
        assert "▸ Go to the kitchen · ■ flurb: " in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "▸ Go to the kitchen · 0.9 m to go" in desk.text


async def test_an_open_question_is_told_as_one() -> None:
    async with console(engine(), size=(100, 3), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))
        await desk.settled()
        assert "ASKING" in desk.text


@pytest.mark.parametrize("columns", [60, 80])
async def test_how_many_wait_has_its_room_beside_a_question_that_is_too_long(columns: int) -> None:
    async with console(engine(), size=(columns, 1), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ClarificationAsked("Which one: the white cup or the blue cup?", "bring me the cup"))
        desk.engine.publish(ev.RequestsWaiting(("nod", "dance")), turn=None)
        await desk.settled()
        assert re.search(r"ASKING .*… +2 waiting", desk.text)


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


# How requests ended that were not done

UNKNOWN = "I don't know a place called moon."
REFUSED = "The emergency stop is pressed: release it first."


def over(engine: ScriptedEngine, request: str, text: str, outcome: ev.RequestOutcome, message: str, turn: str) -> None:
    """A request in words has become a turn, which ended like this."""
    engine.publish(ev.TranscriptFinal(text, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0), turn=turn)
    code = 0 if outcome == "done" else 1
    engine.publish(ev.StateChanged("ACTING", "WAITING", outcome, ev.TurnResult(code, outcome, message)), turn=turn)
    engine.publish(ev.RequestEnded(request, text, outcome), turn=turn)


def refused(engine: ScriptedEngine, request: str, text: str, turn: str) -> None:
    """The emergency stop refuses a request in words, which has become a turn."""
    engine.publish(ev.TranscriptFinal(text, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0), turn=turn)
    engine.publish(scripted.queued(f"A{turn}", 1, 1, "arm_shake", {}), turn=turn)
    ended = ev.ActionFinished(f"A{turn}", "arm_shake", {}, "failed", "robot_halted", REFUSED, 0.0)
    engine.publish(ended, turn=turn)
    result = ev.TurnResult(1, "failed", REFUSED)
    engine.publish(ev.StateChanged("FEEDBACK", "WAITING", "failed", result), turn=turn)
    engine.publish(ev.RequestEnded(request, text, "failed"), turn=turn)


def replacing(engine: ScriptedEngine) -> None:
    """Another request comes while one is done and two wait."""
    engine.publish(ev.TranscriptFinal("go to the bedroom", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0), turn="T1")
    engine.publish(ev.InterruptRaised("replaced", "say", "ACTING"), turn="T1")
    engine.publish(ev.RequestEnded("R2", "find the cup", "replaced", "replaced"), turn=None)
    engine.publish(ev.RequestEnded("R3", "go to the hall", "replaced", "replaced"), turn=None)
    result = ev.TurnResult(130, "interrupted", "A newer command replaced this one.")
    engine.publish(ev.StateChanged("ACTING", "WAITING", "interrupted", result), turn="T1")
    engine.publish(ev.RequestEnded("R1", "go to the bedroom", "replaced", "replaced"), turn="T1")


async def test_a_request_that_failed_is_told_behind_what_runs() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        over(desk.engine, "R1", "go to the moon", "failed", UNKNOWN, "T0")
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert re.search(rf"▸ Go [^■]* · ■ go to the moon: {UNKNOWN}", desk.text)
        await desk.press(*"wave")
        assert f"■ go to the moon: {UNKNOWN}" in desk.text, "who types has not read it yet"
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "▸ Go" in desk.text
        assert "■" not in desk.text


async def test_what_the_robot_says_now_goes_before_the_end_of_an_older_request() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        over(desk.engine, "R1", "go to the moon", "failed", UNKNOWN, "T0")
        desk.engine.publish(ev.StateChanged("WAITING", "SPEAKING", "answering"))
        desk.engine.publish(ev.SpeechStarted("I am in the hall.", False))
        await desk.settled()
        assert f"robot: I am in the hall. · ■ go to the moon: {UNKNOWN}" in desk.text


async def test_an_engine_that_hangs_goes_before_ends_and_trouble_is_told_once() -> None:
    async with console(engine(), size=(140, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ErrorRaised("no_path", UNKNOWN, ""), turn="T1")
        over(desk.engine, "R1", "go to the moon", "failed", UNKNOWN, "T1")
        desk.engine.publish(ev.ErrorRaised("no_path", UNKNOWN, ""), turn="T1")
        await desk.settled()
        assert desk.text.count(UNKNOWN) == 1
        desk.app.drawing.model = engine_is_silent(desk.app.drawing.model, stop="esc", leave="ctrl+c")
        desk.app.redraw()
        await desk.settled()
        assert re.search(r"✗ It hangs or was paused.* · ■ go to the moon", desk.text)


async def test_what_was_done_or_is_asked_about_is_told_as_it_was() -> None:
    async with console(engine(), size=(100, 2), one_line=True, in_line=True) as desk:
        over(desk.engine, "R1", "wave", "done", "Waved.", "T1")
        over(desk.engine, "R2", "go to the bedrom", "clarify", "Shall I go to the bedroom?", "T2")
        await desk.settled()
        assert "■" not in desk.text


async def test_all_that_a_new_request_replaces_is_told_one_after_the_other() -> None:
    async with console(engine(), size=(100, 2), one_line=True, in_line=True) as desk:
        replacing(desk.engine)
        over(desk.engine, "R4", "qwer asdf", "failed", "I did not understand.", "T2")
        await desk.settled()
        for words in (
            "■ (2) find the cup, go to the hall  replaced before it began",
            "■ go to the bedroom  replaced by a newer request",
            "■ qwer asdf: I did not understand.",
        ):
            assert words in desk.text
            desk.app.drawing.ending.next()
            await desk.settled()
        assert "■" not in desk.text


async def test_ends_with_the_same_reason_are_told_together_their_names_first_and_others_by_themselves() -> None:
    unknown = f"{UNKNOWN} I know kitchen, living room, bedroom, study, hall, and charging dock."
    async with console(engine(), size=(80, 2), one_line=True, in_line=True) as desk:
        over(desk.engine, "R1", "go to the moon", "failed", unknown, "T1")
        over(desk.engine, "R2", "drive to the moon", "failed", unknown, "T2")
        over(desk.engine, "R3", "flurb", "failed", "I did not understand.", "T3")
        await desk.settled()
        assert "■ (2) go to the moon, drive to the moon: I don't" in desk.text
        assert "flurb" not in desk.text
        assert "…" in desk.text, "the reason is cut"
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "■ flurb: I did not understand." in desk.text


async def test_what_must_be_read_now_comes_before_an_end_which_is_told_afterwards() -> None:
    async with console(engine(), size=(100, 2), one_line=True, in_line=True) as desk:
        over(desk.engine, "R1", "go to the moon", "failed", UNKNOWN, "T1")
        await desk.press("ctrl+p")
        assert "That needs the whole console." in desk.text
        desk.app.keeping.forget()
        await desk.settled()
        assert f"■ go to the moon: {UNKNOWN}" in desk.text


@pytest.mark.parametrize("asks", [False, True])
async def test_what_the_stop_key_drops_is_told_at_once(*, asks: bool) -> None:
    async with console(engine(), size=(100, 2), one_line=True, in_line=True) as desk:
        if asks:
            desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))
        waiting = tuple(ev.WaitingRequest(f"R{number}", text) for number, text in enumerate(("nod", "beep")))
        desk.engine.publish(ev.RequestsWaiting(("nod", "beep"), waiting), turn=None)

        def stopped(command: Command) -> None:
            desk.engine.publish(ev.InterruptRaised("interrupt", "interrupt", "IDLE"), turn=None)
            for one in waiting:
                desk.engine.publish(ev.RequestEnded(one.request, one.text, "interrupted", "interrupt"), turn=None)
            desk.engine.publish(ev.RequestsWaiting((), ()), turn=None)
            if asks:
                desk.engine.publish(ev.QuestionEnded("go to the bedrom", "withdrawn", "interrupt"))

        desk.engine.on_command = stopped
        await desk.press("escape")
        assert "■ (2) nod, beep  never begun: the stop key" in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert ("■ go to the bedrom  question withdrawn: the stop key" in desk.text) is asks


async def test_what_the_stop_key_drops_while_the_engine_starts_is_told_at_once() -> None:
    gate = threading.Event()

    def start() -> EngineHandle:
        gate.wait(30)
        return engine()

    async with console(start=start, size=(100, 2), one_line=True, in_line=True) as desk:
        await desk.press(*"nod", "enter", *"beep", "ctrl+j", "escape")
        assert "■ (2) nod, beep  never begun: the stop key" in desk.text
        gate.set()


async def test_a_request_that_the_emergency_stop_refuses_is_told_while_it_is_pressed() -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        assert "E-STOP" in desk.text
        assert "nothing moves" in desk.text
        over(desk.engine, "R1", "wave", "failed", REFUSED, "T1")
        await desk.settled()
        assert "E-STOP" in desk.text
        assert re.search(rf"nothing moves; .* · ■ wave: {REFUSED}", desk.text), "the stop comes first"
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "nothing moves" in desk.text


def released(desk: Desk) -> None:
    desk.engine.robot = robot_at(-1.42, 0.08, 1.5708)
    desk.app.redraw()


@pytest.mark.parametrize("read", [False, True])
async def test_nothing_says_that_the_emergency_stop_is_pressed_once_it_is_released(*, read: bool) -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "beep", "interrupted", "estop"), turn=None)
        refused(desk.engine, "R2", "wave", "T1")
        desk.engine.publish(ev.SpeechStarted(REFUSED, False), turn="T1")
        await desk.settled()
        for _ in range(2 * read):
            desk.app.drawing.ending.next()
            await desk.settled()
        released(desk)
        while True:
            await desk.settled()
            assert "READY" in desk.text
            assert "is pressed" not in desk.text
            if not desk.app.drawing.ending.told:
                break
            desk.app.drawing.ending.next()
        assert "emergency stop" not in desk.text
        over(desk.engine, "R3", "go to the moon", "failed", UNKNOWN, "T2")
        await desk.settled()
        assert f"■ go to the moon: {UNKNOWN}" in desk.text


async def test_how_each_request_ended_is_told_also_after_the_emergency_stop_is_released() -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "beep", "interrupted", "estop"), turn=None)
        desk.engine.publish(ev.QuestionEnded("find the cup", "withdrawn", "estop"), turn=None)
        refused(desk.engine, "R2", "wave", "T1")
        over(desk.engine, "R3", "go to the moon", "failed", UNKNOWN, "T2")
        await desk.settled()
        assert "■ beep  never begun: the emergency stop" in desk.text
        for words in (
            "■ find the cup  ques",
            f"■ wave: {REFUSED}",
            f"■ go to the moon: {UNKNOWN}",
            "■ beep  never beg",
        ):
            desk.app.drawing.ending.next()
            await desk.settled()
            assert words in desk.text, "all of them in turn, as long as it is pressed"
        desk.app.drawing.ending.next()
        released(desk)
        await desk.settled()
        for words in (
            "■ beep  never begun: the emergency stop",
            "■ find the cup  question withdrawn: the emergency stop",
            "■ wave  not done: the emergency stop was pressed",
            f"■ go to the moon: {UNKNOWN}",
        ):
            assert words in desk.text
            desk.app.drawing.ending.next()
            await desk.settled()


async def test_while_the_emergency_stop_is_pressed_the_newest_request_is_told_first() -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "nod", "interrupted", "estop"), turn=None)
        await desk.settled()
        assert "■ nod" in desk.text
        assert desk.app.drawing.ending._next is None, "nothing else is to be told"
        refused(desk.engine, "R2", "wave", "T1")
        await desk.settled()
        assert f"■ wave: {REFUSED}" in desk.text
        assert desk.app.drawing.ending._next is not None


@pytest.mark.parametrize("columns", [60, 80])
async def test_on_a_short_line_the_emergency_stop_leaves_room_for_how_a_request_ended(columns: int) -> None:
    async with console(pressed(), size=(columns, 1), one_line=True, in_line=True) as desk:
        refused(desk.engine, "R1", "wave", "T1")
        await desk.settled()
        assert "E-STOP" in desk.text
        assert "ctrl+o releases · ■ wave" in desk.text


async def test_a_request_refused_just_before_the_release_is_told_after_it() -> None:
    async with console(pressed(), size=(120, 1), one_line=True, in_line=True) as desk:
        refused(desk.engine, "R1", "wave", "T1")
        released(desk)
        await desk.settled()
        assert "■ wave  not done: the emergency stop was" in desk.text


async def test_what_another_terminals_emergency_stop_halted_is_told_and_no_trouble_after_the_release() -> None:
    halted = "I stopped by myself: the emergency stop is pressed."
    async with console(pressed(), size=(140, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.TranscriptFinal("nod", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0), turn="T1")
        desk.engine.publish(ev.ErrorRaised("robot_halted", halted, "Say it again to go on."), turn=None)
        desk.engine.publish(ev.InterruptRaised("halted", "robot", "ACTING"), turn="T1")
        result = ev.TurnResult(1, "failed", halted)
        desk.engine.publish(ev.StateChanged("ACTING", "WAITING", "failed", result), turn="T1")
        desk.engine.publish(ev.RequestEnded("R1", "nod", "failed", "halted"), turn="T1")
        await desk.settled()
        assert f"■ nod: {halted}" in desk.text
        released(desk)
        await desk.settled()
        assert "■ nod  not done: the emergency stop was pressed" in desk.text
        assert "is pressed" not in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "is pressed" not in desk.text


async def test_the_answer_to_words_that_pressed_the_emergency_stop_is_told_no_more_once_it_is_released() -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        answer = "The emergency stop is pressed: nothing moves until it is released."
        desk.engine.publish(ev.InterruptRaised("estop", "say", "IDLE"), turn=None)
        desk.engine.publish(ev.TranscriptFinal("emergency stop", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0), turn="T1")
        desk.engine.publish(ev.SpeechStarted(answer, False), turn="T1")
        result = ev.TurnResult(0, "done", answer)
        desk.engine.publish(ev.StateChanged("SPEAKING", "WAITING", "done", result), turn="T1")
        await desk.settled()
        assert "robot: The emergency stop is pressed" in desk.text
        released(desk)
        await desk.settled()
        assert "READY" in desk.text
        assert "is pressed" not in desk.text


async def test_a_press_itself_is_told_no_more_once_it_is_released_and_an_answer_is() -> None:
    async with console(pressed(), size=(100, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.InterruptRaised("estop", "estop", "IDLE"), turn=None)
        await desk.settled()
        desk.engine.robot = robot_at(-1.42, 0.08, 1.5708)
        desk.app.redraw()
        await desk.settled()
        assert "emergency stop" not in desk.text
        desk.engine.robot = pressed().robot
        desk.app.redraw()
        await desk.settled()
        over(desk.engine, "R1", "where are you?", "done", "I am in the hall.", "T1")
        desk.engine.robot = robot_at(-1.42, 0.08, 1.5708)
        desk.app.redraw()
        await desk.settled()
        assert "I am in the hall." in desk.text


async def test_the_whole_console_has_rows_for_ends_and_nothing_else() -> None:
    async with console(engine()) as desk:
        over(desk.engine, "R1", "go to the moon", "failed", UNKNOWN, "T1")
        await desk.settled()
        assert desk.app.drawing.ending.told == ()


# While the emergency stop is pressed, and where the engine does not start


async def test_what_is_said_and_asked_while_the_emergency_stop_is_pressed_is_told() -> None:
    async with console(pressed(), size=(80, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.InterruptRaised("estop", "estop", "IDLE"), turn=None)
        await desk.settled()
        assert "E-STOP" in desk.text
        assert "nothing moves; ctrl+o releases" in desk.text
        desk.engine.publish(ev.TranscriptFinal("where are you?", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0))
        await desk.settled()
        assert "you: where are you? · nothing moves; ctrl+o releases" in desk.text
        answer = "I am in the hall."
        desk.engine.publish(ev.SpeechStarted(answer, False))
        desk.engine.publish(ev.StateChanged("SPEAKING", "WAITING", "done", ev.TurnResult(0, "done", answer)))
        await desk.settled()
        assert "E-STOP" in desk.text
        assert "robot: I am in the hall. · nothing moves; ctrl+o releases" in desk.text
        desk.engine.publish(ev.ClarificationAsked("Which cup?", "find the cup"))
        await desk.settled()
        assert "robot: Which cup? · ctrl+o releases" in desk.text


async def test_a_notice_is_told_behind_the_emergency_stop_while_that_is_pressed() -> None:
    async with console(pressed(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.app.keeping.remark("Copied.")
        await desk.settled()
        assert re.search(r"nothing moves; ctrl\+o releases.* · Copied\.", desk.text)


async def test_an_open_question_goes_before_how_older_requests_ended() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        replacing(desk.engine)
        desk.engine.publish(ev.ClarificationAsked("Which room?", "go to the room"))
        await desk.settled()
        assert "robot: Which room? · ■ (2) find the cup, go to the hall" in desk.text


async def test_what_a_question_cuts_off_in_a_single_row_is_told_when_that_has_its_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    timed: list[tuple[int, bool]] = []
    monkeypatch.setattr(Ending, "_time", lambda _, told: timed.append(told))
    async with console(engine(), size=(80, 1), one_line=True, in_line=True) as desk:
        replacing(desk.engine)
        desk.engine.publish(ev.ClarificationAsked("Which one: the white cup or the blue cup?", "bring me the cup"))
        await desk.settled()
        assert re.search("ASKING .*Which one: the white cu…", desk.text)
        assert "find the cup" not in desk.text
        assert timed[-1] == (0, False), "nobody can read it yet"
        desk.engine.publish(ev.RequestsWaiting(("nod",)), turn=None)
        await desk.settled()
        assert re.search(r"ASKING .*… +1 waiting", desk.text), "an older end takes no room from what waits"
        desk.engine.publish(ev.QuestionEnded("bring me the cup", "declined"))
        await desk.settled()
        assert "■ (2) find the cup, g… 1 waiting" in desk.text
        assert timed[-1] == (2, True)


@pytest.mark.parametrize("by", ["interrupt", "estop"])
async def test_that_a_question_was_withdrawn_is_told_also_where_something_else_is_said_at_once(by: ev.Scope) -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ClarificationAsked("Which room?", "go to the room"))
        desk.engine.publish(ev.QuestionEnded("go to the room", "withdrawn", by))
        desk.engine.publish(ev.SpeechStarted("I stopped.", False))
        await desk.settled()
        assert "■ go to the room  question withdrawn: the" in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "robot: I stopped." in desk.text


async def test_a_request_for_an_engine_that_does_not_start_is_told_as_never_begun() -> None:
    gate = threading.Event()

    def fail() -> EngineHandle:
        gate.wait(30)
        raise SaysoError("There is no scene at the place that the settings name, which is a long way to put it.")

    async with console(start=fail, size=(80, 2), one_line=True, in_line=True) as desk:
        await desk.press(*"nod", "enter")
        gate.set()
        await desk.until(lambda: desk.shown_problem)
        await desk.settled()
        assert "FAILED" in desk.text
        assert "■ nod  never begun: the engine did not start · ✗ There" in desk.text
        desk.app.drawing.ending.next()
        await desk.press(*"beep", "enter")
        assert "■ beep  never begun: the engine did not start" in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "✗ There is no scene at the place" in desk.text


async def test_on_a_single_row_an_end_goes_before_what_runs_for_its_time() -> None:
    async with console(engine(), size=(80, 1), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "go to the bedroom", "replaced", "replaced"), turn=None)
        desk.engine.play(scripted.acting())
        desk.engine.publish(ev.RequestsWaiting(("nod",)), turn=None)
        await desk.settled()
        assert re.search(r"■ go to the bedroom .*1 waiting", desk.text)
        desk.app.drawing.ending.next()
        await desk.settled()
        assert re.search(r"▸ Go to the kitchen.*1 waiting", desk.text)


async def test_that_a_request_was_given_up_by_its_answer_is_told() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.ClarificationAsked("Which cup?", "bring the cup"))
        desk.engine.publish(ev.QuestionEnded("bring the cup", "declined"))
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert re.search(r"▸ Go .*■ bring the cup  given up: the answer was no order", desk.text)


async def test_an_answer_is_told_behind_the_request_that_begins_at_once_after_it() -> None:
    async with console(engine(), size=(120, 2), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestsWaiting(("go to the kitchen",)), turn=None)
        over(desk.engine, "R1", "where are you?", "done", "I am in the hall.", "T0")
        desk.engine.publish(ev.RequestsWaiting(()), turn=None)
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert re.search(r"▸ Go .*✓ where are you\?: I am in the hall\.", desk.text)
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "I am in the hall" not in desk.text


async def test_while_the_emergency_stop_is_pressed_an_answer_has_its_turn_before_what_that_dropped() -> None:
    async with console(pressed(), size=(120, 3), one_line=True, in_line=True) as desk:
        desk.engine.publish(ev.RequestEnded("R1", "nod", "interrupted", "estop"), turn=None)
        await desk.settled()
        assert "■ nod" in desk.text
        over(desk.engine, "R2", "where are you?", "done", "I am in the hall.", "T0")
        await desk.settled()
        assert "✓ where are you?: I am in the hall." in desk.text
        desk.app.drawing.ending.next()
        await desk.settled()
        assert "■ nod" in desk.text, "what it dropped is still to be told when it is released"
