"""The epoch: one counter that says which generation of work may still have effects.

Whatever starts something (a turn, a plan, a motion) remembers the epoch it was started in. Every interruption
advances the epoch, from whatever thread it comes, and advancing *is* the stop: the robot is told first, inside the
same lock, before anybody else learns of it. Work of an older epoch is recorded and dropped; the robot process drops
its motion commands too, because they carry their epoch.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

FIRST: Final = 1
"""What was begun before any interruption belongs to it."""


class Epoch:
    """Thread-safe counter, starting at ``FIRST``. ``on_advance`` gets each new epoch before :meth:`advance` returns."""

    def __init__(self, on_advance: Callable[[int], None]) -> None:
        self._on_advance = on_advance
        self._lock = threading.Lock()
        self._current = FIRST

    @property
    def current(self) -> int:
        return self._current

    def advance(self) -> int:
        """Begin a new epoch and stop what the old one moves. Never blocks for longer than a memory write."""
        with self._lock:
            epoch = self._current + 1
            self._on_advance(epoch)
            self._current = epoch
            return epoch

    def tell_again(self) -> None:
        """Tell the epoch in force to whoever could not hear of it when it began."""
        with self._lock:
            self._on_advance(self._current)

    def is_current(self, epoch: int) -> bool:
        return epoch == self._current
