"""What the console costs the link and the processor, on a pseudo-terminal, with a scripted engine behind it.

``python -m tests.bench.tui [--json] [--seconds 10] [--only-keys]`` prints time to the first paint and to a usable
screen, and bytes per second and processor share, idle and while the robot drives (20 Hz state, path, lidar, progress,
log), without the camera and with it. Starts are those of people, who start it again and again: with the byte code that
the first start left. It also prints how long it takes from a key to the command that stops the robot, on a fast line,
on one of 20 kB/s, and on one that has stalled, and how much was on its way at most.
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
from compileall import compile_dir
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import psutil

from tests.bench.report import Figure, figures, print_report, report
from tests.tui.line import SlowLine

USABLE = b"quit"
"""The last word of the status line: when it is on the screen, keys are taken."""

CONSOLE = """
import gc, sys
gc.disable()  # as the command line does; the console enables it after the first paint
from tui.app import run_console

def start(dress):
    from tests.tui.scripted import engine_for  # behind the first picture, as the real engine
    if "--camera" in sys.argv:
        dress("sayso-dark", 8, camera="on")
    return engine_for(sys.argv[1:])

sys.exit(run_console(start))
"""


STOPPED = """
import os, sys, threading, time
from engine.commands import Interrupt
from tests.tui.scripted import LiveEngine
from tui.app import run_console

class Engine(LiveEngine):
    def send(self, command):
        if isinstance(command, Interrupt):  # and the robot drives on, for the next key
            os.write(int(sys.argv[1]), b"%.6f\\n" % time.monotonic())

def start(dress):
    engine = Engine()
    threading.Timer(0.0, engine.begin).start()
    return engine

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


@cache
def environment() -> dict[str, str]:
    """As people have it: byte code is there from the installation, or from an earlier start. Compilation would be a
    fifth of a start, and holds the interpreter lock for 25 ms at a time."""
    for folder in ("config", "engine", "tests", "tui"):
        compile_dir(Path(__file__).parents[2] / folder, quiet=2)
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


@contextmanager
def console(columns: int, rows: int, *arguments: str, program: str = CONSOLE) -> Iterator[Terminal]:
    """The console, with the scripted engine unless told, on a terminal of this size; quits at the end."""
    environ = {**environment(), "TERM": "xterm-256color", "COLORTERM": "truecolor"}
    began = time.monotonic()
    pid, master = pty.fork()
    if pid == 0:
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


def key_to_stop(keys: int, *, rate: float, stalled: bool = False) -> tuple[list[float], int]:
    """Milliseconds from an escape key to the command, by a clock that both processes share; and the bytes that were on
    the line at most."""
    reader, writer = os.pipe()
    os.set_inheritable(writer, True)
    with console(120, 40, str(writer), program=STOPPED) as terminal:
        os.close(writer)
        line = SlowLine(terminal.master, 120, 40, rate=rate)
        try:
            line.until(lambda: "ACTING" in line.text)
            line.most, line.stalled = 0, stalled
            took = []
            for _ in range(keys):
                time.sleep(0.2)
                pressed = time.monotonic()
                os.write(terminal.master, b"\x1b")
                if not select.select([reader], [], [], 10)[0]:
                    raise SystemExit("A key did not stop the robot within 10 s.")
                took.append(1000 * (float(os.read(reader, 64).split()[0]) - pressed))
            return took, line.most
        finally:
            line.close()
            os.close(reader)


def starting(starts: int) -> dict[str, Figure]:
    start_times(120, 40)  # leaves the byte code
    times = [start_times(120, 40) for _ in range(starts)]
    return {
        "first_paint": figures([first for first, _ in times], "s"),
        "usable": figures([usable for _, usable in times], "s"),
    }


def sending(seconds: float) -> dict[str, Figure]:
    found: dict[str, Figure] = {}
    for name, flags, settle in (
        ("idle", ("--idle",), 3.0),
        ("acting", ("--act",), 10.0),
        ("camera at rest", ("--idle", "--camera"), 8.0),
        ("camera while acting", ("--act", "--camera"), 10.0),
    ):
        for columns, rows in ((120, 40), (80, 24)):
            kilobytes, shares = traffic(columns, rows, seconds, *flags, settle=settle)
            found[f"{name} {columns}x{rows} traffic"] = figures(kilobytes, "kB/s")
            found[f"{name} {columns}x{rows} processor"] = figures(shares, "% of a core")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description="Traffic, processor share and start of the console.")
    parser.add_argument("--seconds", type=float, default=10.0, help="length of each measurement")
    parser.add_argument("--starts", type=int, default=5, help="number of starts")
    parser.add_argument("--keys", type=int, default=50, help="number of escape keys on each line")
    parser.add_argument("--only-keys", action="store_true", help="measure nothing but them")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    found: dict[str, Figure] = {}
    if not arguments.only_keys:
        found |= starting(arguments.starts) | sending(arguments.seconds)
    for name, rate, stalled in (("fast", 10e6, False), ("20 kB/s", 20e3, False), ("stalled", 20e3, True)):
        took, most = key_to_stop(arguments.keys, rate=rate, stalled=stalled)
        found[f"key to interrupt, {name} line"] = figures(took, "ms")
        found[f"most on a {name} line"] = figures([most / 1000], "kB")
    print_report(report("tui", arguments.starts, found), arguments.json)


if __name__ == "__main__":
    main()
