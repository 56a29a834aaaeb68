"""Our own messages on a topic that we listen to as well: each comes back once, and is not taken for a peer's.

A text is expected as often as it was published, and no longer than a few seconds: a peer that says the same is heard
again after that, whether ours has come back or not.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Final, NamedTuple

LASTS_S: Final = 5.0
"""How long one that we have published may take to come back, s."""
LONGEST_S: Final = 60.0
"""The same where nothing passes for a while, s."""
MOST: Final = 100
"""That are expected at a time; more are not published within a few seconds by somebody who speaks."""


class _Expected(NamedTuple):
    text: str
    until: float  # s
    last: float  # s: however long nothing passes


class OwnMessages:
    """Thread-safe. ``clock`` gives s."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._expected: deque[_Expected] = deque(maxlen=MOST)

    def publishing(self, text: str) -> None:
        """It is about to be published."""
        with self._lock:
            now = self._clock()
            self._expected.append(_Expected(text, now + LASTS_S, now + LONGEST_S))

    def is_own(self, text: str) -> bool:
        """Whether what has come is one of ours; then it is not expected any more."""
        with self._lock:
            now = self._clock()
            self._expected = deque((one for one in self._expected if one.until >= now), maxlen=MOST)
            own = next((one for one in self._expected if one.text == text), None)
            if own is not None:
                self._expected.remove(own)
            return own is not None

    def wait(self) -> None:
        """Nothing passes at present: what was published may come back when it does again."""
        with self._lock:
            until = self._clock() + LASTS_S
            self._expected = deque(
                (_Expected(one.text, max(one.until, min(until, one.last)), one.last) for one in self._expected),
                maxlen=MOST,
            )
