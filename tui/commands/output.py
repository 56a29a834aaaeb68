"""Where commands print: data to stdout, words for people to stderr.

Lines are written by a thread of their own, so that a reader who stalls never holds up the engine, and one who goes
away is noticed once.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import threading
from collections.abc import Callable
from typing import Any

import msgspec


def say(text: str) -> None:
    """A line for people, on stderr."""
    with contextlib.suppress(OSError, ValueError):
        print(text, file=sys.stderr, flush=True)  # noqa: T201 - this is where commands print


def data(text: str) -> None:
    """A line of data, on stdout."""
    print(text, flush=True)  # noqa: T201 - this is where commands print


def json_line(value: Any) -> None:
    """One JSON object on stdout."""
    data(msgspec.json.encode(value).decode())


class LineWriter:
    """Writes lines to stdout in the background. ``on_closed`` is called once when the reader has gone."""

    def __init__(self, on_closed: Callable[[], None]) -> None:
        self._lines: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._on_closed = on_closed
        self.closed = False
        """The reader has gone; further lines are dropped."""
        self._thread = threading.Thread(target=self._run, name="stdout", daemon=True)
        self._thread.start()

    def write(self, line: bytes) -> None:
        """Queue one line, without its newline. Never blocks."""
        if not self.closed:
            self._lines.put(line)

    def close(self, timeout: float = 5.0) -> None:
        """Write what is queued, for ``timeout`` seconds at most."""
        self._lines.put(None)
        self._thread.join(timeout)

    def _run(self) -> None:
        while (line := self._lines.get()) is not None:
            try:
                sys.stdout.buffer.write(line + b"\n")
                sys.stdout.buffer.flush()
            except (OSError, ValueError):
                self.closed = True
                silence_stdout()
                self._on_closed()
                return


def silence_stdout() -> None:
    """Point stdout at nothing after its reader has gone, so that the interpreter's last flush does not fail."""
    with contextlib.suppress(OSError, ValueError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
