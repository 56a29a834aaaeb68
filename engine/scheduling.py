"""Priority for what must not be late: the robot process, and the threads in which somebody stops the robot.

On a machine with more to do than it has cores, an ordinary thread that wakes up may wait for tens of milliseconds.
"""

from __future__ import annotations

import contextlib
import gc
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Literal, get_args

Scheduling = Literal["normal", "nice", "realtime"]
"""``realtime`` is SCHED_FIFO, ``nice`` a better niceness than others have."""

_FIFO_PRIORITY = 10  # above everything that is not real-time, below the kernel's own threads (50 and up)
_NICENESS = -10


def raise_priority(thread: int = 0) -> Scheduling:
    """Get the best scheduling that this system allows for a thread (``threading.get_native_id()``; 0: the one that
    calls), and say which one that is. What it starts does not inherit it.

    SCHED_FIFO needs root, CAP_SYS_NICE, or an ``rtprio`` limit in ``/etc/security/limits.d``. Whoever has it
    must sleep most of the time: the machine stands still while it runs.
    """
    if hasattr(os, "sched_setscheduler"):
        with contextlib.suppress(OSError):  # not allowed: the next best is tried
            policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
            os.sched_setscheduler(thread, policy, os.sched_param(_FIFO_PRIORITY))
            return "realtime"
    if thread == 0 or sys.platform == "linux":  # elsewhere only whole processes have a niceness
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, thread, _NICENESS)
            return "nice"
    return "normal"


def prefer(thread: int = 0) -> bool:
    """Give a thread a better niceness than others have, where the system allows it; what it starts does not inherit
    that. For threads that hold the interpreter lock, for which those that stop the robot have to wait."""
    if sys.platform != "linux":  # elsewhere only whole processes have a niceness
        return False
    with contextlib.suppress(OSError):
        os.sched_setscheduler(thread, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
        os.setpriority(os.PRIO_PROCESS, thread, _NICENESS)
        return True
    return False


def workers(name: str, most: int | None = None, *, prompt: bool) -> ThreadPoolExecutor:
    """A pool of threads (``most``: as many as the library thinks), which :func:`prefer` raises if ``prompt``."""
    return ThreadPoolExecutor(most, thread_name_prefix=name, initializer=prefer if prompt else None)


def quiet_memory() -> None:
    """No garbage collection from now on: the control loop makes no cycles, and a collection takes milliseconds."""
    gc.collect()
    gc.freeze()
    gc.disable()


def collect_in_small_steps() -> None:
    """For a process in which somebody stops the robot: garbage collection holds the interpreter lock all the while, so
    it goes through a few objects often (1 ms at a time), and through all of them seldom."""
    gc.set_threshold(400, 4, 200)  # Python: 700, 10, 10


def as_word(scheduling: Scheduling) -> int:
    """For shared memory."""
    return get_args(Scheduling).index(scheduling)


def from_word(word: int) -> Scheduling:
    """The reverse of :func:`as_word`."""
    found: Scheduling = get_args(Scheduling)[word]
    return found
