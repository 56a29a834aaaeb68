"""Lines in the log about what peers do: one a second at most, and then how many there were besides."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

QUIET_S: Final = 1.0
"""Between two lines, s."""


class Complaints:
    """Thread-safe. ``tell`` writes a line; ``clock`` gives s."""

    def __init__(self, tell: Callable[[str], object], clock: Callable[[], float]) -> None:
        self._tell = tell
        self._clock = clock
        self._lock = threading.Lock()
        self._quiet_until = float("-inf")
        self._untold = 0

    def __call__(self, words: str) -> None:
        with self._lock:
            now = self._clock()
            if now < self._quiet_until:
                self._untold += 1
                return
            self._quiet_until = now + QUIET_S
        self._tell(words)

    def catch_up(self, *, at_once: bool = False) -> None:
        """Say how many lines were left out, once it has been quiet for long enough; to be called now and then."""
        with self._lock:
            now = self._clock()
            if not self._untold or (now < self._quiet_until and not at_once):
                return
            untold, self._untold = self._untold, 0
            self._quiet_until = now + QUIET_S
        self._tell(f"{untold} more messages from the ROS graph were refused.")
