"""A line between a terminal and a console, as deep and as slow as one over half the world.

What the console writes is taken at once, as a connection takes it, and comes out at the other end bit by bit; there
a terminal draws it and reports when it is asked. The line can stall.
"""

from __future__ import annotations

import os
import select
import threading
import time
from collections.abc import Callable
from contextlib import suppress

import pyte

from tui.terminal.link import ASK, REPORT

TICK_S = 0.005
PATIENCE_S = 60
QUIET_S = 1.0
"""A console that has sent nothing for so long has drawn everything."""


class SlowLine:
    """Reads ``terminal`` until it is closed; give the terminal back to nobody else in the meantime."""

    def __init__(self, terminal: int, columns: int, rows: int, *, rate: float, reports: bool = True) -> None:
        """``rate`` is bytes per second; ``reports``: the terminal tells when it is asked."""
        self.screen = pyte.Screen(columns, rows)
        self.rate = rate
        self.stalled = False
        self.sent = 0  # bytes the console has written
        self._sent_at = time.monotonic()
        self.asked = 0  # reports that the terminal was asked for
        self.most = 0  # bytes that were on the line at the same time
        self.most_frames = 0  # frames that were
        self._stream = pyte.ByteStream(self.screen)
        self._reports = reports
        self._terminal = terminal
        self._on_it = bytearray()
        self._tail = b""
        self._changed = threading.Condition()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    @property
    def waiting(self) -> int:
        """Bytes on the line."""
        return len(self._on_it)

    @property
    def quiet(self) -> bool:
        """Everything has arrived, and there has been nothing more for a while."""
        return not self._on_it and time.monotonic() - self._sent_at > QUIET_S

    @property
    def text(self) -> str:
        """What a person sees."""
        return "\n".join(self.screen.display)

    def until(self, seen: Callable[[], object]) -> None:
        """Wait until it holds; it is looked at whenever something happens on the line."""
        with self._changed:
            assert self._changed.wait_for(seen, PATIENCE_S), f"Not seen within {PATIENCE_S} s:\n{self.text}"

    def resize(self, columns: int, rows: int) -> None:
        with self._changed:
            self.screen.resize(rows, columns)

    def close(self) -> None:
        self._closed.set()
        self._thread.join(PATIENCE_S)

    def _carry(self) -> None:
        credit, before = 0.0, time.monotonic()
        while not self._closed.is_set():
            with suppress(OSError):
                while select.select([self._terminal], [], [], TICK_S)[0]:
                    data = os.read(self._terminal, 65536)
                    self._on_it += data
                    self.sent += len(data)
                    self._sent_at = time.monotonic()
                    if time.monotonic() - before > TICK_S:
                        break
            now = time.monotonic()
            credit, before = min(credit + self.rate * (now - before), self.rate / 10), now
            with self._changed:
                self.most = max(self.most, len(self._on_it))
                self.most_frames = max(self.most_frames, self._on_it.count(ASK.encode()))
                if not self.stalled and (arrived := bytes(self._on_it[: int(credit)])):
                    credit -= len(arrived)
                    del self._on_it[: len(arrived)]
                    self._draw(arrived)
                self._changed.notify_all()

    def _draw(self, data: bytes) -> None:
        self._stream.feed(data)
        data = self._tail + data
        ask = ASK.encode()
        count = data.count(ask)
        self.asked += count
        self._tail = b"" if data.endswith(ask) else data[-len(ask) + 1 :]
        if self._reports and count:
            with suppress(OSError):
                os.write(self._terminal, REPORT[0].encode() * count)
