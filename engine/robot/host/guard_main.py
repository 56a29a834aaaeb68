"""The guard process of a port: ``python -m engine.robot.host.guard_main``, started by
:class:`engine.robot.host.guard.Guard`; and :func:`watch`, what every guard does.

It loads nothing but the standard library: it must be there within milliseconds, and nothing here may fail.
"""

from __future__ import annotations

import argparse
import contextlib
import mmap
import os
import select
import signal
import socket
import sys
import termios
import time
from collections.abc import Callable

from engine.scheduling import raise_priority

TICK_S = 0.01
"""Between two looks at the host."""
SILENCE_S = 0.1
"""From this long without a sign of life, the host counts as hanging."""
REPEAT_TICKS = 2
"""Every how many ticks it tells the body to rest while the host hangs."""
LAST_WORDS = 5
"""How often it does before it leaves."""
HUNG_S = 5.0
"""A host that has hung for so long is ended: its engine, which would have replaced it by now, must be gone as well."""

HOST_ALIVE, GUARD_ALIVE = 0, 1
"""Words of the memory that both share: when each was last there, seconds of ``time.monotonic()``."""
SIZE = 16
"""Of that memory, bytes."""


def main(argv: list[str]) -> int:
    """Watch the host until it is gone or ends; bring the body to rest whenever nobody else would."""
    parser = argparse.ArgumentParser(prog="python -m engine.robot.host.guard_main", description="Internal to sayso.")
    for name in ("memory", "link", "port"):
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--rest", type=bytes.fromhex, required=True, help="what brings the body to rest")
    args = parser.parse_args(argv)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # it leaves when the host does
    watch(args.memory, args.link, lambda: _rest(args.port, args.rest))
    return 0


def watch(memory: int, link_fd: int, rest: Callable[[], object], *, last_words: int = LAST_WORDS) -> None:
    """Look after the host until it is gone or ends; ``rest`` brings the body to rest, and is called so often at the
    end."""
    raise_priority()
    words = memoryview(mmap.mmap(memory, SIZE)).cast("d")
    with socket.socket(fileno=link_fd) as link:
        tick, host = 0, os.getppid()
        while not (select.select([link], [], [], TICK_S)[0] and not _heard(link)):
            words[GUARD_ALIVE] = now = time.monotonic()
            tick += 1
            if now - words[HOST_ALIVE] > SILENCE_S and tick % REPEAT_TICKS == 0:
                rest()
            if now - words[HOST_ALIVE] > HUNG_S and os.getppid() == host:
                os.kill(host, signal.SIGKILL)
    for _ in range(last_words):
        rest()
        time.sleep(TICK_S)


def _heard(link: socket.socket) -> bytes:
    try:
        return link.recv(64)
    except OSError:
        return b""


def _rest(port: int, frame: bytes) -> None:
    """Write the frame, before anything that still waits to be written."""
    with contextlib.suppress(OSError, termios.error):  # unplugged: there is nobody to tell
        try:
            os.write(port, frame)
        except BlockingIOError:
            termios.tcflush(port, termios.TCOFLUSH)
            os.write(port, frame)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
