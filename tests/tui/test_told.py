"""What the console has to say stands in the status line, and covers nothing that somebody may choose from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from textual.widgets._toast import Toast

from engine import events as ev
from engine.handle import PartStatus
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_READY, ScriptedEngine, flat, robot_at
from tests.tui.test_stopping import starting, there
from tui.widgets.queue import ActionQueue
from tui.words import strings
from tui.words.language import Language


def toasts(desk: Desk) -> list[Toast]:
    return list(desk.app.screen.query(Toast))


async def test_what_the_status_line_has_room_for_lies_over_nothing() -> None:
    async with console(size=(80, 24)) as desk:
        await desk.press("a", "a", "a")
        assert strings.NOT_OFFERED["again"] in desk.text.splitlines()[0]
        assert not desk.app._notifications


@pytest.mark.parametrize("size", [(60, 20), (80, 24), (120, 40)])
async def test_what_lies_over_the_screen_covers_no_offer(size: tuple[int, int]) -> None:
    async with console(size=size, notices=True) as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ev.OffersMade("T1", "T1", "T1", "T1"), turn=None)
        await desk.settled()
        desk.app.keeping.tell("word " * (size[0] // 5))
        await desk.until(lambda: toasts(desk) and toasts(desk)[0].region.height)
        (toast,) = toasts(desk)
        assert not toast.region.overlaps(desk.app.query_one(ActionQueue).region)
        assert toast.region.y == 1
        await desk.press("t")
        assert "k continue · u undo · a again" in desk.text


@pytest.mark.parametrize("language", ["en", "zh"])
async def test_a_robot_that_is_at_nothing_is_ready_whatever_was_before(language: Language) -> None:
    async with console(language=language) as desk:
        first = desk.text.splitlines()[0][:16]
        desk.engine.play(scripted.done())
        desk.engine.publish(ev.StateChanged("FEEDBACK", "WAITING", "done"))
        await desk.settled()
        assert desk.app.shown.model.state == "WAITING"
        assert desk.text.splitlines()[0][:16] == first


# What is told goes when it is true no more


async def off_the_screen(desk: Desk, words: str, change: Callable[[], object]) -> None:
    """These words are told, and no more once that has happened; nor do they come back."""
    assert words in desk.app.shown.notice
    change()
    desk.app.redraw()
    await desk.settled()
    assert words not in desk.text.splitlines()[0], "the log keeps it"
    assert desk.app.keeping.told == ""


async def test_that_nothing_is_to_be_stopped_goes_for_good_when_something_begins() -> None:
    async with console() as desk:
        desk.app.drawing.nothing_to_stop()
        await desk.settled()
        await off_the_screen(desk, "Nothing to stop", lambda: desk.engine.play(scripted.acting()))


async def test_that_the_robot_is_at_something_goes_when_it_is_not() -> None:
    async with console() as desk:
        desk.engine.publish(ev.StateChanged("WAITING", "ACTING", "x"))
        await desk.press("u")
        over = ev.StateChanged("ACTING", "WAITING", "done", ev.TurnResult(0, "done", ""))
        await off_the_screen(desk, "The robot is at something", lambda: desk.engine.publish(over))


async def test_that_the_emergency_stop_is_pressed_goes_with_its_release_also_over_the_screen() -> None:
    async with console(notices=True) as desk:
        robot = desk.engine.robot
        assert robot is not None
        desk.engine.robot = replace(robot, estop=True)
        desk.app.redraw()
        await desk.press("g")
        assert [box.message for box in desk.app._notifications] == [
            "The emergency stop is pressed: ctrl+o releases it."
        ]
        desk.engine.robot = robot
        desk.app.redraw()
        await desk.settled()
        assert not desk.app._notifications
        assert desk.app.shown.notice == ""


async def test_that_it_is_not_pressed_goes_when_it_is() -> None:
    async with console() as desk:
        robot = desk.engine.robot
        assert robot is not None
        await desk.press("R")
        pressed = replace(robot, estop=True)
        await off_the_screen(desk, "not pressed", lambda: setattr(desk.engine, "robot", pressed))


async def test_that_the_robot_still_starts_goes_when_it_is_there() -> None:
    engine = ScriptedEngine(parts=(PartStatus("robot", "loading"), *PARTS_READY[1:]), floor=flat())
    async with console(engine) as desk:
        await desk.press("g")
        await off_the_screen(desk, "still starting", lambda: setattr(engine, "robot", robot_at(0.0, 0.0, 0.0)))


async def test_that_the_emergency_stop_will_be_pressed_goes_when_it_is_released_or_the_robot_is_there() -> None:
    comes = "once the robot is there"
    async with starting() as (desk, gate):
        await desk.press("ctrl+x")
        assert comes in desk.app.shown.notice
        await desk.press("ctrl+o")
        assert comes not in desk.text
        await desk.press("ctrl+x")
        assert comes in desk.text
        gate.set()
        await there(desk)
        desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
        desk.app.redraw()
        await desk.settled()
        assert comes not in desk.text
