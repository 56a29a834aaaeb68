"""The walls tell which way the robot faces: scans of the real lidar in the flat, and in a room where nothing is
straight."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from engine.perception.compass import Heading, heading
from engine.perception.localise import Localiser
from engine.perception.memory import WorldMemory
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.sim.scene import Scene
from engine.skills.travel import go_to
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import flat, places

NOWHERE = Pose(0, 0, 0)


def told(robot: HandRobot, astray: float, within: float = math.inf) -> Heading | None:
    """What the walls ``within`` so many metres tell a robot whose heading is ``astray`` by so much, rad."""
    state, true, scan = robot.state(), robot.world.true_pose, robot.scan()
    scan = replace(scan, ranges=np.where(scan.ranges < within, scan.ranges, math.inf))
    return heading(scan, state, state.t, Pose(true.x, true.y, wrap(true.yaw + astray)))


def scanned(robot: HandRobot) -> HandRobot:
    """With a scan from where it stands."""

    async def wait() -> None:
        before = robot.world.scan_time
        while robot.world.scan_time == before:
            await robot.tick()

    asyncio.run(wait())
    return robot


@pytest.mark.parametrize("astray", [-9.0, 0.0, 6.0])
def test_the_heading_is_told_at_every_place_of_the_flat(astray: float) -> None:
    robot = HandRobot()
    for symbol, pose in places().items():
        robot.stand_at(pose)
        found = told(scanned(robot), math.radians(astray))
        assert found is not None, symbol
        assert math.degrees(abs(wrap(found.yaw - robot.world.true_pose.yaw))) < 1.0, symbol


def test_it_is_told_while_the_robot_turns_too() -> None:
    robot, off = HandRobot(), list[float]()

    def compare() -> None:
        found = told(robot, math.radians(4))
        if found is not None:
            off.append(abs(wrap(found.yaw - robot.world.true_pose.yaw)) / found.sigma)

    async def turn() -> None:
        robot.each_tick = compare
        for _ in range(150):
            robot.drive(Twist(wz=1.5), 1)
            await robot.tick()

    asyncio.run(turn())
    assert len(off) > 100
    assert max(off) < 3


def test_cartons_that_stand_askew_tell_nothing_where_the_walls_are_out_of_range() -> None:
    cartons = {
        f"carton {n}": {"kind": "box", "at": [math.cos(n), math.sin(n)], "size": 0.3, "turn": 17.0 * n}
        for n in range(6)
    }  # fmt: skip
    wide = {"x": [-5, 5], "y": [-5, 5]}
    scene = {"name": "wide", "bounds": wide, "rooms": {"hall": wide}, "start": {"x": 0, "y": 0}, "objects": cartons}
    robot = scanned(HandRobot(Scene.model_validate(scene)))
    assert told(robot, 0.0) is not None
    assert told(robot, 0.0, within=2.0) is None


def test_walls_that_contradict_odometry_are_not_believed() -> None:
    localiser = Localiser()
    localiser.update(0.0, NOWHERE, None)
    assert localiser.update(0.1, NOWHERE, None, Heading(math.radians(11), math.radians(0.4))) == NOWHERE
    assert localiser.update(0.2, NOWHERE, None, Heading(math.radians(2), math.radians(0.4))).yaw > math.radians(1)


def test_without_any_landmark_the_robot_still_knows_which_way_it_faces() -> None:
    robot = HandRobot(flat().model_copy(update={"landmarks": ()}), odometry_noise=0.02, seed=1)
    off: list[float] = []
    robot.each_tick = lambda: off.append(abs(wrap(robot.state().pose.yaw - robot.world.true_pose.yaw)))
    assert asyncio.run(go_to(context_of(robot, WorldMemory()), places()["C"], "C")).ok
    assert math.degrees(float(np.max(off))) < 3
