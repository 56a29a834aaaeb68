"""The emergency stop of this user's robot: pressed and released from here or from another terminal, and kept.

It is a file in the state folder, for a program that ends must not release it. Pressing it takes effect before the file
is written, in the thread of whoever presses; what another process does with the file is seen within a tenth of a
second.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

LOOK_S: Final = 0.1


class EmergencyStop:
    """``pressed`` is told when it is pressed or released by another process; ``act`` presses it on the robot."""

    def __init__(self, file: Path, act: Callable[[bool], None], told: Callable[[bool], None]) -> None:
        self._file = file
        self._act = act
        self._told = told
        self._pressed = self._is_there()
        if self._pressed:
            act(True)

    @property
    def pressed(self) -> bool:
        return self._pressed

    def press(self, pressed: bool) -> None:
        """Press it, or release it. Thread-safe; a file that cannot be written changes nothing about the robot."""
        self._act(pressed)
        self._pressed = pressed
        with contextlib.suppress(OSError):
            write(self._file, pressed)

    async def keep(self) -> None:
        """Look for what other processes do with it, until this is cancelled."""
        there = self._is_there()
        while True:
            await asyncio.sleep(LOOK_S)
            before, there = there, self._is_there()
            if there != before and there != self._pressed:
                self._told(there)

    def _is_there(self) -> bool:
        try:
            return self._file.exists()
        except OSError:
            return False


def write(file: Path, pressed: bool) -> None:
    """Have it pressed for every program of this user, or released. Raises ``OSError``."""
    if pressed:
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        file.touch(mode=0o600)
    else:
        file.unlink(missing_ok=True)
