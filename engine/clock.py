"""Time, injectable. Nothing in the engine reads the system clock directly.

:class:`SystemClock` is real time. :class:`LoopClock` follows an asyncio loop, so that under a virtual-time loop
(tests) every stamp follows the loop's clock and a session is the same at every run.
"""

from __future__ import annotations

import asyncio
import time
from datetime import UTC, datetime, timedelta
from typing import Protocol


class Clock(Protocol):
    """Where time comes from."""

    def now(self) -> float:
        """Monotonic seconds; only differences mean anything."""
        ...

    def wall(self) -> datetime:
        """Time of day, UTC, timezone-aware."""
        ...


class SystemClock:
    """Real time."""

    def now(self) -> float:
        return time.monotonic()

    def wall(self) -> datetime:
        return datetime.now(UTC)


class LoopClock:
    """Time of an asyncio loop; the time of day starts at a fixed moment and advances with it."""

    def __init__(self, loop: asyncio.AbstractEventLoop, *, start: datetime | None = None) -> None:
        self._loop = loop
        self._start = start or datetime(2026, 1, 1, tzinfo=UTC)
        self._origin = loop.time()

    def now(self) -> float:
        return self._loop.time()

    def wall(self) -> datetime:
        return self._start + timedelta(seconds=self._loop.time() - self._origin)


def iso_utc(moment: datetime) -> str:
    """ISO 8601 with milliseconds and a final Z: ``2026-11-21T10:00:00.123Z``."""
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
