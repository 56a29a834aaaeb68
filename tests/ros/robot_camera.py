"""The camera of :mod:`tests.ros.robot`: its topics, and a program that takes its pictures. As drivers do, it takes none
while nobody listens."""

from __future__ import annotations

import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.qos import QoSProfile  # type: ignore[import-not-found]
from sensor_msgs.msg import CameraInfo, CompressedImage, Image  # type: ignore[import-not-found]

from tests.ros.lines import Line, Program

FRAME = "camera_color_optical_frame"
COLOURS, DEPTHS = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
PACKED, INFO = "/camera/color/image_raw/compressed", "/camera/color/camera_info"


class Camera:
    """Publishes pictures of what it is shown, one at a time, each with the stamp of what it shows."""

    def __init__(self, node: Any, python: Path, surroundings: Mapping[str, str], *more: str) -> None:
        qos = QoSProfile(depth=1)
        self._colours = node.create_publisher(Image, COLOURS, qos)
        self._depths = node.create_publisher(Image, DEPTHS, qos)
        self._packed = node.create_publisher(CompressedImage, PACKED, qos)
        self._info = node.create_publisher(CameraInfo, INFO, qos)
        self._lens: Line | None = None
        self._stamp: Any = None  # of the picture that is being taken
        self._program = Program([python, "-m", "tests.ros.photographer", *more], surroundings, self._hear)

    def show(self, qpos: Sequence[float], stamp: Any) -> None:
        """This is how the world is."""
        if self._lens is None or self._stamp is not None:
            return
        packed = self._packed.get_subscription_count() > 0
        if packed or self._colours.get_subscription_count() or self._depths.get_subscription_count():
            self._stamp = stamp
            self._program.tell({"qpos": qpos, "packed": packed})
        self._info.publish(self._of_lens(self._lens, stamp))

    def close(self) -> None:
        self._program.close()

    def _hear(self, line: Line) -> None:
        if "focal" in line:
            self._lens = line
            return
        stamp, self._stamp = self._stamp, None
        self._colours.publish(self._image("rgb8", 3, line["rgb"], stamp))
        self._depths.publish(self._image("16UC1", 2, line["depth"], stamp))
        if "jpeg" in line:
            packed = CompressedImage(format="rgb8; jpeg compressed bgr8", data=array.array("B", line["jpeg"]))
            packed.header.stamp, packed.header.frame_id = stamp, FRAME
            self._packed.publish(packed)

    def _image(self, encoding: str, deep: int, data: bytes, stamp: Any) -> Any:
        assert self._lens is not None, "that comes first"
        width, height = self._lens["width"], self._lens["height"]
        image = Image(width=width, height=height, encoding=encoding, step=deep * width, data=array.array("B", data))
        image.header.stamp, image.header.frame_id = stamp, FRAME
        return image

    def _of_lens(self, lens: Line, stamp: Any) -> Any:
        width, height, focal = lens["width"], lens["height"], lens["focal"]
        info = CameraInfo(width=width, height=height, distortion_model="plumb_bob", d=[0.0] * 5)
        info.header.stamp, info.header.frame_id = stamp, FRAME
        info.k = [focal, 0.0, width / 2, 0.0, focal, height / 2, 0.0, 0.0, 1.0]
        info.p = [focal, 0.0, width / 2, 0.0, 0.0, focal, height / 2, 0.0, 0.0, 0.0, 1.0, 0.0]
        info.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        return info
