"""Every pane has a number that goes there, one key that gives it all the room, and a share that is remembered."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from engine import events as ev
from tests.tui import conversation, scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, flat, robot_at, sight_of
from tui.kept.sizes import LEAST, MOST, STEP, USUAL, SizeFile
from tui.keys.keys import shown
from tui.screens.console import ConsoleScreen
from tui.shown.facts import Plan
from tui.widgets.ask import Ask
from tui.widgets.camera import CameraView
from tui.widgets.conversation import Conversation
from tui.widgets.floor_view import FloorView
from tui.widgets.lines import Lines
from tui.widgets.log import LogView
from tui.widgets.plan import PlanView, plan_items
from tui.widgets.queue import ActionQueue
from tui.widgets.said import Said
from tui.widgets.timeline import Timeline
from tui.words import strings

SIZES = [(120, 40), (80, 24), (60, 18)]
PANES: list[tuple[str, type[Widget]]] = [
    ("1", Conversation),
    ("2", PlanView),
    ("3", ActionQueue),
    ("4", FloorView),
    ("5", LogView),
    ("6", Timeline),
    ("7", CameraView),
]
TITLES = ("Conversation", "Plan", "Actions", "Map", "Log", "Turns", "Camera")
NARROWER, WIDER = "less_than_sign", "greater_than_sign"

sizes = pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))


def robot() -> ScriptedEngine:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    engine.on_look = lambda deliver: deliver(sight_of())
    return engine


def area(desk: Desk, pane: type[Widget]) -> Region:
    """Where on the screen a pane is; nowhere when it is hidden."""
    widget = desk.app.screen_stack[0].query_one(pane)
    return widget.region if widget in desk.app.screen_stack[0]._compositor.visible_widgets else Region()


def counting(widget: Lines[object], drawn: Counter[str]) -> Callable[[int], Strip]:
    """Draws lines of the widget, and counts them."""
    draw = widget.render_line

    def render_line(y: int) -> Strip:
        drawn[type(widget).__name__] += 1
        return draw(y)

    return render_line


def left_share(desk: Desk) -> float:
    """Percent of the columns that the conversation has."""
    return 100 * area(desk, Conversation).width / desk.app.size.width


@sizes
async def test_a_number_goes_to_its_pane_and_shows_it_wherever_it_was(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        for key, pane in (*PANES, *reversed(PANES)):
            await desk.press(key)
            assert isinstance(desk.app.focused, pane)
            assert area(desk, pane).area > 0, key


@pytest.mark.parametrize("before", [("l",), ("t",), ("m",), ("slash",), ("enter",)], ids="".join)
async def test_a_number_leads_there_from_wherever_one_is(before: tuple[str, ...]) -> None:
    async with console(robot(), size=(80, 24)) as desk:
        for key, pane in PANES[::2]:
            await desk.press(*before, *(("tab",) if before == ("slash",) else ()), key)
            assert isinstance(desk.app.focused, pane)
            assert area(desk, pane).area > 0, key


async def test_numbers_that_follow_each_other_at_once_lead_to_the_last() -> None:
    async with console(robot(), size=(80, 24)) as desk:
        await desk.press("4", "1", "4")
        assert area(desk, FloorView).width > 70
        await desk.press("5", "4", "6", "2")
        assert isinstance(desk.app.focused, PlanView)
        assert area(desk, PlanView).area > 0


@sizes
async def test_z_gives_a_pane_the_whole_middle_and_takes_it_back(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        desk.engine.play(scripted.acting())
        strips = 3 if size == (120, 40) else 2  # microphone strip and input
        for (key, kind), title in zip(PANES, TITLES, strict=True):
            await desk.press(key)
            before = area(desk, kind)
            await desk.press("z")
            pane = desk.app.screen.query_one(kind)
            frame = pane.parent if kind in (FloorView, CameraView) else pane
            below = strips + (kind is not Conversation)  # what was said last
            assert isinstance(frame, Widget)
            assert frame.region == Region(0, 1, size[0], size[1] - 1 - below)
            for words in ("ACTING", "esc stop", "mic", "Press / and type", f"{title} · z back"):
                assert words in desk.text
            await desk.press("z")
            assert area(desk, kind) == before
            assert "z back" not in desk.text


@sizes
async def test_going_back_leaves_the_zoom_then_the_pane(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        for key in "157":
            await desk.press(key, "z", "backspace")
            assert "z back" not in desk.text
            assert desk.app.focused is not None
            await desk.press("backspace")
            assert desk.app.focused is None
        assert desk.engine.sent == []


@sizes
async def test_the_pane_that_was_gone_to_last_is_the_one_that_is_zoomed(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        await desk.press("z")
        assert "1 Conversation · z back" in desk.text
        await desk.press("z", "2", "backspace", "z")
        assert "2 Plan · z back" in desk.text


@sizes
async def test_another_pane_takes_the_room_of_the_one_that_has_it(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        await desk.press("1", "z")
        for key, title in (("3", "Actions"), ("l", "Log"), ("t", "Turns"), ("m", "Map"), ("c", "Camera")):
            await desk.press(key)
            assert f"{title} · z back" in desk.text, key
        await desk.press("c")
        assert "Map · z back" in desk.text


async def test_what_is_zoomed_stays_while_one_types_and_through_every_size() -> None:
    async with console(robot()) as desk:
        for (key, kind), title in list(zip(PANES, TITLES, strict=True))[3:]:
            await desk.press(key, "z")
            assert f"{key} {title} · z back" in desk.text, key
            await desk.press("slash", "z")
            for other in ((80, 24), (40, 10), (70, 16), (120, 40)):
                await desk.pilot.resize_terminal(*other)
                await desk.settled()
                if other != (40, 10):
                    assert f"─ {title} · ctrl+g z back ─" in desk.text, "digits and letters are text now"
                    assert area(desk, kind).area > 0, (key, other)
            assert desk.app.screen.query_one(Ask).value.endswith("z")
            await desk.press("ctrl+g", "z")


async def test_the_pane_with_the_keyboard_is_in_sight_at_every_size() -> None:
    async with console(robot()) as desk:
        for key, kind in PANES:
            await desk.press(key)
            for size in ((80, 24), (60, 16), (120, 40)):
                await desk.pilot.resize_terminal(*size)
                await desk.settled()
                assert isinstance(desk.app.focused, kind), (key, size)
                assert area(desk, kind).area > 0, (key, size)


async def test_the_frame_of_the_pane_with_the_keyboard_is_heavier() -> None:
    async with console(robot()) as desk:
        for key, _ in PANES[:6]:
            await desk.press(key)
            assert desk.text.count("┏") == desk.text.count("┛") == 1, key
        await desk.press("backspace")
        assert "┏" not in desk.text


async def test_titles_have_the_numbers_or_the_keys_that_somebody_chose() -> None:
    async with console(robot()) as desk:
        for key, title in zip("123456", TITLES, strict=False):
            assert f"{key} {title}" in desk.text
        desk.app.dress("sayso-dark", 30, keys={"pane_plan": "f2", "zoom": "Z"})
        await desk.until(lambda: "f2 Plan" in desk.text)
        await desk.press("f2", "Z")
        assert "f2 Plan · Z back" in desk.text


@sizes
async def test_fewer_than_80_columns_show_one_column_at_a_time(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        narrow = size[0] < 80
        assert (area(desk, FloorView).area == 0) == narrow
        await desk.press("4")
        assert area(desk, FloorView).area > 0
        await desk.press("2")
        assert area(desk, Conversation).area > 0
        await desk.press("4", "backspace")
        assert (area(desk, FloorView).area == 0) == narrow, "where one was before"
        await desk.press("1")
        assert area(desk, Conversation).area > 0
        await desk.press("c")
        assert area(desk, CameraView).area > 0
        await desk.press("c")
        assert area(desk, Conversation).area > 0


@sizes
@pytest.mark.parametrize(("key", "kind"), [("1", Conversation), ("5", LogView)])
async def test_keys_that_scroll_act_on_the_pane_with_the_keyboard(
    key: str, kind: type[Lines[object]], size: tuple[int, int]
) -> None:
    async with console(robot(), size=size) as desk:
        for number in range(60):
            desk.engine.publish(ev.SpeechStarted(f"sentence {number:02}", False))
            desk.engine.publish(ev.Log("info", "test", f"line {number:02}"))
        await desk.press(key)
        newest = "sentence 59" if key == "1" else "line 59"
        assert newest in desk.text
        await desk.press("up")
        assert newest not in desk.text
        await desk.press("down")
        assert newest in desk.text
        await desk.press("z", "pageup")
        assert newest not in desk.text
        await desk.press("pagedown")
        assert newest in desk.text


async def test_the_log_in_place_of_all_else_is_scrolled_without_the_keyboard() -> None:
    async with console(robot(), size=(80, 24)) as desk:
        for number in range(60):
            desk.engine.publish(ev.Log("info", "test", f"line {number:02}"))
        await desk.press("l", "pageup")
        assert "line 59" not in desk.text


@pytest.mark.parametrize(
    ("key", "words", "others"), [("3", "Go to the kitchen", "robot"), ("5", "ready", "navigation")]
)
async def test_what_is_copied_is_the_pane_with_the_keyboard(key: str, words: str, others: str) -> None:
    async with console(robot()) as desk:
        desk.engine.play(scripted.acting())
        await desk.press(key, "y")
        assert words in desk.app.clipboard
        assert others not in desk.app.clipboard


async def test_the_log_is_in_sight_beside_the_camera_for_whom_it_was_hidden() -> None:
    async with console(robot()) as desk:
        await desk.press("c")
        assert area(desk, LogView).area == 0
        await desk.press("5")
        assert area(desk, LogView).area > 0
        await desk.press("l")
        assert area(desk, LogView).area == 0
        assert desk.app.focused is None


async def test_numbers_that_are_typed_are_text() -> None:
    async with console(robot()) as desk:
        await desk.press("slash", *"123z", NARROWER)
        assert desk.app.screen.query_one(Ask).value == "123z<"
        assert "z back" not in desk.text


async def test_a_terminal_that_is_too_small_has_no_panes_to_go_to() -> None:
    async with console(robot(), size=(40, 10)) as desk:
        await desk.press("1", "z", "7", NARROWER)
        assert desk.app.focused is None
        await desk.pilot.resize_terminal(80, 24)
        await desk.settled()
        assert "z back" not in desk.text


async def test_going_to_another_pane_draws_those_two_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console(robot()) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("1")
        drawn: Counter[str] = Counter()
        for widget in desk.app.screen.query(Lines):
            monkeypatch.setattr(widget, "render_line", counting(widget, drawn))
        await desk.press("2")
        assert drawn.keys() <= {"Conversation", "PlanView"}
        drawn.clear()
        await desk.press("2", "escape", "backspace")
        assert drawn.keys() <= {"PlanView"}


# Sizes


@pytest.mark.parametrize("size", SIZES[:2], ids=str)
async def test_the_border_between_the_columns_can_be_moved_to_a_limit(size: tuple[int, int]) -> None:
    async with console(robot(), size=size) as desk:
        usual = left_share(desk)
        await desk.press(WIDER)
        assert left_share(desk) - usual == pytest.approx(STEP, abs=1.5)
        await desk.press(NARROWER)
        assert left_share(desk) == usual
        for key, limit in ((WIDER, MOST), (NARROWER, LEAST)):
            await desk.press(*[key] * 12)
            assert area(desk, Conversation).right / size[0] == pytest.approx(limit / 100, abs=0.04)


async def test_the_border_between_log_and_turns_moves_while_one_of_them_has_the_keyboard() -> None:
    async with console(robot()) as desk:
        log, left = area(desk, LogView).width, area(desk, Conversation).width
        await desk.press("5", WIDER)
        assert area(desk, LogView).width > log
        assert area(desk, Conversation).width == left


@pytest.mark.parametrize(
    ("size", "keys"), [((60, 18), ()), ((80, 24), ("5",)), ((80, 24), ("m",)), ((120, 40), ("1", "z"))], ids=str
)
async def test_where_there_is_no_border_nothing_moves(size: tuple[int, int], keys: tuple[str, ...]) -> None:
    async with console(robot(), size=size) as desk:
        await desk.press(*keys)
        before = desk.text
        await desk.press(WIDER, NARROWER, NARROWER)
        assert desk.text.splitlines()[1:] == before.splitlines()[1:]
        assert "No border to move there" in desk.text
        await desk.press("backspace", "1")
        await desk.pilot.resize_terminal(120, 40)
        await desk.settled()
        assert left_share(desk) == pytest.approx(USUAL["wide"], abs=4)


async def test_the_robot_s_figures_keep_their_last_line_in_a_slim_column() -> None:
    async with console(robot()) as desk:
        assert "planner" in desk.text
        await desk.press(*[WIDER] * 5)
        assert "all parts ready" in desk.text


async def test_sizes_are_kept_for_the_next_session(tmp_path: Path) -> None:
    file = tmp_path / "state" / "panes.json"
    async with console(robot()) as desk:
        desk.app.dress("sayso-dark", 30, sizes=(sizes := SizeFile(file)))
        await desk.until(lambda: desk.app.dressing.sizes is sizes)
        await desk.press(WIDER, WIDER)
        chosen = left_share(desk)
        await asyncio.to_thread(sizes.close)
    assert file.stat().st_mode & 0o777 == 0o600
    async with console(robot()) as desk:
        assert left_share(desk) != chosen
        desk.app.dress("sayso-dark", 30, sizes=SizeFile(file))
        await desk.until(lambda: left_share(desk) == chosen)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", "[" * 1000, '{"wide": "52"}', '{"wide": 5000, "compact": true, "below": null}', "\0\xff"],
)
def test_a_broken_file_of_sizes_is_as_good_as_none(text: str, tmp_path: Path) -> None:
    file = tmp_path / "panes.json"
    file.write_bytes(text.encode("latin-1"))
    complaints: list[str] = []
    sizes = SizeFile(file)
    assert sizes.read(complaints.append) == USUAL
    assert len(complaints) == (0 if text.startswith('{"') else 1)
    sizes.keep({**USUAL, "wide": 60})
    sizes.close()
    assert SizeFile(file).read() == {**USUAL, "wide": 60}


def test_a_part_of_a_file_of_sizes_is_used(tmp_path: Path) -> None:
    file = tmp_path / "panes.json"
    file.write_text('{"compact": 40, "wide": 99, "left": 3}')
    assert SizeFile(file).read() == {**USUAL, "compact": 40}


def test_a_place_where_no_file_can_be_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    complaints: list[str] = []
    sizes = SizeFile(tmp_path / "taken" / "panes.json")
    assert sizes.read(complaints.append) == USUAL
    sizes.keep(USUAL)
    sizes.keep(USUAL)
    sizes.close()
    assert len(complaints) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


async def test_the_sessions_of_several_turns_are_browsed_where_they_are_zoomed() -> None:
    async with console(robot(), size=(80, 24)) as desk:
        conversation.play(desk.engine, conversation.ALL)
        await desk.press("1", "z", "left_square_bracket")
        assert "Turns · z back" in desk.text
        await desk.press("enter")
        assert not isinstance(desk.app.screen, ConsoleScreen)
        await desk.press("backspace", "5")
        assert "Log · z back" in desk.text


def test_every_number_is_shown_as_it_is_typed() -> None:
    assert [shown(key) for key in (NARROWER, WIDER, "7", "z")] == ["<", ">", "7", "z"]


@pytest.mark.parametrize(
    ("size", "keys"),
    [
        ((120, 40), ("4", "z", "slash")),
        ((80, 24), ("m",)),
        ((80, 24), ("l",)),
        ((60, 18), ("4",)),
        ((120, 40), ("3", "z")),
    ],
    ids=lambda value: "".join(map(str, value)),
)
async def test_what_the_robot_says_and_asks_is_in_sight_whichever_pane_is_in_front(
    size: tuple[int, int], keys: tuple[str, ...]
) -> None:
    async with console(robot(), size=size) as desk:
        await desk.press(*keys)
        assert area(desk, Conversation).area == 0
        desk.engine.publish(conversation.typed("go to the exit"))
        desk.engine.publish(ev.SpeechStarted("I am at the exit.", False))
        await desk.settled()
        assert "I am at the exit." in desk.text
        question = "I cannot fly. Shall I drive there?"
        desk.engine.publish(ev.ClarificationAsked(question, "fly to the moon"))
        desk.engine.publish(ev.SpeechStarted(question, False))
        desk.engine.publish(ev.RequestEnded("R1", "text", "nod", "dropped"), turn=None)
        await desk.settled()
        assert question in desk.text, "also when something else has happened since"
        await desk.press("ctrl+g", "1")
        said = desk.app.screen.query_one(Said)
        assert not said.display
        assert area(desk, Conversation).area > 0


async def test_a_long_answer_that_has_no_room_ends_with_an_ellipsis() -> None:
    async with console(robot(), size=(80, 24)) as desk:
        await desk.press("4", "z")
        desk.engine.publish(ev.SpeechStarted("I see many things here. " * 40 + "That is the end.", False))
        await desk.settled()
        rows = [row.rstrip() for row in desk.text.splitlines()]
        assert sum("I see many things" in row for row in rows) == 6
        assert "end." not in desk.text
        assert any(row.endswith("…") for row in rows if "many things" in row)
        await desk.pilot.resize_terminal(200, 55)
        await desk.settled()
        assert "end." in desk.text


async def test_a_question_needs_no_row_where_there_is_room_for_none() -> None:
    async with console(robot()) as desk:
        await desk.press("4", "z")
        desk.engine.publish(ev.SpeechStarted("I am at the exit.", False))
        await desk.pilot.resize_terminal(38, 9)
        await desk.settled()
        assert "exit" not in desk.text


def test_of_what_is_no_order_the_plan_does_not_say_that_the_robot_asks() -> None:
    for is_open, words in ((True, strings.QUESTION), (False, strings.NO_ORDER)):
        first, *_ = plan_items(Plan("question", "no", message="What shall I do?", open=is_open))
        assert first[3] == words
