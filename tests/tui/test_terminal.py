"""The console on a real (pseudo-)terminal: what no headless test can show."""

from __future__ import annotations

import fcntl
import os
import pty
import queue
import select
import signal
import struct
import sys
import termios
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import pytest

from tests.tui.told import PATIENCE_S, Told
from tests.tui.unshown import unshown
from tui.terminal.driver import listening_driver
from tui.terminal.keyboard import READ_BYTES, LoneEscape

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


@dataclass
class Session(Told):
    """The console in a process of its own; ``told`` gives the commands its engine got, a line each."""

    pid: int
    terminal: int
    told: int

    def read_until(self, wanted: bytes) -> None:
        seen = b""
        while wanted not in seen:
            assert select.select([self.terminal], [], [], PATIENCE_S)[0], f"The console never wrote {wanted!r}."
            seen += os.read(self.terminal, 65536)


@contextmanager
def session(*, controlled: bool = True, before: str = "") -> Iterator[Session]:
    """``controlled``: the terminal is the one that sends the console its signals, as in every shell.
    ``before``: what is run in its process before the console."""
    reader, writer = os.pipe()
    os.set_inheritable(writer, True)
    command, environ = [sys.executable, "-c", before + PROGRAM, str(writer)], {**os.environ, "TERM": "xterm-256color"}
    if controlled:
        pid, terminal = pty.fork()
        if pid == 0:
            os.execve(command[0], command, environ)
    else:
        terminal, inside = pty.openpty()
        ends = [(os.POSIX_SPAWN_DUP2, inside, number) for number in range(3)]
        pid = os.posix_spawn(command[0], command, environ, file_actions=ends, setsid=True)
        os.close(inside)
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
        for key in (b"\x1b[27u", b"\x1b"):  # with the extended keyboard protocol, and without
            os.write(console.terminal, key)
            assert console.next_command() == "interrupt"


def test_escape_acts_before_anything_could_follow_it_and_only_once() -> None:
    acted: queue.SimpleQueue[str] = queue.SimpleQueue()  # keys as they act, and (in brackets) as they are queued
    ended = threading.Event()
    inside, outside = os.pipe()

    driver = listening_driver(unshown(inside, acted), acted.put, ended.set)()  # type: ignore[call-arg]
    thread = threading.Thread(target=driver.run_input_thread)  # type: ignore[attr-defined]
    thread.start()
    for data, keys in (
        (b"\x1b", ["escape", "(escape)"]),
        (b"\x1b[A", ["up", "(up)"]),
        (b"\x1b[27u", ["escape", "(escape)"]),
        (b"\x1b", ["escape", "(escape)"]),
        (b"a", ["a", "(a)"]),
    ):
        os.write(outside, data)
        assert [acted.get(timeout=PATIENCE_S) for _ in keys] == keys
    for rest, keys in (
        (b"q", ["(escape)", "q", "(q)"]),  # typed, or pasted, right behind it
        (b"\x1b", ["(escape)", "escape", "(escape)"]),
    ):
        os.write(outside, b"\x1b")
        assert acted.get(timeout=PATIENCE_S) == "escape"
        os.write(outside, rest)
        assert [acted.get(timeout=PATIENCE_S) for _ in keys] == keys
    assert acted.empty()
    os.close(outside)
    thread.join(PATIENCE_S)
    os.close(inside)
    assert ended.is_set(), "the end of the terminal was told"
    assert not thread.is_alive()


def test_an_escape_that_began_a_torn_sequence_acts_and_is_not_taken_for_typed() -> None:
    done: list[str] = []
    escape = LoneEscape(lambda: done.append("acts"), lambda: done.append("queued"))
    assert escape.taken("\x1b") == ""
    assert escape.taken("[A") == "\x1b[A"
    assert done == ["acts"]
    assert escape.taken("\x1b[A") == "\x1b[A", "whole"
    assert escape.taken("\x1b") == ""
    assert escape.taken("\x1b[B") == "\x1b[B", "a key of its own behind it"
    escape.overdue()
    assert done == ["acts", "acts", "queued"]


def test_an_escape_right_behind_a_report_acts_as_early_as_one_by_itself() -> None:
    done: list[str] = []
    escape = LoneEscape(lambda: done.append("acts"), lambda: done.append("queued"))
    assert escape.taken("\x1b[0n\x1b") == "\x1b[0n"
    assert done == ["acts"]
    assert escape.taken("\x1b[0n") == "\x1b[0n", "a report of its own behind it"
    assert done == ["acts", "queued"]
    assert escape.taken("ab\x1b\x1b") == "ab"
    assert done == ["acts", "queued", "acts", "acts"]
    assert escape.taken("q") == "q", "and not Alt+q"
    assert done[4:] == ["queued", "queued"]
    torn = "x" * (READ_BYTES - 1) + "\x1b"
    assert escape.taken(torn) == torn, "what is pasted comes in pieces"
    assert len(done) == 6


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT])
def test_a_terminal_that_goes_away_ends_the_session(number: signal.Signals) -> None:
    with session() as console:
        console.read_until(b"READY")
        assert console.next_command() == "started"
        os.kill(console.pid, number)
        assert console.next_command() == "quit"
        console.read_until(b"\x1b[?1049l")
        _, status = os.waitpid(console.pid, 0)
        assert os.waitstatus_to_exitcode(status) == 130


@pytest.mark.parametrize("controlled", [True, False], ids=["with SIGHUP", "without a signal"])
@pytest.mark.parametrize("state", [b"READY", b"LISTENING"], ids=["idle", "drawing"])
def test_a_closed_terminal_ends_the_process(controlled: bool, state: bytes) -> None:
    with session(controlled=controlled) as console:
        console.read_until(state)
        assert console.next_command() == "started"
        os.close(console.terminal)
        assert console.next_command() == "quit"
        _, status = os.waitpid(console.pid, 0)
        assert os.waitstatus_to_exitcode(status) == 130


def test_a_signal_ends_a_console_whose_screen_nobody_reads() -> None:
    with session() as console:
        console.read_until(b"LISTENING")
        assert console.next_command() == "started"
        while select.select([console.told], [], [], 2.0)[0]:
            assert console.next_line() == "frame"
        os.kill(console.pid, signal.SIGTERM)
        assert console.next_command() == "quit"
        _, status = os.waitpid(console.pid, 0)
        assert os.waitstatus_to_exitcode(status) == 130
