"""Cancelling work that may not want to be cancelled.

asyncio asks a task to end, and a task can take its time or refuse. Nobody who interrupts a robot may wait for that:
:func:`bounded` gives cancelled work a short grace and then goes on without it. What it brings after that can be
recorded, and goes nowhere else.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any, Final, Generic, TypeVar

T = TypeVar("T")

GRACE_S: Final = 0.5
"""How long cancelled work may take to clean up, s."""

_abandoned: set[asyncio.Task[Any]] = set()  # the loop itself keeps only weak references


class Remains(Generic[T]):
    """What is left of work that was cancelled."""

    def __init__(self, late: Callable[[T | BaseException], None] = lambda found: None) -> None:
        self.let_go = True
        """It ended within the grace."""
        self.found: T | BaseException | None = None
        """What it brought within the grace; a plain cancellation brings nothing."""
        self.late = late
        """Called with what it brings after the grace, if anything."""


async def bounded(work: Coroutine[Any, Any, T], remains: Remains[T] | None = None) -> T:
    """Await ``work`` in a task of its own. Cancelling the caller takes ``GRACE_S`` at most, whatever ``work`` does;
    ``remains`` then says what became of it."""
    remains = Remains() if remains is None else remains
    task = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        caller = asyncio.current_task()
        if task.cancelled() and caller is not None and not caller.cancelling():
            raise RuntimeError("the work cancelled itself") from None
        task.cancel()
        _abandoned.add(task)
        task.add_done_callback(_abandoned.discard)
        try:
            await asyncio.wait([task], timeout=GRACE_S)
        finally:
            remains.let_go = task.done()
            if task.done():
                remains.found = _found(task)
            else:
                task.add_done_callback(lambda ended: _tell(ended, remains))
        raise


def _tell(task: asyncio.Task[T], remains: Remains[T]) -> None:
    if (found := _found(task)) is not None:
        remains.late(found)


def _found(task: asyncio.Task[T]) -> T | BaseException | None:
    return None if task.cancelled() else task.exception() or task.result()
