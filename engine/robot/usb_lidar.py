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
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.errors import DeviceError, UsageError
from engine.robot.description import Hull, LidarOf
from engine.robot.lidar import Turn, outside
from engine.scheduling import prefer
from engine.serial_port import opened

AGAIN_S: Final = 1.0
"""Between two tries to open a lidar that is not there."""
STILL_S: Final = 4.0
"""Without a whole turn for so long, it is opened again; a motor needs some of it to start."""
LONGEST_S: Final = 0.5
"""What takes longer is no turn: something is missing in it."""
SECTORS: Final = 36
"""Of a turn; in every one something must have been measured, be it that there is nothing."""
LEAST_SEEN: Final = 0.03
"""Of the points of a turn; a lidar that sees less is covered."""
_PIECE_S: Final = 0.005
"""Between two reads, so that a thread that shares the interpreter with a control loop wakes seldom."""
_AROUND: Final = 400.0
"""deg; what is beyond is no angle. Some lidars correct theirs a little beyond a turn."""


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
        prefer()  # whoever stops the robot may have to wait for this thread to let go of the interpreter
        while not self._closing.is_set():
            try:
                self._read_on()
            except DeviceError as error:
                self.trouble = error.message
            except Exception as error:  # noqa: BLE001 - lds2d and pyserial, on whatever comes over a cable
                self.trouble = f"The lidar on {self._port} has a fault: {error!r:.120}."
            self._closing.wait(AGAIN_S)

    def _read_on(self) -> None:
        """Read until it is closed. Raises :class:`DeviceError` when it is lost, or cannot be opened."""
        from lds2d.core import NotSupportedError

        wire = _Patient(self._open_wire(self._port, self._driver.DEFAULT_BAUD), self._port, self._closing, self._clock)
        lidar: Any = None
        try:
            lidar = self._driver(wire)
            with contextlib.suppress(NotSupportedError):  # those that spin by themselves
                lidar.start()
            self._collect(lidar, wire)
        except OSError as error:
            raise DeviceError(f"The lidar on {self._port} was unplugged.") from error
        except _Closed:
            pass
        finally:
            with contextlib.suppress(Exception):  # it may be gone
                lidar.stop()
            with contextlib.suppress(OSError):
                wire.close()

    def _collect(self, lidar: Any, wire: _Patient) -> None:
        """One whole turn after another, from wherever it begins: the way from point to point is added up, for angles
        hop to and fro a little, and one that was misread hops there and back."""
        polar: list[tuple[float, float, float]] = []  # deg, m, s
        sectors: set[int] = set()
        points, way, before, began = 0, 0.0, math.nan, self._clock()
        for point in lidar.points():
            if not -_AROUND < point.angle_deg < _AROUND:
                continue
            angle, now = point.angle_deg % 360, self._clock()
            if now - began > LONGEST_S:
                polar, sectors, points, way, before, began = [], set(), 0, 0.0, math.nan, now
            way += 0.0 if math.isnan(before) else (angle - before + 180) % 360 - 180
            before = angle
            points += 1
            sectors.add(int(angle * SECTORS / 360) % SECTORS)
            distance = point.dist_mm / 1000
            if 0 < distance <= self._about.range:
                polar.append((angle, distance, now))
            if abs(way) >= 360 and len(sectors) == SECTORS:
                wire.turned()
                if len(polar) > LEAST_SEEN * points:
                    self._turns.append(self._turn(polar))
                    self.trouble = ""
                else:
                    self.trouble = f"The lidar on {self._port} sees nothing. Is it covered?"
                polar, sectors, points, way, began = [], set(), 0, 0.0, now

    def _turn(self, polar: list[tuple[float, float, float]]) -> Turn:
        angles, distances, times = np.array(polar).T
        around = np.radians((-angles if self._about.clockwise else angles) + self._about.turned)
        seen = np.column_stack((np.cos(around), np.sin(around))) * distances[:, None]
        seen += self._about.at
        foreign = outside(seen, self._hull.length, self._hull.width)
        return Turn(seen[foreign], times[foreign])


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
    """A wire that gives up when no whole turn comes any more, or nobody wants one."""

    def __init__(self, wire: Wire, port: str, closing: threading.Event, clock: Callable[[], float]) -> None:
        self._wire, self._port, self._closing, self._clock = wire, port, closing, clock
        self._turned = clock()

    def turned(self) -> None:
        """A turn has come."""
        self._turned = self._clock()

    def read(self, size: int) -> bytes:
        if self._closing.is_set():
            raise _Closed
        data = self._wire.read(size)
        if self._clock() - self._turned > STILL_S:
            why = "Is it the right port and model, and does it turn?"
            raise DeviceError(f"The lidar on {self._port} makes no whole turn.", hint=why)
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
        time.sleep(_PIECE_S)
        found: bytes = self._port.read(max(1, min(size, self._port.in_waiting)))
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
