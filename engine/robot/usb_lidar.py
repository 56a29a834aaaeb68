"""A lidar on a serial port, which is read by lds2d. It comes and goes without anybody else noticing more than that.

A thread reads it. Every point keeps the moment at which it came: a turn takes up to a fifth of a second, in which the
robot drives on, and whoever makes a scan of it must know from where each was seen.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.errors import DeviceError, UsageError
from engine.robot.description import Hull, LidarOf
from engine.robot.geometry import Pose
from engine.serial_port import opened

AGAIN_S: Final = 1.0
"""Between two tries to open a lidar that is not there."""
SILENT_S: Final = 2.0
"""Without a byte for so long, it is opened again; a motor needs one to start."""
_MOST_POINTS: Final = 20_000
"""Of a turn; more than any lidar has."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn: points in the base frame that the robot had when each came, shape (n, 2), m, and those moments, s."""

    points: NDArray[np.float64]
    times: NDArray[np.float64]

    def seen_from(self, been: NDArray[np.float64], here: Pose) -> NDArray[np.float64]:
        """Its points as they lie around the robot that is ``here`` by now, shape (n, 2), m. ``been`` is where it was:
        rows of s, m, m and rad, in the order of time; in between, it is interpolated."""
        when = been[:, 0]
        x, y = np.interp(self.times, when, been[:, 1]), np.interp(self.times, when, been[:, 2])
        yaw = np.interp(self.times, when, np.unwrap(been[:, 3]))
        cos, sin = np.cos(yaw), np.sin(yaw)
        ahead, aside = self.points.T
        there = np.column_stack((x + cos * ahead - sin * aside - here.x, y + sin * ahead + cos * aside - here.y))
        c, s = math.cos(here.yaw), math.sin(here.yaw)
        around: NDArray[np.float64] = there @ np.array([[c, -s], [s, c]])
        return around


class Wire(Protocol):
    """What lds2d reads from and writes to; ``read`` blocks for a moment at most. They raise ``OSError`` where it is
    gone."""

    def read(self, size: int) -> bytes: ...
    def write(self, data: bytes) -> int: ...
    def close(self) -> None: ...


OpenWire = Callable[[str, int], Wire]


class UsbLidar:
    """One lidar, read in the background until it is closed."""

    def __init__(
        self,
        port: str,
        about: LidarOf,
        hull: Hull,
        *,
        clock: Callable[[], float] = time.monotonic,
        open_wire: OpenWire | None = None,
    ) -> None:
        """What it sees within ``hull`` is the robot itself. Raises :class:`UsageError` where lds2d knows no such
        model."""
        self._port, self._about, self._hull, self._clock = port, about, hull, clock
        self._driver = driver_of(about)
        self._open_wire = open_wire or _opened
        self._turns: deque[Turn] = deque(maxlen=1)
        self.trouble = "it has not been opened"
        """Why there are no turns; empty where there are."""
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="lidar", daemon=True)
        self._thread.start()

    def newest(self) -> Turn | None:
        """The newest turn; None where there is none that is newer than the last one that was asked for."""
        with contextlib.suppress(IndexError):
            return self._turns.pop()
        return None

    def close(self) -> None:
        """Let go of it; its motor is told to stand."""
        self._closing.set()
        self._thread.join(AGAIN_S)

    def _keep(self) -> None:
        while not self._closing.is_set():
            try:
                self._read_on()
            except DeviceError as error:
                self.trouble = error.message
            self._closing.wait(AGAIN_S)

    def _read_on(self) -> None:
        """Read until it is closed. Raises :class:`DeviceError` when it is lost, or cannot be opened."""
        wire = _Patient(self._open_wire(self._port, self._driver.DEFAULT_BAUD), self._port, self._closing, self._clock)
        lidar: Any = self._driver(wire)
        try:
            self._collect(lidar)
        except OSError as error:
            raise DeviceError(f"The lidar on {self._port} was unplugged.") from error
        except _Closed:
            pass
        finally:
            with contextlib.suppress(Exception):  # those that spin by themselves cannot be told to stand
                lidar.stop()
            with contextlib.suppress(OSError):
                wire.close()

    def _collect(self, lidar: Any) -> None:
        """One turn after another; a new one begins where the angle falls by more than half a turn."""
        polar: list[tuple[float, float, float]] = []  # deg, m, s
        before = 0.0
        for point in lidar.points():
            if (point.angle_deg + 180 < before or len(polar) > _MOST_POINTS) and polar:
                self._turns.append(self._turn(polar))
                self.trouble = ""
                polar = []
            before = point.angle_deg
            distance = point.dist_mm / 1000
            if 0 < distance <= self._about.range:
                polar.append((point.angle_deg, distance, self._clock()))

    def _turn(self, polar: list[tuple[float, float, float]]) -> Turn:
        angles, distances, times = np.array(polar).T
        around = np.radians((-angles if self._about.clockwise else angles) + self._about.turned)
        seen = np.column_stack((np.cos(around), np.sin(around))) * distances[:, None]
        seen += self._about.at
        own = (np.abs(seen[:, 0]) < self._hull.length / 2) & (np.abs(seen[:, 1]) < self._hull.width / 2)
        return Turn(seen[~own], times[~own])


def driver_of(about: LidarOf) -> Any:
    """The class of lds2d that reads this lidar. Raises :class:`UsageError`."""
    import lds2d
    import lds2d.drivers
    from lds2d.core import driver_for

    found = driver_for(about.model or "")
    if found is None or found.NEEDS_MOTOR:
        why = "its motor wants a pin of this machine" if found is not None else "lds2d does not know it"
        known = [name for name in lds2d.available_models() if "_" not in name and not driver_for(name).NEEDS_MOTOR]
        raise UsageError(f"A lidar {about.model!r} cannot be read: {why}.", hint=f"Those can: {', '.join(known)}.")
    return found


def in_words(points: NDArray[np.float64]) -> str:
    """What a turn has seen, so that a person can tell whether it is so: the nearest points, from the robot's centre."""
    if not len(points):
        return "sees nothing"
    away = np.hypot(points[:, 0], points[:, 1])
    x, y = points[int(np.argmin(away))].tolist()
    side = "left" if y > 0 else "right"
    turn = abs(math.degrees(math.atan2(y, x)))
    return f"{len(points)} points; the nearest {away.min():.2f} m away, {turn:.0f}° to the {side}"


class _Closed(Exception):
    """Nobody wants to read any more."""


class _Patient:
    """A wire that gives up when nothing comes any more, or nobody wants it."""

    def __init__(self, wire: Wire, port: str, closing: threading.Event, clock: Callable[[], float]) -> None:
        self._wire, self._port, self._closing, self._clock = wire, port, closing, clock
        self._heard = clock()

    def read(self, size: int) -> bytes:
        if self._closing.is_set():
            raise _Closed
        data = self._wire.read(size)
        now = self._clock()
        if data:
            self._heard = now
        elif now - self._heard > SILENT_S:
            raise DeviceError(f"The lidar on {self._port} is silent.", hint="Is it the right port, and does it turn?")
        return data

    def write(self, data: bytes) -> int:
        return self._wire.write(data)

    def close(self) -> None:
        self._wire.close()


class _Opened:
    """A serial port: what has come, as soon as something has."""

    def __init__(self, port: Any) -> None:
        self._port = port

    def read(self, size: int) -> bytes:
        found: bytes = self._port.read(min(size, max(1, self._port.in_waiting)))
        return found

    def write(self, data: bytes) -> int:
        written: int = self._port.write(data)
        return written

    def close(self) -> None:
        self._port.close()


def _opened(path: str, baud: int) -> Wire:
    port = opened(path, "robot.lidar", "`sayso robot check` lists the ports there are.", baud=baud)
    port.timeout = 0.1
    return _Opened(port)
