"""A loop whose clock jumps to the next timer: a two-minute conversation tests in milliseconds, always the same way.

Time stands still while code runs or a worker thread is busy, and jumps when there is nothing left to do but wait. A
loop that waits for something that can never come fails at once instead of hanging.
"""

from __future__ import annotations

import asyncio
import selectors
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

T = TypeVar("T")

STUCK_S = 20.0
"""Real seconds that a worker thread may take before the test is called stuck."""


class _JumpingSelector(selectors.DefaultSelector):
    """Never waits while nothing outside the loop is at work: it jumps instead."""

    def __init__(self) -> None:
        super().__init__()
        self.jump: Callable[[float], None] = lambda seconds: None
        self.busy: Callable[[], bool] = lambda: False

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if ready := super().select(0):
            return ready
        if timeout is not None and timeout <= 0:  # there is work in the loop itself
            return []
        if self.busy():
            if ready := super().select(STUCK_S):
                return ready
            raise TimeoutError("a worker thread did not finish")
        if timeout is None:
            raise RuntimeError("everything waits and nothing is scheduled: a deadlock")
        self.jump(timeout)
        return []


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An asyncio loop under virtual time, starting at 0."""

    def __init__(self) -> None:
        selector = _JumpingSelector()
        self._now = 0.0
        self._threads = 0
        selector.jump, selector.busy = self._jump, lambda: self._threads > 0
        super().__init__(selector)

    def time(self) -> float:
        return self._now

    def _jump(self, seconds: float) -> None:
        self._now += max(0.0, seconds)

    def run_in_executor(self, executor: Any, func: Any, *args: Any) -> asyncio.Future[Any]:
        future = super().run_in_executor(executor, func, *args)
        self._threads += 1
        future.add_done_callback(self._thread_done)
        return future

    async def shutdown_default_executor(self, *args: Any) -> None:
        self._threads += 1  # it joins the workers in a thread of its own
        try:
            await super().shutdown_default_executor(*args)
        finally:
            self._threads -= 1

    def _thread_done(self, future: asyncio.Future[Any]) -> None:
        del future
        self._threads -= 1


def run(work: Coroutine[Any, Any, T]) -> T:
    """``asyncio.run`` under virtual time."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(work)
