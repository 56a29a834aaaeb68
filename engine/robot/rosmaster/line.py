"""The serial line to a board: bytes out and in, without ever waiting."""

from __future__ import annotations

import contextlib
import os
import termios
from collections.abc import Callable
from typing import Protocol

from engine.serial_port import opened


class Line(Protocol):
    """An open line. Reading and writing raise ``OSError`` where it is gone."""

    def fileno(self) -> int:
        """For a guard, which writes to it too."""
        ...

    def read(self) -> bytes:
        """What has come; nothing where nothing has."""
        ...

    def write(self, data: bytes) -> int:
        """Write as much as it takes now; how many bytes that is."""
        ...

    def forget(self) -> None:
        """Drop what was written and has not gone out yet."""
        ...

    def close(self) -> None:
        """Let go of it. Raises nothing."""
        ...


Opener = Callable[[str], Line]


class SerialLine:
    """A serial port, for nobody but us."""

    def __init__(self, path: str) -> None:
        """Raises ``PortError``."""
        self._port = opened(path, "robot.port", "`sayso robot check` lists the ports there are; robot.port names one.")

    def fileno(self) -> int:
        fd: int = self._port.fileno()
        return fd

    def read(self) -> bytes:
        try:
            return os.read(self.fileno(), 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> int:
        try:
            return os.write(self.fileno(), data)
        except BlockingIOError:
            return 0

    def forget(self) -> None:
        with contextlib.suppress(termios.error):  # gone: the next write says so
            termios.tcflush(self.fileno(), termios.TCOFLUSH)

    def close(self) -> None:
        with contextlib.suppress(OSError, termios.error):
            self._port.close()
