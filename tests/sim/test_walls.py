"""The walls of the house tell where the robot stands: scans of the real lidar in the flat and in rooms made for it."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from engine.perception.compass import Heading, heading
from engine.perception.landmarks import Fix
from engine.perception.localise import Localiser
from engine.perception.memory import WorldMemory
from engine.perception.walls import WallSighting, walls
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.sim.scene import Scene
from engine.skills.travel import go_to
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import flat, places

ASTRAY = Pose(0.06, -0.05, math.radians(2))
"""Between belief and truth."""


def believed(robot: HandRobot) -> Pose:
    true = robot.world.true_pose
    return Pose(true.x + ASTRAY.x, true.y + ASTRAY.y, wrap(true.yaw + ASTRAY.yaw))


def told(robot: HandRobot) -> tuple[WallSighting, ...]:
    """By the newest scan, to a robot that is somewhat astray."""
    state, scan = robot.state(), robot.scan()
    facing = heading(scan, state, state.t, believed(robot))
    return () if facing is None else walls(scan, state, state.t, believed(robot), facing, robot.floor_map)


def off(robot: HandRobot, wall: WallSighting) -> float:
    """How far what is taken for a wall is from that wall in truth, m."""
    true = robot.world.true_pose
    c, s = math.cos(true.yaw), math.sin(true.yaw)
    return (true.x + c * wall.x - s * wall.y, true.y + s * wall.x + c * wall.y)[wall.axis] - wall.at


def scanned(robot: HandRobot, pose: Pose) -> HandRobot:
    """With a scan from there."""

    async def wait() -> None:
        before = robot.world.scan_time
        while robot.world.scan_time == before:
            await robot.tick()

    robot.stand_at(pose)
    asyncio.run(wait())
    return robot


def test_walls_are_known_again_at_every_place_of_the_flat_and_nearly_everywhere_tell_both_coordinates() -> None:
    robot, both = HandRobot(), 0
    for symbol, pose in places().items():
        found = told(scanned(robot, pose))
        assert found, symbol
        assert max(abs(off(robot, wall)) for wall in found) < 0.01, symbol
        both += {wall.axis for wall in found} == {0, 1}
    assert both > 0.8 * len(places())


def test_they_are_where_they_are_while_the_robot_drives_and_turns_too() -> None:
    robot, worst = HandRobot(), list[float]()
    robot.each_tick = lambda: worst.extend(abs(off(robot, wall)) / wall.sigma for wall in told(robot))

    async def go() -> None:
        for twist in (Twist(0.5), Twist(0.3, 0, 1.0), Twist(wz=-1.5)):
            for _ in range(50):
                robot.drive(twist, 1)
                await robot.tick()

    asyncio.run(go())
    assert len(worst) > 200
    assert max(worst) < 3


DEN = {"x": [-2, 2], "y": [-1.5, 1.5]}


def a_den(**more: object) -> Scene:
    return Scene.model_validate(
        {"name": "den", "bounds": DEN, "rooms": {"den": DEN}, "start": {"x": 0, "y": 0}, **more}
    )


CHEST = {"kind": "carton", "at": [1.8, 0.0], "size": [1.4, 0.2, 0.4], "turn": 270}


@pytest.mark.parametrize(
    "hidden", [{"furniture": {"chest": CHEST}}, {"furniture": {"chest": {**CHEST, "mapped": False}}}]
)
def test_what_stands_before_a_wall_is_not_taken_for_it(hidden: dict[str, object]) -> None:
    found = told(scanned(HandRobot(a_den(**hidden)), Pose(0.3, 0.1, 0.4)))
    assert {(wall.axis, wall.at) for wall in found} <= {(0, -1.95), (0, 1.95), (1, -1.45), (1, 1.45)}
    assert all(abs(off(scanned(HandRobot(a_den(**hidden)), Pose(0.3, 0.1, 0.4)), wall)) < 0.01 for wall in found)


def test_a_wall_that_contradicts_odometry_is_none() -> None:
    localiser = Localiser()
    localiser.update(0.0, Pose(0, 0, 0), None)
    assert localiser.update(0.1, Pose(0, 0, 0), None, None, [WallSighting(1, 0, 0, 1.12, 0.01)]) == Pose(0, 0, 0)
    assert localiser.update(0.2, Pose(0, 0, 0), None, None, [WallSighting(1, 0, 0, 1.03, 0.01)]).x > 0.01


def test_one_wall_tells_how_far_it_is_and_nothing_of_where_along_it() -> None:
    localiser = Localiser()
    localiser.update(0.0, Pose(0, 0, 0), None)
    pose = localiser.update(0.1, Pose(0, 0, 0), None, None, [WallSighting(0, 2, 1, 2.03, 0.01)])
    assert pose.x == pytest.approx(0, abs=1e-9)
    assert pose.y == pytest.approx(0.024, abs=0.003)


def test_walls_tell_the_heading_also_where_a_far_tag_tells_it_badly() -> None:
    wrong = math.radians(1)
    fix = Fix(Pose(0, 0, wrong), np.diag([0.02**2, 0.02**2, wrong**2]), tags=1)
    assert Localiser().update(1.0, Pose(0, 0, 0), fix).yaw > math.radians(0.5)
    assert Localiser().update(1.0, Pose(0, 0, 0), fix, Heading(0.0, math.radians(0.4))).yaw < math.radians(0.2)


async def error_on_a_way_without_tags(knows_walls: bool, seed: int) -> float:
    """The largest on the way, m."""
    robot = HandRobot(flat().model_copy(update={"landmarks": ()}), odometry_noise=0.02, seed=seed)
    if not knows_walls:
        robot._map = replace(robot.floor_map, walls=())
    worst: list[float] = []
    robot.each_tick = lambda: worst.append(robot.state().pose.distance_to(robot.world.true_pose))
    context, goals = context_of(robot, WorldMemory()), places()
    for symbol in "TH":
        assert (await go_to(context, goals[symbol], symbol)).ok
    return max(worst)


def test_on_ways_without_a_tag_the_walls_keep_the_belief_within_five_centimetres() -> None:
    seed = 3  # forward and sideways odometry are wrong by 4 %
    assert asyncio.run(error_on_a_way_without_tags(True, seed)) < 0.05
    assert asyncio.run(error_on_a_way_without_tags(False, seed)) > 0.1, "the noise is too small to test anything"
