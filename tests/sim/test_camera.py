"""Pictures of the simulated camera: what they show is where it is, with either backend, and they are of now."""

from __future__ import annotations

import asyncio
import math
import os
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest

from config.schema import Camera as CameraSettings
from engine.errors import CameraError
from engine.robot.arm import ARM_INITIAL, Joints
from engine.robot.camera import Picture, Points
from engine.robot.camera_news import CameraNews, GivenUp, Opened
from engine.robot.geometry import Pose, Twist
from engine.robot.host.memory import Memory
from engine.robot.sim.camera import SimCamera
from engine.robot.sim.colours import rgba
from engine.robot.sim.robot import SimRobot
from engine.robot.sim.scene_file import scene_path
from engine.robot.sim.textures import TAG_CELLS, tag_cells
from tests.sim.eye import Eye
from tests.sim.rig import running

BACKENDS = ("rays", "opengl")
LOOKING_DOWN: Joints = (0.0, -0.3, 1.5, 1.5, 0.0)
LOOKING_LEFT: Joints = (0.9, -1.0, 1.9, 1.1, 0.0)
DEADLINE_S = 60.0


class Darkroom:
    """A camera whose robot is a test: the memory holds the states that the test puts there."""

    def __init__(self, backend: str, width: int = 160, height: int = 120) -> None:
        self.eye = Eye("flat")
        self.news: list[CameraNews] = []
        self.memory = Memory.create()
        settings = CameraSettings.model_validate({"backend": backend, "width": width, "height": height})
        self.camera = SimCamera(scene_path("flat"), settings, self.memory, self.news.append)

    async def look(
        self, pose: Pose, joints: Joints = ARM_INITIAL, believed: Pose | None = None, *, labels: bool = False
    ) -> Picture:
        """A picture from where the robot is, with the things where ``eye`` has them."""
        self.eye.look(pose, joints)
        state = self.memory.state
        state.scratch["t"] += 0.02
        where = believed or pose
        state.scratch["pose"], state.scratch["joints"] = (where.x, where.y, where.yaw), joints
        state.scratch["qpos"][: self.eye.model.nq] = self.eye.data.qpos
        state.put()
        async with asyncio.timeout(DEADLINE_S):
            return await self.camera.look(labels=labels)


@asynccontextmanager
async def darkroom(backend: str, **size: int) -> AsyncIterator[Darkroom]:
    """A camera of this kind, or the test is skipped where there is none."""
    room = Darkroom(backend, **size)
    try:
        try:
            await room.look(Pose(0, 0, 0))
        except CameraError as error:
            if backend == "rays":
                raise
            pytest.skip(f"no OpenGL here: {error.message}")
        yield room
    finally:
        await room.camera.close()
        os.close(room.memory.fd)


def with_a_robot(test: Callable[[SimRobot], Awaitable[None]], **changes: object) -> None:
    """Run ``test`` with a robot in the hall."""

    async def run() -> None:
        async with running(**changes) as robot, asyncio.timeout(DEADLINE_S):
            await robot.tick()
            await test(robot)

    asyncio.run(run())


def around(pose: Pose, point: tuple[float, float, float]) -> Points:
    """A point of the map in the base frame of a robot that is at ``pose``."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = point[0] - pose.x, point[1] - pose.y
    return np.array([[c * x + s * y, c * y - s * x, point[2]]])


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_thing_appears_where_it_is_in_its_colour_and_at_its_distance(backend: str) -> None:
    radius = 0.03
    colour = np.array(rgba("orange")[:3])
    views: list[tuple[Pose, Joints, tuple[float, float, float]]] = [  # the ball ahead, to the left, above the floor
        (Pose(0, 0, 0), ARM_INITIAL, (0.45, 0.0, 0.2)),
        (Pose(0, 0, 0), ARM_INITIAL, (1.2, -0.2, 0.1)),
        (Pose(0, 0, 0), LOOKING_DOWN, (0.3, 0.03, 0.0)),
        (Pose(-0.3, 0.2, 0.0), LOOKING_LEFT, (0.5, 0.6, 0.05)),
        (Pose(0.4, 0.1, math.pi), ARM_INITIAL, (0.8, 0.1, 0.15)),
        (Pose(0.2, -0.3, 0.8), LOOKING_DOWN, (0.32, -0.04, 0.0)),
    ]

    async def run() -> None:
        async with darkroom(backend) as room:
            for pose, joints, (ahead, left, up) in views:
                c, s = math.cos(pose.yaw), math.sin(pose.yaw)
                x, y = pose.x + c * ahead - s * left, pose.y + s * ahead + c * left
                room.eye.put("ball", x, y, up)
                picture = await room.look(pose, joints, labels=True)
                middle = around(pose, (x, y, up + radius))
                [[column, row]] = picture.pixels(middle)
                assert 0 <= column < 160, "the view has the ball in it"
                assert 0 <= row < 120, "the view has the ball in it"
                at = int(row), int(column)
                seen = picture.rgb[at] / 255.0
                assert seen @ colour / np.linalg.norm(seen) / np.linalg.norm(colour) > 0.985, (pose, joints, seen)
                [into] = picture.mount.into(middle)
                nearest = into[2] * (1 - radius / np.linalg.norm(into))
                assert picture.depth[at] == pytest.approx(nearest, abs=0.01), (pose, joints)
                assert picture.labels is not None
                assert picture.labels[at] == room.eye.model.geom("ball").id
                mask = picture.labels == room.eye.model.geom("ball").id
                surface = picture.points(mask)
                assert np.linalg.norm(surface - middle, axis=1) == pytest.approx(radius, abs=0.003)

    asyncio.run(run())


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_only_the_eye_meets_is_seen_as_well_as_what_collides(backend: str) -> None:
    async def run() -> None:
        async with darkroom(backend) as room:
            room.eye.put("bottle", 0.7, 0.0, 0.0)
            picture = await room.look(Pose(0, 0, 0), labels=True)
            model = room.eye.model
            parts = np.flatnonzero(model.geom_bodyid == model.body("bottle").id)
            assert len(parts) == 4, "the body, a neck, a cap and a label"
            assert picture.labels is not None
            shown = [picture.points(picture.labels == part) for part in parts]
            assert min(len(points) for points in shown) > 3
            assert max(points[:, 2].max() for points in shown) == pytest.approx(0.15, abs=0.01)

    asyncio.run(run())


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_tag_is_upright_and_not_mirrored_on_every_side(backend: str) -> None:
    size, pose = 0.045, Pose(0, 0, 0)
    code = tag_cells(1)
    cells = (np.arange(TAG_CELLS) + 0.5) / TAG_CELLS - 0.5

    async def run() -> None:
        async with darkroom(backend, width=320, height=240) as room:
            for quarter in range(4):
                room.eye.put("block 1", 0.4, 0.0, 0.15, quarter * math.pi / 2)
                picture = await room.look(pose)
                # The face towards us: to the right on it is −y, up on it is z.
                face = [
                    (0.4 - size / 2, -right * size, 0.15 + size / 2 - down * size) for down in cells for right in cells
                ]
                pixels = picture.pixels(np.array(face)).astype(int)
                bright = picture.rgb[pixels[:, 1], pixels[:, 0]].mean(axis=1).reshape(TAG_CELLS, TAG_CELLS)
                assert ((bright > (bright.min() + bright.max()) / 2) == code).mean() > 0.97, quarter
            room.eye.put("block 1", 0.35, 0.0, 0.0)
            above = await room.look(pose, LOOKING_DOWN)
            # On top, to the right on it is x, up on it is y.
            face = [(0.35 + right * size, -down * size, size) for down in cells for right in cells]
            pixels = above.pixels(np.array(face)).astype(int)
            bright = above.rgb[pixels[:, 1], pixels[:, 0]].mean(axis=1).reshape(TAG_CELLS, TAG_CELLS)
            assert ((bright > (bright.min() + bright.max()) / 2) == code).mean() > 0.97

    asyncio.run(run())


def test_both_backends_see_the_same() -> None:
    views = [(Pose(0, 0, 0), ARM_INITIAL), (Pose(0.4, 0.1, 2.0), ARM_INITIAL), (Pose(0, 0, -0.7), LOOKING_DOWN)]

    async def run() -> None:
        async with darkroom("opengl") as opengl, darkroom("rays") as rays:
            for pose, joints in views:
                one = await opengl.look(pose, joints, labels=True)
                other = await rays.look(pose, joints, labels=True)
                assert one.labels is not None
                assert other.labels is not None
                same = one.labels == other.labels
                assert same.mean() > 0.99
                shown = same & np.isfinite(one.depth)
                assert np.abs(one.depth[shown] - other.depth[shown]).max() < 0.002
                assert np.abs(one.rgb[shown].astype(int) - other.rgb[shown]).mean() < 10

    asyncio.run(run())


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_same_state_gives_the_same_picture_with_the_pose_that_the_robot_believes_in(backend: str) -> None:
    believed = Pose(0.1, -0.2, 0.3)

    async def run() -> None:
        async with darkroom(backend) as room:
            first = await room.look(Pose(0, 0, 0), believed=believed)
            await room.look(Pose(0.5, 0, 1.0))
            again = await room.look(Pose(0, 0, 0), believed=believed)
            assert again.t > first.t
            assert again.pose == first.pose == believed
            assert np.array_equal(again.rgb, first.rgb)
            assert np.array_equal(again.depth, first.depth)
            assert again.labels is None, "nobody asked for them"

    asyncio.run(run())


@pytest.mark.parametrize(
    "library", ["raise ImportError('broken')", "import os; os.abort()"], ids=["missing", "crashes"]
)
def test_without_opengl_rays_are_cast_and_that_is_told_once(
    library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "OpenGL").mkdir()
    (tmp_path / "OpenGL" / "__init__.py").write_text(library)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    async def run() -> None:
        async with darkroom("auto") as room:
            opened = [news for news in room.news if isinstance(news, Opened)]
            assert [news.detail for news in opened] == ["rays 160×120"]
            assert "OpenGL cannot be used" in opened[0].note
        broken = Darkroom("opengl")
        try:
            with pytest.raises(CameraError, match="camera process"):
                await broken.look(Pose(0, 0, 0))
            assert isinstance(broken.news[-1], GivenUp)
        finally:
            await broken.camera.close()
            os.close(broken.memory.fd)

    asyncio.run(run())


def test_at_full_speed_no_time_passes_while_a_picture_is_taken() -> None:
    async def test(robot: SimRobot) -> None:
        async def let_time_pass() -> None:
            while True:
                await robot.tick()

        passing = asyncio.create_task(let_time_pass())
        for _ in range(5):
            before = (await robot.tick()).t
            picture = await robot.look()
            assert before == picture.t == robot.state().t
        passing.cancel()

    with_a_robot(test, camera={"backend": "rays", "width": 160, "height": 120})


def test_pictures_are_taken_in_the_order_of_asking_and_each_is_the_askers_own() -> None:
    async def test(robot: SimRobot) -> None:
        await robot.look()
        order: list[int] = []

        async def look(number: int) -> Picture:
            picture = await robot.look()
            order.append(number)
            return picture

        pictures = await asyncio.gather(*(look(number) for number in range(4)))
        assert order == [0, 1, 2, 3]
        assert len({id(picture.rgb) for picture in pictures}) == 4

    with_a_robot(test)


def test_whoever_gives_up_on_a_picture_does_not_leave_it_to_the_next() -> None:
    async def test(robot: SimRobot) -> None:
        await robot.look()
        for _ in range(5):
            looking = asyncio.create_task(robot.look())
            await asyncio.sleep(0)  # it has asked by now
            looking.cancel()
            now = await robot.tick()
            assert (await robot.look()).t == now.t
            assert looking.cancelled()

    with_a_robot(test)


def test_what_moves_is_seen_where_it_has_moved_to() -> None:
    async def test(robot: SimRobot) -> None:
        before = await robot.look()
        for _ in range(25):
            robot.drive(Twist(0, 0, 1.0), 1)
            await robot.tick()
        after = await robot.look()
        assert after.pose == robot.state().pose != before.pose
        assert not np.array_equal(after.rgb, before.rgb)
        assert np.allclose(after.mount.position, robot.arm.camera(robot.state().joints).position)

    with_a_robot(test)
