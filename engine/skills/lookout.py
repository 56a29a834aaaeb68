"""Looking out on the way, for landmarks, so that odometry's error does not grow with it, and for what lies about.

Whenever the robot has driven or turned enough since it last looked, and when it goes straight on after a turn, it takes
a picture while it drives on; the eyes correct what it believes, and the memory learns what lies ahead. In a simulation
at full speed time stands still until somebody ticks, so there the drive waits for the picture, and a journey is the
same at every run. Without a camera the robot drives by odometry alone and says so once.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

from engine.errors import CameraError
from engine.perception.sighting import Sight
from engine.robot.geometry import wrap
from engine.skills.context import SkillContext

Motion = tuple[float, float]
"""A way and a turn, m and rad."""

OFTEN: Final[Motion] = (0.4, math.radians(20))
"""The robot drives or turns so far before it looks again…"""
ARRIVED: Final[Motion] = (0.1, math.radians(8))
"""…and before it goes straight on, or believes that it is there."""
STRAIGHT: Final = 0.3
"""rad/s below which it goes straight on."""
PATIENCE_S: Final = 0.02
"""How long to wait for a clock that may stand still, s."""


class Lookout:
    """Looks while somebody else drives; see :func:`lookout`."""

    def __init__(self, context: SkillContext) -> None:
        self._context = context
        self._useful = "camera" in context.robot.capabilities
        self._landmarks = bool(context.robot.floor_map.tags)
        self._last = context.pose
        self._way = self._turn = 0.0
        self._turned = True  # nobody knows how far it has come since it last looked
        self._look: asyncio.Task[Sight] | None = None

    async def go_on(self) -> None:
        """Called in every control tick: looks where that is due, and takes in what was seen."""
        if not self._useful:
            return
        self._moved()
        straight = abs(self._context.robot.state().twist.wz) < STRAIGHT
        self._turned = self._turned or self._turn >= ARRIVED[1]
        if self._look is None and (self._beyond(OFTEN) or (straight and self._turned)):
            self._begin()
        if self._look is not None:
            await self._while_time_stands_still(self._look)
            if self._look.done():
                self._end(self._look)

    async def confirm(self) -> bool:
        """Look where the robot stands, unless it has hardly moved since it last did: whether that changed what it
        believes."""
        if not (self._useful and self._landmarks):
            return False
        self._moved()
        believed = self._last
        if self._look is None and self._beyond(ARRIVED):
            self._begin()
        if self._look is not None:
            await asyncio.wait({self._look})
            self._end(self._look)
            await self._context.robot.tick()  # in which a correction shows
        return self._context.pose != believed

    async def close(self) -> None:
        """Leave nothing behind."""
        if self._look is not None:
            self._look.cancel()
            await asyncio.wait({self._look})

    def _moved(self) -> None:
        """Add up the motion since the last picture; a correction counts too, and does no harm."""
        last, self._last = self._last, self._context.pose
        self._way += last.distance_to(self._last)
        self._turn += abs(wrap(self._last.yaw - last.yaw))

    def _beyond(self, limits: Motion) -> bool:
        return self._way >= limits[0] or self._turn >= limits[1]

    def _begin(self) -> None:
        self._look = asyncio.create_task(self._context.see())
        self._way = self._turn = 0.0
        self._turned = False

    async def _while_time_stands_still(self, look: asyncio.Task[Sight]) -> None:
        began = self._context.robot.state().t
        while not look.done() and self._context.robot.state().t == began:
            await asyncio.wait({look}, timeout=PATIENCE_S)

    def _end(self, look: asyncio.Task[Sight]) -> None:
        self._look = None
        try:
            look.result()
        except CameraError as error:
            self._useful = False
            self._context.progress(None, f"I drive without looking: {error.message}")


@asynccontextmanager
async def lookout(context: SkillContext) -> AsyncIterator[Lookout]:
    """For the time of a drive."""
    watch = Lookout(context)
    try:
        yield watch
    finally:
        await watch.close()
