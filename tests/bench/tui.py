"""What the console costs the link and the processor, on a pseudo-terminal, with a scripted engine behind it.

``python -m tests.bench.tui [--json] [--seconds 10]`` prints time to the first paint and to a usable screen, and bytes
per second and processor share, idle and while the robot drives (20 Hz state, path, progress, log).
"""

from __future__ import annotations

import argparse
import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import psutil

from tests.bench.report import Figure, figures, print_report, report

USABLE = b"quit"
"""The last word of the status line: when it is on the screen, keys are taken."""

CONSOLE = """
import gc, sys
gc.disable()  # as the command line does; the console enables it after the first paint
from tui.app import run_console

def start(dress):
    from tests.tui.scripted import engine_for  # behind the first picture, as the real engine
    return engine_for(sys.argv[1:])

sys.exit(run_console(start))
"""


@dataclass
class Terminal:
    """A process on a pseudo-terminal of our own, and what it wrote."""

    pid: int
    master: int
    began: float
    written: int = 0
    seen: bytearray = field(default_factory=bytearray)

    def read(self, seconds: float, until: Callable[[bytes], bool] = lambda seen: False) -> float | None:
        """Read for so long, or until the condition holds for everything read; then the time since the start, s."""
        end = time.monotonic() + seconds
        if until(bytes(self.seen)):
            return time.monotonic() - self.began
        while (left := end - time.monotonic()) > 0:
            if select.select([self.master], [], [], left)[0]:
                data = os.read(self.master, 65536)
                self.written += len(data)
                self.seen += data
                if until(bytes(self.seen)):
                    return time.monotonic() - self.began
        return None


@contextmanager
def console(columns: int, rows: int, *arguments: str, program: str = CONSOLE) -> Iterator[Terminal]:
    """The console, with the scripted engine unless told, on a terminal of this size; quits at the end."""
    began = time.monotonic()
    pid, master = pty.fork()
    if pid == 0:
        environ = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor"}
        os.execve(sys.executable, [sys.executable, "-c", program, *arguments], environ)
    fcntl.ioctl(master, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    terminal = Terminal(pid, master, began)
    try:
        yield terminal
    finally:
        os.write(master, b"\x03")
        terminal.read(1.5, lambda seen: b"\x1b[?1049l" in seen[-400:])
        os.close(master)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)


def start_times(columns: int, rows: int) -> tuple[float, float]:
    """Seconds to the first characters drawn, and to a usable screen."""
    with console(columns, rows, "--idle") as terminal:
        first = terminal.read(10, lambda seen: "╭".encode() in seen or USABLE in seen)
        usable = terminal.read(0.01) or first if USABLE in terminal.seen else terminal.read(10, lambda s: USABLE in s)
        if first is None or usable is None:
            raise SystemExit("The console drew nothing in 10 s.")
        return first, usable


def traffic(columns: int, rows: int, seconds: float, *arguments: str, settle: float) -> tuple[list[float], list[float]]:
    """kB written and per cent of one core used, second by second, after ``settle`` seconds."""
    with console(columns, rows, *arguments) as terminal:
        terminal.read(settle)
        process = psutil.Process(terminal.pid)
        kilobytes, shares = [], []
        for _ in range(round(seconds)):
            written, busy = terminal.written, sum(process.cpu_times()[:2])
            terminal.read(1.0)
            kilobytes.append((terminal.written - written) / 1000)
            shares.append(100 * (sum(process.cpu_times()[:2]) - busy))
        return kilobytes, shares


def main() -> None:
    parser = argparse.ArgumentParser(description="Traffic, processor share and start of the console.")
    parser.add_argument("--seconds", type=float, default=10.0, help="length of each measurement")
    parser.add_argument("--starts", type=int, default=5, help="number of starts")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    starts = [start_times(120, 40) for _ in range(arguments.starts)]
    found: dict[str, Figure] = {
        "first_paint": figures([first for first, _ in starts], "s"),
        "usable": figures([usable for _, usable in starts], "s"),
    }
    for name, flags, settle in (("idle", ("--idle",), 3.0), ("acting", ("--act",), 10.0)):
        for columns, rows in ((120, 40), (80, 24)):
            kilobytes, shares = traffic(columns, rows, arguments.seconds, *flags, settle=settle)
            found[f"{name} {columns}x{rows} traffic"] = figures(kilobytes, "kB/s")
            found[f"{name} {columns}x{rows} processor"] = figures(shares, "% of a core")
    print_report(report("tui", arguments.starts, found), arguments.json)


if __name__ == "__main__":
    main()
