"""What is typed while the engine starts waits like all that waits: it is dropped, moved and changed by those keys."""

from __future__ import annotations

import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from engine import events as ev
from engine.commands import Drop, EStop, Move
from engine.errors import SaysoError
from engine.handle import EngineHandle
from engine.session.inbox import Busy
from tests.tui.desk import Desk, console
from tests.tui.test_queue import listed, waits
from tests.tui.test_stopping import lost, said_in, starting, there
from tui.shown.facts import Line


@asynccontextmanager
async def typed(*texts: str) -> AsyncIterator[tuple[Desk, threading.Event]]:
    """A console at whose actions somebody is who has asked for these, each to be done after the one before, and whose
    engine starts when the event is set."""
    async with starting() as (desk, gate):
        for text in texts:
            await desk.press(*text, "ctrl+j")
        await desk.press("ctrl+g", "3")
        yield desk, gate


async def start(desk: Desk, gate: threading.Event) -> None:
    gate.set()
    await there(desk)


def sent(desk: Desk) -> list[tuple[str, tuple[str, ...]]]:
    """What the engine was asked for, and what was to be done after it."""
    return [(said.text, said.then) for said in said_in(desk)]


def shown(desk: Desk) -> list[str]:
    return [one.text for one in desk.app.shown.model.waiting]


def ids(desk: Desk) -> list[str]:
    return [one.id for one in desk.app.shown.model.waiting]


async def test_one_is_dropped_and_the_others_are_sent() -> None:
    async with typed("nod", "beep", "go home") as (desk, gate):
        assert listed(desk)[0] == ("nod", True), "it can be chosen"
        assert "x drop" in desk.text
        await desk.press("down", "x")
        assert lost(desk) == [Line("lost", "beep", "dropped")]
        assert listed(desk) == [("nod", False), ("go home", True)]
        await start(desk, gate)
        assert sent(desk) == [("nod", ()), ("go home", ())]


async def test_one_is_moved_and_they_are_done_in_that_order_then() -> None:
    async with typed("nod", "beep", "go home") as (desk, gate):
        await desk.press("down", "shift+up")
        assert shown(desk) == ["beep", "nod", "go home"]
        await desk.press("shift+down", "shift+down", "shift+down")
        assert shown(desk) == ["nod", "go home", "beep"]
        await start(desk, gate)
        assert sent(desk) == [("nod", ("go home", "beep"))]


@pytest.mark.parametrize(
    ("key", "order"), [("enter", ["nod", "beep twice", "go home"]), ("ctrl+j", ["nod", "go home", "beep twice"])]
)
async def test_one_is_taken_back_and_changed(key: str, order: list[str]) -> None:
    async with typed("nod", "beep", "go home") as (desk, gate):
        await desk.press("down", "enter")
        assert desk.app.main.line.value == "beep"
        assert lost(desk) == [], "it is not lost: it stands in the line"
        assert shown(desk) == ["nod", "go home"]
        await desk.press(*" twice", key)
        assert shown(desk) == order
        await start(desk, gate)
        assert [text for said in said_in(desk) for text in (said.text, *said.then)] == order


async def test_one_that_is_taken_back_and_left_out_has_a_row() -> None:
    async with typed("nod") as (desk, gate):
        await desk.press("enter", "ctrl+u")
        assert lost(desk) == [Line("lost", "nod", "dropped")]
        await start(desk, gate)
        assert sent(desk) == []


@pytest.mark.parametrize("key", ["escape", "ctrl+x", "ctrl+g"])
async def test_that_it_goes_back_into_its_place_is_told_no_longer_than_that_is_so(key: str) -> None:
    async with typed("nod", "beep") as (desk, _):
        await desk.press("enter")
        assert "puts it back into its" in desk.app.shown.notice
        await desk.press(key)
        assert "puts it back into its" not in desk.app.shown.notice


async def test_who_takes_a_second_one_back_puts_the_first_back_into_its_place() -> None:
    async with typed("nod", "beep", "go home") as (desk, _):
        await desk.press("down", "enter", *" twice", "ctrl+g", "3", "up", "enter")
        assert desk.app.main.line.value == "nod"
        assert shown(desk) == ["beep", "go home"]
        await desk.press("enter")
        assert shown(desk) == ["nod", "beep", "go home"]


async def test_the_engine_knows_them_by_the_ids_that_they_had_before() -> None:
    async with typed("nod", "beep", "go home") as (desk, gate):
        nod, beep, home = ids(desk)
        await desk.press("shift+down")
        await start(desk, gate)
        (said,) = said_in(desk)
        assert said.requests == (beep, nod, home)
        desk.engine.publish(waits(ev.WaitingRequest(nod, "nod"), ev.WaitingRequest(home, "go home")), turn=None)
        await desk.press("x")
        assert desk.engine.sent[-1] == Drop(nod)


async def test_one_that_stands_in_the_line_when_the_engine_comes_goes_back_into_its_place() -> None:
    async with typed("nod", "beep", "go home") as (desk, gate):
        home = ev.WaitingRequest(ids(desk)[2], "go home")
        await desk.press("down", "enter")
        await start(desk, gate)
        desk.engine.publish(waits(home), turn=None)
        await desk.press(*" twice", "enter")
        said = said_in(desk)[-1]
        assert (said.text, said.wait) == ("beep twice", True)
        again = ev.WaitingRequest(said.requests[0], "beep twice", said.id)
        desk.engine.publish(waits(home, again), turn=None)
        await desk.until(lambda: desk.engine.sent[-1] == Move(again.request, home.request))


async def test_where_the_engine_does_not_start_what_was_asked_for_has_a_row() -> None:
    gate = threading.Event()

    def fail() -> EngineHandle:
        gate.wait(30)
        raise SaysoError("No.")

    async with console(start=fail, in_line=True) as desk:
        await desk.press(*"nod", "enter")
        gate.set()
        await desk.until(lambda: desk.shown_problem)
        await desk.press(*"beep", "enter")
        note = "never begun: the engine did not start"
        assert lost(desk) == [Line("lost", "nod", note), Line("lost", "beep", note)]
        assert shown(desk) == []


# What is typed does at once what it would do with the engine there

REPLACED = "replaced before it began"


async def test_a_new_request_replaces_what_waits_and_the_engine_hears_of_that_one_alone() -> None:
    async with starting() as (desk, gate):
        await desk.press(*"go to the bedrom", "enter", *"beep", "ctrl+j", *"nod", "enter", *"and then wave", "enter")
        assert shown(desk) == ["nod", "and then wave"]
        assert lost(desk) == [Line("lost", "go to the bedrom", REPLACED), Line("lost", "beep", REPLACED)]
        assert "2 waiting" in desk.text.splitlines()[0]
        await start(desk, gate)
        assert sent(desk) == [("nod", ()), ("and then wave", ())]


@pytest.mark.parametrize(
    ("busy", "waiting", "rows"),
    [("queue", ["nod", "beep"], []), ("reject", ["nod"], [Line("lost", "beep", "not taken: the robot was busy")])],
)
async def test_as_the_settings_say(busy: Busy, waiting: list[str], rows: list[Line]) -> None:
    async with starting() as (desk, _):
        desk.app.early.busy = busy
        await desk.press(*"nod", "enter", *"beep", "enter")
        assert (shown(desk), lost(desk)) == (waiting, rows)


@pytest.mark.parametrize(("said", "by"), [("stop", "stop"), ("end the task", "the end of the task")])
async def test_a_stop_drops_what_waits_at_once_and_does_not_wait_itself(said: str, by: str) -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter", *"beep", "ctrl+j", *said, "enter")
        assert shown(desk) == []
        assert lost(desk) == [Line("lost", text, f"never begun: {by}") for text in ("nod", "beep")]
        assert Line("you", said, "typed") in desk.app.drawing.model.conversation
        await start(desk, gate)
        assert sent(desk) == []


async def test_of_lines_that_were_pasted_those_before_a_stop_never_begin() -> None:
    async with starting() as (desk, gate):
        desk.app.main.line.paste("nod\nstop\nbeep\ngo home")
        await desk.press("enter")
        assert lost(desk) == [Line("lost", "nod", "never begun: stop")]
        assert shown(desk) == ["beep", "go home"]
        await start(desk, gate)
        assert sent(desk) == [("beep", ("go home",))]


async def test_the_emergency_stop_in_words_is_pressed_once_the_engine_is_there() -> None:
    async with starting() as (desk, gate):
        await desk.press(*"nod", "enter", *"emergency stop", "enter")
        assert "E-STOP once the robot is there" in desk.text
        await start(desk, gate)
        assert desk.engine.sent == [EStop()]
        assert lost(desk) == [Line("lost", "nod", "never begun: the emergency stop")]
