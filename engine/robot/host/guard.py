"""A second process beside a host whose body keeps moving when nobody speaks to it any more.

It shares the body's port, or has a way of its own to the body. When the host dies, or hangs for 0.1 s, it tells the
body to rest, over and over. The host in turn looks after its guard, and stands while there is none. So the death of
either leaves the body at rest.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import signal
import time
from collections.abc import Sequence
from pathlib import Path

from engine.child import Child
from engine.robot.host.guard_main import GUARD_ALIVE, HOST_ALIVE, SIZE
from engine.unnamed import unnamed_file

SILENCE_S = 0.2
"""From this long without a sign of life, the guard counts as lost."""
LEAVE_S = 0.3
"""In which it leaves after its host is gone."""
START_S = 5.0
"""In which it must have given its first."""


def end_guard(pid: int) -> None:
    """End a guard whose host is gone, unless it leaves by itself, having told the body to rest; blocks until then."""
    until = time.monotonic() + LEAVE_S
    while _is_guard(pid):
        if time.monotonic() > until:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
            return
        time.sleep(0.01)


def _is_guard(pid: int) -> bool:
    try:
        return b"guard_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:  # gone, or a system that tells nothing of its processes
        return False


class Guard(Child):
    """One running guard. Whoever makes it ends it, then releases it."""

    def __init__(
        self, module: str, arguments: Sequence[str], shared: Sequence[int] = (), *, start_s: float = START_S
    ) -> None:
        """Start the program ``module``, whose name ends with ``guard_main``, with these arguments and descriptors; it
        gives its first sign of life within ``start_s``. Raises ``ProcessError``."""
        self._start_s = start_s
        self._shared = unnamed_file("sayso-guard", SIZE)
        try:
            self._words = memoryview(mmap.mmap(self._shared, SIZE)).cast("d")
            self._began = self._words[HOST_ALIVE] = time.monotonic()
            super().__init__("guard", module, [f"--memory={self._shared}", *arguments], shared=(self._shared, *shared))
            self.link.setblocking(False)
        except BaseException:
            os.close(self._shared)
            raise

    def beat(self, now: float) -> bool:
        """Tell it that the host lives, and say whether it lives itself; ``now`` is ``time.monotonic()``. Never
        waits."""
        self._words[HOST_ALIVE] = now
        try:
            if not self.link.recv(64):
                return False
        except BlockingIOError:
            pass
        except OSError:
            return False
        alive = self._words[GUARD_ALIVE]
        return now - alive <= SILENCE_S if alive else now - self._began <= self._start_s

    @property
    def watches(self) -> bool:
        """Whether it has begun to."""
        return self._words[GUARD_ALIVE] > 0

    def release(self) -> None:
        super().release()
        os.close(self._shared)


def guard_of_port(port: int, rest: bytes) -> Guard:
    """One that shares this open port; ``rest`` brings the body to rest. Raises ``ProcessError``."""
    return Guard("engine.robot.host.guard_main", [f"--port={port}", f"--rest={rest.hex()}"], (port,))
