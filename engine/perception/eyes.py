"""From the robot's camera to its memory: takes a picture, understands it, remembers, and finds out where it stands."""

from __future__ import annotations

import asyncio

from engine.perception.localise import Fix, Localiser, replaced, where
from engine.perception.memory import WorldMemory
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight
from engine.robot.camera import Picture
from engine.robot.robot import FloorMap, Pose, Robot, wrap

SLIGHT = (0.05, 0.03)
"""m and rad: after a greater correction the picture is understood anew, because what is a wall and what is a thing
depends on where the robot stands."""


class Eyes:
    """The eyes of one robot; they live as long as it does. What they see is in ``world``."""

    def __init__(self, robot: Robot, world: WorldMemory) -> None:
        self.world = world
        self._robot = robot
        self._localiser = Localiser()
        self._one_by_one = asyncio.Lock()  # a picture that was taken before a correction knows nothing of it

    async def see(self) -> Sight:
        """Take a picture and understand it. Raises ``CameraError``."""
        house = self._robot.floor_map
        async with self._one_by_one:
            picture = await self._robot.look()
            sight, fix = await asyncio.to_thread(_understand, picture, house)
            pose = self._localiser.update(picture.t, picture.pose, fix)
            if pose != picture.pose:
                self._robot.relocate(picture.pose, pose)
                sight = replaced(sight, pose)
        if not _within(picture.pose, pose, SLIGHT):
            sight, _ = await asyncio.to_thread(_understand, sight.picture, house)
        self.world.update(sight)
        return sight


def _understand(picture: Picture, house: FloorMap) -> tuple[Sight, Fix | None]:
    """What is in a picture, and what the landmarks in it say about where it was taken."""
    sight = perceive(picture, house)
    return sight, where(sight.tags, picture, house.tags)


def _within(a: Pose, b: Pose, limits: tuple[float, float]) -> bool:
    return a.distance_to(b) <= limits[0] and abs(wrap(a.yaw - b.yaw)) <= limits[1]
