"""What the calibrations of ``sayso robot calibrate`` share: questions to the person beside the robot, and a robot that
drives for a moment under everything that keeps it safe."""

from __future__ import annotations

import asyncio
import math
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from engine.errors import RobotError, UsageError

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.robot.robot import Robot

SPEED: Final = 0.2
"""m/s; slow, so that no wheel slips."""
DRIVE_LIMIT_S: Final = 30.0


@asynccontextmanager
async def running(settings: Settings) -> AsyncIterator[Robot]:
    """The configured robot, started and told that somebody lives. Raises ``RobotError`` while the emergency stop is
    pressed."""
    from config import paths
    from engine.parts.estop import EmergencyStop
    from engine.robot.bodies import make_robot
    from engine.robot.watch import beat

    robot = make_robot(settings.robot)
    estop = EmergencyStop(paths().estop, robot.press, robot.press)
    if estop.pressed:
        raise RobotError("The emergency stop is pressed.", hint="sayso robot release")
    await robot.start()

    beating, keeping = asyncio.create_task(beat(robot)), asyncio.create_task(estop.keep())
    try:
        yield robot
    finally:
        beating.cancel()
        keeping.cancel()
        await robot.close()


async def drive_straight(robot: Robot, way: float) -> float:
    """Drive straight on by so many metres, by the robot's own reckoning, and say by how many it was."""
    from engine.robot.geometry import ZERO, Twist

    start, until = robot.state().pose, time.monotonic() + DRIVE_LIMIT_S
    while (left := abs(way) - (state := await robot.tick()).pose.distance_to(start)) > 0.002:
        if state.halted or state.blocked or time.monotonic() > until:
            raise RobotError(f"It does not come further: {state.halted or state.blocked or 'no progress'}.")
        speed = math.copysign(max(0.03, min(SPEED, left)), way)
        robot.drive(Twist(speed), 1)
    robot.drive(ZERO, 1)
    await pass_time(robot, 0.5)
    return math.copysign(robot.state().pose.distance_to(start), way)


async def pass_time(robot: Robot, seconds: float) -> None:
    """Let so much of the robot's time pass."""
    until = robot.state().t + seconds
    while (await robot.tick()).t < until:
        pass


def answer() -> str:
    """A line that the person has typed. Raises ``UsageError`` when none will come."""
    line = sys.stdin.readline()
    if not line:
        raise UsageError("Nobody answers: nothing was written.")
    return line.strip()


def today() -> str:
    """As it is noted in a description."""
    return time.strftime("%Y-%m-%d")
