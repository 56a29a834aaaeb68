"""From the robot's camera to its memory: takes a picture, understands it, remembers, and finds out where it stands."""

from __future__ import annotations

import asyncio
from collections.abc import Collection, Sequence

from engine.perception.compass import Heading, heading
from engine.perception.landmarks import Fix, where
from engine.perception.localise import Localiser, replaced
from engine.perception.memory import WorldMemory
from engine.perception.perceive import perceive
from engine.perception.sighting import EVERYTHING, Part, Sight
from engine.perception.walls import WallSighting, walls
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose, wrap
from engine.robot.robot import Robot, RobotState, Scan

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

    async def see(self, parts: Collection[Part] = EVERYTHING) -> Sight:
        """Take a picture and understand it. Raises ``CameraError``.

        With less than everything it is a glance at these ``parts`` alone, which takes less time: nothing is remembered
        of it, because what was not looked for is not gone, and no landmark corrects where the robot stands.
        """
        house = self._robot.floor_map
        if not EVERYTHING.issubset(parts):
            return await asyncio.to_thread(perceive, await self._robot.look(), house, parts)
        async with self._one_by_one:
            picture = await self._robot.look()
            facing, seen = _around(self._robot.scan(), self._robot.state(), picture, house)
            sight, fix = await asyncio.to_thread(_understand, picture, house)
            if fix is not None and not house.holds(fix.pose.x, fix.pose.y):
                fix = None  # a tag hangs where it is not on the map, or something only looks like one
            pose = self._localiser.update(picture.t, picture.pose, fix, facing, seen)
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


def _around(
    scan: Scan, now: RobotState, picture: Picture, house: FloorMap
) -> tuple[Heading | None, Sequence[WallSighting]]:
    """What the lidar says about where a picture was taken."""
    facing = heading(scan, now, picture.t, picture.pose) if house.rooms else None
    if facing is None:
        return None, ()
    return facing, walls(scan, now, picture.t, picture.pose, facing, house)


def _within(a: Pose, b: Pose, limits: tuple[float, float]) -> bool:
    return a.distance_to(b) <= limits[0] and abs(wrap(a.yaw - b.yaw)) <= limits[1]
