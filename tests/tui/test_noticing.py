"""A device that is lost or found again is told once, wherever somebody looks, and the log keeps it."""

from __future__ import annotations

from engine import events as ev
from engine.handle import PartName, PartState, PartStatus
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_LOADING, ScriptedEngine


async def turns(desk: Desk, name: PartName, state: PartState, detail: str = "") -> None:
    """That part is in another state, as an engine tells it."""
    others = tuple(part for part in desk.engine.parts if part.name != name)
    desk.engine.parts = (*others, PartStatus(name, state, detail))
    desk.engine.publish(ev.Log("info" if state == "ready" else "warning", name, detail or state), turn=None)
    await desk.settled()
    await desk.until(lambda: desk.app.shown.parts == desk.engine.parts)
    await desk.settled()


def notices(desk: Desk) -> list[str]:
    return [notification.message for notification in desk.app._notifications]


async def test_a_microphone_that_is_unplugged_is_told_with_what_still_works() -> None:
    async with console() as desk:
        await turns(desk, "microphone", "failed", "The microphone was unplugged.")
        assert notices(desk) == ["! The microphone is not connected. Typing still works."]
        assert "The microphone was unplugged." in desk.text


async def test_it_is_told_on_every_page_in_the_language_of_the_console() -> None:
    async with console(language="zh") as desk:
        await desk.press("question_mark")
        await turns(desk, "wake", "ready")
        await turns(desk, "wake", "failed", "The port is gone.")
        assert notices(desk) == ["! 唤醒模块未连接 · 空格键仍可唤醒"]


async def test_what_was_told_of_a_device_goes_when_it_is_true_no_more() -> None:
    now = [0.0]
    async with console() as desk:
        desk.app.clock = lambda: now[0]
        await turns(desk, "microphone", "failed")
        now[0] = 60.0
        await turns(desk, "microphone", "ready")
        assert notices(desk) == ["✓ The microphone is connected. The robot hears you."]


async def test_coming_back_at_once_is_not_told_at_once() -> None:
    async with console() as desk:  # its clock stands still
        for state in ("failed", "ready", "failed", "ready"):
            await turns(desk, "microphone", state)
        assert len(notices(desk)) == 1


async def test_what_loads_at_the_start_is_no_news() -> None:
    async with console(ScriptedEngine(parts=PARTS_LOADING)) as desk:
        for name in ("recogniser", "planner"):
            await turns(desk, name, "ready")
        assert notices(desk) == []


async def test_a_service_that_another_one_stands_in_for_is_told() -> None:
    async with console() as desk:
        desk.engine.publish(ev.Log("warning", "model", "No answer. The platform local is asked instead."), turn=None)
        await desk.settled()
        assert notices(desk) == ["! A model does not answer. Another one is asked, which may take longer."]


async def test_nobody_was_woken_where_there_turns_out_to_be_no_microphone() -> None:
    async with console(ScriptedEngine()) as desk:
        desk.engine.publish(ev.WakeHeard("key"))
        await desk.settled()
        assert "woken by key" in desk.text
        await turns(desk, "microphone", "missing", "There is none.")
        assert "woken by key" not in desk.text
