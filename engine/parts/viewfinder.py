"""Pictures for people who look on: one for each time that somebody asks, with what perception recognises in it.

Nothing is remembered of such a picture, and no landmark in it corrects where the robot stands: looking on changes
nothing. While nobody looks on there is no picture and no work. The camera serves in the order of asking, so a skill
waits for at most one picture of somebody else.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from engine.errors import CameraError, RobotError, SaysoError
from engine.parts.part import Loading
from engine.perception.onlooker import Onlooker
from engine.perception.sighting import Sight
from engine.robot.robot import Robot

Deliver = Callable[[Sight | SaysoError], object]
"""Gets the picture, or why there is none; in the engine's thread, and must not block."""


class Viewfinder:
    """Takes pictures of one robot in one asyncio loop, for others who may be in any thread. Whoever makes it closes
    it, in the loop. ``prompt``: see ``engine.scheduling.workers``."""

    def __init__(self, robot: Loading[Robot], loop: asyncio.AbstractEventLoop, *, prompt: bool = False) -> None:
        self._robot = robot
        self._loop = loop
        self._looking: set[asyncio.Task[None]] = set()
        self._onlooker = Onlooker(prompt=prompt)

    def look(self, deliver: Deliver) -> None:
        """Ask for a picture. Thread-safe."""
        try:
            self._loop.call_soon_threadsafe(self._begin, deliver)
        except RuntimeError:  # the loop is closed
            deliver(CameraError("The engine has ended."))

    async def close(self) -> None:
        """Take no more pictures, and leave nothing behind."""
        for task in self._looking:
            task.cancel()
        await asyncio.gather(*self._looking, return_exceptions=True)
        await self._onlooker.close()

    def _begin(self, deliver: Deliver) -> None:
        task = asyncio.get_running_loop().create_task(self._look(deliver))
        self._looking.add(task)  # a loop keeps no task alive
        task.add_done_callback(self._looking.discard)

    async def _look(self, deliver: Deliver) -> None:
        robot = self._robot.value
        if robot is None:
            deliver(CameraError("The robot is not there yet."))
            return
        self._onlooker.begin()
        try:
            deliver(await self._onlooker.perceive(await robot.look(), robot.floor_map))
        except (CameraError, RobotError) as error:
            deliver(error)
