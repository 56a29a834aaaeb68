"""Redrawing no oftener than the link to the terminal can bear, and not at all when nothing happens."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

from textual.message_pump import MessagePump

T = TypeVar("T")


class Inbox(Generic[T]):
    """Carries items from other threads to the UI thread, which is woken once per batch and not once per item."""

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._items: deque[T] = deque()
        self._lock = Lock()
        self._waking = False

    def put(self, item: T) -> None:
        """Add an item; safe from any thread."""
        with self._lock:
            self._items.append(item)
            first, self._waking = not self._waking, True
        if first:
            self._wake()

    def take(self) -> list[T]:
        """All items so far, oldest first; the next ``put`` wakes again."""
        with self._lock:
            items = list(self._items)
            self._items.clear()
            self._waking = False
        return items


class Pacer:
    """Calls ``draw`` at once when it has been quiet, then at most every ``interval`` seconds.

    ``draw`` returns whether it wants to be called again without being asked, because something is still moving.
    With nothing to do the timer is paused: an idle console writes and computes nothing.
    """

    def __init__(self, owner: MessagePump, interval: float, draw: Callable[[], bool]) -> None:
        self._draw = draw
        self.asked = False  # somebody asked since the last drawing
        self._wanted = False  # the last drawing wants another
        self.ticking = False
        self._owner = owner
        self._timer = owner.set_interval(interval, self._tick, pause=True)

    def pace(self, interval: float) -> None:
        """Draw every ``interval`` seconds at most from now on."""
        self._timer.stop()
        self._timer = self._owner.set_interval(interval, self._tick, pause=not self.ticking)

    def ask(self) -> None:
        """Draw as soon as the pace allows. In the UI thread only."""
        if self.ticking:
            self.asked = True
            return
        self._wanted = self._draw()
        self.ticking = True
        self._timer.reset()
        self._timer.resume()

    def _tick(self) -> None:
        if not self.asked and not self._wanted:
            self.ticking = False
            self._timer.pause()
            return
        self.asked = False
        self._wanted = self._draw()
