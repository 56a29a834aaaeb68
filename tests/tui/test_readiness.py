"""The console looks ready when a request is begun at once, and says what it waits for as long as it is not."""

from __future__ import annotations

import threading

import pytest

from engine import events as ev
from engine.commands import Say
from engine.errors import SaysoError
from engine.handle import EngineHandle, PartName, PartStatus
from tests.tui.desk import Desk, console
from tests.tui.scripted import PARTS_READY, ScriptedEngine, flat, robot_at
from tui.widgets.conversation import Conversation


def loading(*names: PartName) -> tuple[PartStatus, ...]:
    """All parts, of which these are not there yet."""
    return tuple(PartStatus(part.name, "loading" if part.name in names else "ready") for part in PARTS_READY)


def typed(text: str) -> ev.TranscriptFinal:
    return ev.TranscriptFinal(text, "text", "en", 1.0, 0.0, 0.0, 0.0, 0.0)


def line(desk: Desk, number: int) -> str:
    return desk.text.splitlines()[number]


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16)])
async def test_it_is_not_ready_while_robot_or_planner_load_and_a_request_is_said_to_wait(size: tuple[int, int]) -> None:
    engine = ScriptedEngine(parts=loading("robot", "planner"), floor=flat())
    async with console(engine, size=size) as desk:
        assert "◌ LOADING" in line(desk, 0)
        assert "READY" not in line(desk, 0)
        assert "it waits for robot and planner to load" in desk.text
        assert ("robot and planner · requests wait" in line(desk, 0)) is (size[0] == 120)
        await desk.press("slash", *"nod", "enter")
        assert engine.sent == [Say("nod")]  # it is not refused
        await desk.press("ctrl+g")
        engine.parts = loading("robot")
        await desk.until(lambda: "waits for robot to load" in desk.text and "planner" not in line(desk, -1))
        engine.parts = PARTS_READY
        await desk.until(
            lambda: "○ READY" in line(desk, 0) and "Press / and type what the robot should do" in desk.text
        )


async def test_a_request_that_waits_says_for_what() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), parts=loading("robot", "planner"), floor=flat())
    async with console(engine) as desk:
        engine.publish(typed("nod"))
        await desk.until(lambda: "waits for the robot and planner" in desk.text)
        engine.parts = loading("robot")
        engine.publish(ev.StateChanged("IDLE", "PLANNING", "a request was understood"))
        await desk.until(lambda: "PLANNING" in line(desk, 0) and "thinking…" in desk.text)
        engine.publish(ev.PlanMade("nod", ("Nod.",), (ev.ActionView("arm_nod", {}),), "", "phrases"))
        await desk.until(lambda: "LOADING" in line(desk, 0) and "waits for the robot" in desk.text)
        engine.parts = PARTS_READY
        await desk.until(lambda: "PLANNING" in line(desk, 0) and "by known phrases" in desk.text)


async def test_while_a_request_is_thought_over_it_is_not_ready_for_another() -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.publish(typed("nod"))
        await desk.until(lambda: "PLANNING" in line(desk, 0) and "thinking…" in desk.text)
        desk.engine.publish(ev.InterruptRaised("interrupt", "key", "IDLE"))
        await desk.until(lambda: "READY" in line(desk, 0))


async def test_what_happened_before_anything_was_asked_leaves_the_welcome_where_it_is() -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.publish(ev.Timing("paused", 1.3))
        await desk.until(lambda: "Not responding for 1.3 s" in desk.text)
        assert "Press space and speak" in desk.text
        assert "go to the kitchen" in desk.text
        desk.engine.publish(typed("nod"))
        await desk.until(lambda: "Press space and speak" not in desk.text)


async def test_of_many_parts_the_one_that_is_missing_is_named_whatever_else_there_is() -> None:
    names: tuple[PartName, ...] = ("robot", "recogniser", "planner", "voice", "camera", "model", "wake", "wake words")
    ready = tuple(PartStatus(name, "ready") for name in names)
    parts = (*ready, PartStatus("microphone", "missing", "There is no microphone."))
    async with console(ScriptedEngine(robot=robot_at(0, 0, 0), parts=parts, floor=flat())) as desk:
        assert "– mic  ✓ all others ready" in desk.text
        desk.engine.parts = (*ready[:4], parts[-1])
        desk.engine.publish(ev.Log("info", "robot", "x"))
        await desk.until(lambda: "– mic  ✓ robot recogniser planner voice" in desk.text)


async def test_ears_that_load_keep_nobody_from_typing_and_say_so_themselves() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), parts=loading("recogniser"), floor=flat())
    async with console(engine, size=(80, 24)) as desk:
        assert "○ READY" in line(desk, 0)
        assert "○ loading · recogniser" in line(desk, -2)


async def test_without_a_planner_it_is_not_ready_either() -> None:
    parts = tuple(PartStatus(part.name, "failed" if part.name == "planner" else "ready") for part in PARTS_READY)
    async with console(ScriptedEngine(robot=robot_at(0, 0, 0), parts=parts, floor=flat())) as desk:
        assert "✗ FAILED" in line(desk, 0)


async def test_what_the_robot_does_is_shown_whatever_else_loads() -> None:
    async with console(ScriptedEngine(robot=robot_at(0, 0, 0), parts=loading("planner"), floor=flat())) as desk:
        desk.engine.publish(ev.StateChanged("IDLE", "ACTING", "x"))
        await desk.until(lambda: "ACTING" in line(desk, 0))


# An engine that does not start


def fail() -> EngineHandle:
    raise SaysoError("The scene is broken.", hint="In five words, or more.\n" * 4)


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 20)], ids=str)
async def test_nothing_says_that_it_starts_once_it_did_not(size: tuple[int, int]) -> None:
    async with console(start=fail, size=size, in_line=True) as desk:
        await desk.until(lambda: desk.app.shown.failed)
        await desk.settled()
        assert "FAILED" in line(desk, 0)
        assert "▲ The engine did not start" in desk.text, "at the microphone"
        for untrue in ("start…", "starting", "loading", "Type what the robot should do."):
            assert untrue not in desk.text, untrue
        assert desk.app.main.query_one(Conversation).size.height >= 4, "there is room to read what was asked for"
        assert ("The robot is not there." in desk.text) is (size[0] >= 80), "on the map"


@pytest.mark.parametrize("keys", [(), ("ctrl+g", "ctrl+g"), ("ctrl+g", "ctrl+g", "3")])
async def test_nobody_is_invited_to_type_where_the_engine_did_not_start(keys: tuple[str, ...]) -> None:
    async with console(start=fail, in_line=True) as desk:
        await desk.until(lambda: desk.app.shown.failed)
        await desk.press(*keys)
        assert "Nothing is done: the engine did not start · ctrl+c quits" in desk.text
        assert "what the robot should do" not in desk.text


async def test_no_picture_is_waited_for_and_no_map_zoomed_where_the_engine_did_not_start() -> None:
    async with console(start=fail, in_line=True) as desk:
        await desk.until(lambda: desk.app.shown.failed)
        await desk.press("ctrl+g", "ctrl+g", "c")  # from what is told of the failure, and from the line
        assert "waiting for a picture" not in desk.text
        assert desk.app.main.camera_in_sight
        await desk.press("m")
        assert "zoom" not in str(desk.app.main.query_one("#map").border_subtitle)


async def test_a_pane_with_the_keyboard_says_which_key_leads_to_the_line_also_while_the_engine_starts() -> None:
    gate = threading.Event()

    def start() -> EngineHandle:
        gate.wait(30)
        return ScriptedEngine()

    async with console(start=start, in_line=True) as desk:
        await desk.press("ctrl+g", "3")
        assert "Press / and type" in desk.text.splitlines()[-1]
        await desk.press("slash", *"nod")
        assert desk.app.main.line.value == "nod"
        gate.set()


async def test_of_a_robot_that_cannot_be_had_no_map_is_loaded() -> None:
    parts = (PartStatus("robot", "failed"), *PARTS_READY[1:])
    async with console(ScriptedEngine(parts=parts)) as desk:
        assert "loading the map" not in desk.text
