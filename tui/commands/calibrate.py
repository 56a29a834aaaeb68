"""``sayso robot calibrate``, and of it wheels and servos: measured by a person, written into the robot's description.

For the wheels the robot drives a metre by its own reckoning, forth and back, and asks how far it has come; a wheel that
is larger than it is described makes that more. For the servos it stretches each joint, and asks by how much it is off.
"""

from __future__ import annotations

import asyncio
import contextlib
import statistics
from argparse import Namespace
from typing import TYPE_CHECKING, Final

from engine.errors import ExitCode, UsageError
from tui.commands.guided import answer, drive_straight, pass_time, running, today
from tui.output import data, say

if TYPE_CHECKING:
    from config.schema import Settings

WAY_M: Final = 1.0
RUNS: Final = 4
MOST_OFF: Final = 0.3
"""Of the way: a measure that is further off is a mistake, or another robot."""
MOST_DEG: Final = 30.0


def run(settings: Settings, arguments: Namespace) -> int:
    """The command as the command line gives it. Raises ``UsageError``, ``RobotError`` or ``DeviceError``."""
    if arguments.name == "camera" and arguments.sheet is not None:
        from tui.commands.calibrate_camera import write_sheet

        return write_sheet(arguments)
    if settings.robot.kind == "sim":
        raise UsageError("The simulated robot needs no calibration.", hint="--set robot.kind=rosmaster, robot.port=…")
    if settings.robot.emulated and arguments.name != "camera":
        hint = "`sayso robot emulate` puts one on a terminal; name that in robot.port."
        raise UsageError("A board without a cable cannot be calibrated.", hint=hint)
    match arguments.name:
        case "wheels":
            return asyncio.run(_wheels(settings))
        case "servos":
            return asyncio.run(_servos(settings))
        case "steering":
            from tui.commands.calibrate_steering import run as steering

            return steering(settings, arguments)
        case "camera":
            from tui.commands.calibrate_camera import run as camera

            return camera(settings, arguments)
    raise UsageError("What is to be calibrated?", hint="sayso robot calibrate wheels, steering, servos, or camera.")


async def _wheels(settings: Settings) -> int:
    from engine.robot.bodies import description_of
    from engine.robot.description import note

    description = description_of(settings.robot)
    assert description.wheels is not None, "a robot with a board has wheels"
    say(f"Put it on a hard floor with {WAY_M + 0.5:g} m free ahead, and mark where its front is. Enter begins.")
    await asyncio.to_thread(answer)
    ratios: list[float] = []
    async with running(settings) as robot:
        for number in range(RUNS):
            way = WAY_M if number % 2 == 0 else -WAY_M
            own = await drive_straight(robot, way)
            say(f"{number + 1} of {RUNS}: how far has it come, in cm? (It believes: {100 * abs(own):.1f})")
            ratios.append(await _measure(abs(own)))
    mean, spread = statistics.mean(ratios), statistics.stdev(ratios)
    radius = round(description.wheels.radius * mean, 5)
    found = f"{today()}: {RUNS} drives of {WAY_M:g} m; {100 * (mean - 1):+.1f} % ± {100 * spread:.1f} %"
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
    await asyncio.to_thread(answer)
    found: dict[str, float | str] = {}
    async with running(settings) as robot:
        robot.move_arm((0.0,) * len(description.arm.joints), 1, speed=0.5)
        await pass_time(robot, 6.0)
        for name, joint in description.arm.joints.items():
            assert joint.servo is not None, "on a board every joint has one"
            say(f"{name}: by how many degrees is it off? Forward or left is more, back or right is less; Enter: none.")
            off = await _degrees()
            if off:
                zero = joint.servo.zero - joint.servo.sign * off
                found[f"arm.joints.{name}.servo.zero"] = round(max(0.0, min(270.0, zero)), 1)
    found["calibrated.servos"] = f"{today()}: {len(found)} of {len(description.arm.joints)} were off"
    file = note(settings.robot.made_as, found)
    for key, value in found.items():
        data(f"{key} {value}")
    say(f"sayso: written into {file}")
    return int(ExitCode.DONE)


async def _measure(own: float) -> float:
    """What was measured as a part of what the robot believes."""
    while True:
        with contextlib.suppress(ValueError):
            ratio = float((await asyncio.to_thread(answer)).replace(",", ".").removesuffix("cm")) / 100 / own
            if abs(ratio - 1) <= MOST_OFF:
                return ratio
        say("A number of centimetres that can be: measure again.")


async def _degrees() -> float:
    while True:
        text = (await asyncio.to_thread(answer)).replace(",", ".")
        with contextlib.suppress(ValueError):
            off = float(text or 0)
            if abs(off) <= MOST_DEG:
                return off
        say("A number of degrees, or Enter.")
