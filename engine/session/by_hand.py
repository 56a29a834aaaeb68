"""Driving by hand: a person's velocities, each of which dies with its command lifetime.

Whoever lets go of the key sends no more, and the robot stands a fifth of a second later, without anybody telling it.
"""

from __future__ import annotations

import asyncio
import contextlib

from engine.errors import RobotError
from engine.parts.part import Loading
from engine.robot.geometry import Twist
from engine.robot.robot import Robot

HOLDS_S = 0.3
"""s of robot time for which somebody waits for the robot after each command: at full speed a simulation moves only
while somebody does."""


class ByHand:
    """Passes a person's velocities on to the robot; in the session's loop."""

    def __init__(self, robot: Loading[Robot]) -> None:
        self._robot = robot
        self._until = 0.0
        self._passing: asyncio.Task[None] | None = None

    def drive(self, twist: Twist, epoch: int) -> str:
        """Drive so for a moment; why not, in words, where it cannot."""
        robot = self._robot.value
        if robot is None:
            return "The robot is not there yet."
        try:
            state = robot.state()
            if state.estop:
                return "The emergency stop is pressed: release it first."
            robot.drive(twist, epoch)
        except RobotError as error:
            return error.message
        self._until = state.t + HOLDS_S
        if self._passing is None or self._passing.done():
            self._passing = asyncio.create_task(self._pass_time(robot))
        return ""

    async def close(self) -> None:
        """Wait for nothing any more."""
        if self._passing is not None:
            self._passing.cancel()
            await asyncio.wait([self._passing])

    async def _pass_time(self, robot: Robot) -> None:
        with contextlib.suppress(RobotError):  # its loss is told by whoever keeps it
            while (await robot.tick()).t < self._until:
                pass
