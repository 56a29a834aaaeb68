"""What the camera sees, on a terminal: only while somebody looks, and no more than a slow line can bear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.errors import CameraError, SaysoError
from engine.perception.sighting import Sight
from tests.tui.desk import Desk, console
from tests.tui.paper import CELL
from tests.tui.scripted import ScriptedEngine, flat, robot_at, sight_of
from tui.graphics.asking import Graphics
from tui.graphics.surface import Surface
from tui.graphics.tiles import Extent, afforded, changed, cost, extent, frames, runs, settled, shrunk, total
from tui.messages import CameraChoice
from tui.rooms.portrait import portrait
from tui.terminal.feed import BYTES_PER_S, CALM_S, FASTEST_S, pause
from tui.terminal.terminal import over_ssh
from tui.widgets.camera import CameraView

SIGHT = sight_of()
RNG = np.random.default_rng(1)


def looking(found: Sight | SaysoError = SIGHT) -> ScriptedEngine:
    """An engine whose camera shows this, whenever it is asked."""
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    engine.on_look = lambda deliver: deliver(found)
    return engine


def view(desk: Desk) -> CameraView:
    return desk.app.screen_stack[0].query_one(CameraView)


def of(rgb: NDArray[np.uint8]) -> Sight:
    return replace(SIGHT, picture=replace(SIGHT.picture, rgb=rgb), objects=())


# While somebody looks


async def test_nobody_looks_and_the_camera_is_not_asked() -> None:
    async with console(looking()) as desk:
        await desk.settled()
        assert desk.engine.looks == []
        assert not view(desk).display or not view(desk).size.width


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (160, 50)])
async def test_c_shows_the_camera_with_names_on_what_is_recognised_and_c_hides_it(size: tuple[int, int]) -> None:
    async with console(looking(), size=size) as desk:
        await desk.press("c")
        await desk.until(lambda: "blue box" in desk.text)
        assert "▀" in desk.text
        await desk.press("c")
        await desk.until(lambda: "blue box" not in desk.text)
        asked = len(desk.engine.looks)
        for _ in range(20):
            await desk.pilot.pause()
        assert len(desk.engine.looks) == asked, "nobody looks any more"


@pytest.mark.parametrize("keys", [("enter",), ("t",), ("l",), ("m",), ("t", "z"), ("c", "t")])
async def test_c_shows_the_camera_wherever_one_is(keys: tuple[str, ...]) -> None:
    async with console(looking(), size=(80, 24)) as desk:
        await desk.press(*keys)
        assert "blue box" not in desk.text
        await desk.press("c")
        await desk.until(lambda: "blue box" in desk.text)
        await desk.press("c")
        await desk.until(lambda: "blue box" not in desk.text)
        assert desk.engine.sent == []


@pytest.mark.parametrize("graphics", [Graphics("kitty"), Graphics("sixel", CELL)])
async def test_a_saved_picture_of_the_screen_has_the_camera_also_where_the_terminal_shows_it_in_pixels(
    graphics: Graphics,
) -> None:
    async with console(looking()) as desk:
        await desk.press("c")
        await desk.until(lambda: "blue box" in desk.text)
        blocks = portrait(desk.app)
        view(desk).draw_on(Surface(graphics))
        await desk.until(lambda: "blue box" not in desk.text and view(desk).place() is not None)
        blank = desk.app.export_screenshot()
        saved = portrait(desk.app)
        assert saved.count("▀") >= blocks.count("▀") > blank.count("▀") + 50
        for words in ("READY", "blue&#160;box", "Conversation"):
            assert words in saved, words
        assert "blue box" not in desk.text  # what is on the screen stays as it is


async def test_the_next_picture_is_asked_for_when_the_last_one_has_come() -> None:
    engine = looking()
    engine.on_look = lambda deliver: None  # a camera that takes its time
    async with console(engine) as desk:
        await desk.press("c")
        for _ in range(20):
            await desk.pilot.pause()
        assert len(engine.looks) == 1
        engine.looks[0](SIGHT)
        await desk.until(lambda: len(engine.looks) == 2)


async def test_a_camera_that_shows_nothing_says_why_and_is_asked_again() -> None:
    engine = looking(CameraError("The camera process ended."))
    async with console(engine) as desk:
        await desk.press("c")
        await desk.until(lambda: "The camera process ended." in desk.text)
        engine.on_look = lambda deliver: deliver(SIGHT)
        await desk.until(lambda: "blue box" in desk.text)


async def test_on_a_small_terminal_the_map_comes_back_while_one_points_at_it() -> None:
    async with console(looking(), size=(80, 24)) as desk:
        await desk.press("c")
        await desk.until(lambda: "blue box" in desk.text)
        await desk.press("m")
        await desk.until(lambda: "kitchen" in desk.text)
        assert "blue box" not in desk.text
        await desk.press("m")
        await desk.until(lambda: "blue box" in desk.text)


async def test_the_camera_may_be_wanted_before_the_engine_is_there() -> None:
    gate: list[Callable[[], None]] = []
    engine = looking()

    def start() -> ScriptedEngine:
        import threading

        opened = threading.Event()
        gate.append(opened.set)
        opened.wait(30)
        return engine

    async with console(engine, start=start) as desk:
        await desk.pilot.press("c")
        await desk.until(lambda: gate)
        gate[0]()
        await desk.until(lambda: "blue box" in desk.text)


@pytest.mark.parametrize(
    ("choice", "size", "shown"),
    [("auto", (160, 50), True), ("auto", (120, 40), False), ("on", (80, 24), True), ("off", (160, 50), False)],
)
async def test_the_settings_say_whether_it_is_shown_from_the_start(
    choice: CameraChoice, size: tuple[int, int], shown: bool
) -> None:
    async with console(looking(), size=size) as desk:
        desk.app.dress("sayso-light", 8, camera=choice)
        await desk.until(lambda: desk.app.theme == "sayso-light")
        await desk.pilot.pause()
        assert bool(desk.engine.looks) == shown


def test_over_ssh_pictures_are_not_shown_unless_asked_for() -> None:
    assert over_ssh({"SSH_CONNECTION": "10.0.0.1 5000 10.0.0.2 22"})
    assert not over_ssh({"TERM": "xterm"})


async def test_a_picture_that_is_as_before_sends_nothing_and_noise_next_to_nothing() -> None:
    async with console(looking()) as desk:
        await desk.press("c")
        await desk.until(lambda: "blue box" in desk.text)
        sent = [view(desk).show_sight(SIGHT) for _ in range(30)]  # it becomes fine by and by
        assert sent[-1] == 0
        noise = RNG.integers(-5, 6, SIGHT.picture.rgb.shape)
        noisy = np.clip(SIGHT.picture.rgb.astype(int) + noise, 0, 255).astype(np.uint8)
        assert view(desk).show_sight(replace(SIGHT, picture=replace(SIGHT.picture, rgb=noisy))) < 200
        other = SIGHT.picture.rgb.copy()
        other[:20, :20] = (255, 0, 0)
        sent = view(desk).show_sight(replace(SIGHT, picture=replace(SIGHT.picture, rgb=other)))
        assert 0 < sent < 1500


# Pixels


def test_a_picture_keeps_its_proportions() -> None:
    assert extent(160, 120, 55, 14) == Extent(37, 14)
    assert extent(160, 120, 30, 40) == Extent(30, 11)
    assert extent(160, 120, 1, 1) == Extent(1, 1)


def test_pixels_are_the_means_of_what_they_stand_for() -> None:
    halves = np.zeros((120, 160, 3), dtype=np.uint8)
    halves[:, 80:] = 200
    small = shrunk(halves, Extent(4, 3))
    assert small.shape == (6, 4, 3)
    assert small[:, :, 0].tolist() == [[0, 0, 200, 200]] * 6
    assert shrunk(halves[:2, :3], Extent(9, 9)).shape == (18, 9, 3), "also where there are fewer than cells"


def test_colours_have_five_bits_and_stay_until_one_sees_the_difference() -> None:
    first = settled(RNG.integers(0, 256, (8, 8, 3)).astype(np.uint8), None)
    slightly = np.clip(first.astype(int) + 6, 0, 255).astype(np.uint8)
    assert (settled(slightly, first) == first).all()
    much = (255 - first.astype(int)).astype(np.uint8)
    after = settled(much, first)
    assert np.abs(after.astype(int) - much).max() <= 20
    assert len({tuple(colour) for colour in after.reshape(-1, 3).tolist()}) <= 64


def test_neighbours_that_are_nearly_alike_become_runs() -> None:
    slope = np.repeat(np.linspace(100, 140, 40)[None, :, None], 2, axis=0).repeat(3, axis=2).astype(np.uint8)
    shown = settled(slope, None)
    assert np.abs(shown.astype(int) - slope).max() <= 14
    assert cost(shown, 0, 0, 40) < cost(slope, 0, 0, 40) / 4


def test_a_picture_costs_no_more_than_it_may_and_becomes_fine_when_it_stands() -> None:
    size = Extent(37, 14)
    before = settled(shrunk(SIGHT.picture.rgb, size), None)
    after = shrunk(np.ascontiguousarray(SIGHT.picture.rgb[:, ::-1]), size)
    limit = 4000
    assert total(settled(after, before), before) > limit
    shown, errors = before, []
    for _ in range(30):
        following = afforded(after, shown, limit)
        assert total(following, shown) <= 1.3 * limit
        shown = following
        errors.append(int(np.abs(shown.astype(int) - after).max()))
    assert errors[0] > errors[-1]
    assert errors[-1] <= 16
    assert (afforded(after, shown, limit) == shown).all()


def test_changed_cells_are_sent_in_runs_and_small_gaps_are_filled() -> None:
    old = np.zeros((4, 20, 3), dtype=np.uint8)
    new = old.copy()
    new[1, [2, 4, 15]] = 99
    cells = changed(old, new)
    assert cells.tolist()[1] == [False] * 20
    assert runs(cells[0].tolist()) == [(2, 3), (15, 1)]
    assert changed(None, new).all()


def test_names_stand_beside_their_frames_and_never_over_each_other() -> None:
    marks = frames(SIGHT.objects, 160, 120, Extent(29, 11))
    rows = ["".join(marks.get((row, column), (" ", False))[0] for column in range(29)) for row in range(11)]
    text = "\n".join(rows)
    assert "blue box" in text, "the nearest has its name"
    assert "boxbox" not in text
    assert text.count("┌") >= 2
    assert all(0 <= row < 11 and 0 <= column < 29 for row, column in marks)


def test_a_frame_at_the_edge_stays_inside_the_picture() -> None:
    thing = replace(SIGHT.objects[0], box=(0, 0, 160, 120))
    assert all(0 <= row < 3 and 0 <= column < 4 for row, column in frames([thing], 160, 120, Extent(4, 3)))


# The pace


def test_what_costs_much_is_shown_less_often_and_what_is_calm_hardly_ever() -> None:
    assert pause(100, FASTEST_S) == FASTEST_S
    assert 8000 / pause(8000, FASTEST_S) <= BYTES_PER_S + 1
    waits, last = [], FASTEST_S
    for _ in range(6):
        last = pause(0, last)
        waits.append(last)
    assert waits[-1] == CALM_S
    assert waits == sorted(waits)
    assert pause(500, CALM_S) == FASTEST_S
