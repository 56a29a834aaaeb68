"""The console looks as it looked: every picture of the README is compared here, character by character.

After a change that is meant: ``pytest tests/tui/test_pictures.py --snapshot-update``, then
``python -m tests.tui.pictures``, and look at what came out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from syrupy.assertion import SnapshotAssertion

from engine.handle import PartStatus
from engine.perception.memory import Thing, World
from engine.robot.arm import ARM_DOWN
from tests.tui import conversation, scripted
from tests.tui.desk import console
from tests.tui.house import offer
from tests.tui.scripted import PARTS_LOADING, PARTS_READY, PATH, ScriptedEngine, Step, flat, robot_at, sight_of
from tui.widgets.camera import CameraView

pytestmark = pytest.mark.filterwarnings("ignore:\\s*Can not relate snapshot")  # pictures are named by what they show

SIZES = [(120, 40), (80, 24)]
HOME = robot_at(*PATH[0], 0.9)
UNDER_WAY = robot_at(-1.35, 0.05, 0.4, speed=0.5)
REACHING = replace(robot_at(-1.35, 0.05, 0.4, t=200.0, speed=0.5), joints=ARM_DOWN)
IN_THE_KITCHEN = robot_at(0.2, 2.0, 3.14)
THINGS = (
    Thing(1, "box", "red", None, (-2.9, 1.75, 0.16), 0.01, (0.04, 0.04), 0.14, None, seen_at=190.0),
    Thing(2, "bottle", "green", None, (-3.9, -0.9, 0.07), 0.01, (0.06, 0.15), 0.0, None, seen_at=195.0),
    Thing(3, "ball", "orange", None, (-2.2, -1.2, 0.03), 0.01, (0.06, 0.06), 0.0, None, seen_at=100.0),
    Thing(4, "box", "yellow", None, (2.3, 1.5, 0.16), 0.01, (0.04, 0.04), 0.14, None, seen_at=20.0),
)
BLUE_CUP = Thing(5, "cup", "blue", None, (0.0, 0.0, 0.04), 0.01, (0.06, 0.08), 0.0, None, seen_at=198.0)
LOOKS = {
    "map": ("m", "shift+tab"),
    "map_near": ("m", "tab", "plus", "plus", "enter"),
    "camera": ("c",),
    "queue": (),
    "waiting": ("3", "down"),
}
"""What is pressed before the picture is taken."""
SCENES = {
    "start": (ScriptedEngine(parts=PARTS_LOADING, robot=HOME, floor=flat()), scripted.OPENING[:2]),
    "listening": (ScriptedEngine(robot=HOME, floor=flat()), scripted.listening()),
    "acting": (ScriptedEngine(robot=UNDER_WAY, floor=flat()), scripted.acting()),
    "done": (ScriptedEngine(robot=IN_THE_KITCHEN, floor=flat()), scripted.done()),
    "tidying": (
        ScriptedEngine(
            robot=robot_at(-1.35, 0.05, 0.4, t=200.0, speed=0.5), floor=flat(), seen=World(THINGS, BLUE_CUP)
        ),
        scripted.tidying(),
    ),
    "map": (
        ScriptedEngine(robot=REACHING, floor=flat(), seen=World(THINGS), lidar=True),
        scripted.driving(),
    ),
    "map_near": (
        ScriptedEngine(robot=REACHING, floor=flat(), seen=World(THINGS), lidar=True),
        scripted.driving(),
    ),
    "camera": (
        ScriptedEngine(robot=REACHING, floor=flat(), seen=World(THINGS), lidar=True),
        scripted.driving(),
    ),
    "queue": (ScriptedEngine(robot=UNDER_WAY, floor=flat()), scripted.queueing()),
    "waiting": (ScriptedEngine(robot=UNDER_WAY, floor=flat()), scripted.waiting()),
    "stopped": (ScriptedEngine(robot=HOME, floor=flat()), scripted.stopped()),
    "error": (
        ScriptedEngine(
            parts=(PartStatus("robot", "failed", "The robot process does not answer."), *PARTS_READY[1:]),
            robot=robot_at(-1.35, 0.05, 0.4),
            floor=flat(),
        ),
        scripted.failed(),
    ),
}


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
@pytest.mark.parametrize("scene", SCENES)
async def test_a_scene_looks_as_in_its_picture(
    scene: str, size: tuple[int, int], screenshot: SnapshotAssertion
) -> None:
    prepared, steps = SCENES[scene]
    engine = ScriptedEngine(parts=prepared.parts, robot=prepared.robot, floor=prepared.floor, seen=prepared.seen)
    engine.lidar, engine.on_look = prepared.lidar, lambda deliver: deliver(sight_of())
    await _compare(engine, steps, size, scene, screenshot, LOOKS.get(scene, ()))


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_the_turns_look_as_in_their_picture(size: tuple[int, int], screenshot: SnapshotAssertion) -> None:
    engine = ScriptedEngine(robot=IN_THE_KITCHEN, floor=flat())
    async with console(engine, size=size) as desk:
        conversation.play(engine, conversation.ALL)
        if size == (80, 24):
            await desk.press("t")
        assert await desk.picture() == screenshot(name=f"turns_{size[0]}x{size[1]}")


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_a_whole_turn_looks_as_in_its_picture(size: tuple[int, int], screenshot: SnapshotAssertion) -> None:
    engine = ScriptedEngine(robot=IN_THE_KITCHEN, floor=flat())
    async with console(engine, size=size) as desk:
        conversation.play(engine, conversation.ALL)
        await desk.press("enter")
        assert await desk.picture() == screenshot(name=f"turn_{size[0]}x{size[1]}")


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_what_was_not_heard_looks_as_in_its_picture(size: tuple[int, int], screenshot: SnapshotAssertion) -> None:
    engine = ScriptedEngine(robot=IN_THE_KITCHEN, floor=flat())
    async with console(engine, size=size) as desk:
        conversation.play(engine, [conversation.SPOKEN, conversation.UNHEARD])
        assert await desk.picture() == screenshot(name=f"not_heard_{size[0]}x{size[1]}")


PANES = {
    "focus_120x40": ("3",),
    "zoom_120x40": ("6", "z"),
    "zoom_80x24": ("3", "z"),
    "zoom_map_80x24": ("4", "z"),
    "log_80x24": ("5",),
    "narrow_60x24": (),
    "narrow_map_60x24": ("4",),
    "narrow_turns_60x24": ("6",),
}
"""What is pressed to arrange the panes, by picture and size."""


@pytest.mark.parametrize("picture", PANES)
async def test_an_arrangement_of_the_panes_looks_as_in_its_picture(picture: str, screenshot: SnapshotAssertion) -> None:
    columns, rows = map(int, picture.rpartition("_")[2].split("x"))
    engine = ScriptedEngine(robot=UNDER_WAY, floor=flat())
    async with console(engine, size=(columns, rows)) as desk:
        if picture == "zoom_120x40":
            conversation.play(engine, conversation.ALL)
        else:
            engine.play(scripted.queueing())
        await desk.press(*PANES[picture])
        assert await desk.picture() == screenshot(name=picture)


PANELS = {
    "palette": ("ctrl+p",),
    "palette_found": ("ctrl+p", *"turn"),
    "form": ("ctrl+p", *"carry", "enter", "r", "e", "d", "tab", "tab", *"kit"),
}
"""What is pressed to have a panel over the console."""


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
@pytest.mark.parametrize("panel", PANELS)
async def test_a_panel_looks_as_in_its_picture(
    panel: str, size: tuple[int, int], screenshot: SnapshotAssertion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", "/home/me/.config/sayso")
    engine = ScriptedEngine(robot=UNDER_WAY, floor=flat())
    engine.offers = offer()
    await _compare(engine, scripted.acting(), size, panel, screenshot, PANELS[panel])


async def test_a_terminal_that_is_too_small_says_so(screenshot: SnapshotAssertion) -> None:
    await _compare(ScriptedEngine(), scripted.acting(), (40, 10), "too_small", screenshot)


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_the_help_page_looks_as_in_its_picture(size: tuple[int, int], screenshot: SnapshotAssertion) -> None:
    async with console(size=size) as desk:
        await desk.press("question_mark")
        assert await desk.picture() == screenshot(name=f"help_{size[0]}x{size[1]}")


async def test_the_light_theme_looks_as_in_its_picture(screenshot: SnapshotAssertion) -> None:
    engine = ScriptedEngine(robot=UNDER_WAY, floor=flat())
    async with console(engine, theme="sayso-light", in_line=True) as desk:
        engine.play(scripted.acting())
        assert await desk.picture() == screenshot(name="acting_light_120x40")


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_the_theme_of_high_contrast_looks_as_in_its_picture(
    size: tuple[int, int], screenshot: SnapshotAssertion
) -> None:
    engine = ScriptedEngine(robot=UNDER_WAY, floor=flat())
    async with console(engine, size=size, theme="sayso-contrast", in_line=True) as desk:
        engine.play(scripted.queueing())
        assert await desk.picture() == screenshot(name=f"queue_contrast_{size[0]}x{size[1]}")


async def _compare(
    engine: ScriptedEngine,
    steps: list[Step],
    size: tuple[int, int],
    name: str,
    screenshot: SnapshotAssertion,
    keys: Sequence[str] = (),
) -> None:
    async with console(engine, size=size, in_line=not keys) as desk:
        engine.play(steps)
        await desk.settled()
        await desk.press(*keys)
        camera = desk.app.query_one(CameraView)
        if camera.display and name == "camera":  # as sharp as it gets, however many pictures came
            await desk.until(lambda: camera.marks)
            await desk.until(lambda: not camera.show_sight(sight_of()))
        assert await desk.picture() == screenshot(name=f"{name}_{size[0]}x{size[1]}")
