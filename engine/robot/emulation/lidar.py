"""A lidar to test on: it speaks as a Slamtec RPLIDAR A1 does, and sees the simulated house around the robot.

It turns while the robot drives, so each point is seen from where the robot is at that moment.
"""

from __future__ import annotations

import math
from typing import Final

from engine.robot.description import LidarOf
from engine.robot.lidar import RAYS
from engine.robot.sim.simulated import SimulatedBody

POINTS_S: Final = 2160
"""Points in a second: six turns of 360."""
_STEP_S: Final = 0.01
"""How long one look into the house holds."""
_SCAN, _STOP = b"\xa5\x20", b"\xa5\x25"
_ANSWER: Final = b"\xa5\x5a\x05\x00\x00\x40\x81"
"""What comes before the points: five bytes each, and many of them."""


class EmulatedLidar:
    """One lidar, on the robot whose body is ``body``."""

    def __init__(self, body: SimulatedBody, about: LidarOf) -> None:
        """``about``: what the description says of it; it sits at the middle of the robot all the same."""
        self._body, self._about = body, about
        self._turns = False
        self._held = b""
        self._out = bytearray()
        self._next = 0  # point of the turn
        self._due = body.t

    def receive(self, data: bytes) -> None:
        """Bytes that have come."""
        self._held = (self._held + data)[-64:]
        if _STOP in self._held:
            self._turns, self._held = False, b""
        elif _SCAN in self._held:
            self._turns, self._held = True, b""
            self._out += _ANSWER
            self._due = self._body.t

    def send(self) -> bytes:
        """Bytes that go out."""
        data = bytes(self._out)
        self._out.clear()
        return data

    def step(self) -> None:
        """Turn on to where it is by now."""
        if not self._turns or self._body.t < self._due:
            return
        self._due += _STEP_S
        ranges = self._body.scan()
        for _ in range(round(POINTS_S * _STEP_S)):
            degrees = self._next * 360 / RAYS
            left = (-degrees if self._about.clockwise else degrees) + self._about.turned
            self._out += _node(degrees, float(ranges[round(left) % RAYS]), first=self._next == 0)
            self._next = (self._next + 1) % RAYS


def _node(degrees: float, distance: float, *, first: bool) -> bytes:
    """A point in five bytes; 0 is a distance that was not measured."""
    quarters = round(4000 * distance) if math.isfinite(distance) and distance < 12 else 0
    angle = round(64 * degrees) << 1 | 1
    quality = (47 << 2 if quarters else 0) | (1 if first else 2)
    return bytes((quality, angle & 255, angle >> 8, quarters & 255, quarters >> 8))
