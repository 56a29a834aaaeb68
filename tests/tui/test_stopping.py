"""A stop is a stop in every phase, and keys count in the order in which they were pressed."""

from __future__ import annotations

import os
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from textual import events

from engine import events as ev
from engine.commands import EStop, Interrupt, Say
from engine.handle import EngineHandle
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, robot_at
from tests.tui.test_readiness import fail
from tests.tui.test_terminal import session
from tui.shown.facts import Line

STOPPED = "never begun: the stop key"
PRESSED = "never begun: the emergency stop"


@asynccontextmanager
async def starting() -> AsyncIterator[tuple[Desk, threading.Event]]:
    """A console whose engine starts when the event is set."""
    engine, gate = ScriptedEngine(), threading.Event()

    def start() -> EngineHandle:
        gate.wait(30)
        return engine

    async with console(engine, start=start, in_line=True) as desk:
        try:
            yield desk, gate
        finally:
            gate.set()


def lost(desk: Desk) -> list[Line]:
    return [line for line in desk.app.drawing.model.conversation if line.who == "lost"]


def said_in(desk: Desk) -> list[Say]:
    """What the engine was asked for, in order."""
    return [command for command in desk.engine.sent if isinstance(command, Say)]


async def there(desk: Desk) -> None:
    await desk.until(lambda: desk.app.handle is not None)
    await desk.settled()


# While the engine starts


async def test_what_is_asked_for_while_the_engine_starts_is_shown_as_waiting_at_once() -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter", *"beep", "ctrl+j")
        assert [one.text for one in desk.app.shown.model.waiting] == ["nod", "beep"]
        gate.set()
        await there(desk)
        assert [(said.text, said.wait) for said in said_in(desk)] == [("nod", False), ("beep", True)]
        assert desk.app.shown.model.waiting == ()


async def test_esc_while_the_engine_starts_drops_what_was_asked_for_and_tells_it() -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter", *"beep", "ctrl+j", "escape")
        assert lost(desk) == [Line("lost", "nod", STOPPED), Line("lost", "beep", STOPPED)]
        assert "2 waiting requests dropped" in desk.text
        assert desk.app.shown.model.waiting == ()
        gate.set()
        await there(desk)
        assert desk.engine.sent == []


async def test_esc_that_is_read_before_the_engine_is_there_and_dealt_out_after_it_drops_it_too() -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter")
        desk.app._key_arrived("escape")
        gate.set()
        await there(desk)
        assert desk.engine.sent == []
        assert lost(desk) == [Line("lost", "nod", STOPPED)]
        await desk.press("escape")
        desk.engine.publish(ev.InterruptRaised("interrupt", "interrupt", "IDLE"), turn=None)
        await desk.settled()
        assert "1 waiting request dropped" in desk.text


@pytest.mark.parametrize("dealt", [True, False])
async def test_the_emergency_stop_is_pressed_once_the_engine_is_there(*, dealt: bool) -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter")
        if dealt:
            await desk.press("ctrl+x")
            assert "E-STOP once the robot is there; ctrl+o takes it back" in desk.text
        else:
            desk.app._key_arrived("ctrl+x")
        gate.set()
        await there(desk)
        assert desk.engine.sent == [EStop()]
        assert lost(desk) == [Line("lost", "nod", PRESSED)]


async def test_until_the_robot_is_there_the_status_line_says_that_the_emergency_stop_comes() -> None:
    async with starting() as (desk, gate):
        await desk.press("ctrl+x")
        gate.set()
        await there(desk)
        desk.app.keeping.forget()
        await desk.settled()
        assert "E-STOP once the robot is there; ctrl+o takes it back" in desk.text.splitlines()[0]
        desk.engine.robot = robot_at(0.0, 0.0, 0.0)
        desk.app.redraw()
        await desk.settled()
        assert "E-STOP" not in desk.text


async def test_a_press_that_is_taken_back_before_the_engine_is_there_says_so() -> None:
    async with starting() as (desk, gate):
        await desk.press("ctrl+x", "ctrl+o")
        assert "Taken back: this console presses no E-STOP" in desk.text
        gate.set()
        await there(desk)
        assert desk.engine.sent == []


@pytest.mark.parametrize("is_there", [False, True])
async def test_before_the_robot_is_there_nobody_knows_whether_the_emergency_stop_is_pressed(*, is_there: bool) -> None:
    async with starting() as (desk, gate):
        if is_there:
            gate.set()
            await there(desk)
        await desk.press("ctrl+o")
        assert "E-STOP not known yet: again when the robot is there" in desk.text
        assert "not pressed" not in desk.text
        assert desk.engine.sent == []


@pytest.mark.parametrize("key", ["ctrl+x", "ctrl+o"])
async def test_where_the_engine_did_not_start_no_emergency_stop_is_promised(key: str) -> None:
    async with console(start=fail, in_line=True) as desk:
        await desk.until(lambda: desk.app.shown.failed)
        await desk.press(key)
        assert "No emergency stop: the engine did not start" in desk.text
        assert "once the robot is there" not in desk.text


async def test_esc_while_the_engine_starts_and_nothing_was_asked_for_stops_nothing() -> None:
    async with starting() as (desk, _):
        await desk.press("escape")
        assert "Nothing to stop" in desk.text


# When it is there


async def test_a_request_whose_key_was_pressed_before_the_stop_is_not_sent_after_it() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"nod")
        enter = events.Key("enter", "\r")
        desk.app._key_arrived("escape")
        desk.app.post_message(enter)
        await desk.until(lambda: lost(desk))
        assert desk.engine.sent == [Interrupt()]
        assert lost(desk) == [Line("lost", "nod", STOPPED)]
        await desk.press("escape", *"beep", "enter")
        assert desk.engine.sent[-1] == Say("beep")


async def test_a_request_behind_a_stop_is_sent_also_where_that_was_never_dealt_out() -> None:
    async with console(in_line=True) as desk:
        desk.app._key_arrived("escape")  # what began with it was another key
        await desk.press(*"nod", "enter")
        assert desk.engine.sent == [Interrupt(), Say("nod")]


@pytest.mark.parametrize(("key", "command"), [("\x1b", "interrupt"), ("\x18", "estop")])
def test_a_key_that_stops_in_one_read_with_the_enter_before_it_stops_that_request(key: str, command: str) -> None:
    with session() as terminal:
        terminal.read_until(b"LISTENING")
        assert terminal.next_command() == "started"
        os.write(terminal.terminal, b"nod")
        terminal.read_until(b"nod")
        os.write(terminal.terminal, b"\r" + key.encode())
        if (first := terminal.next_command()) == "say":  # it was sent before the second key was looked at
            assert terminal.next_command() == command
            return
        assert first == command
        terminal.read_until(b"begun")  # a space that is there already is not written
        os.write(terminal.terminal, b"\x18")
        assert terminal.next_command() == "estop", "nothing was said"


async def test_a_turn_that_is_stopped_before_it_has_a_state_has_its_row_and_is_counted() -> None:
    async with console(in_line=True) as desk:
        desk.engine.publish(ev.TranscriptFinal("go to the bedroom", "text", "en", 1.0, 0.0, 0.0, 0.0, 0.0))
        waiting = ev.WaitingRequest("R2", "nod", None)
        desk.engine.publish(ev.RequestsWaiting(("nod",), (waiting,)))
        await desk.press("escape")
        desk.engine.publish(ev.InterruptRaised("interrupt", "interrupt", "IDLE"))
        await desk.settled()
        assert desk.app.shown.model.conversation[-1] == Line("mark", "stopped", "interrupt")
        assert "2 waiting requests dropped" in desk.text
        assert "Nothing to stop" not in desk.text
