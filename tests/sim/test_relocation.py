"""Somebody who knows better where the robot is tells odometry, which goes on from there; nothing moves by it."""

from __future__ import annotations

import asyncio
import math
import os
import signal
from collections.abc import Awaitable, Callable

import pytest

from engine.errors import RobotError
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.sim.robot import SimRobot
from tests.sim.rig import running

DEADLINE_S = 60.0
SHIFTED = Pose(0.4, -0.3, 0.5)
"""Where the robot really is when it believes to be at the start."""


def with_a_robot(test: Callable[[SimRobot], Awaitable[None]], **changes: object) -> None:
    async def run() -> None:
        async with running(**changes) as robot, asyncio.timeout(DEADLINE_S):
            await robot.tick()
            await test(robot)

    asyncio.run(run())


def true_pose(robot: SimRobot) -> Pose:
    return Pose(*robot.memory.state.get()["true_pose"].tolist())


def shifted(pose: Pose) -> Pose:
    """A pose near the start, told on the map where the start is at ``SHIFTED``."""
    c, s = math.cos(SHIFTED.yaw), math.sin(SHIFTED.yaw)
    x, y = SHIFTED.x + c * pose.x - s * pose.y, SHIFTED.y + s * pose.x + c * pose.y
    return Pose(x, y, wrap(pose.yaw + SHIFTED.yaw))


def same(one: Pose, other: Pose, within: float = 1e-6) -> bool:
    return one.distance_to(other) < within and abs(wrap(one.yaw - other.yaw)) < within


def test_every_state_and_picture_from_then_on_is_corrected_and_nothing_moves() -> None:
    async def test(robot: SimRobot) -> None:
        stood = true_pose(robot)
        robot.relocate(Pose(0, 0, 0), SHIFTED)
        assert same(robot.state().pose, SHIFTED)
        assert same((await robot.look()).pose, SHIFTED)
        state = await robot.tick()
        assert same(state.pose, SHIFTED)
        assert same(true_pose(robot), stood, within=1e-9)

    with_a_robot(test)


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_while_driving_the_way_goes_on_from_the_corrected_pose(noise: float) -> None:
    async def drive(robot: SimRobot, *, relocated: bool) -> list[Pose]:
        way = []
        for tick in range(60):
            if relocated and tick == 20:
                before = robot.state().pose
                robot.relocate(before, shifted(before))
            robot.drive(Twist(0.3, 0.1, 0.6), 1)
            way.append((await robot.tick()).pose)
        return way

    ways: list[list[Pose]] = []

    async def plainly(robot: SimRobot) -> None:
        ways.append(await drive(robot, relocated=False))

    async def corrected(robot: SimRobot) -> None:
        ways.append(await drive(robot, relocated=True))

    with_a_robot(plainly, odometry_noise=noise)
    with_a_robot(corrected, odometry_noise=noise)
    plain, other = ways
    assert all(same(a, b) for a, b in zip(plain[:20], other[:20], strict=True))
    assert all(same(shifted(a), b) for a, b in zip(plain[20:], other[20:], strict=True))


def test_corrections_in_quick_succession_all_count() -> None:
    async def test(robot: SimRobot) -> None:
        for _ in range(3):
            here = robot.state().pose
            robot.relocate(here, Pose(here.x + 0.1, here.y, here.yaw))
        assert same((await robot.tick()).pose, Pose(0.3, 0, 0), within=1e-4)

    with_a_robot(test)


def test_a_robot_process_that_is_replaced_keeps_the_correction() -> None:
    async def test(robot: SimRobot) -> None:
        robot.relocate(Pose(0, 0, 0), SHIFTED)
        await robot.tick()
        robot.relocate(SHIFTED, Pose(1.0, 0.5, -0.2))  # the process never hears of this one
        assert robot.pid is not None
        os.kill(robot.pid, signal.SIGKILL)
        with pytest.raises(RobotError):
            await robot.tick()
        await robot.start()
        assert same(robot.state().pose, Pose(1.0, 0.5, -0.2), within=1e-4)
        assert same((await robot.tick()).pose, Pose(1.0, 0.5, -0.2), within=1e-4)

    with_a_robot(test)
