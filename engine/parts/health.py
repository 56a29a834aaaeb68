"""What must be well around the robot: its battery, the disk, the temperature and the clock of the machine.

Each is told once when it goes bad, and once when it is well again.
"""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from engine.bus import Emit
from engine.errors import RobotError
from engine.events import Log
from engine.parts.part import Loading
from engine.robot.robot import BatteryState, Robot

LOOK_S: Final = 5.0
LEAST_FREE: Final = 200_000_000
"""Bytes on the disk of the logs; below this they may soon not be written."""
HOTTEST_C: Final = 80.0
"""A Raspberry Pi slows down from here on."""
OLDEST: Final = 1_767_225_600.0
"""The beginning of 2026: a clock that is behind it has not been set since the machine was switched on."""
RECOVERY_V: Final = 0.4
"""By so much a low battery must rise to be well again: it does by less as soon as the robot stands."""
THERMAL: Final = Path("/sys/class/thermal")


class Health:
    """Looks after a machine and the robot on it."""

    def __init__(
        self,
        robot: Loading[Robot],
        folder: Path,
        emit: Emit,
        *,
        clock: Callable[[], float] = time.time,
        thermal: Path = THERMAL,
        on_battery: Callable[[BatteryState], object] = lambda battery: None,
    ) -> None:
        """``folder`` is on the disk that is looked at; ``clock`` gives s since 1970; ``on_battery`` is told
        what the battery gives, at each look."""
        self._robot = robot
        self._folder = folder
        self._emit = emit
        self._clock = clock
        self._thermal = thermal
        self._on_battery = on_battery
        self._low: float | None = None  # V of the battery when it became low
        self._told: dict[str, str] = {}

    async def keep(self) -> None:
        """Look again and again, until this is cancelled."""
        while True:
            self.look(dict(await asyncio.to_thread(lambda: list(self._machine()))))
            await asyncio.sleep(LOOK_S)

    def look(self, machine: dict[str, str]) -> None:
        """Tell what has changed; ``machine`` is what is bad about it, by kind."""
        bad = {**machine, **dict(self._battery())}
        for kind, words in bad.items():
            if kind not in self._told:
                self._emit(Log("warning", "machine", words))
        for kind in self._told.keys() - bad.keys():
            self._emit(Log("info", "machine", WELL[kind]))
        self._told = bad

    def _battery(self) -> Iterator[tuple[str, str]]:
        if (robot := self._robot.value) is None:
            return
        with contextlib.suppress(RobotError):  # its loss is told by whoever keeps it
            battery = robot.state().battery
            if battery is None:
                return
            if self._low is not None and battery.volts > self._low + RECOVERY_V:
                self._low = None
            if battery.low and self._low is None:
                self._low = battery.volts
            self._on_battery(battery)
            if self._low is not None:
                yield "battery", f"The battery is low ({battery.volts:g} V): charge it soon."

    def _machine(self) -> Iterator[tuple[str, str]]:
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(self._folder if self._folder.exists() else self._folder.anchor).free
            if free < LEAST_FREE:
                yield "disk", f"The disk has {free / 1e6:.0f} MB left: logs may soon not be written."
        hottest = max(self._temperatures(), default=0.0)
        if hottest > HOTTEST_C:
            yield "temperature", f"The machine is {hottest:.0f} °C hot: it will become slow."
        if self._clock() < OLDEST:
            yield "clock", "The clock of the machine has not been set: times in logs are wrong."

    def _temperatures(self) -> Iterator[float]:
        with contextlib.suppress(OSError):
            for file in self._thermal.glob("thermal_zone*/temp"):
                with contextlib.suppress(OSError, ValueError):
                    yield int(file.read_text()) / 1000


WELL: Final = {
    "battery": "The battery is fine again.",
    "disk": "The disk has room again.",
    "temperature": "The machine has cooled down.",
    "clock": "The clock has been set.",
}
