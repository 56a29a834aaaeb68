"""Pointing at the map, looking closer, and being sent somewhere."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from textual.events import Key, MouseScrollUp

from engine import events as ev
from engine.commands import Here, Interrupt, Say
from engine.perception.memory import Thing, World
from engine.perception.people import PersonSeen
from engine.robot.arm import ARM_DOWN, ARM_UP
from engine.robot.robot import RobotState
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import PLACES, ScriptedEngine, flat, robot_at, scanned
from tui.plan.chart import TRAIL, Moving, faded, hits, overlay, posture
from tui.plan.floor import draw, fit, person_sign, thing_sign
from tui.plan.targets import Target, ago, pointed_at, targets
from tui.plan.viewport import ZOOMS, Viewport
from tui.widgets.floor_view import TURN, FloorView

FLAT = flat()
RED = Thing(1, "box", "red", None, (2.9, -1.5, 0.02), 0.01, (0.04, 0.04), 0.0, None, seen_at=60.0)
ANNA = PersonSeen(1, "Anna", "green", None, "standing", None, (-2.0, 0.5, 0.7), 0.08, 1.5, seen_at=199.0)
HERE = robot_at(-0.7, 0.2, 0.0, t=200.0)


def view(desk: Desk) -> FloorView:
    return desk.app.screen_stack[0].query_one(FloorView)


def engine(*things: Thing) -> ScriptedEngine:
    return ScriptedEngine(robot=HERE, floor=FLAT, seen=World(things))


def moved(robot_x: float, robot_y: float) -> ev.RobotStateView:
    return ev.RobotStateView(0.0, ev.PoseView(robot_x, robot_y, 0.0), ev.TwistView(0, 0, 0), (), 1.0, False, None)


def scrolled_up(widget: FloorView, x: int, y: int) -> MouseScrollUp:
    return MouseScrollUp(widget, x, y, 0, 0, 0, False, False, False, x, y)


# Keys


async def test_m_takes_the_focus_to_the_map_and_away_again() -> None:
    async with console() as desk:
        await desk.press("m")
        assert desk.app.focused is view(desk)
        assert "enter goes" in desk.text
        await desk.press("m")
        assert desk.app.focused is None
        assert "enter goes" not in desk.text


async def test_on_a_small_terminal_the_map_gets_the_room_while_it_has_the_focus() -> None:
    async with console(size=(80, 24)) as desk:
        narrow = view(desk).size.width
        await desk.press("m")
        await desk.until(lambda: view(desk).size.width > 2 * narrow)
        await desk.press("backspace")
        await desk.until(lambda: view(desk).size.width == narrow)
        assert desk.engine.sent == []


async def test_tab_points_at_places_then_at_things_and_round_again() -> None:
    async with console(engine(RED)) as desk:
        await desk.press("m")
        seen = []
        for _ in range(len(PLACES) + 2):
            await desk.press("tab")
            pointed = view(desk).pointed
            assert pointed is not None
            seen.append(pointed.name)
        assert seen == [*(place.name for place in PLACES.values()), "red box", "kitchen"]
        await desk.press("shift+tab")
        assert "red box, seen 2 min ago" in desk.text


async def test_keys_typed_ahead_of_the_map_are_its_own() -> None:
    async with console() as desk:
        for key, character in (("m", "m"), ("tab", "\t"), ("enter", "\r")):  # as a slow link delivers them
            desk.app.post_message(Key(key, character))
        await desk.settled()
        assert "Go to the kitchen?" in desk.text


async def test_enter_asks_and_enter_again_sends_the_robot() -> None:
    async with console(engine(RED)) as desk:
        await desk.press("m", "tab", "enter")
        assert desk.engine.sent == []
        assert "Go to the kitchen?" in desk.text
        await desk.press("enter")
        assert desk.engine.sent == [Say("go to the kitchen")]
        assert "Go to the kitchen?" not in desk.text


@pytest.mark.parametrize("zoom", [False, True])
@pytest.mark.parametrize(
    "key",
    [
        "right",
        "tab",
        "plus",
        "f",
        "0",
        "shift+left",
        "x",
        "backspace",
        "ctrl+g",
        "pageup",
        "pagedown",
        "ctrl+p",
        "ctrl+r",
    ],
)
async def test_any_other_key_takes_the_question_back(key: str, *, zoom: bool) -> None:
    async with console() as desk:
        await desk.press("m", *["z"][: int(zoom)], "tab", "enter")
        assert "Go to the kitchen?" in desk.text
        await desk.press(key)
        assert "Go to the kitchen?" not in desk.text
        await desk.press("m", "enter")
        assert desk.engine.sent == []


async def test_escape_takes_the_question_back_too_and_stops_as_everywhere() -> None:
    async with console() as desk:
        await desk.press("m", "tab", "enter", "escape", "enter")
        assert desk.engine.sent == [Interrupt()]


async def test_what_has_no_name_asks_nothing() -> None:
    nowhere = replace(FLAT, rooms=(), furniture=())
    async with console(ScriptedEngine(robot=robot_at(-4.0, 3.0, 0.0), floor=nowhere)) as desk:
        await desk.press("m", "enter", "enter")
        assert desk.engine.sent == []
        assert "tab chooses one" in desk.text


async def test_arrows_move_the_cursor_by_a_cell_and_it_stays_on_the_map() -> None:
    async with console() as desk:
        await desk.press("m")
        floor = view(desk)
        start, cell = floor._cursor, floor._frame
        assert start is not None
        assert cell is not None
        await desk.press("right", "up")
        assert floor._cursor == pytest.approx((start[0] + cell.cell_width, start[1] + cell.cell_height))
        await desk.press("left", "down")
        assert floor._cursor == pytest.approx(start)
        await desk.press(*["up"] * 60)
        assert floor._cursor is not None
        assert cell.cell(*floor._cursor) is not None


async def test_plus_looks_closer_at_the_cursor_minus_back_and_zero_shows_everything() -> None:
    async with console() as desk:
        await desk.press("m", "tab", "plus", "equals_sign")
        floor = view(desk)
        assert floor.viewport.zoom == ZOOMS[2]
        assert floor._frame is not None
        column, row = floor._frame.at(0.2, 2.0)  # the kitchen, where the cursor is
        assert column / floor._frame.columns == pytest.approx(0.5, abs=0.05)
        assert row / floor._frame.rows == pytest.approx(0.5, abs=0.05)
        await desk.press("minus")
        assert floor.viewport.zoom == ZOOMS[1]
        await desk.press("plus", "plus", "0")
        assert floor.viewport == Viewport()


async def test_who_leaves_the_map_sees_what_was_shown_before_unless_it_follows_the_robot() -> None:
    async with console() as desk:
        floor = view(desk)
        await desk.press("m", "tab", "tab", "plus", "plus", "plus", "plus")
        assert floor._frame is not None
        assert floor._frame.cell(-1.35, 0.05) is None, "the robot is out of sight"
        await desk.press("m")
        assert floor.viewport == Viewport()
        await desk.press("m", "f", "plus", "slash")
        assert floor.viewport.follows
        assert floor.viewport.zoom > 1


async def test_a_robot_that_is_nowhere_is_neither_followed_nor_pointed_at() -> None:
    async with console(ScriptedEngine(robot=robot_at(math.nan, math.nan, math.nan), floor=FLAT)) as desk:
        await desk.press("m", "f", "plus", "h", "f", "tab")
        assert not view(desk).viewport.follows
        assert desk.app.acting("map_follow") is None


@pytest.mark.parametrize("robot", [None, robot_at(math.nan, math.nan, math.nan)])
async def test_where_nobody_knows_where_the_robot_is_the_map_offers_to_go_nowhere(robot: RobotState | None) -> None:
    async with console(engine()) as desk:
        await desk.press("m", "tab", "enter")
        assert "Go to the kitchen?" in desk.text
        desk.engine.robot = robot
        desk.app.redraw()
        await desk.until(lambda: "Go to the kitchen?" not in desk.text)
        await desk.press("tab")
        assert desk.app.acting("map_go") is None
        assert "enter goes" not in desk.text
        assert "nobody knows where the robot is" in desk.text
        await desk.press("enter", "enter")
        await desk.pilot.click(FloorView, offset=(20, 5))
        await desk.settled()
        assert "Go to " not in desk.text
        assert desk.engine.sent == []
        desk.engine.robot = HERE
        desk.app.redraw()
        await desk.press("tab", "enter")
        assert "Go to " in desk.text


@pytest.mark.parametrize(
    ("keys", "dx", "dy"),
    [
        (("shift+left", "h"), -1, 0),
        (("shift+right", "l"), 1, 0),
        (("shift+up", "k"), 0, 1),
        (("shift+down", "j"), 0, -1),
    ],
)
async def test_shift_and_arrows_and_hjkl_shift_the_map(keys: tuple[str, str], dx: int, dy: int) -> None:
    async with console() as desk:
        await desk.press("m", "plus", "plus", "plus", "plus")
        floor = view(desk)
        for key in keys:
            before = floor._frame
            assert before is not None
            await desk.press(key)
            after = floor._frame
            assert after is not None
            assert (after.left - before.left) * dx >= 0
            assert (after.top - before.top) * dy >= 0
            assert (after.left, after.top) != (before.left, before.top)


async def test_f_goes_along_with_the_robot_until_the_map_is_shifted() -> None:
    async with console() as desk:
        await desk.press("m", "f")
        floor = view(desk)
        assert floor.viewport.follows
        desk.engine.robot = robot_at(3.0, 2.0, 0.0)
        desk.engine.publish(moved(3.0, 2.0))
        await desk.settled()
        assert floor._frame is not None
        assert floor._frame.cell(3.0, 2.0) is not None
        await desk.press("h")
        assert not floor.viewport.follows
        await desk.press("f", "f")
        assert not floor.viewport.follows


async def test_after_the_mouse_the_keys_that_the_map_names_are_those_that_act() -> None:
    async with console(engine()) as desk:
        await desk.press("m")
        floor = view(desk)
        assert "f follows" in desk.text
        await desk.click("kitchen")
        assert "any other key: no" in desk.text
        assert "f follows" not in desk.text, "any key but the answer is a no"
        await desk.press("escape")
        for _ in ZOOMS:
            floor.post_message(scrolled_up(floor, 3, 3))
        await desk.until(lambda: floor.viewport.zoom == ZOOMS[-1])
        await desk.until(lambda: "+" not in desk.text.splitlines()[floor.region.bottom])


@pytest.mark.parametrize("key", ["q", "e", "d", "y", "m", "2", "tab", "up"])
async def test_any_key_but_the_answer_is_a_no_and_nothing_else(key: str) -> None:
    async with console(engine()) as desk:
        await desk.press("m", "tab", "enter")
        assert "any other key: no" in desk.text
        assert "q quit" not in desk.text
        pointed = view(desk).pointed
        await desk.press(key)
        assert "any other key: no" not in desk.text
        assert desk.app.screen is desk.app.main
        assert (view(desk).has_focus, view(desk).pointed) == (True, pointed)
        assert desk.engine.sent == []
        await desk.press("enter")
        assert "any other key: no" in desk.text


async def test_a_click_points_and_asks_and_a_click_on_the_question_goes() -> None:
    async with console(engine(RED)) as desk:
        floor = view(desk)
        assert floor._frame is not None
        row, column = floor._frame.cell(*RED.position[:2]) or (0, 0)
        await desk.pilot.click(FloorView, offset=(column, row))
        await desk.settled()
        assert "Go to the red box?" in desk.text
        assert desk.engine.sent == []
        await desk.pilot.click(FloorView, offset=(5, floor.size.height - 1))
        await desk.settled()
        assert desk.engine.sent == [Say("go to the red box")]


@pytest.mark.parametrize("pointer", [(10, 5), (3, 3), (40, 12)])
async def test_the_wheel_looks_closer_at_what_is_under_the_pointer(pointer: tuple[int, int]) -> None:
    async with console() as desk:
        floor = view(desk)
        assert floor._frame is not None
        spot = (
            floor._frame.left + pointer[0] * floor._frame.cell_width,
            (floor._frame.top - pointer[1] * floor._frame.cell_height),
        )
        for zoom in ZOOMS[1:]:
            floor.post_message(scrolled_up(floor, *pointer))
            await desk.settled()
            assert floor.viewport.zoom == zoom
            column, row = floor._frame.at(*spot)
            assert abs(column - pointer[0]) <= 2
            assert abs(row - pointer[1]) <= 2, "it stays under the pointer"
        before = floor.viewport
        floor.post_message(scrolled_up(floor, *pointer))
        await desk.settled()
        assert floor.viewport == before, "it cannot be closer"


async def test_the_map_keys_can_be_others() -> None:
    async with console(keymap={"map": "v", "map_nearer": "z"}) as desk:
        await desk.press("v", "z")
        assert view(desk).viewport.zoom == ZOOMS[1]


# What is drawn


def test_walls_that_the_lidar_sees_are_lit_and_what_is_not_on_the_map_is_dots() -> None:
    frame = fit(FLAT, 55, 22)
    plan = draw(FLAT, {}, frame)
    scan = scanned(FLAT, HERE)
    seen, loose = hits(replace(scan, ranges=np.where(scan.angles < 0.1, 1.7, scan.ranges)), HERE, FLAT)
    cells = overlay(Moving(seen=seen, loose=loose), frame, plan)
    lit = [at for at, cell in cells.items() if "seen" in (cell.ink, cell.ground)]
    assert len(lit) > 20
    assert all(cells[at].char == plan[at[0]][at[1]].char for at in lit), "a wall stays a wall"
    carton = frame.cell(1.0, 0.2)
    assert carton is not None
    assert cells[carton].ink == "scan"
    assert 0x2800 < ord(cells[carton].char) <= 0x28FF


def test_what_matters_more_hides_what_matters_less() -> None:
    frame = fit(FLAT, 55, 22)
    plan = draw(FLAT, PLACES, frame)
    spot = RED.position[:2]
    at = frame.cell(*spot)
    assert at is not None
    along = ((spot[0] - 1, spot[1]), (spot[0] + 1, spot[1]))
    robot = robot_at(*spot, 0.0)
    layers = [
        ("trail", Moving(trail=along)),
        ("scan", Moving(trail=along, loose=(spot,))),
        ("path", Moving(trail=along, loose=(spot,), path=along)),
        ("thing", Moving(trail=along, loose=(spot,), path=along, things=(RED,))),
        ("robot", Moving(robot, trail=along, loose=(spot,), path=along, things=(RED,))),
        ("cursor", Moving(robot, trail=along, loose=(spot,), path=along, things=(RED,), cursor=spot)),
    ]
    assert [overlay(moving, frame, plan)[at].ink for _, moving in layers] == [ink for ink, _ in layers]


def test_things_fade_by_steps_with_their_age() -> None:
    assert [faded(age) for age in (0, 30, 100, 1000)] == [0, 1, 2, 3]


def test_the_hand_shows_what_the_arm_does() -> None:
    assert posture(HERE) == "folded"
    assert posture(replace(HERE, joints=ARM_UP)) == "up"
    assert posture(replace(HERE, joints=ARM_DOWN)) == "out"
    frame = fit(FLAT, 110, 44)
    plan = draw(FLAT, {}, frame)

    def hand(joints: tuple[float, float, float, float, float], held: Thing | None = None) -> list[str]:
        cells = overlay(Moving(replace(HERE, joints=joints), held=held), frame, plan)
        return [cell.char for cell in cells.values() if cell.char in "◇◆"]

    assert hand(HERE.joints) == []
    assert hand(ARM_DOWN) == ["◇"]
    assert hand(HERE.joints, RED) == ["◆"]


def test_looked_at_closely_the_robot_is_as_large_as_it_is() -> None:
    near = Viewport(8.0, (-0.7, 0.2)).frame(FLAT, 110, 44)
    cells = overlay(Moving(HERE), near, draw(FLAT, {}, near))
    hull = [at for at, cell in cells.items() if cell.ink == "robot"]
    rows, columns = {row for row, _ in hull}, {column for _, column in hull}
    assert len(columns) * near.cell_width == pytest.approx(0.30, abs=2 * near.cell_width)
    assert len(rows) * near.cell_height == pytest.approx(0.24, abs=2 * near.cell_height)


def test_names_of_furniture_appear_where_there_is_room() -> None:
    near = Viewport(2.0, (3.0, -3.0)).frame(FLAT, 55, 22)
    text = "\n".join("".join(cell.char for cell in row) for row in draw(FLAT, {}, near))
    assert "bed" in text
    assert "bedroom" in text, "a room is named in what shows of it"


def test_shifting_keeps_the_raster_so_that_walls_do_not_flicker() -> None:
    whole = fit(FLAT, 55, 22)
    viewport = Viewport(3.0, (0.0, 0.0))
    frames = [viewport.within(whole)]
    for _ in range(3):
        viewport = viewport.shifted(1, 1, whole)
        frames.append(viewport.within(whole))
    for frame in frames[1:]:
        cells = (frame.left - frames[0].left) / frame.cell_width, (frame.top - frames[0].top) / frame.cell_height
        assert cells == pytest.approx((round(cells[0]), round(cells[1])), abs=1e-6)


def test_the_map_cannot_be_lost_by_shifting() -> None:
    whole = fit(FLAT, 55, 22)
    viewport = Viewport(4.0, (0.0, 0.0))
    for _ in range(100):
        viewport = viewport.shifted(1, 1, whole)
    assert viewport.centre is not None
    assert whole.left <= viewport.centre[0] <= whole.left + whole.columns * whole.cell_width
    assert not math.isnan(viewport.centre[1])


def test_people_are_on_the_map_in_the_colour_of_their_shirt() -> None:
    frame = fit(FLAT, 55, 22)
    cells = overlay(Moving(people=(ANNA,), now=200.0), frame, draw(FLAT, {}, frame))
    assert [(cell.char, cell.colour) for cell in cells.values()] == [("☻", "green")]
    later = overlay(Moving(people=(replace(ANNA, gone=True),), now=200.0), frame, draw(FLAT, {}, frame))
    assert [cell.char for cell in later.values()] == ["☺"]


# What one points at


def test_the_nearest_target_is_meant_else_the_room() -> None:
    known = targets(PLACES, (RED,), (ANNA, replace(ANNA, name=None, position=(-2.0, -0.5, 0.7))), 200.0)
    assert pointed_at(2.95, -1.5, 0.3, known, FLAT, PLACES).name == "red box"
    assert pointed_at(-2.1, 0.5, 0.3, known, FLAT, PLACES).request == "go to Anna"
    assert pointed_at(-2.0, -0.4, 0.3, known, FLAT, PLACES).about == "person, seen just now"
    assert pointed_at(0.2, 2.1, 0.3, known, FLAT, PLACES).name == "kitchen"
    assert pointed_at(4.0, 1.5, 0.3, known, FLAT, PLACES).name == "study", "a room that is a place"
    on_the_bed = pointed_at(3.5, -3.0, 0.3, known, FLAT, PLACES)
    assert (on_the_bed.about, on_the_bed.name) == ("bed (3.5, -3.0)", "")


def test_a_place_is_asked_for_in_the_language_of_its_name() -> None:
    assert Target(0, 0, "", "kitchen").request == "go to the kitchen"
    assert Target(0, 0, "", "厨房").request == "去厨房"


def test_ages_are_told_as_people_say_them() -> None:
    assert [ago(seconds) for seconds in (0, 4, 43, 59, 61, 150, 4000, math.nan)] == [
        "just now", "just now", "40 s ago", "55 s ago", "1 min ago", "2 min ago", "1 h ago", "just now",
    ]  # fmt: skip


async def test_the_trail_is_where_the_robot_has_been_in_this_task() -> None:
    async with console() as desk:
        for step in range(10):
            desk.engine.publish(moved(0.05 * step, 0.0))
        desk.engine.publish(moved(math.nan, 0.0))
        await desk.settled()
        trail = desk.app.shown.model.trail
        assert trail[0] == (0.0, 0.0)
        assert 4 <= len(trail) <= 6
        assert any(cell.ink == "trail" for cell in view(desk)._overlay.values())
        desk.engine.publish(ev.TaskEnded("asked to"))
        await desk.settled()
        assert desk.app.shown.model.trail == ()


async def test_scans_are_shown_no_oftener_than_they_can_be_sent() -> None:
    lidar = ScriptedEngine(robot=HERE, floor=FLAT, lidar=True)
    async with console(lidar) as desk:
        shown = []
        for t in (200.0, 200.1, 200.3, 200.6):
            lidar.robot = robot_at(0.3 * (t - 200), 0.0, 0.0, t=t)
            desk.engine.play(scripted.OPENING[1:2])
            await desk.settled()
            shown.append(view(desk)._moving.seen)
        assert shown[0] == shown[1] == shown[2] != shown[3]


def test_walls_are_whole_however_closely_one_looks() -> None:
    for zoom in ZOOMS:
        near = Viewport(zoom, (-1.5, 2.0)).frame(FLAT, 55, 22)
        column = (near.cell(-1.5, 2.0) or (0, 0))[1]
        rows = draw(FLAT, {}, near)
        middle = [row for row in range(22) if 1.5 < near.top - (row + 0.5) * near.cell_height < 2.5]
        assert middle
        for row in middle:
            assert any(
                "wall" in (cell.ground, cell.ink if cell.char != " " else "")
                for cell in rows[row][column - 1 : column + 2]
            )


async def test_an_arm_that_is_not_folded_is_told_in_words_too() -> None:
    async with console(engine()) as desk:
        assert "arm" not in desk.text.partition("Robot")[2].partition("Log")[0]
        desk.engine.robot = replace(HERE, joints=ARM_DOWN)
        desk.engine.publish(moved(-0.7, 0.2))
        await desk.until(lambda: "arm out" in desk.text)


async def test_the_robot_is_told_on_the_map_where_it_is() -> None:
    async with console(ScriptedEngine(robot=HERE, floor=flat())) as desk:
        await desk.press("m", "right", "p")
        (here,) = desk.engine.sent
        assert isinstance(here, Here)
        assert here.x > HERE.pose.x
        assert (here.y, here.yaw) == (pytest.approx(HERE.pose.y, abs=0.3), pytest.approx(HERE.pose.yaw))
        await desk.press("comma")
        turned = desk.engine.sent[-1]
        assert isinstance(turned, Here)
        assert (turned.x, turned.y) == (HERE.pose.x, HERE.pose.y)
        assert turned.yaw == pytest.approx(HERE.pose.yaw + TURN)


@pytest.mark.parametrize("key", ["p", "comma", "full_stop"])
async def test_why_it_is_not_there_is_said_where_one_looks(key: str) -> None:
    async with console(ScriptedEngine(robot=HERE, floor=flat()), size=(80, 24), notices=True) as desk:
        await desk.press("m", "right", key)
        desk.engine.publish(ev.Ack("here", False, "Not while it does something: stop it first."), turn=None)
        await desk.settled()
        assert "Not while it does something" in desk.text
        desk.engine.publish(ev.Ack("here", False, "That is not on the map."), turn=None)
        await desk.settled()
        assert "That is not on the map." in desk.text


# Where the robot is, and what the signs mean


@pytest.mark.parametrize(
    ("x", "y", "sign", "where"),
    [(9.0, 0.0, "▶", "right"), (-9.0, 0.0, "◀", "left"), (0.0, 9.0, "▲", "top"), (0.0, -9.0, "▼", "bottom")],
)
def test_an_arrow_at_the_edge_shows_where_the_robot_is_out_of_the_picture(
    x: float, y: float, sign: str, where: str
) -> None:
    frame = Viewport(4.0, (0.0, 0.0)).within(fit(FLAT, 40, 14))
    plan = draw(FLAT, PLACES, frame)
    (at,) = [at for at, cell in overlay(Moving(robot_at(x, y, 0.0)), frame, plan).items() if cell.char in "▶◀▲▼"]
    edges = {"right": at[1] == 39, "left": at[1] == 0, "top": at[0] == 0, "bottom": at[0] == 12}
    assert edges[where]
    assert overlay(Moving(robot_at(x, y, 0.0)), frame, plan)[at].char == sign
    inside = overlay(Moving(robot_at(0.1, 0.1, 0.0)), frame, plan)
    assert not any(cell.char in "▶◀▲▼" for cell in inside.values())


async def test_the_picture_that_was_there_before_pointing_is_there_again_afterwards() -> None:
    async with console(engine()) as desk:
        before = view(desk).viewport
        await desk.press("m", "plus", "plus", "shift+left")
        assert view(desk).viewport != before
        await desk.press("m")
        assert view(desk).viewport == before


async def test_following_goes_on_when_pointing_ends_and_ends_where_somebody_shifts_the_picture() -> None:
    async with console(engine()) as desk:
        await desk.press("m", "f", "m")
        assert view(desk).viewport.follows
        desk.engine.robot = robot_at(3.0, 2.0, 0.0)
        desk.app.drawing.ask()
        await desk.settled()
        frame = view(desk)._frame
        assert frame is not None
        assert frame.cell(3.0, 2.0) is not None
        await desk.press("m", "h")
        assert not view(desk).viewport.follows


async def test_the_map_says_whether_the_key_makes_it_follow_or_stay() -> None:
    async with console(engine()) as desk:
        await desk.press("m")
        assert "f follows" in desk.text
        await desk.press("f")
        assert "f stays" in desk.text
        assert "f follows" not in desk.text


async def test_the_legend_says_what_the_signs_mean_and_who_and_what_was_seen_where_and_when() -> None:
    scene = ScriptedEngine(robot=HERE, floor=FLAT, seen=World((RED,), people=(ANNA,)))
    async with console(scene) as desk:
        await desk.press("m", "z")
        assert "seen long ago" not in desk.text
        await desk.press("L")
        for words in ("the robot and its heading", "☻ a person", "B living room", "Anna · living room · just now",
                      "red box · bedroom · 2 min ago"):  # fmt: skip
            assert words in desk.text, words
        for words in ("its way ahead", "its way so far", "the hand holds"):
            assert words not in desk.text, "nothing of that kind is in the picture"
        await desk.press("L")
        assert "the robot and its heading" not in desk.text


async def test_the_legend_has_a_line_for_every_sign_in_the_picture_and_no_two_kinds_share_one() -> None:
    bottle = replace(RED, kind="bottle", colour="green")
    scene = ScriptedEngine(robot=HERE, floor=FLAT, seen=World((RED, bottle), people=(ANNA,)))
    async with console(scene) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("m", "z", "L")
        floor = view(desk)
        assert floor._legend is not None
        listed = {entry.sign.char for row in floor._legend for entry in row}
        shown = {cell.char for row in floor._cells for cell in row if cell.ink == "place"}
        shown |= {cell.char for cell in floor._overlay.values() if cell.ink in ("thing", "hand", "robot")} - {" "}
        assert shown <= listed
        assert "its way ahead" in desk.text
    assert len({person_sign(ANNA, 0.0), thing_sign(RED, 0.0), thing_sign(bottle, 0.0), TRAIL}) == 4


async def test_pointing_into_a_room_tells_and_shows_where_the_robot_would_go() -> None:
    async with console(engine()) as desk:
        await desk.press("m", "z")
        floor = view(desk)
        living = next(place for place in PLACES.values() if place.name == "living room")
        floor._point((living.position.x + 0.9, living.position.y - 0.9))
        await desk.settled()
        target = floor.pointed
        assert target is not None
        assert target.goal is not None
        assert target.goal[:2] == (living.position.x, living.position.y)
        assert f"· enter goes to {target.goal[2]}" in desk.text
        assert floor._frame is not None
        at = floor._frame.cell(living.position.x, living.position.y)
        assert at is not None
        assert floor._overlay[at].ink == "cursor", "it is marked"
        await desk.press("enter")
        assert "Go to the living room? enter: yes" in desk.text


# While the emergency stop is pressed


async def press(desk: Desk, *, estop: bool) -> None:
    """The robot has its emergency stop pressed from now on, or released."""
    desk.engine.robot = replace(HERE, estop=estop)
    desk.app.redraw()
    await desk.until(lambda: bool(desk.app.shown.standstill) is estop)


async def test_while_the_emergency_stop_is_pressed_the_map_asks_nobody_whether_to_go_and_says_why() -> None:
    async with console(engine()) as desk:
        await press(desk, estop=True)
        await desk.press("m", "tab")
        caption = next(line for line in desk.text.splitlines() if "kitchen" in line and "releases" in line)
        assert "nothing moves; ctrl+o releases" in caption
        assert "enter goes" not in desk.text
        await desk.press("enter", "enter")
        assert "Go to the kitchen?" not in desk.text
        assert desk.engine.sent == []
        await press(desk, estop=False)
        assert "enter goes there" in desk.text
        await desk.press("enter", "enter")
        assert desk.engine.sent == [Say("go to the kitchen")]


async def test_a_question_whether_to_go_falls_with_the_emergency_stop() -> None:
    async with console(engine()) as desk:
        await desk.press("m", "tab", "enter")
        assert "Go to the kitchen?" in desk.text
        await press(desk, estop=True)
        assert "Go to the kitchen?" not in desk.text
        await desk.press("enter")
        await press(desk, estop=False)
        await desk.press("x")
        assert desk.engine.sent == []
