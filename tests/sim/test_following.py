"""Following and tracking by camera on the real physics and real pictures: what moves is kept up with, what is lost is
let go, and an interruption stops the robot wherever it is."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from config import load
from engine.epoch import Epoch
from engine.errors import CameraError
from engine.perception.memory import WorldMemory
from engine.perception.perceive import perceive
from engine.robot.camera import Picture, floor_depth
from engine.robot.geometry import Pose
from engine.robot.sim.scene import Scene
from engine.skills.context import SkillContext
from engine.skills.external.host import external_skill
from engine.skills.library import following
from engine.skills.library.accompanying import person_follow
from engine.skills.library.manipulation import pick_object
from engine.skills.outcome import Result
from engine.skills.registry import Skill
from tests.eval.gpsr.three_people import among
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import beating, running, ticks_until

BLOCK = {"block 7": {"kind": "tag_block", "at": [1.0, 0.0], "size": 0.09, "tag": 7}}
RED = {"red box": {"kind": "box", "at": [0.9, 0.0], "size": 0.06, "colour": "red"}}
TAPE = {"tape": {"colour": "blue", "width": 0.04, "points": [[-0.6, 0], [0.6, 0], [0.9, 0.3], [0.9, 1.2]]}}
TAPE_LENGTH = 1.2 + 0.3 * math.sqrt(2) + 0.9
HOME = Pose(0, 0, 0)
DEADLINE_S = 60.0
"""Of robot time."""


def hall(start: Pose = HOME, **more: Any) -> Scene:
    """A bare room of 8 × 6 m with what a test needs in it."""
    return Scene.model_validate(
        {
            "name": "hall",
            "bounds": {"x": [-4, 4], "y": [-3, 3]},
            "start": {"x": start.x, "y": start.y, "yaw": math.degrees(start.yaw)},
            "rooms": {"hall": {"x": [-4, 4], "y": [-3, 3], "floor": "plain", "colour": "#cdb08a"}},
            **more,
        }
    )


class Run:
    """One skill on a robot in hand; ``each_tick`` is told the robot time and may move things."""

    def __init__(self, scene: Scene, each_tick: Callable[[HandRobot, float], None] = lambda robot, t: None) -> None:
        self.robot = HandRobot(scene)
        self.told: list[str] = []
        self._each_tick = each_tick
        self.robot.each_tick = self._tick
        self.world = WorldMemory()

    @property
    def context(self) -> SkillContext:
        def progress(fraction: float | None, message: str = "", **more: object) -> None:
            self.told.append(message)

        return replace(context_of(self.robot, self.world), progress=progress)

    def _tick(self) -> None:
        assert self.robot.world.t < DEADLINE_S, f"it never ended: {self.told[-3:]}"
        self._each_tick(self.robot, self.robot.world.t)

    def do(self, skill: Skill, *args: Any) -> Result:
        async def run() -> Result:
            await self.robot.tick()
            return await skill.run(self.context, *args)

        return asyncio.run(run())

    def away(self, name: str) -> float:
        """From the robot's middle to a loose object, m."""
        x, y, _ = self.robot.where(name)
        pose = self.robot.world.true_pose
        return math.hypot(x - pose.x, y - pose.y)


class Walk:
    """Moves a loose object along a line and a bend, until it vanishes behind the robot's back; notes the distances."""

    def __init__(self, name: str, *, speed: float, seconds: float, turned: float = 0.0) -> None:
        self.name, self.speed, self.seconds, self.turned = name, speed, seconds, turned
        self.distances: list[float] = []

    def __call__(self, robot: HandRobot, t: float) -> None:
        if t > self.seconds:
            robot.put(self.name, -3.5, -2.5, 0.0)
            return
        way = self.speed * max(0.0, t - 2.0)
        x, y = 0.9 + way, 0.3 * math.sin(1.2 * way)
        robot.put(self.name, x, y, 0.0, self.turned)
        pose = robot.world.true_pose
        self.distances.append(math.hypot(x - pose.x, y - pose.y))


def test_a_coloured_thing_that_moves_is_followed_at_a_distance_and_let_go_when_it_is_gone() -> None:
    walk = Walk("red box", speed=0.25, seconds=7.0)
    run = Run(hall(Pose(-0.5, 0, 0), objects=RED), walk)
    result = run.do(following.color_follow, "red")
    assert (result.outcome, result.error_code) == ("failed", "target_lost")
    assert result.data["x"] == pytest.approx(0.9 + 0.25 * 5, abs=0.05)
    assert "hall" in result.message
    assert "the red thing" in result.message
    kept = np.array(walk.distances[150:])  # from 3 s on
    assert abs(float(np.median(kept)) - following.KEEP_THING) < 0.08
    assert kept.min() > 0.4
    assert kept.max() < 1.0
    assert not run.robot.state().moving
    assert any("looking for" in words for words in run.told)


def test_a_robot_backs_away_from_what_comes_near() -> None:
    seen: list[float] = []

    def come(robot: HandRobot, t: float) -> None:
        robot.put("red box", 0.9 - min(0.6, 0.1 * t), 0.0, 0.0)
        seen.append(robot.world.true_pose.x)
        if t > 7:
            raise _EnoughError

    run = Run(hall(objects=RED), come)
    with pytest.raises(_EnoughError):
        run.do(following.color_follow, "red")
    assert min(seen) < -0.2


def test_what_was_never_there_is_looked_for_and_not_found() -> None:
    run = Run(hall())
    result = run.do(following.color_follow, "red")
    assert result.error_code == "object_not_found"
    assert run.robot.world.true_pose.x == pytest.approx(0, abs=0.05)  # it has only turned


def gap(robot: HandRobot, who: str) -> float:
    """From the robot's middle to somebody who walks, m."""
    x, y = (float(robot.world.data.joint(f"{who} {axis}").qpos[0]) for axis in "xy")
    pose = robot.world.true_pose
    return math.hypot(x - pose.x, y - pose.y)


def test_a_walking_person_is_followed() -> None:
    people = {"worker": {"path": [[0.9, 0.0], [2.6, 0.5], [2.6, 1.8], [-2.0, 1.8]], "speed": 0.3}}
    gaps: list[float] = []

    def watch(robot: HandRobot, t: float) -> None:
        gaps.append(gap(robot, "worker"))
        if t > 11:
            raise _EnoughError

    beside = {"red box": RED["red box"] | {"at": [2.4, -0.4]}}
    run = Run(hall(Pose(-1.2, 0, 0), people=people, objects=beside), watch)
    with pytest.raises(_EnoughError):
        run.do(person_follow)
    assert run.world.people.everybody, "whole pictures are understood on the way, too"
    assert min(gaps[150:]) > 0.7
    assert max(gaps[150:]) < 1.9
    assert run.robot.world.true_pose.distance_to(Pose(-1.2, 0, 0)) > 1.5


def test_somebody_who_passes_between_is_not_taken_for_the_one_who_is_followed() -> None:
    scene, _ = among("following", 6612)  # somebody who goes the same way hides the one in purple
    gaps: list[float] = []

    def watch(robot: HandRobot, t: float) -> None:
        gaps.append(gap(robot, "person 1"))
        if t > 30:
            raise _EnoughError

    with pytest.raises(_EnoughError):
        Run(scene, watch).do(person_follow, "person in purple")
    assert np.mean(np.array(gaps) < 2.0) > 0.9


def test_a_robot_that_is_held_on_three_sides_says_so_and_does_not_try_for_ever() -> None:
    around = {"left": (0.0, 0.35), "right": (0.0, -0.35), "ahead": (0.405, 0.0)}
    cartons = {
        name: {"kind": "carton", "at": at, "size": [0.35, 0.3, 0.2], "mapped": False} for name, at in around.items()
    }
    run = Run(hall(people={"worker": {"path": [[2.2, 0.0]]}}, furniture=cartons))
    result = run.do(person_follow)
    assert result.error_code == "path_blocked"
    assert result.message.startswith("I cannot get any nearer to the person in blue: obstacle 0.0")


@pytest.mark.parametrize(("trousers", "facing"), [("grey", 180), ("blue", 0)])
def test_shoes_and_legs_are_not_taken_for_things_that_lie_about(trousers: str, facing: int) -> None:
    def watch(robot: HandRobot, t: float) -> None:
        if t > 25:
            raise _EnoughError

    worker = {"path": [[1.6, 0.5]], "trousers": trousers, "facing": facing}
    run = Run(hall(people={"worker": worker}), watch)
    with pytest.raises(_EnoughError):
        run.do(pick_object, "black thing")
    assert run.told
    assert not any("black" in words for words in run.told), "it went for a shoe"


def test_a_glance_finds_what_it_asks_for_and_what_it_does_not_look_for_is_not_forgotten() -> None:
    run = Run(hall(objects=BLOCK | {"red box": RED["red box"] | {"at": [0.8, 0.25]}}))

    async def look() -> None:
        await run.robot.tick()
        whole = await run.context.see()
        assert {thing.name for thing in run.world.things} == {"red box", "block 7"}
        for _ in range(3):
            tags = await run.context.see({"tags"})
            assert {tag.id for tag in tags.tags} == {tag.id for tag in whole.tags} == {7}
            assert not tags.objects
        assert {thing.name for thing in run.world.things} == {"red box", "block 7"}
        run.robot.put("red box", 0.8, -0.2, 0.0)
        await run.context.see({"things"})
        assert all(thing.position[1] > -0.1 for thing in run.world.things)

    asyncio.run(look())


def test_a_qr_code_is_approached_and_kept_at_a_distance() -> None:
    poster = {"text": "FOLLOW ME", "at": [1.6, 0.3], "z": 0.35, "facing": 180, "size": 0.45}

    def watch(robot: HandRobot, t: float) -> None:
        if t > 6:
            raise _EnoughError

    run = Run(hall(posters=[poster]), watch)
    with pytest.raises(_EnoughError):
        run.do(following.qr_follow)
    pose = run.robot.world.true_pose
    assert math.hypot(1.6 - pose.x, 0.3 - pose.y) == pytest.approx(following.KEEP_CODE, abs=0.08)
    assert math.atan2(0.3 - pose.y, 1.6 - pose.x) == pytest.approx(pose.yaw, abs=0.1)


class _EnoughError(Exception):
    """The test has seen what it wanted."""


def test_a_tag_is_followed_by_a_program_of_its_own() -> None:
    walk = Walk("block 7", speed=0.2, seconds=5.0)
    run = Run(hall(objects=BLOCK), walk)
    skill = external_skill("apriltag_follow", load(environ={}).skills["apriltag_follow"])

    async def follow() -> Result:
        await run.robot.tick()
        return await skill.run(run.context, tag=7.0)

    result = asyncio.run(follow())
    assert result.error_code == "target_lost", result
    assert "tag 7" in result.message
    assert max(walk.distances[150:]) < 0.95
    assert min(walk.distances[150:]) > 0.4


def test_an_interruption_in_mid_follow_ends_at_once_and_leaves_the_robot_standing() -> None:
    on_its_way = asyncio.Event()
    walk = Walk("red box", speed=0.25, seconds=50)

    def watch(robot: HandRobot, t: float) -> None:
        walk(robot, t)
        if robot.world.true_pose.x > 0.2:
            on_its_way.set()

    run = Run(hall(Pose(-0.5, 0, 0), objects=RED), watch)

    async def interrupted() -> tuple[float, float]:
        await run.robot.tick()
        following_it = asyncio.create_task(following.color_follow.run(run.context, "red"))
        await on_its_way.wait()
        run.robot.stop(2)
        following_it.cancel()
        before = run.robot.world.t
        with pytest.raises(asyncio.CancelledError):
            await following_it
        ticks = (run.robot.world.t - before) / 0.02
        for _ in range(25):
            await run.robot.tick()
        x = run.robot.world.true_pose.x
        for _ in range(25):
            await run.robot.tick()
        assert abs(run.robot.world.true_pose.x - x) < 0.002
        assert not run.robot.state().moving
        return ticks, x

    ticks, x = asyncio.run(interrupted())
    assert ticks <= 1
    assert x < 0.35


def test_the_robot_in_its_own_process_follows_and_is_interrupted(tmp_path: Path) -> None:
    scene = hall(Pose(-0.5, 0, 0), objects=RED)
    path = tmp_path / "hall.yaml"
    path.write_text(yaml.safe_dump(scene.model_dump(mode="json")), encoding="utf-8")

    async def test() -> None:
        async with running(scene=str(path)) as robot, beating(robot):
            await robot.tick()
            epoch = Epoch(robot.stop)
            on_its_way = asyncio.Event()

            def progress(*told: object, **more: object) -> None:
                if robot.state().pose.x > -0.3:
                    on_its_way.set()

            context = replace(context_of(robot, WorldMemory(), epoch.current), progress=progress)
            task = asyncio.create_task(following.color_follow.run(context, "red"))
            await asyncio.wait_for(on_its_way.wait(), 30)
            epoch.advance()
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            state = await robot.tick()
            assert state.command.is_zero
            stood = await ticks_until(robot, lambda state: not state.moving)
            assert stood.pose.x < 0.0

    asyncio.run(test())


def test_a_camera_that_dies_stops_the_robot_and_says_so() -> None:
    run = Run(hall(Pose(-0.5, 0, 0), objects=RED), Walk("red box", speed=0.25, seconds=50))
    look = run.robot.look

    async def failing() -> Any:
        if run.robot.world.true_pose.x > 0.0:
            raise CameraError("The camera is gone.")
        return await look()

    run.robot.look = failing  # type: ignore[method-assign]
    with pytest.raises(CameraError):
        run.do(following.color_follow, "red")
    for _ in range(20):
        asyncio.run(run.robot.tick())
    assert run.robot.world.true_pose.x < 0.2
    assert not run.robot.state().moving


def test_what_is_tracked_stays_in_view_while_the_robot_stays_where_it_is() -> None:
    def circle(robot: HandRobot, t: float) -> None:
        angle = 0.35 * max(0.0, t - 1.0)
        robot.put("red box", 0.9 * math.cos(angle), 0.9 * math.sin(angle), 0.0)
        if t > 7:
            raise _EnoughError

    run = Run(hall(objects=RED), circle)
    box = asyncio.run(_box_of(run, "red box"))
    with pytest.raises(_EnoughError):
        run.do(following.track, *box)
    pose, [yaw, *_] = run.robot.world.true_pose, run.robot.state().joints
    assert math.hypot(pose.x, pose.y) < 0.03
    assert pose.yaw > 0.8  # the base helps
    assert abs(pose.yaw + yaw - 0.35 * 6) < 0.2  # and the arm does the rest


async def _box_of(run: Run, name: str) -> tuple[float, ...]:
    await run.robot.tick()
    sight = perceive(await run.robot.look(), run.robot.floor_map)
    return tuple(float(edge) for edge in next(thing.box for thing in sight.objects if thing.name == name))


def test_a_box_of_the_picture_with_nothing_in_it_is_refused() -> None:
    result = Run(hall(objects=RED)).do(following.track, 2.0, 2.0, 12.0, 12.0)
    assert result.error_code == "object_not_found"
    assert "red box" in result.message  # which it does see


def test_a_line_is_followed_to_its_end() -> None:
    run = Run(hall(Pose(-1.0, 0, 0), lines=TAPE))
    result = run.do(following.follow_line, "blue")
    assert result.ok, result
    assert result.message == f"I followed the blue line to its end, {result.data['length']:.1f} m."
    assert result.data["length"] == pytest.approx(TAPE_LENGTH, abs=0.15)
    assert run.robot.world.true_pose.distance_to(Pose(0.9, 1.2, 0)) < 0.05
    assert math.degrees(run.robot.world.true_pose.yaw) == pytest.approx(90, abs=8)


def test_a_line_with_something_on_it_stops_the_robot_before() -> None:
    red = {"red box": {"kind": "box", "at": [0.3, 0.02], "size": 0.04, "colour": "red", "turn": 20}}
    run = Run(hall(Pose(-1.0, 0, 0), lines=TAPE, objects=red))
    result = run.do(following.follow_line, "blue")
    assert result.error_code == "path_blocked"
    assert result.data["thing"] == "red box"
    assert run.away("red box") > 0.3
    assert run.robot.where("red box")[0] == pytest.approx(0.3, abs=0.005)


def test_what_stands_on_a_line_is_put_beside_it_and_the_robot_goes_on() -> None:
    red = {"red box": {"kind": "box", "at": [0.3, 0.0], "size": 0.04, "colour": "red", "turn": 20}}
    run = Run(hall(Pose(-1.0, 0, 0), lines=TAPE, objects=red))
    result = run.do(following.follow_line_clear)
    assert result.ok, result
    assert result.data["cleared"] == 1
    assert run.robot.world.true_pose.distance_to(Pose(0.9, 1.2, 0)) < 0.05
    _, y, z = run.robot.where("red box")
    assert abs(y) > 0.16
    assert z == pytest.approx(0, abs=0.005)
    assert run.world.held is None


def test_a_line_that_nobody_sees_is_not_followed() -> None:
    result = Run(hall(Pose(-1.0, 0, 0), lines=TAPE)).do(following.follow_line, "red")
    assert result.error_code == "object_not_found"


@pytest.mark.parametrize(("x", "y"), [(0.6, 0.0), (1.4, -0.3)])
def test_the_distance_at_a_pixel_is_right_to_two_centimetres(x: float, y: float) -> None:
    red = {"red box": {"kind": "box", "at": [x, y], "size": 0.06, "colour": "red"}}
    run = Run(hall(objects=red))
    left, top, right, bottom = asyncio.run(_box_of(run, "red box"))
    result = run.do(following.get_dist, (left + right) / 2, (top + bottom) / 2)
    assert result.ok, result
    assert result.data["distance"] == pytest.approx(_truth(run, (left + right) / 2, (top + bottom) / 2), abs=0.02)
    assert result.data["x"] == pytest.approx(x, abs=0.04)
    assert result.data["y"] == pytest.approx(y, abs=0.04)
    assert f"{result.data['distance']:.2f} m" in result.message


@pytest.mark.parametrize("row", [70.0, 90.0, 115.0])
def test_without_depth_the_distance_is_that_of_the_floor_and_says_how_good_it_is(row: float) -> None:
    run = Run(hall())
    look = run.robot.look

    async def look_without_depth(**more: bool) -> Picture:
        seen = await look(**more)
        return replace(seen, depth=floor_depth(seen.lens, seen.mount), guessed=True)

    run.robot.look = look_without_depth  # type: ignore[method-assign]
    result = run.do(following.get_dist, 80.0, row)
    assert result.ok, result
    error = result.data["error"]
    assert isinstance(error, float)
    assert abs(float(str(result.data["distance"])) - _truth(run, 80.0, row)) < error
    assert "if it lies on the floor, give or take" in result.message


def _truth(run: Run, column: float, row: float) -> float:
    """The length of the ray through a pixel, as physics has it."""
    model, data = run.robot.world.model, run.robot.world.data
    camera = next(index for index in range(model.ncam))
    height, width = 120, 160
    focal = height / 2 / math.tan(math.radians(float(model.cam_fovy[camera])) / 2)
    ray = np.array([(column - width / 2) / focal, -(row - height / 2) / focal, -1.0])
    direction = data.cam_xmat[camera].reshape(3, 3) @ (ray / np.linalg.norm(ray))
    hit = np.zeros(1, dtype=np.int32)
    return float(mujoco.mj_ray(model, data, data.cam_xpos[camera], direction, None, 1, -1, hit, None))


def test_a_pixel_outside_the_picture_is_refused() -> None:
    result = Run(hall()).do(following.get_dist, 500.0, 20.0)
    assert result.error_code == "object_not_found"
    assert "160×120" in result.message
