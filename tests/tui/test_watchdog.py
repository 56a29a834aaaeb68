"""The console says when the engine or the robot is away, and when it is back."""

from __future__ import annotations

from dataclasses import replace

from engine import events as ev
from engine.commands import Interrupt, Quit
from engine.errors import ExitCode
from engine.handle import PartStatus
from engine.robot.robot import EMERGENCY_STOP
from engine.robot.watch import view
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_READY
from tui.shown.watchdog import INTERVAL_S, SILENT_S, Watchdog
from tui.words import strings


def test_an_engine_is_silent_from_a_limit_on_and_back_below_it() -> None:
    watchdog, now = Watchdog(0.0), 0.0
    found = []
    for pulse in (0.02, SILENT_S, SILENT_S + 0.1, SILENT_S + 0.6, 0.03, 0.01):
        now += INTERVAL_S
        found.append(watchdog.look(now, pulse))
    assert found == [None, None, "silent", None, "back", None]


def test_a_console_that_was_paused_itself_gives_the_engine_a_moment() -> None:
    watchdog = Watchdog(0.0)
    assert watchdog.look(60.0, 60.0) is None
    assert watchdog.look(60.0 + INTERVAL_S, 0.04) is None
    assert watchdog.look(60.0 + 2 * INTERVAL_S, SILENT_S + 1) == "silent"


async def silent(desk: Desk) -> None:
    desk.engine.silence = SILENT_S + 1
    await desk.until(lambda: strings.ABOUT_SILENT in desk.text)


async def test_a_silent_engine_is_told_with_the_keys_that_still_work() -> None:
    async with console() as desk:
        await silent(desk)
        assert "The robot has stopped by itself" in desk.text
        assert "esc still stops the robot, ctrl+c quits at once" in desk.text
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]


async def test_when_the_engine_is_back_the_console_says_for_how_long_it_was_away() -> None:
    async with console() as desk:
        await silent(desk)
        desk.engine.silence = 0.0
        desk.engine.publish(ev.Log("warning", "engine", "The engine did not respond for 12.3 s."), turn=None)
        desk.engine.publish(ev.Timing("paused", 12.3), turn=None)
        await desk.until(
            lambda: "Not responding for 12.3 s" in desk.text and strings.ENGINE_SILENT not in desk.shown_problem
        )
        await desk.settled()
        assert "The engine did not respond for 12.3 s." in [line.message for line in desk.app.shown.model.log]


async def test_a_silent_engine_does_not_hide_what_ended_everything() -> None:
    async with console() as desk:
        desk.engine.publish(ev.ErrorRaised("engine_died", "It broke.", fatal=True))
        desk.engine.silence = SILENT_S + 1
        await desk.until(lambda: strings.ENGINE_SILENT in desk.text)  # in the log
        assert "It broke." in desk.shown_problem
        desk.engine.silence = 0.0
        await desk.settled()
        assert "It broke." in desk.shown_problem


async def test_leaving_a_silent_engine_asks_no_question_and_exits_with_a_failure() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        await silent(desk)
        await desk.pilot.press("q")
        assert desk.engine.sent == [Quit()]
        assert desk.app.return_code == ExitCode.FAILED


async def test_a_lost_robot_is_told_until_it_is_back() -> None:
    async with console() as desk:
        there, desk.engine.robot = desk.engine.robot, None
        desk.engine.parts = (PartStatus("robot", "loading"), *PARTS_READY[1:])
        desk.engine.publish(ev.ErrorRaised("robot_lost", "The robot process was killed by SIGKILL.", "It stands."))
        await desk.until(lambda: "SIGKILL" in desk.shown_problem and "◌ robot" in desk.text)
        desk.engine.robot, desk.engine.parts = there, PARTS_READY
        await desk.until(lambda: "✓ robot" in desk.text and not desk.shown_problem)
        assert strings.ROBOT_BACK in desk.text


async def test_a_robot_that_is_gone_for_good_stays_told() -> None:
    async with console() as desk:
        desk.engine.parts = (PartStatus("robot", "loading"), *PARTS_READY[1:])
        desk.engine.publish(ev.ErrorRaised("robot_lost", "It died."))
        await desk.until(lambda: "◌ robot" in desk.text)
        desk.engine.parts = (PartStatus("robot", "failed"), *PARTS_READY[1:])
        desk.engine.publish(ev.ErrorRaised("robot_lost", "It died too often.", fatal=True))
        await desk.until(lambda: "✗ robot" in desk.text and "It died too often." in desk.shown_problem)
        assert "FAILED" in desk.text


async def test_a_robot_that_halted_by_itself_is_marked_in_the_conversation() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(ev.InterruptRaised("halted", "halted", "ACTING"))
        assert desk.engine.robot is not None
        desk.engine.robot = replace(desk.engine.robot, halted="heartbeat lost")
        await desk.until(lambda: strings.HALTED in desk.text and "heartbeat lost" in desk.text)


async def test_nothing_says_that_the_emergency_stop_is_pressed_while_the_robot_notices_its_release() -> None:
    async with console() as desk:
        assert desk.engine.robot is not None
        pressed = replace(desk.engine.robot, estop=True, halted=EMERGENCY_STOP)
        desk.engine.robot = pressed
        desk.app.redraw()
        await desk.until(lambda: "▲ the emergency" in desk.text)
        desk.engine.robot = released = replace(pressed, estop=False)
        desk.app.redraw()
        await desk.until(lambda: "READY" in desk.text)
        await desk.settled()
        assert "the emergency" not in desk.text
        assert view(released).blocked is None
