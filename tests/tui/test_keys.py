"""Every key of the console does what it says, wherever the person is."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest
from textual import events
from textual.drivers.headless_driver import HeadlessDriver

from engine import events as ev
from engine.commands import Command, Drive, EndTask, EStop, Interrupt, LimitSpeed, Quit, Release, Say, Wake
from engine.errors import DeviceError, ExitCode, RobotError
from engine.handle import EngineHandle, PartState, PartStatus
from tests.tui import conversation, scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_READY, ScriptedEngine, flat, robot_at
from tui.screens.console import ConsoleScreen
from tui.screens.help import HelpScreen
from tui.terminal.driver import listening_driver
from tui.widgets.ask import Ask
from tui.widgets.log import LogView


async def test_space_wakes_and_e_ends_the_task() -> None:
    async with console() as desk:
        await desk.press("space", "e")
        assert desk.engine.sent == [Wake("key"), EndTask()]


async def test_escape_interrupts_in_every_state() -> None:
    for scene in (list(scripted.OPENING), scripted.listening(), scripted.acting(), scripted.done(), scripted.failed()):
        async with console() as desk:
            desk.engine.play(scene)
            await desk.press("escape")
            assert desk.engine.sent == [Interrupt()]


async def test_escape_interrupts_on_a_terminal_that_is_too_small() -> None:
    async with console(size=(40, 10)) as desk:
        assert "60×16" in desk.text
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]


def test_a_key_is_shown_to_its_listener_before_it_is_queued() -> None:
    """The driver's thread sends the interrupt itself: a stalled screen cannot hold it up."""
    order: list[str] = []

    class Recording(HeadlessDriver):
        def __init__(self) -> None:
            self.cursor_origin = None
            self._app = None  # type: ignore[assignment]

        def send_message(self, message: object) -> None:
            order.append("queued")

    driver = listening_driver(Recording, order.append)()  # type: ignore[call-arg]
    driver.process_message(events.Key("escape", None))
    assert order == ["escape", "queued"]


async def test_the_key_for_typing_may_be_pressed_once_more() -> None:
    async with console() as desk:
        await desk.press("slash", *"one", "enter", "slash", *"a/b", "enter")
        assert desk.engine.sent == [Say("one"), Say("a/b")]


async def test_slash_types_and_enter_says() -> None:
    async with console() as desk:
        await desk.press("slash", *"go", "space", *"e?q", "enter")
        assert desk.engine.sent == [Say("go e?q")]


async def test_up_and_down_recall_what_was_said() -> None:
    async with console() as desk:
        await desk.press("slash", *"one", "enter", *"two", "enter", *"dra")
        line = desk.app.query_one(Ask)
        seen = []
        for key in ("up", "up", "up", "down", "down", "down"):
            await desk.press(key)
            seen.append(line.value)
        assert seen == ["two", "one", "one", "two", "dra", "dra"]


async def test_the_line_has_the_keyboard_from_the_start_and_letters_typed_there_are_never_keys() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"go", "space", *"to", "enter", *"never", "space", *"mind", "enter", "enter", *"eq1")
        assert desk.engine.sent == [Say("go to"), Say("never mind")]
        assert desk.app.main.line.value == "eq1"


async def test_keys_that_come_all_at_once_are_dealt_out_in_their_order() -> None:
    async with console(in_line=True) as desk:
        for key in ("g", "o", "enter", "ctrl+g", "e", "slash", "h", "i", "enter"):  # as a slow link delivers them
            desk.app.post_message(events.Key(key, key if len(key) == 1 else None))
        await desk.until(lambda: len(desk.engine.sent) == 3)
        assert desk.engine.sent == [Say("go"), EndTask(), Say("hi")]
        assert desk.app.main.line.has_focus


async def test_in_the_empty_line_a_key_that_no_request_begins_with_does_what_it_does_outside() -> None:
    async with console(in_line=True) as desk:
        await desk.press("space", "slash")
        assert desk.engine.sent == [Wake("key")]
        assert desk.app.main.line.value == ""
        await desk.press("question_mark")
        assert isinstance(desk.app.screen, HelpScreen)
        await desk.press("backspace", *"a?", "space", "slash", "less_than_sign", "enter")
        assert desk.engine.sent[1:] == [Say("a? /<")]
        await desk.press("left_parenthesis", "minus", "enter")
        assert desk.engine.sent[2:] == [Say("(-")], "no keys of the console are text there, too"


async def test_keys_that_somebody_chose_act_in_the_empty_line_unless_they_are_letters() -> None:
    async with console(in_line=True, keymap={"wake": "w", "help": "f1", "end_task": "&"}) as desk:
        await desk.press(*"w", "backspace", "home", "ampersand", "f1")
        assert desk.engine.sent == [EndTask()]
        assert isinstance(desk.app.screen, HelpScreen)


async def test_tab_goes_from_the_line_through_all_panes_but_the_map_and_comes_back() -> None:
    async with console(in_line=True) as desk:
        seen = []
        for _ in range(6):
            await desk.press("tab")
            seen.append(type(desk.app.focused).__name__)
        assert seen == ["Conversation", "PlanView", "ActionQueue", "LogView", "Timeline", "Ask"]
        await desk.press("shift+tab", "shift+tab", "e")
        assert isinstance(desk.app.focused, LogView)
        assert desk.engine.sent == [EndTask()]


async def test_tab_in_a_request_completes_it_and_does_not_leave() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"zzz", "tab", "e")
        assert desk.app.main.line.value == "zzze"


async def test_a_click_on_a_pane_goes_there_and_one_on_the_line_comes_back() -> None:
    async with console(in_line=True) as desk:
        await desk.pilot.click(LogView)
        await desk.press("e")
        assert desk.engine.sent == [EndTask()]
        await desk.pilot.click(Ask)
        await desk.press("e")
        assert desk.app.main.line.value == "e"


@pytest.mark.parametrize("size", [(60, 20), (80, 24), (120, 40)])
async def test_the_keys_in_the_status_line_are_true_where_the_keyboard_is(size: tuple[int, int]) -> None:
    async with console(in_line=True, size=size) as desk:
        assert "space wake  ? help  tab panes" in desk.text.splitlines()[0]
        await desk.press("ctrl+g")
        top = desk.text.splitlines()[0]
        assert "space wake" in top
        assert "/ type" in top
        assert "tab panes" not in top
        await desk.press("enter")
        assert "⌫ back" in desk.text.splitlines()[0]
        assert "quit" not in desk.text.splitlines()[0]


async def test_keys_below_panes_are_shown_while_they_are_true() -> None:
    async with console(in_line=True) as desk:
        conversation.play(desk.engine, conversation.ALL)
        await desk.settled()
        assert "m points" not in desk.text
        assert "enter opens" not in desk.text, "it sends"
        assert "[ browse" in desk.text, "no request begins with it"
        await desk.press(*"go")
        assert "browse" not in desk.text
        await desk.press("ctrl+g")
        assert "m points" in desk.text
        assert "[ browse · enter opens" in desk.text
        await desk.press("left_square_bracket")
        assert "[ ] browse · enter opens" in desk.text


@pytest.mark.parametrize("before", [(), ("1",), ("m",), ("enter",), ("g",)])
async def test_what_is_pasted_outside_the_line_goes_into_it_and_is_no_key(before: tuple[str, ...]) -> None:
    async with console() as desk:
        await desk.press(*before)
        desk.app.post_message(events.Paste("beep\nquit\n"))
        await desk.settled()
        assert desk.app.main.line.has_focus
        await desk.press("enter")
        assert desk.engine.sent == [Say("beep", then=("quit",))]


async def test_a_draft_is_not_typed_over_when_one_comes_back_to_it() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"go", "ctrl+p", "ctrl+g", *"on")
        assert desk.app.main.line.value == "goon"


async def paste(desk: Desk, text: str) -> None:
    desk.app.query_one(Ask).post_message(events.Paste(text))
    await desk.settled()


async def test_every_line_that_is_pasted_is_a_request_and_they_are_done_one_after_the_other() -> None:
    async with console() as desk:
        await desk.press("slash")
        await paste(desk, "go to the kitchen\r\n\n  beep \nturn left\n")
        assert " 3›go to the kitchen ⏎ beep ⏎ turn left" in desk.text
        await desk.press("enter")
        assert desk.engine.sent == [Say("go to the kitchen", then=("beep", "turn left"))]
        assert " › " in desk.text
        await desk.press("up", "enter")
        assert desk.engine.sent[1:] == desk.engine.sent[:1], "they are recalled as they were sent"


async def test_one_line_that_is_pasted_goes_where_the_cursor_is() -> None:
    async with console() as desk:
        await desk.press("slash", *"go", "home")
        await paste(desk, "please \n")
        await paste(desk, "\n")
        assert desk.app.query_one(Ask).value == "pleasego"
        await desk.press("enter")
        assert desk.engine.sent == [Say("pleasego")]


async def test_what_is_too_long_to_be_pasted_says_so() -> None:
    async with console() as desk:
        await desk.press("slash")
        await paste(desk, "beep\n" * 5000)
        (told,) = desk.app._notifications
        assert told.message.startswith("Too long to be pasted: the line holds 20000 characters.")
        assert desk.app.query_one(Ask).value == ""


async def test_lines_that_are_pasted_before_the_engine_is_there_wait_for_it() -> None:
    there = threading.Event()
    engine = ScriptedEngine()

    def start() -> EngineHandle:
        there.wait()
        return engine

    async with console(engine, start=start) as desk:
        await desk.press("slash")
        await paste(desk, "beep\nturn left")
        await desk.press("enter")
        there.set()
        await desk.until(lambda: engine.sent)
        (said,) = engine.sent
        assert isinstance(said, Say)
        assert (said.text, said.then) == ("beep", ("turn left",))


async def test_question_mark_opens_help_and_keys_work_there() -> None:
    async with console() as desk:
        await desk.press("question_mark")
        assert isinstance(desk.app.screen, HelpScreen)
        await desk.press("space")
        assert desk.engine.sent == [Wake("key")]
        await desk.press("question_mark")
        assert isinstance(desk.app.screen, ConsoleScreen)


async def test_q_quits_at_once_when_nothing_is_under_way() -> None:
    async with console() as desk:
        await desk.pilot.press("q")
        assert desk.engine.sent == [Quit()]
        assert desk.app.return_code == ExitCode.DONE


async def test_q_asks_once_more_while_a_task_is_running() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await desk.press("q")
        assert desk.engine.sent == []
        assert "q again quits" in desk.text
        await desk.pilot.press("q")
        assert desk.engine.sent == [Quit()]


async def test_q_does_not_ask_about_a_task_whose_end_has_not_been_drawn_yet() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        desk.engine.play(scripted.done()[len(scripted.acting()) :])
        desk.app.action_leave()
        assert desk.engine.sent == [Quit()]


async def test_the_question_is_forgotten_when_the_task_ends() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await desk.press("q")
        desk.engine.play(scripted.done()[len(scripted.acting()) :])
        await desk.settled()
        assert "again" not in desk.text


@pytest.mark.parametrize("before", [(), ("slash",), ("question_mark",)])
async def test_control_c_quits_from_everywhere(before: tuple[str, ...]) -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await desk.pilot.press(*before, "ctrl+c")
        assert desk.engine.sent == [Quit()]


async def test_l_shows_the_log_on_a_small_terminal() -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.play(scripted.OPENING)
        await desk.settled()
        assert "ready: whisper-base" not in desk.text
        await desk.press("l")
        await desk.until(lambda: "ready: whisper-base" in desk.text)
        await desk.press("l")
        await desk.until(lambda: "ready: whisper-base" not in desk.text)


async def test_an_action_can_have_another_key() -> None:
    async with console(keymap={"interrupt": "x", "wake": "w"}) as desk:
        assert "x stop" in desk.text
        await desk.press("x", "w", "escape", "space")
        assert desk.engine.sent == [Interrupt(), Wake("key")]


async def test_an_engine_that_does_not_start_is_explained_and_decides_the_exit_code() -> None:
    def broken() -> EngineHandle:
        raise DeviceError("The robot on /dev/ttyUSB0 does not answer.", hint="Check its cable.")

    async with console(start=broken, in_line=True) as desk:
        await desk.until(lambda: "Check its cable." in desk.text)
        assert "does not answer" in desk.text
        assert "FAILED" in desk.text
        await desk.press("space", "escape", "tab")
        await desk.pilot.press("q")
        assert desk.app.return_code == ExitCode.MISSING


async def test_a_mistake_in_starting_is_shown_and_not_swallowed() -> None:
    def mistaken() -> EngineHandle:
        raise ZeroDivisionError("the sum was [red]0[/red]")

    async with console(start=mistaken, in_line=True) as desk:
        await desk.until(lambda: "ZeroDivisionError('the sum was [red]0[/red]')" in desk.text)
        await desk.press("tab")
        await desk.pilot.press("q")
        assert desk.app.return_code == ExitCode.FAILED


async def test_a_robot_that_is_lost_for_good_is_shown_and_quitting_tells_the_shell() -> None:
    async with console() as desk:
        desk.engine.play(scripted.failed())
        await desk.settled()
        assert "does not answer any more" in desk.text
        await desk.pilot.press("q")
        assert desk.app.return_code == ExitCode.MISSING


async def test_a_command_that_is_not_taken_is_explained() -> None:
    engine = ScriptedEngine()

    def refuse(command: object) -> None:
        raise RobotError("The robot process is gone.", hint="Start sayso again.")

    engine.on_command = refuse
    async with console(engine) as desk:
        await desk.pilot.press("space")
        await desk.until(lambda: "The robot process is gone." in desk.text)


async def test_what_is_typed_while_the_engine_starts_is_said_when_it_has() -> None:
    engine, gate = ScriptedEngine(), threading.Event()

    def start() -> EngineHandle:
        gate.wait(30)
        return engine

    async with console(engine, start=start) as desk:
        assert "STARTING" in desk.text
        await desk.pilot.press("slash", *"dance", "enter")
        assert engine.sent == []
        gate.set()
        await desk.until(lambda: engine.sent)
        assert [command.text for command in engine.sent if isinstance(command, Say)] == ["dance"]


async def test_an_engine_that_starts_after_the_person_left_is_told_to_quit() -> None:
    engine, gate = ScriptedEngine(), threading.Event()
    told = threading.Event()
    engine.on_command = lambda command: told.set()

    def start() -> EngineHandle:
        gate.wait(30)
        return engine

    async with console(engine, start=start) as desk:
        await desk.pilot.press("q")
    gate.set()
    assert told.wait(30)
    assert engine.sent == [Quit()]


async def test_page_up_holds_the_conversation_until_one_is_back_at_its_end() -> None:
    async with console(size=(80, 24)) as desk:
        for number in range(40):
            desk.engine.publish(ev.SpeechStarted(f"sentence {number:02}", False))
        await desk.settled()
        assert "sentence 39" in desk.text
        await desk.press("pageup")
        assert "sentence 39" not in desk.text
        desk.engine.publish(ev.SpeechStarted("sentence 40", False))
        await desk.settled()
        assert "sentence 40" not in desk.text
        await desk.press("pagedown", "pagedown")
        assert "sentence 40" in desk.text


async def test_the_log_is_there_on_a_large_terminal() -> None:
    async with console() as desk:
        desk.engine.play(scripted.OPENING)
        await desk.settled()
        assert desk.app.screen.query_one(LogView).known == desk.app.shown.model.log
        assert "ready: whisper-base" in desk.text


async def test_keys_typed_ahead_of_the_line_go_into_it_and_are_no_commands() -> None:
    async with console() as desk:
        for key, character in (("slash", "/"), ("e", "e"), ("space", " "), ("q", "q")):  # as a slow link delivers them
            desk.app.post_message(events.Key(key, character))
        await desk.pilot.pause()
        assert desk.app.screen.query_one(Ask).value == "e q"
        assert desk.engine.sent == []


@pytest.mark.parametrize("key", ["R", "ctrl+o"])
async def test_where_the_emergency_stop_is_not_pressed_its_release_stops_nothing(key: str) -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.press(key)
        assert "The emergency stop is not pressed" in desk.text.splitlines()[0]
        assert desk.engine.sent == []


async def test_an_emergency_stop_that_is_released_while_the_engine_starts_is_not_pressed_then() -> None:
    gate = threading.Event()
    engine = ScriptedEngine()

    def start() -> EngineHandle:
        gate.wait(30)
        return engine

    async with console(engine, start=start, in_line=True) as desk:
        await desk.press("ctrl+x", "ctrl+o")
        assert "E-STOP once" not in desk.text
        gate.set()
        await desk.until(lambda: desk.app.handle is not None)
        await desk.settled()
        assert engine.sent == []


async def test_the_emergency_stop_has_a_key_that_works_while_typing_and_another_one_releases_it() -> None:
    async with console() as desk:
        await desk.press("slash", "ctrl+x")
        assert desk.engine.sent == [EStop()]
        await desk.press("escape", "ctrl+g", "R")
        assert desk.engine.sent == [EStop(), Interrupt(), Release()]


@pytest.mark.parametrize("page", ["", "question_mark", "o", "d"])
async def test_a_pressed_emergency_stop_is_shown_on_every_page(page: str) -> None:
    async with console() as desk:
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        await desk.press(*([page] if page else []))
        desk.app.redraw()
        await desk.until(lambda: "E-STOP" in desk.text)
        assert "nothing moves; ctrl+o releases" in desk.text


async def test_by_hand_arrows_drive_until_one_goes_back() -> None:
    async with console() as desk:
        await desk.press("g", "up", "left", "plus", "down", "comma")
        assert desk.engine.sent == [
            Drive(0.2, 0.0, 0.0), Drive(0.0, 0.0, 0.5), Drive(-0.3, 0.0, 0.0), Drive(0.0, 0.3, 0.0),
        ]  # fmt: skip
        assert "by hand 0.3 m/s" in desk.text
        await desk.press("g")
        assert "by hand" not in desk.text
        await desk.press("up")
        assert desk.engine.sent[4:] == []


@pytest.mark.parametrize(
    ("state", "words"), [("failed", "The robot is not there."), ("loading", "The robot is still starting.")]
)
async def test_nobody_drives_a_robot_by_hand_that_is_not_there(state: PartState, words: str) -> None:
    robot = PartStatus("robot", state)
    async with console(ScriptedEngine(parts=(robot, *PARTS_READY[1:]), floor=flat())) as desk:
        assert PARTS_READY[0].name == "robot"
        assert words in desk.text, "so the pane of the robot says"
        await desk.press("g")
        assert words in desk.text.splitlines()[0]
        assert not desk.app.main.driving_by_hand
        assert desk.engine.sent == []


async def test_nobody_drives_by_hand_while_the_emergency_stop_is_pressed_and_the_key_says_what_releases_it() -> None:
    async with console() as desk:
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        desk.app.redraw()
        await desk.until(lambda: "E-STOP" in desk.text)
        await desk.press("g")
        assert "by hand" not in desk.text
        told = "The emergency stop is pressed: ctrl+o releases it."
        assert [one.message for one in desk.app._notifications] == [told]
        await desk.press("up")
        assert desk.engine.sent == []


async def test_a_hand_that_drives_stands_with_the_emergency_stop_and_goes_on_after_it() -> None:
    async with console() as desk:
        desk.engine.robot = robot_at(0.0, 0.0, 0.0)
        await desk.press("g", "up")
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        desk.app.redraw()
        await desk.until(lambda: "nothing moves; ctrl+o releases" in desk.text.splitlines()[-1])
        await desk.press("up")
        desk.engine.robot = robot_at(0.0, 0.0, 0.0)
        desk.app.redraw()
        await desk.until(lambda: "by hand 0.2 m/s" in desk.text)
        await desk.press("down")
        assert desk.engine.sent == [Drive(0.2, 0.0, 0.0), Drive(-0.2, 0.0, 0.0)]


async def test_whoever_types_drives_no_more() -> None:
    async with console() as desk:
        await desk.press("g", "up", "slash", "w", "a")
        assert desk.engine.sent == [Drive(0.2, 0.0, 0.0)]
        assert "by hand" not in desk.text
        assert "wa" in desk.text


async def test_plus_and_minus_set_the_speed_limit_and_so_does_a_click_on_them() -> None:
    async with console() as desk:

        def limit(command: Command) -> None:
            if isinstance(command, LimitSpeed):
                assert desk.engine.robot is not None
                desk.engine.robot = replace(desk.engine.robot, speed_limit=command.share)

        desk.engine.on_command = limit
        assert "Robot · − fast ─" in desk.text, "it may not drive any faster"
        await desk.press("minus", "minus")
        assert "− medium +" in desk.text
        await desk.press("plus")
        assert desk.engine.sent == [LimitSpeed(0.75), LimitSpeed(0.5), LimitSpeed(0.75)]
        for sign, words in (("−", "− medium +"), ("+", "− quick +"), ("+", "− fast ─")):
            rows = desk.text.splitlines()
            y = next(number for number, row in enumerate(rows) if "Robot · −" in row)
            at = rows[y].index("Robot · −")
            await desk.pilot.click(offset=(rows[y].index(sign, at), y))
            await desk.settled()
            assert words in desk.text


@pytest.mark.parametrize(
    ("keys", "title"),
    [
        ((), "Robot · − medium + ─"),
        (("slash",), "Robot · − medium + ─"),
        (("slash", *"turn"), "Robot · medium ─"),
        (("slash", *"turn", "ctrl+u"), "Robot · − medium + ─"),
        (("g",), "Robot · medium ─"),
        (("g", "backspace"), "Robot · − medium + ─"),
    ],
)
@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_the_keys_of_the_speed_limit_are_named_only_where_they_change_it(
    keys: tuple[str, ...], title: str, size: tuple[int, int]
) -> None:
    async with console(size=size) as desk:
        assert desk.engine.robot is not None
        desk.engine.robot = replace(desk.engine.robot, speed_limit=0.5)
        desk.app.redraw()
        await desk.press(*keys)
        await desk.settled()
        assert title in desk.text


@pytest.mark.parametrize("one_line", [False, True])
async def test_where_the_robots_pane_is_not_in_sight_the_speed_limit_is_told(*, one_line: bool) -> None:
    async with console(size=(60, 1 if one_line else 20), one_line=one_line) as desk:
        await desk.press("minus")
        assert desk.engine.sent == [LimitSpeed(0.75)]
        assert "Speed limit: quick" in desk.text


@pytest.mark.parametrize(
    ("key", "told"),
    [("i", "delay unknown · 0.0 kB/s"), ("less_than_sign", "No border"), ("greater_than_sign", "No border")],
)
async def test_what_has_no_room_to_be_seen_is_told(key: str, told: str) -> None:
    async with console(size=(60, 20)) as desk:
        await desk.press(key)
        assert told in desk.text


async def test_on_the_map_that_zooms_by_the_same_keys_they_are_not_named_at_the_speed_limit() -> None:
    async with console() as desk:
        assert desk.engine.robot is not None
        desk.engine.robot = replace(desk.engine.robot, speed_limit=0.5)
        await desk.press("m")
        await desk.settled()
        assert "Robot · medium ─" in desk.text


async def test_the_speed_limit_names_the_keys_that_somebody_has_chosen_and_a_click_on_them_counts() -> None:
    async with console(keymap={"speed_down": "f7", "speed_up": "f8"}) as desk:
        assert desk.engine.robot is not None
        desk.engine.robot = replace(desk.engine.robot, speed_limit=0.5)
        await desk.press("slash", *"turn")
        await desk.settled()
        assert "Robot · f7 medium f8" in desk.text, "keys that are no text act while somebody types"
        row, line = next((y, line) for y, line in enumerate(desk.text.splitlines()) if "f7 medium f8" in line)
        for key, share in (("f7", 0.25), ("f8", 0.75)):
            await desk.pilot.click(offset=(line.index(f"{key} ", line.index("Robot")), row))
            await desk.settled()
            assert desk.engine.sent[-1] == LimitSpeed(share)
