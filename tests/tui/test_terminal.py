"""The console on a real (pseudo-)terminal: what no headless test can show."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import pytest

PROGRAM = """
import os, sys, threading
from engine.commands import Interrupt, Quit
from tests.tui.scripted import LiveEngine
from tui.app import run_console

told = int(sys.argv[1])

class Engine(LiveEngine):
    def robot_state(self):
        os.write(told, b"frame\\n")  # asked once for every frame: a sign of life of the user interface
        return super().robot_state()

def start(dress):
    dress("sayso-dark", 30)
    engine = Engine()
    commanded = engine.on_command
    def tell(command):
        os.write(told, command.do.encode() + b"\\n")
        if isinstance(command, Interrupt):
            commanded(command)
    engine.on_command = tell
    threading.Timer(0.0, engine.begin).start()
    os.write(told, b"started\\n")
    return engine

sys.exit(run_console(start))
"""
PATIENCE_S = 30


@dataclass
class Session:
    """The console in a process of its own; ``told`` gives the commands its engine got, a line each."""

    pid: int
    terminal: int
    told: int

    def next_command(self) -> str:
        """The next thing told that is no frame."""
        while (line := self.next_line()) == "frame":
            pass
        return line

    def next_line(self) -> str:
        assert select.select([self.told], [], [], PATIENCE_S)[0], "The engine was told nothing."
        line = b""
        while not line.endswith(b"\n"):
            line += os.read(self.told, 1)
        return line.decode().strip()

    def read_until(self, wanted: bytes) -> None:
        seen = b""
        while wanted not in seen:
            assert select.select([self.terminal], [], [], PATIENCE_S)[0], f"The console never wrote {wanted!r}."
            seen += os.read(self.terminal, 65536)


@contextmanager
def session() -> Iterator[Session]:
    reader, writer = os.pipe()
    os.set_inheritable(writer, True)
    pid, terminal = pty.fork()
    if pid == 0:
        environ = {**os.environ, "TERM": "xterm-256color"}
        os.execve(sys.executable, [sys.executable, "-c", PROGRAM, str(writer)], environ)
    os.close(writer)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    try:
        yield Session(pid, terminal, reader)
    finally:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        with suppress(ChildProcessError):
            os.waitpid(pid, 0)
        for descriptor in (terminal, reader):
            with suppress(OSError):
                os.close(descriptor)


def test_escape_reaches_the_engine_although_nobody_reads_the_screen() -> None:
    with session() as console:
        console.read_until(b"LISTENING")
        assert console.next_command() == "started"
        # From here on nobody reads the terminal: its buffer fills, and the user interface waits for it for ever.
        frames = 0
        while select.select([console.told], [], [], 2.0)[0]:
            assert console.next_line() == "frame"
            frames += 1
        assert frames
        os.write(console.terminal, b"\x1b[27u")  # escape, as terminals with the extended keyboard protocol send it
        assert console.next_command() == "interrupt"


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM])
def test_a_terminal_that_goes_away_ends_the_session(number: signal.Signals) -> None:
    with session() as console:
        console.read_until(b"READY")
        assert console.next_command() == "started"
        os.kill(console.pid, number)
        assert console.next_command() == "quit"
        console.read_until(b"\x1b[?1049l")
        _, status = os.waitpid(console.pid, 0)
        assert os.waitstatus_to_exitcode(status) == 130


def test_a_closed_terminal_ends_the_process() -> None:
    with session() as console:
        console.read_until(b"READY")
        assert console.next_command() == "started"
        os.close(console.terminal)
        assert console.next_command() == "quit"
        os.waitpid(console.pid, 0)
