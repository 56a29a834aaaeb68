"""``sayso robot calibrate steering``: it drives ahead and back, and measures by how much it turns on the way.

What it finds becomes the description's ``trim``, which the motors are told from then on to make up for it.
"""

from __future__ import annotations

import asyncio
from argparse import Namespace
from typing import TYPE_CHECKING, Final

from engine.errors import DeviceError, ExitCode, RobotError
from tui.commands.guided import answer, drive_straight, running, today
from tui.output import data, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.robot.calibration.steering import Drive, Pull
    from engine.robot.robot import Robot

WAY_M: Final = 0.6
ROOM_M: Final = (1.0, 0.5)
"""Free ahead, and on either side: the most that is put right by a trim takes it 9 cm aside."""
LISTEN_S: Final = 1.0
"""How long the board is listened to before."""
MOST: Final = 0.5
"""rad/m, as in the description: what turns by more has another fault."""
UNEVEN: Final = 0.02
"""rad/m of spread, from which on something was not right."""


def run(settings: Settings, arguments: Namespace) -> int:
    """The command as the command line gives it. Raises ``UsageError``, ``RobotError`` or ``DeviceError``."""
    from engine.robot.bodies import description_of
    from engine.robot.description import note
    from engine.robot.rosmaster.inspection import inspect

    trim, port = description_of(settings.robot).trim, settings.robot.port
    assert port is not None, "the configuration sees to that"
    runs, (ahead, aside) = arguments.runs, ROOM_M
    say(
        f"It drives {WAY_M:g} m ahead and back, {runs} times. "
        f"Put it on a hard floor with {ahead:g} m free ahead and {aside:g} m on either side."
    )
    if not arguments.yes:
        say("Enter begins.")
        answer()
    if not inspect(port, LISTEN_S).attitude:
        raise DeviceError(
            f"The board on {port} does not tell which way it points, so nobody can measure how it turns.",
            hint="Is the robot switched on? `sayso robot check` looks closer.",
        )
    pull = asyncio.run(_pull(settings, runs))
    new = round(trim - pull.mean, 4)
    if abs(new) > MOST:
        raise RobotError(
            f"It turns by {pull.mean:+.2f} rad a metre: that is more than a pull, and nothing was written.",
            hint="Do all wheels turn, and the right way?",
        )
    found = f"{today()}: {runs} times {WAY_M:g} m ahead and back; {pull.mean:+.3f} ± {pull.spread:.3f} rad/m"
    file = note(settings.robot.made_as, {"trim": new, "calibrated.steering": found})
    data(f"trim {new:g} rad/m (it was {trim:g}); {found}")
    if pull.spread > UNEVEN:
        say("sayso: the runs differ by much. Does a wheel slip? Measure again on a harder floor.")
    say(f"sayso: written into {file}")
    return int(ExitCode.DONE)


async def _pull(settings: Settings, runs: int) -> Pull:
    from engine.robot.calibration.steering import pull_of

    driven: list[tuple[Drive, Drive]] = []
    async with running(settings) as robot:
        for number in range(runs):
            driven.append((await _drive(robot, WAY_M), await _drive(robot, -WAY_M)))
            ahead = driven[-1][0]
            say(f"{number + 1} of {runs}: {ahead.turned:+.3f} rad on {ahead.ahead:.2f} m ahead")
    return pull_of(driven)


async def _drive(robot: Robot, way: float) -> Drive:
    from engine.robot.calibration.steering import Drive
    from engine.robot.geometry import wrap

    before = robot.state().pose.yaw
    ahead = await drive_straight(robot, way)
    return Drive(ahead, wrap(robot.state().pose.yaw - before))
