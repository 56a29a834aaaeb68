"""What a person reads on the screen, under ordinary and extraordinary circumstances."""

from __future__ import annotations

import random
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import pytest
from rich.cells import cell_len

from config.schema import Place, Position
from engine import events as ev
from engine.commands import Interrupt
from engine.handle import PartStatus
from engine.perception.memory import Thing, World
from tests.tui import scripted
from tests.tui.desk import console
from tests.tui.scripted import PARTS_LOADING, PARTS_READY, ScriptedEngine, flat, robot_at
from tui.plan.chart import Moving
from tui.shown.facts import Level
from tui.terminal.terminal import MIN_COLUMNS, MIN_ROWS, layout_for, why_not_usable
from tui.widgets.floor_view import FloorView
from tui.widgets.lines import Lines
from tui.widgets.mic import trace_step
from tui.widgets.queue import ActionQueue


def typed(text: str) -> ev.TranscriptFinal:
    return ev.TranscriptFinal(text, "text", "en", 1.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("text", ["[red]stop[/red]", "[@click=app.leave]here[/]", "[/]", "\\[b]", "a[b", "$primary"])
async def test_markup_in_what_was_said_is_only_text(text: str) -> None:
    async with console() as desk:
        desk.engine.publish(typed(text))
        desk.engine.publish(ev.PlanMade(text, (text,), (), text, "phrases"))
        desk.engine.publish(ev.ActionStarted("a1", 1, 1, "say", {"text": text}))
        desk.engine.publish(ev.Log("info", text, text))
        desk.engine.publish(ev.ErrorRaised(text, text, text))
        await desk.until(lambda: desk.text.count(text) >= 8)


async def test_wide_characters_keep_every_line_as_wide_as_the_terminal() -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.publish(typed("去厨房，然后向左转九十度，再告诉我你看到了什么。" * 4))
        desk.engine.publish(ev.PlanMade("去厨房", ("去厨房", "向左转九十度"), (), "好的", "local"))
        desk.engine.publish(ev.ActionStarted("a1", 1, 1, "说话", {"文本": "好的，我现在就去厨房看一看有没有人"}))
        await desk.settled()
        assert "去厨房，然后向左转" in desk.text
        assert {cell_len(line) for line in desk.text.splitlines()} == {80}


async def test_very_long_words_and_texts_stay_inside_their_pane() -> None:
    async with console(size=(80, 24)) as desk:
        for text in ("x" * 5000, "word " * 5000, "e\u0301" * 500, "👩‍🚀" * 200):
            desk.engine.publish(typed(text))
            desk.engine.publish(ev.ActionStarted(text[:9], 1, 1, text, {}))
            await desk.settled()
            assert {len(line) for line in desk.text.splitlines() if line.isascii()} <= {80}
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]


async def test_a_flood_of_events_is_shown_and_keys_still_work() -> None:
    async with console() as desk:
        for number in range(2500):
            desk.engine.publish(ev.Log("info", "flood", f"line {number}"))
            desk.engine.publish(ev.TranscriptPartial(f"words {number}", 1))
            desk.engine.publish(ev.ListenLevel(-20.0, -10.0, 0.9, True))
            desk.engine.publish(ev.ActionStarted(f"a{number}", 1, 1, "wait", {"seconds": 1.0}))
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]
        assert "line 2499" in desk.text
        assert "words 2499" in desk.text


async def test_a_storm_of_resizes_ends_in_the_right_arrangement() -> None:
    sizes = random.Random(1)
    async with console() as desk:
        desk.engine.play(scripted.acting())
        for _ in range(40):
            await desk.pilot.resize_terminal(sizes.randint(1, 200), sizes.randint(1, 70))
        await desk.pilot.resize_terminal(80, 24)
        await desk.settled()
        assert "Go to the kitchen" in desk.text
        assert "Log" not in desk.text
        await desk.pilot.resize_terminal(120, 40)
        await desk.settled()
        assert "Log" in desk.text


@pytest.mark.parametrize("size", [(60, 16), (60, 40), (79, 21), (110, 20), (250, 70)])
async def test_every_usable_size_shows_state_stop_key_and_input(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        for words in ("ACTING", "esc stop", "Go to the kitchen", "Going to the kitchen.", "Press / and type"):
            assert words in desk.text


@pytest.mark.parametrize("size", [(1, 1), (20, 3), (59, 40), (200, 15)])
async def test_less_than_that_says_so(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        shown = desk.text.replace("\n", " ")
        assert size[0] < 20 or f"{size[0]}×{size[1]}" in shown


async def test_without_a_microphone_one_line_offers_typing_and_the_demo() -> None:
    async with console(ScriptedEngine(parts=PARTS_LOADING), size=(80, 24)) as desk:
        lines = [line for line in desk.text.splitlines() if "No microphone" in line]
        assert len(lines) == 1
        assert "--demo" in lines[0]
        assert "type, or start" in lines[0]


@pytest.mark.parametrize(
    ("reason", "word"), [("no_speech", "nobody spoke"), ("cancelled", "cancelled"), ("silence", "end of speech")]
)
async def test_on_one_line_a_mark_has_its_sign_once(
    reason: Literal["no_speech", "cancelled", "silence"], word: str
) -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.play(scripted.listening())
        desk.engine.publish(ev.ListenEnded(reason, 2.0, 1.0))
        await desk.settled()
        mic = desk.text.splitlines()[-2]
        assert f" {word}" in mic
        assert len(re.findall("[✗◆■✓]", mic)) == 1


async def test_loading_parts_are_named_until_they_are_ready() -> None:
    async with console(ScriptedEngine(parts=PARTS_LOADING), size=(80, 24)) as desk:
        assert "loading: recogniser" in desk.text
        desk.engine.parts = PARTS_READY
        await desk.until(lambda: "all parts ready" in desk.text)


async def test_a_part_that_takes_long_says_how_far_it_is() -> None:
    fetching = PartStatus("model", "loading", "fetching 43%, 481 of 1117 MB")
    async with console(ScriptedEngine(parts=(*PARTS_READY, fetching)), size=(80, 24)) as desk:
        assert "model: fetching 43%" in desk.text
        desk.engine.parts = (*PARTS_READY, PartStatus("model", "ready"))
        await desk.until(lambda: "all parts ready" in desk.text)


async def test_a_part_that_fails_later_is_noticed() -> None:
    async with console(size=(80, 24)) as desk:
        assert "all parts ready" in desk.text
        desk.engine.parts = (PartStatus("robot", "failed", "gone"), *PARTS_READY[1:])
        desk.engine.publish(ev.ErrorRaised("robot_lost", "The robot is gone."))
        await desk.until(lambda: "failed: robot" in desk.text)


async def test_a_session_that_ends_by_itself_says_so_and_how_to_leave() -> None:
    async with console() as desk:
        desk.engine.publish(ev.SessionEnded("stopped from outside"))
        await desk.until(lambda: "q quits; session ended: stopped from outside" in desk.text)
        assert "ENDED" in desk.text


async def test_a_running_duration_follows_event_time() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert [item.seconds for item in desk.app.query_one(ActionQueue).items[:2]] == ["0.1 s", "4.7 s"]
        desk.engine.publish(ev.ActionProgress("a2", "navigation", 0.5), after=10)
        await desk.settled()
        assert desk.app.query_one(ActionQueue).items[1].seconds == "14.7 s"


async def test_what_holds_the_robot_back_is_shown() -> None:
    engine = ScriptedEngine(robot=replace(robot_at(0, 0, 0), blocked="obstacle 0.05 m ahead"), floor=flat())
    async with console(engine, size=(80, 24)) as desk:
        assert "▲ obstacle 0.05 m ahead" in desk.text


async def test_a_robot_that_is_nowhere_is_not_drawn() -> None:
    async with console(ScriptedEngine(robot=robot_at(float("nan"), 99.0, float("nan")), floor=flat())) as desk:
        assert "kitchen" in desk.text


async def test_only_cells_that_changed_are_marked_on_the_map(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        marked: list[object] = []
        view = desk.app.query_one(FloorView)
        monkeypatch.setattr(view, "refresh", lambda *regions, **_: marked.extend(regions or ["everything"]))
        view.show_moving(Moving(robot_at(-1.35, 0.05, 0.4)))
        assert marked == []
        view.show_moving(Moving(robot_at(1.0, 0.05, 0.4)))
        assert len(marked) == 2
        assert "everything" not in marked


async def test_whoever_waits_for_the_console_to_settle_sees_all_that_has_happened() -> None:
    async with console() as desk:
        desk.app.drawing.pace(4)  # as slow as under load: the next frame, and the log behind it, are some time off
        desk.engine.publish(ev.Log("info", "robot", "the first line"))
        await desk.until(lambda: "the first line" in desk.text)
        desk.engine.publish(ev.Log("info", "robot", "the line behind it"))
        await desk.settled()
        assert "the line behind it" in desk.text


async def test_an_idle_console_has_nothing_to_draw(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        await desk.settled()
        await desk.until(lambda: not desk.app.drawing.ticking)
        drawn: list[object] = []
        monkeypatch.setattr(desk.app, "_display", lambda *arguments: drawn.append(arguments))
        for pane in desk.app.query(Lines):
            pane.show(pane.items, matters=pane._matters)
        await desk.pilot.pause()
        assert drawn == []


async def test_an_unknown_theme_is_reported_and_replaced() -> None:
    async with console() as desk:
        desk.app.dress("no-such-theme", 8)
        await desk.settled()
        assert "no-such-theme" in desk.text
        assert desk.app.theme == "sayso-dark"


async def test_the_settings_dress_the_console_after_its_first_picture() -> None:
    async with console() as desk:
        desk.app.dress("sayso-light", 8)
        await desk.settled()
        assert desk.app.theme == "sayso-light"


def test_the_trace_is_as_high_as_it_was_loud_and_solid_where_it_was_speech() -> None:
    loudness = (-200.0, -60.0, -35.0, -10.0, 40.0)
    assert [trace_step(Level(db, 0.9, True)) for db in loudness] == ["▁", "▁", "▅", "█", "█"]
    assert [trace_step(Level(db, 0.1, True)) for db in loudness] == ["⣀", "⣀", "⣶", "⣿", "⣿"]


def test_the_arrangement_follows_the_size() -> None:
    assert layout_for(MIN_COLUMNS - 1, 50) == layout_for(200, MIN_ROWS - 1) == "tiny"
    assert layout_for(80, 24) == layout_for(109, 50) == layout_for(200, 31) == "compact"
    assert layout_for(110, 32) == "wide"


@pytest.mark.parametrize(
    ("environ", "terminals", "words"),
    [
        ({"TERM": "xterm"}, (True, True, True), None),
        ({"TERM": "dumb"}, (True, True, True), "dumb"),
        ({}, (True, True, True), "not set"),
        ({"TERM": "xterm"}, (False, True, True), "standard input"),
        ({"TERM": "xterm"}, (True, False, True), "standard output"),
        ({"TERM": "xterm"}, (True, True, False), "standard error"),
    ],
)
def test_a_terminal_that_cannot_be_used_is_refused_with_a_reason(
    environ: dict[str, str], terminals: tuple[bool, bool, bool], words: str | None
) -> None:
    why = why_not_usable(environ, *terminals)
    assert why is None if words is None else why is not None and words in why


async def test_what_was_seen_is_on_the_map_in_its_colour_and_hollow_once_it_is_stale() -> None:
    red = Thing(1, "box", "red", None, (1.0, 0.5, 0.02), 0.01, (0.04, 0.04), 0.0, None, seen_at=99.0)
    cup = Thing(2, "cup", "blue", None, (-1.0, -0.5, 0.04), 0.01, (0.06, 0.08), 0.0, None, seen_at=1.0)
    engine = ScriptedEngine(robot=robot_at(0, 0, 0, t=100.0), floor=flat())
    engine.seen = World((red, cup), held=None)
    async with console(engine) as desk:
        await desk.settled()
        shown = desk.app.query_one(FloorView)
        signs = {cell.char: cell.colour for cell in shown._overlay.values() if cell.ink == "thing"}
        assert signs == {"■": "red", "○": "blue"}


async def test_what_the_gripper_holds_is_named() -> None:
    red = Thing(1, "box", "red", None, (1.0, 0.5, 0.02), 0.01, (0.04, 0.04), 0.0, None, seen_at=99.0)
    engine = ScriptedEngine(robot=robot_at(0, 0, 0, t=100.0), floor=flat())
    engine.seen = World((), held=red)
    async with console(engine) as desk:
        await desk.settled()
        assert "◆ red box" in " ".join(desk.text.split())


async def test_the_examples_name_a_place_of_this_house_and_none_where_there_is_none() -> None:
    class Workshop(ScriptedEngine):
        def places(self) -> Mapping[str, Place]:
            return {"A": Place(name="workshop", position=Position(x=0, y=0))}

    class Empty(ScriptedEngine):
        def places(self) -> Mapping[str, Place]:
            return {}

    here = robot_at(0, 0, 0)
    for engine, example in ((Workshop(robot=here, floor=flat()), "go to the workshop"), (Empty(robot=here), "")):
        async with console(engine) as desk:
            assert "Try:  turn left 90 degrees" in desk.text
            assert "go to the kitchen" not in desk.text
            assert example in desk.text
            assert example or "go to" not in desk.text
