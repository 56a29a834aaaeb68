"""The camera of a robot of ROS 2, with a door that a test holds in its hand."""

from __future__ import annotations

import asyncio
import os
from typing import Any

import numpy as np
import pytest

from config.schema import Camera as CameraSettings
from engine.robot.camera import Picture
from engine.robot.description import described
from engine.robot.host.memory import Memory
from engine.robot.ros2.camera import RosCamera
from engine.ros.door import Take
from tests.eval.runner import ROS_ARM_MODEL


class Topics:
    """A door by which pictures come."""

    trouble = ""

    def __init__(self) -> None:
        self.takes: dict[str, Take] = {}

    def subscribe(self, topic: str, type: str, take: Take, **how: Any) -> None:
        self.takes[topic] = take

    def close(self) -> None:
        """Nothing is held."""

    def colours(self, stamp: float | None) -> None:
        self.takes["/camera/color/image_raw"](image("rgb8", 3, bytes(24), stamp))

    def depths(self, stamp: float | None, metres: float) -> None:
        data = np.full(8, 1000 * metres, "<u2").tobytes()
        self.takes["/camera/aligned_depth_to_color/image_raw"](image("16UC1", 2, data, stamp))


def image(encoding: str, deep: int, data: bytes, stamp: float | None) -> dict[str, Any]:
    whole = int(stamp or 0)
    header = {"stamp": {"sec": whole, "nanosec": int(1e9 * ((stamp or 0) - whole))}}
    return {"header": header, "width": 4, "height": 2, "step": 4 * deep, "encoding": encoding, "data": data}


async def looked(topics: Topics, *come: Any) -> Picture:
    """The picture that is had when these come after it was asked for."""
    memory = Memory.create()
    settings = CameraSettings(backend="auto", width=64, height=48)
    camera = RosCamera(topics, settings, described(str(ROS_ARM_MODEL)), memory, lambda news: None)  # type: ignore[arg-type]
    looking = asyncio.create_task(camera.look())
    await asyncio.sleep(0)
    for act in come:
        act()
        for _ in range(5):  # until whoever waits has seen it
            await asyncio.sleep(0)
    picture = await looking
    await camera.close()
    os.close(memory.fd)
    return picture


def test_colours_get_the_depth_of_the_same_picture_and_not_of_the_one_before() -> None:
    topics = Topics()
    picture = asyncio.run(
        looked(
            topics,
            lambda: topics.depths(100.0, 3.0),
            lambda: topics.colours(100.2),
            lambda: topics.depths(100.2, 1.5),
        )
    )
    assert picture.depth[0, 0] == pytest.approx(1.5)


def test_pictures_without_stamps_go_together_as_they_come() -> None:
    topics = Topics()
    picture = asyncio.run(looked(topics, lambda: topics.depths(None, 3.0), lambda: topics.colours(None)))
    assert picture.depth[0, 0] == pytest.approx(3.0)
