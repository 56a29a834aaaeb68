"""Keeps the robot: starts it, keeps it company, and gets it back where it was when it is lost.

A loss interrupts like any other stop: telling the session of it advances the epoch, so that nothing that was commanded
before moves the robot that comes back. Only then is it started again. Whoever asks for it in the meantime waits, and
gets an error when it cannot be had any more.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from engine.bus import Emit
from engine.commands import Halted
from engine.epoch import Epoch
from engine.errors import RobotError
from engine.events import ErrorRaised, Log
from engine.parts.part import Part
from engine.robot.robot import Robot
from engine.robot.watch import company

PAUSES_S = (0.0, 1.0, 2.0)
"""Before the first, second and third try to get a lost robot back, s."""
WINDOW_S = 60.0
"""A robot that needs more tries than there are pauses within so many seconds is given up."""


class Keeper:
    """Owns the life of one robot. ``tell`` is how the session learns that the robot has stopped by itself or is lost;
    when it returns, the epoch has advanced."""

    def __init__(
        self, robot: Robot, part: Part[Robot], epoch: Epoch, emit: Emit, tell: Callable[[Halted], None]
    ) -> None:
        self._robot = robot
        self._part = part
        self._epoch = epoch
        self._emit = emit
        self._tell = tell
        self._tries: deque[float] = deque(maxlen=len(PAUSES_S))  # when the last ones were, loop time

    async def keep(self, on_start: Callable[[Robot], None]) -> None:
        """Start the robot and keep it until this is cancelled or it cannot be had any more; then close it.

        ``on_start`` is called once, with the robot as it stands at the beginning.
        """

        async def first() -> Robot:
            robot = await self._start()
            on_start(robot)
            return robot

        try:
            await self._part.load(first, _name)
            while self._part.value is not None:
                try:
                    await company(self._robot, self._emit, lambda reason, epoch: self._tell(Halted(reason, epoch)))
                except RobotError as error:
                    await self._get_back(error)
                except Exception as error:  # noqa: BLE001 - nobody keeps the robot any more: that must be told
                    fault = RobotError(f"Keeping the robot failed: {error!r}.", hint="Please report it.")
                    self._tell(Halted(fault.message, lost=True))
                    self._part.fail(fault)
            self._emit(ErrorRaised("robot_lost", self._part.status.detail, fatal=True))
        finally:
            await self._robot.close()

    async def _start(self) -> Robot:
        await self._robot.start()
        self._epoch.tell_again()  # an interruption may have come before the robot could hear of it
        return self._robot

    async def _get_back(self, error: RobotError) -> None:
        self._tell(Halted(error.message, lost=True))
        self._emit(ErrorRaised(error.code, error.message, "It has stopped. It is being restarted where it was."))
        await self._part.load(lambda: self._start_again(error), _name)
        if self._part.value is not None:
            self._emit(Log("info", "robot", "The robot is running again where it was."))

    async def _start_again(self, lost: RobotError) -> Robot:
        """The robot, after as many tries as it takes and is allowed. Raises what the last one failed with."""
        now = asyncio.get_running_loop().time
        for pause in PAUSES_S:
            if len(self._tries) == len(PAUSES_S) and now() - self._tries[0] < WINDOW_S:
                message = f"The robot was lost too often within {WINDOW_S:g} s, the last time so: {lost.message}"
                raise RobotError(message, hint="Start sayso again.")
            await asyncio.sleep(pause)
            self._tries.append(now())
            try:
                return await self._start()
            except RobotError as error:
                lost = error
        raise lost


def _name(robot: Robot) -> str:
    return robot.name
