"""The console on one line, for a small pane beside other work."""

from __future__ import annotations

import pytest

from engine import events as ev
from engine.commands import Interrupt, Say
from tests.tui import scripted
from tests.tui.desk import console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.widgets.ask import Ask

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
    async with console(engine(), size=(120, 2), one_line=True) as desk:
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


async def test_what_happens_keeps_its_room_where_there_is_little() -> None:
    async with console(engine(), size=(40, 2), one_line=True) as desk:
        desk.engine.publish(ev.SpeechStarted("I am in the kitchen, and nothing is there.", False))
        await desk.settled()
        assert "robot: I am in" in desk.text
        assert "m 90°" not in desk.text


async def test_a_pane_that_is_made_larger_and_smaller_goes_on_as_a_line() -> None:
    async with console(engine(), size=(80, 1), one_line=True) as desk:
        for size in ((120, 40), (80, 2), (60, 1)):
            await desk.pilot.resize_terminal(*size)
            await desk.settled()
            assert "READY" in desk.text
            assert "Conversation" not in desk.text
            assert "too small" not in desk.text
