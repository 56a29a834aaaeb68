"""The one thread of a door, in which all that it was given is called, one at a time."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

Act = Callable[[], object]


class DoorThread:
    """Runs what it is given in order, until it is closed. Thread-safe."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._lock = threading.Lock()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def soon(self, act: Act) -> bool:
        """Run it after all that was given before. False where it has been closed, and runs nothing any more."""
        with self._lock:
            if not self._closed:
                self._loop.call_soon_threadsafe(act)
            return not self._closed

    def later(self, delay_s: float, act: Act) -> Act:
        """Run it after a while. What is returned cancels it; within this thread it then surely does not run."""
        cancelled = False
        timer: asyncio.TimerHandle | None = None

        def start() -> None:
            nonlocal timer
            if not cancelled:
                timer = self._loop.call_later(delay_s, act)

        def stop() -> None:
            if timer is not None:
                timer.cancel()

        def cancel() -> None:
            nonlocal cancelled
            cancelled = True
            if self.is_current():
                stop()
            else:
                self.soon(stop)

        if self.is_current():
            start()
        else:
            self.soon(start)
        return cancel

    def is_current(self) -> bool:
        """Whether the caller runs in this thread."""
        return threading.current_thread() is self._thread

    def close(self, limit_s: float) -> None:
        """Run what was given, and end; wait for that, unless this is the thread itself."""
        self.soon(self._loop.stop)
        if not self.is_current():
            self._thread.join(limit_s)

    def _run(self) -> None:
        try:
            self._loop.run_forever()
            with self._lock:
                self._closed = True
            self._loop.run_until_complete(asyncio.sleep(0))  # what was given until now
        finally:
            self._loop.close()
