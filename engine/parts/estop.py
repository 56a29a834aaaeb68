"""The emergency stop of this user's robot: pressed and released from here or from another terminal, and kept.

It is a file in the state folder, for a program that ends must not release it. Pressing it takes effect before the file
is written, in the thread of whoever presses; what another process does with the file is seen within a tenth of a
second. A file that cannot be looked at releases nothing.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final

LOOK_S: Final = 0.1


class EmergencyStop:
    """``act`` presses it on the robot, or releases it; ``told`` hears that another process did. Thread-safe."""

    def __init__(
        self,
        file: Path,
        act: Callable[[bool], None],
        told: Callable[[bool], None],
        warn: Callable[[str], None] = lambda words: None,
    ) -> None:
        """``warn`` gets a sentence where it could not be kept in the file."""
        self._file = file
        self._act = act
        self._told = told
        self._warn = warn
        self._order = threading.Lock()
        self._pressed = False
        self._noticed = False  # that another process has removed the file
        if self._is_there():
            self._pressed = True
            act(True)

    @property
    def pressed(self) -> bool:
        return self._pressed

    def press(self, pressed: bool) -> None:
        """Press it, or release it. A file that cannot be written changes nothing about the robot."""
        with self._order:
            self._act(pressed)
            self._pressed = pressed
            gone, self._noticed = self._noticed, False
            if not pressed and gone:
                return  # whoever removed it; another one may have pressed since
            try:
                write(self._file, pressed)
            except OSError as error:
                self._warn(f"The emergency stop could not be saved in {self._file}: {error.strerror}.")

    async def keep(self) -> None:
        """Look for what other processes do with it, until this is cancelled."""
        before = self._pressed
        while True:
            there = self._is_there()
            if there != before and there != self._pressed:
                self._noticed = not there
                self._told(there)
            before = there
            await asyncio.sleep(LOOK_S)

    def _is_there(self) -> bool:
        try:
            if self._file.exists():
                return True
            return self._pressed and not self._file.parent.is_dir()
        except OSError:
            return self._pressed


def write(file: Path, pressed: bool) -> None:
    """Have it pressed for every program of this user, or released. Raises ``OSError``."""
    if pressed:
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        file.touch(mode=0o600)
    else:
        file.unlink(missing_ok=True)
