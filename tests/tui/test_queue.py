"""The actions of a plan: what runs has the room, what comes next is in view, and what ended badly says why."""

from __future__ import annotations

import pytest

from engine import events as ev
from engine.commands import Interrupt
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.widgets.queue import ActionQueue


def queue_of(desk: Desk) -> ActionQueue:
    return desk.app.query_one(ActionQueue)


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16)])
async def test_what_runs_and_what_comes_next_are_in_view(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        assert "Bring the green bottle" in desk.text
        assert "Go to the charging dock" in desk.text
        assert "12.4 s" in desk.text


async def test_what_runs_says_how_far_it_is_in_all_words() -> None:
    async with console() as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        words = " ".join(desk.text.split())
        assert "holding the green bottle, 1.8 m to the" in words
        running = next(item for item in queue_of(desk).items if item.phase == "running")
        assert running.filled == 5, "five eighths"


async def test_the_pane_counts_what_ended_and_names_the_key_that_stops() -> None:
    async with console(keymap={"interrupt": "x"}) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        assert "3 of 6 ended · 1 failed · x stops" in desk.text
        await desk.press("x")
        assert desk.engine.sent == [Interrupt()]
        desk.engine.publish(ev.ActionFinished("q4", "carry", {}, "interrupted", "interrupted", "Stopped by key.", 13.0))
        await desk.settled()
        assert "x stops" not in desk.text


async def test_when_nothing_runs_any_more_reasons_have_the_room() -> None:
    async with console(size=(120, 50)) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        reason = "I could not find a red box in the living room, the hall and the kitchen."
        assert [item.whole for item in queue_of(desk).items] == [False, False, False, True, False, False]
        desk.engine.publish(ev.ActionFinished("q4", "carry", {}, "failed", "dropped", "It fell down.", 13.0))
        desk.engine.publish(ev.StateChanged("ACTING", "WAITING", "failed", ev.TurnResult(1, "failed", "It fell down.")))
        await desk.settled()
        shown = queue_of(desk).items
        assert [item.phase for item in shown] == ["failed", "uncertain", "ok", "failed", "interrupted", "interrupted"]
        assert [item.whole for item in shown] == [True, True, False, True, True, True]
        queue_of(desk).scroll_lines(-20)
        await desk.settled()
        words = " ".join(line[:62].strip("│ ") for line in desk.text.splitlines())
        assert "box in the living room" in " ".join(words.split())
        assert reason == shown[0].message


@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_requests_that_wait_are_shown_until_they_begin(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(ev.RequestsWaiting(("turn left", "come back")))
        await desk.settled()
        assert "○  turn left  waits" in desk.text
        assert "○  come back  waits" in desk.text
        assert "2 waiting · esc stops" in desk.text
        desk.engine.publish(ev.RequestsWaiting(("come back",)))
        await desk.settled()
        assert "turn left  waits" not in desk.text
        assert "1 waiting · esc stops" in desk.text


async def test_of_many_requests_that_wait_the_next_ones_are_shown_and_the_others_counted() -> None:
    async with console() as desk:
        desk.engine.publish(ev.RequestsWaiting(tuple(f"move {number}" for number in range(9))))
        await desk.settled()
        assert "move 2  waits" in desk.text
        assert "… and 6 more" in desk.text
        assert "9 waiting" in desk.text


async def test_what_an_interruption_drops_is_told() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(ev.RequestsWaiting(("turn left", "come back")))
        desk.engine.publish(ev.RequestsDropped(("turn left", "come back")))
        desk.engine.publish(ev.RequestsWaiting(()))
        await desk.settled()
        assert "■  2 waiting requests dropped: turn left; come back" in desk.text
        assert "2 waiting ·" not in desk.text
        desk.engine.publish(ev.RequestsDropped(("beep",)))
        await desk.settled()
        assert "1 waiting request dropped: beep" in desk.text
