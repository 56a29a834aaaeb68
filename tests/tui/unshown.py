"""A terminal driver without a terminal: it reads keys from a pipe and tells what becomes of them."""

from __future__ import annotations

import queue
import threading

from textual.drivers.linux_driver import LinuxDriver


def unshown(inside: int, acted: queue.SimpleQueue[str]) -> type[LinuxDriver]:
    """A driver that reads from ``inside``; what it queues is told in brackets, what it writes as it stands."""

    class Unshown(LinuxDriver):
        def __init__(self) -> None:
            self.fileno, self._debug, self.cursor_origin = inside, False, None
            self.exit_event = threading.Event()
            self._app = None  # type: ignore[assignment]
            self._file = None

        def send_message(self, message: object) -> None:
            acted.put(f"({message.key})")  # type: ignore[attr-defined]

        def write(self, data: str) -> None:
            acted.put(data)

    return Unshown
