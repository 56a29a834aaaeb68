"""``sayso robot calibrate wheels | servos``: measured by a person with a tape, written into the robot's description.

For the wheels the robot drives a metre by its own reckoning, forth and back, and asks how far it has come; a wheel that
is larger than it is described makes that more. For the servos it stretches each joint, and asks by how much it is off.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import statistics
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from engine.errors import ExitCode, RobotError, UsageError
from tui.output import data, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.robot.robot import Robot

WAY_M: Final = 1.0
RUNS: Final = 4
SPEED: Final = 0.2
"""m/s; slow, so that no wheel slips."""
MOST_OFF: Final = 0.3
"""Of the way: a measure that is further off is a mistake, or another robot."""
MOST_DEG: Final = 30.0
DRIVE_LIMIT_S: Final = 30.0


def run(settings: Settings, what: str | None) -> int:
    """The command as the command line gives it. Raises ``UsageError``, ``RobotError`` or ``DeviceError``."""
    if settings.robot.kind == "sim":
        raise UsageError("The simulated robot needs no calibration.", hint="--set robot.kind=rosmaster, robot.port=…")
    match what:
        case "wheels":
            return asyncio.run(_wheels(settings))
        case "servos":
            return asyncio.run(_servos(settings))
    raise UsageError("What is to be calibrated?", hint="sayso robot calibrate wheels, or servos.")


async def _wheels(settings: Settings) -> int:
    from engine.robot.bodies import description_of
    from engine.robot.description import note

    description = description_of(settings.robot)
    assert description.wheels is not None, "a robot with a board has wheels"
    say(f"Put it on a hard floor with {WAY_M + 0.5:g} m free ahead, and mark where its front is. Enter begins.")
    await _answer()
    ratios: list[float] = []
    async with _running(settings) as robot:
        for number in range(RUNS):
            way = WAY_M if number % 2 == 0 else -WAY_M
            own = await _drive(robot, way)
            say(f"{number + 1} of {RUNS}: how far has it come, in cm? (It believes: {100 * abs(own):.1f})")
            ratios.append(await _measure(abs(own)))
    mean, spread = statistics.mean(ratios), statistics.stdev(ratios)
    radius = round(description.wheels.radius * mean, 5)
    found = f"{_today()}: {RUNS} drives of {WAY_M:g} m; {100 * (mean - 1):+.1f} % ± {100 * spread:.1f} %"
    file = note(settings.robot.made_as, {"wheels.radius": radius, "calibrated.wheels": found})
    data(f"wheels.radius {radius:g} m (it was {description.wheels.radius:g}); {found}")
    if spread > 0.02:
        say("sayso: the drives differ by much. Does a wheel slip? Measure again on a harder floor.")
    say(f"sayso: written into {file}")
    return int(ExitCode.DONE)


async def _servos(settings: Settings) -> int:
    from engine.robot.bodies import description_of
    from engine.robot.description import note

    description = description_of(settings.robot)
    if description.arm is None:
        raise UsageError(f"{description.name} has no arm.")
    say("The arm will stretch straight up. Enter begins.")
    await _answer()
    found: dict[str, float | str] = {}
    async with _running(settings) as robot:
        robot.move_arm((0.0,) * len(description.arm.joints), 1, speed=0.5)
        await _pass(robot, 6.0)
        for name, joint in description.arm.joints.items():
            assert joint.servo is not None, "on a board every joint has one"
            say(f"{name}: by how many degrees is it off? Forward or left is more, back or right is less; Enter: none.")
            off = await _degrees()
            if off:
                zero = joint.servo.zero - joint.servo.sign * off
                found[f"arm.joints.{name}.servo.zero"] = round(max(0.0, min(270.0, zero)), 1)
    found["calibrated.servos"] = f"{_today()}: {len(found)} of {len(description.arm.joints)} were off"
    file = note(settings.robot.made_as, found)
    for key, value in found.items():
        data(f"{key} {value}")
    say(f"sayso: written into {file}")
    return int(ExitCode.DONE)


@asynccontextmanager
async def _running(settings: Settings) -> AsyncIterator[Robot]:
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


async def _drive(robot: Robot, way: float) -> float:
    """Drive straight on by so much, by the robot's own reckoning, and say by how much it was."""
    from engine.robot.geometry import ZERO, Twist

    start, until = robot.state().pose, time.monotonic() + DRIVE_LIMIT_S
    while (left := abs(way) - (state := await robot.tick()).pose.distance_to(start)) > 0.002:
        if state.halted or state.blocked or time.monotonic() > until:
            raise RobotError(f"It does not come further: {state.halted or state.blocked or 'no progress'}.")
        speed = math.copysign(max(0.03, min(SPEED, left)), way)
        robot.drive(Twist(speed), 1)
    robot.drive(ZERO, 1)
    await _pass(robot, 0.5)
    return math.copysign(robot.state().pose.distance_to(start), way)


async def _pass(robot: Robot, seconds: float) -> None:
    until = robot.state().t + seconds
    while (await robot.tick()).t < until:
        pass


async def _measure(own: float) -> float:
    """What was measured as a part of what the robot believes."""
    while True:
        with contextlib.suppress(ValueError):
            ratio = float((await _answer()).replace(",", ".").removesuffix("cm")) / 100 / own
            if abs(ratio - 1) <= MOST_OFF:
                return ratio
        say("A number of centimetres that can be: measure again.")


async def _degrees() -> float:
    while True:
        text = (await _answer()).replace(",", ".")
        with contextlib.suppress(ValueError):
            off = float(text or 0)
            if abs(off) <= MOST_DEG:
                return off
        say("A number of degrees, or Enter.")


async def _answer() -> str:
    line: str = await asyncio.to_thread(sys.stdin.readline)
    if not line:
        raise UsageError("Nobody answers: nothing was written.")
    return line.strip()


def _today() -> str:
    return time.strftime("%Y-%m-%d")
