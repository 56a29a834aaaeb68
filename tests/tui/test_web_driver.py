"""The console behind a tab of a browser, at the other end of its pipes: what it promises to whoever presses a key."""

from __future__ import annotations

import fcntl
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pyte

from tests.tui.test_terminal import PROGRAM
from tests.tui.told import PATIENCE_S, Told
from tui.terminal.link import REPORT

BROWSER = {"TEXTUAL_DRIVER": "textual.drivers.web_driver:WebDriver", "COLUMNS": "120", "ROWS": "40"}
"""How textual-serve starts a program."""


@dataclass
class Tab(Told):
    """The process and what it is connected by; ``told`` gives the commands its engine got, a line each."""

    process: subprocess.Popen[bytes]
    told: int
    screen: pyte.Screen

    def send(self, data: bytes, kind: bytes = b"D") -> None:
        """What is typed, or (``M``) what the server has to say."""
        assert self.process.stdin is not None
        self.process.stdin.write(kind + len(data).to_bytes(4, "big") + data)
        self.process.stdin.flush()

    def read_until(self, wanted: str) -> None:
        """Draw until it is on the screen."""
        stream = pyte.Stream(self.screen)
        while wanted not in "\n".join(self.screen.display):
            kind, data = self.next_packet()
            if kind == b"D":
                stream.feed(data.decode())

    def next_packet(self) -> tuple[bytes, bytes]:
        head = self._read(5)
        return head[:1], self._read(int.from_bytes(head[1:], "big"))

    def _read(self, size: int) -> bytes:
        assert self.process.stdout is not None
        data = b""
        while len(data) < size:
            assert select.select([self.process.stdout], [], [], PATIENCE_S)[0], "The console wrote nothing."
            data += (got := os.read(self.process.stdout.fileno(), size - len(data)))
            assert got, "The console has ended."
        return data


@contextmanager
def tab() -> Iterator[Tab]:
    reader, writer = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(writer)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        bufsize=0,
        pass_fds=(writer,),
        env={**os.environ, **BROWSER},
    )
    os.close(writer)
    try:
        opened = Tab(process, reader, pyte.Screen(120, 40))
        assert opened._read(13) == b"__GANGLION__\n"
        yield opened
    finally:
        process.kill()
        process.wait()
        for end in (process.stdin, process.stdout):
            assert end is not None
            end.close()
        os.close(reader)


def test_escape_reaches_the_engine_although_the_browser_takes_nothing() -> None:
    with tab() as console:
        console.read_until("LISTENING")
        assert console.next_command() == "started"
        # From here on nobody reads: the pipe fills, and the user interface waits for it for ever. So that it does not
        # wait for a report instead, there is one for each frame.
        if hasattr(fcntl, "F_SETPIPE_SZ"):  # Linux: it fills sooner
            fcntl.fcntl(console.process.stdout, fcntl.F_SETPIPE_SZ, 4096)
        frames = 0
        while select.select([console.told], [], [], 2.0)[0]:
            assert console.next_line() == "frame"
            console.send(REPORT[0].encode())
            frames += 1
        assert frames
        for _ in range(2):
            console.send(b"\x1b")
            assert console.next_command() == "interrupt"


def test_the_end_of_a_tab_stops_the_robot_before_anything_else() -> None:
    for end in ("told", "gone"):
        with tab() as console:
            console.read_until("READY")
            assert console.next_command() == "started"
            if end == "told":
                console.send(json.dumps({"type": "quit"}).encode(), b"M")
            else:
                assert console.process.stdin is not None
                console.process.stdin.close()
            assert console.next_command() == "quit"
            assert console.process.wait(PATIENCE_S) == 130


def test_a_signal_ends_a_console_in_a_browser() -> None:
    with tab() as console:
        console.read_until("READY")
        assert console.next_command() == "started"
        console.process.send_signal(signal.SIGTERM)
        assert console.next_command() == "quit"
        assert console.process.wait(PATIENCE_S) == 130
