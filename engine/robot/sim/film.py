"""The memory that the engine and the camera process share: one picture, and the state of the robot it was taken in.

Whoever asks for a picture owns the film until the next request; the link between the two says when the picture is on
it. Like the robot's memory it has no name, so nothing is left over however the processes end.
"""

from __future__ import annotations

import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.robot.host.memory import Record
from engine.unnamed import unnamed_file

_TAKEN = np.dtype([("t", "f8"), ("pose", "f8", 3), ("correction", "f8", 3), ("joints", "f8", 5), ("alive", "f8")])


class Film:
    """Room for one picture, over a file descriptor that both processes have."""

    def __init__(self, fd: int, width: int, height: int) -> None:
        self.fd = fd
        buffer = mmap.mmap(fd, _size(width, height))
        pixels, offset = width * height, _TAKEN.itemsize
        self._taken: NDArray[Any] = np.ndarray((1,), _TAKEN, buffer, 0)
        self.depth: NDArray[np.float32] = np.ndarray((height, width), np.float32, buffer, offset)
        self.labels: NDArray[np.int32] = np.ndarray((height, width), np.int32, buffer, offset + 4 * pixels)
        self.rgb: NDArray[np.uint8] = np.ndarray((height, width, 3), np.uint8, buffer, offset + 8 * pixels)

    @classmethod
    def create(cls, width: int, height: int) -> Film:
        """New film behind a file without a name. The caller closes ``fd``."""
        return cls(unnamed_file("sayso-camera", _size(width, height)), width, height)

    @property
    def taken(self) -> Record:
        """When and where: time, believed pose with its correction, and measured joints, of one and the same state. And
        ``alive``: when the camera process last showed that it is, s of ``time.monotonic()``."""
        return self._taken[0]


def _size(width: int, height: int) -> int:
    return _TAKEN.itemsize + 11 * width * height
