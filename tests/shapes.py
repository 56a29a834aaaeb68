"""Programs that are hard to get rid of, one for each name in ``SHAPES``.

Run as ``python -I -S shapes.py NAME FIFO``. Every process of a shape holds the FIFO's write end, which it inherits by
``fork`` and across ``exec``, and writes a line into it when it is in place: whoever holds the read end sees them all
come, and the end of the file when the last of them has gone.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable


def present(fd: int) -> None:
    os.write(fd, b"%d\n" % os.getpid())


def stay(fd: int) -> None:
    present(fd)
    while True:
        signal.pause()


def ignore() -> None:
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def single(fd: int) -> None:
    stay(fd)


def chain(fd: int) -> None:
    """Five, each the child of the one before."""
    for _ in range(4):
        if os.fork():
            break
    stay(fd)


def sessions(fd: int) -> None:
    """Three children, each in a session of its own."""
    for _ in range(3):
        if not os.fork():
            os.setsid()
            stay(fd)
    stay(fd)


def ignoring(fd: int) -> None:
    """It and three children ignore everything that can be ignored."""
    ignore()
    for _ in range(3):
        if not os.fork():
            break
    stay(fd)


def paused(fd: int) -> None:
    """Two children that are stopped."""
    for _ in range(2):
        if not os.fork():
            present(fd)
            os.kill(os.getpid(), signal.SIGSTOP)
            stay(fd)
    stay(fd)


def orphans(fd: int) -> None:
    """Three that lost their parents, in sessions of their own, with nothing in their environment, ignoring SIGTERM."""
    for _ in range(3):
        if not os.fork():
            os.setsid()
            if os.fork():
                os._exit(0)
            command = [sys.executable, "-I", "-S", __file__, "ignoring_alone", str(fd)]
            os.execve(command[0], command, {})
        os.wait()
    stay(fd)


def ignoring_alone(fd: int) -> None:
    ignore()
    stay(fd)


def storm(fd: int) -> None:
    """Eight that fork and exit all the time, so that none lives longer than a moment; four change sessions too."""
    ignore()
    for number in range(8):
        if not os.fork():
            present(fd)
            while True:
                if os.fork():
                    os._exit(0)
                if number % 2:
                    os.setsid()
    stay(fd)


def polite(fd: int) -> None:
    """It takes SIGTERM as a request, and says so before it goes."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})  # a handler could run just before it is waited for
    present(fd)
    signal.sigwait({signal.SIGTERM})
    os.write(2, b"leaving as asked\n")
    os._exit(7)


def leaving(fd: int) -> None:
    """It ends by itself and leaves a child behind that ignores SIGTERM."""
    ignore()
    if not os.fork():
        stay(fd)
    time.sleep(0.05)
    present(fd)
    os._exit(3)


SHAPES: dict[str, tuple[Callable[[int], None], int]] = {
    "single": (single, 1),
    "chain": (chain, 5),
    "sessions": (sessions, 4),
    "ignoring": (ignoring, 4),
    "ignoring_alone": (ignoring_alone, 1),
    "paused": (paused, 3),
    "orphans": (orphans, 4),
    "storm": (storm, 9),
    "polite": (polite, 1),
    "leaving": (leaving, 2),
}
"""What each one does, and how many lines it writes until it is in place."""

if __name__ == "__main__":
    name, where = sys.argv[1:3]
    fifo = int(where) if where.isdecimal() else os.open(where, os.O_WRONLY)
    os.set_inheritable(fifo, True)
    SHAPES[name][0](fifo)
