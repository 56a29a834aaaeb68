"""Pictures as ROS sends them: ``Image``, ``CompressedImage`` and ``CameraInfo`` into arrays. One that makes no sense is
none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Lens
from engine.ros.door import octets

IMAGE: Final = "sensor_msgs/msg/Image"
COMPRESSED: Final = "sensor_msgs/msg/CompressedImage"
INFO: Final = "sensor_msgs/msg/CameraInfo"
_MOST_PIXELS: Final = 4096 * 4096
_COLOURS: Final = {
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "8UC3": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
    "mono8": (1, (0, 0, 0)),
    "8UC1": (1, (0, 0, 0)),
}
"""By encoding: octets a pixel, and which of them are red, green and blue."""
_DEPTHS: Final = {"16UC1": (2, 0.001), "mono16": (2, 0.001), "32FC1": (4, 1.0)}
"""By encoding: octets a pixel, and what one is in m."""


def colours(message: Mapping[str, Any]) -> NDArray[np.uint8] | None:
    """RGB, shape (height, width, 3), of an ``Image``."""
    if (about := _COLOURS.get(str(message.get("encoding")))) is None:
        return None
    deep, order = about
    if (rows := _rows(message, deep)) is None:
        return None
    pixels = rows.reshape(rows.shape[0], -1, deep)
    return np.ascontiguousarray(pixels[:, :, list(order)])


def depths(message: Mapping[str, Any]) -> NDArray[np.float32] | None:
    """Distances along the line of sight, shape (height, width), m, inf where none was measured, of an ``Image``."""
    if (about := _DEPTHS.get(str(message.get("encoding")))) is None:
        return None
    deep, unit = about
    if (rows := _rows(message, deep)) is None:
        return None
    kind = ("u" if deep == 2 else "f") + str(deep)
    order = ">" if message.get("is_bigendian") else "<"
    found = np.ascontiguousarray(rows).view(order + kind).astype(np.float32) * np.float32(unit)
    found[~(np.isfinite(found) & (found > 0))] = np.inf
    return found


def unpacked(message: Mapping[str, Any]) -> NDArray[np.uint8] | None:
    """RGB, shape (height, width, 3), of a ``CompressedImage``."""
    import cv2

    data = octets(message.get("data"))
    if not data:
        return None
    try:
        bgr = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if bgr is None:
        return None
    rgb: NDArray[np.uint8] = np.ascontiguousarray(bgr[:, :, ::-1])
    return rgb


def lens(message: Mapping[str, Any], width: int, height: int) -> Lens | None:
    """The lens that a ``CameraInfo`` tells, for pictures brought to this size."""
    try:
        k = [float(value) for value in message["k"]]
        across, down = width / float(message["width"]), height / float(message["height"])
        found = Lens(width, height, k[0] * across, k[4] * down, k[2] * across, k[5] * down)
    except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError, OverflowError):
        return None
    numbers = (found.fx, found.fy, found.cx, found.cy)
    return found if all(math.isfinite(n) and n > 0 for n in numbers) else None


def _rows(message: Mapping[str, Any], deep: int) -> NDArray[np.uint8] | None:
    """The octets of an ``Image``, a row each, without what fills a row up."""
    try:
        width, height, step = (int(message[name]) for name in ("width", "height", "step"))
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    data = octets(message.get("data"))
    if data is None or not 0 < width * height <= _MOST_PIXELS or step < width * deep or len(data) < step * height:
        return None
    return np.frombuffer(data, np.uint8, step * height).reshape(height, step)[:, : width * deep]
