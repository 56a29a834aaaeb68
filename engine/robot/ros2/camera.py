"""The camera of a robot of ROS 2: colours, and depth where it has any, each on a topic.

It has a door of its own, in the engine's process: pictures may take their time, and the host waits for nobody.
"""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from config.schema import Camera as CameraSettings
from engine.errors import CameraError
from engine.robot.camera import Lens, Picture, floor_depth
from engine.robot.camera_news import Lost, Opened, Opening, TellOfCamera
from engine.robot.description import Description
from engine.robot.host.memory import Memory, believed
from engine.robot.ros2 import pictures
from engine.robot.ros2.messages import stamp
from engine.ros.door import Door, Message

EVERY_S: Final = 0.1
"""More pictures than that nobody looks at."""
LATE_S: Final = 3.0
"""In which a picture must come."""
TOGETHER_S: Final = 0.07
"""By so much the depth of a picture may be older or newer than its colours, by their stamps."""
CAME_TOGETHER_S: Final = 0.2
"""The same by when they came, where they have no stamps."""


@dataclass(frozen=True, slots=True)
class _Image:
    """What came on one of the topics."""

    came: float  # loop time, s
    stamp: float | None  # by the clock of the robot, s
    pixels: NDArray[Any]

    def goes_with(self, other: _Image) -> bool:
        """Whether both are of one picture."""
        if self.stamp is None or other.stamp is None:
            return abs(self.came - other.came) <= CAME_TOGETHER_S
        return abs(self.stamp - other.stamp) <= TOGETHER_S


class RosCamera:
    """One camera, in one asyncio loop, in which ``tell`` is called too."""

    pid: int | None = None
    """It has no process of its own."""

    def __init__(
        self, door: Door, settings: CameraSettings, description: Description, memory: Memory, tell: TellOfCamera
    ) -> None:
        """``memory`` is what the host fills; ``door`` is closed with it."""
        assert description.camera is not None, "whoever makes one knows"
        assert description.ros is not None, "the same"
        assert description.ros.camera is not None, "the same"
        self._door = door
        self._description, self._topics = description, description.ros.camera
        self._view = np.radians(description.camera.view)
        self._size = settings.width, settings.height
        self._memory = memory
        self._tell = tell
        self._loop = asyncio.get_running_loop()
        self._colours: _Image | None = None
        self._depths: _Image | None = None
        self._lens: Lens | None = None
        self._came = asyncio.Event()
        self._is_there = False
        tell(Opening())
        type = pictures.COMPRESSED if self._topics.compressed else pictures.IMAGE
        door.subscribe(self._topics.image, type, self._take_colours, every_s=EVERY_S)
        if self._topics.info is not None:
            door.subscribe(self._topics.info, pictures.INFO, self._take_lens, every_s=1.0)
        if self._topics.depth is not None:
            door.subscribe(self._topics.depth, pictures.IMAGE, self._take_depths, every_s=EVERY_S)

    async def look(self, *, labels: bool = False) -> Picture:
        """A picture that comes from now on. Raises ``CameraError``."""
        del labels
        asked = self._loop.time()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LATE_S):
                while (found := self._picture(asked)) is None:
                    self._came.clear()
                    await self._came.wait()
                return found
        why = self._door.trouble or f"nothing comes on {self._topics.image}"
        if self._colours is not None and self._colours.came >= asked:
            why = f"no depth comes on {self._topics.depth}"
        error = CameraError(f"The camera has delivered no picture for {LATE_S:g} s: {why}.")
        if self._is_there:
            self._is_there = False
            self._tell(Lost(error))
        raise error

    async def close(self) -> None:
        """Let go of it."""
        await asyncio.to_thread(self._door.close)

    def _picture(self, asked: float) -> Picture | None:
        import cv2

        if self._colours is None or self._colours.came < asked:
            return None
        width, height = self._size
        lens = self._lens or Lens.of_view(width, height, self._view)
        record = self._memory.state.get()
        mount = self._description.eye(record["joints"].tolist())
        pose = believed(record, self._memory.correction.scratch)
        small: NDArray[np.uint8] = np.asarray(
            cv2.resize(self._colours.pixels, self._size, interpolation=cv2.INTER_AREA), np.uint8
        )
        if self._topics.depth is None:
            return Picture(float(record["t"]), small, floor_depth(lens, mount), lens, mount, pose, guessed=True)
        if self._depths is None or not self._depths.goes_with(self._colours):
            return None
        depth = cv2.resize(self._depths.pixels, self._size, interpolation=cv2.INTER_NEAREST).astype(np.float32)
        return Picture(float(record["t"]), small, depth, lens, mount, pose)

    # In the door's thread

    def _take_colours(self, message: Message) -> None:
        found = pictures.unpacked(message) if self._topics.compressed else pictures.colours(message)
        if found is not None:
            self._soon(lambda: self._has_colours(_Image(self._loop.time(), stamp(message), found)))

    def _take_depths(self, message: Message) -> None:
        found = pictures.depths(message)
        if found is not None:
            self._soon(lambda: self._has_depths(_Image(self._loop.time(), stamp(message), found)))

    def _take_lens(self, message: Message) -> None:
        self._lens = pictures.lens(message, *self._size) or self._lens

    def _soon(self, act: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has been closed
            self._loop.call_soon_threadsafe(act)

    # In the loop

    def _has_colours(self, found: _Image) -> None:
        self._colours = found
        if not self._is_there:
            self._is_there = True
            height, width = found.pixels.shape[:2]
            depth = "with depth" if self._topics.depth is not None else "no depth"
            self._tell(Opened(f"{self._topics.image} {width}×{height}, {depth}"))
        self._came.set()

    def _has_depths(self, found: _Image) -> None:
        self._depths = found
        self._came.set()
