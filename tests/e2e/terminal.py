"""The real console in a real pseudo-terminal, with a terminal emulator that says what a person would see."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import select
import signal
import struct
import termios
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyte

from tests.e2e.sayso import command, environment

LIMIT_S = 60


TO_THE_PANES = "\x07"
"""Ctrl+g: out of the line, where letters are text, to the panes, where they are keys."""


class Terminal:
    """A terminal with sayso running in it; its session log tells what happened inside."""

    def __init__(self, fd: int, pid: int, columns: int, rows: int, state: Path) -> None:
        self.fd = fd
        self.pid = pid
        self._screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._screen)
        self._state = state
        self.on_output: Callable[[bytes], object] = lambda data: None

    def type(self, keys: str) -> None:
        os.write(self.fd, keys.encode())

    @property
    def text(self) -> str:
        """The screen, line by line."""
        return "\n".join(self._screen.display)

    def events(self) -> list[dict[str, Any]]:
        """Everything in the session log so far, except what is just being written."""
        lines = [line for log in (self._state / "logs").glob("*.jsonl") for line in log.read_bytes().splitlines(True)]
        return [json.loads(line) for line in lines if line.endswith(b"\n")]

    def until(self, seen: Callable[[], object]) -> None:
        """Feed the screen until ``seen`` holds; fails with the screen after ``LIMIT_S``."""
        end = time.monotonic() + LIMIT_S
        while not seen():
            if time.monotonic() > end:
                raise AssertionError(f"not seen within {LIMIT_S} s:\n{self.text}")
            ready, _, _ = select.select([self.fd], [], [], 0.05)
            if ready:
                try:
                    data = os.read(self.fd, 65536)
                    self._stream.feed(data)
                    self.on_output(data)
                except OSError:  # the program has ended and the terminal with it
                    if not seen():
                        raise AssertionError(f"ended before it was seen:\n{self.text}") from None
                    return

    def hang_up(self) -> None:
        """Close the terminal, as a connection that breaks does."""
        os.close(self.fd)
        self.fd = -1

    def wait(self) -> int:
        """Read to the end and return the exit code (negative: the signal)."""
        while self.fd >= 0:
            try:
                if not os.read(self.fd, 65536):
                    break
            except OSError:
                break
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])


@contextmanager
def console(
    *arguments: str,
    state: Path,
    columns: int = 120,
    rows: int = 40,
    before: str = "",
    below: Callable[[list[str]], list[str]] = list,
    environ: Mapping[str, str] | None = None,
) -> Iterator[Terminal]:
    """Start ``sayso`` in a pseudo-terminal of this size; afterwards it is gone. ``below`` makes its command line one
    that runs it below something else."""
    argv = below(command(*arguments, before=before))
    variables = environment(state, {"TERM": "xterm-256color", "LANG": "C.UTF-8", **(environ or {})})
    pid, fd = pty.fork()
    if pid == 0:  # the child: nothing of pytest may run in it
        os.execve(argv[0], argv, variables)
    fcntl.ioctl(fd, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    terminal = Terminal(fd, pid, columns, rows, state)
    try:
        yield terminal
    finally:
        try:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        except (ProcessLookupError, ChildProcessError):
            pass
        if terminal.fd >= 0:
            os.close(fd)
