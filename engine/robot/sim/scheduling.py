"""Priority for the robot process, so that nothing else on the machine delays a control tick."""

from __future__ import annotations

import contextlib
import gc
import os
from typing import Literal, get_args

Scheduling = Literal["normal", "nice", "realtime"]
"""``realtime`` is SCHED_FIFO, ``nice`` a better niceness than others have."""

_FIFO_PRIORITY = 10  # above everything that is not real-time, below the kernel's own threads (50 and up)
_NICENESS = -10


def raise_priority() -> Scheduling:
    """Get the best scheduling that this system allows us, and say which one that is.

    SCHED_FIFO needs root, CAP_SYS_NICE, or an ``rtprio`` limit in ``/etc/security/limits.d``. A process that has it
    must sleep between its steps: the machine stands still while it runs.
    """
    if hasattr(os, "sched_setscheduler"):
        with contextlib.suppress(OSError):  # not allowed: the next best is tried
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_FIFO_PRIORITY))
            return "realtime"
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
        return "nice"
    return "normal"


def quiet_memory() -> None:
    """No garbage collection from now on: the control loop makes no cycles, and a collection takes milliseconds."""
    gc.collect()
    gc.freeze()
    gc.disable()


def as_word(scheduling: Scheduling) -> int:
    """For shared memory."""
    return get_args(Scheduling).index(scheduling)


def from_word(word: int) -> Scheduling:
    """The reverse of :func:`as_word`."""
    found: Scheduling = get_args(Scheduling)[word]
    return found
