"""What the console has to say stands in the status line, and covers nothing that somebody may choose from."""

from __future__ import annotations

import pytest
from textual.widgets._toast import Toast

from engine import events as ev
from tests.tui import scripted
from tests.tui.desk import Desk, console
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
