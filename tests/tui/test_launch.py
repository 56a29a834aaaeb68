"""The picture that is there before Textual is: on a real (pseudo-)terminal."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import stat
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.tui.told import PATIENCE_S
from tui.terminal.launch import ENTER, LEAVE, LaunchPicture

PROGRAM = """
import os, sys
from pathlib import Path
from tui.terminal.launch import LaunchPicture

launch = LaunchPicture(Path(sys.argv[1]), os.environ)
launch.show()
try:
    if "broken" in sys.argv:
        raise SystemExit("Something cannot be imported.")
    from tests.tui.scripted import engine_for
    from tui.app import run_console
    def start(dress):
        launch.keep()
        return engine_for([])
    run_console(start, launch.passing)
finally:
    launch.withdraw()
"""
FRAME = "╭".encode()
TAKEN = b"\x1b[?2004h"
"""Textual has the terminal."""


class Console:
    """A console on a terminal of this size; everything that it writes is kept."""

    def __init__(self, folder: Path, *how: str, columns: int, rows: int) -> None:
        self._terminal, self.inside = pty.openpty()
        fcntl.ioctl(self.inside, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.before = termios.tcgetattr(self.inside)
        streams = {"stdin": self.inside, "stdout": self.inside, "stderr": self.inside}
        command = [sys.executable, "-c", PROGRAM, str(folder), *how]
        environ = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor"}
        self.process = subprocess.Popen(command, env=environ, start_new_session=True, **streams)  # type: ignore[call-overload]
        self.written = b""

    def read_until(self, *wanted: bytes) -> None:
        """One after the other."""
        at = 0
        for one in wanted:
            while (found := self.written.find(one, at)) < 0:
                assert select.select([self._terminal], [], [], PATIENCE_S)[0], f"{one!r} was never written."
                self.written += os.read(self._terminal, 65536)
            at = found + len(one)

    def quit(self, key: bytes = b"\x03") -> None:
        os.write(self._terminal, key)
        self.read_until(LEAVE[-8:].encode())
        self.process.wait(PATIENCE_S)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._terminal)
        os.close(self.inside)


@contextmanager
def console(folder: Path, *how: str, columns: int = 100, rows: int = 30) -> Iterator[Console]:
    made = Console(folder, *how, columns=columns, rows=rows)
    try:
        yield made
    finally:
        made.close()


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of pictures after a first start, which had none."""
    folder = tmp_path_factory.mktemp("state") / "launch"
    with console(folder) as first:
        first.read_until(TAKEN, b"quit")  # the status line: the engine has been started
        first.quit()
        assert first.written.find(FRAME) > first.written.find(TAKEN)
        assert first.written.startswith(ENTER.encode())
    return folder


def test_the_second_start_begins_with_what_textual_drew_first(kept: Path) -> None:
    (picture,) = kept.iterdir()
    assert stat.S_IMODE(picture.stat().st_mode) == 0o600
    with console(kept) as second:
        second.read_until(TAKEN, FRAME)
        begins = ENTER.encode() + b"\x1b[?25l" + picture.read_bytes()
        assert second.written.replace(b"\r\n", b"\n").startswith(begins)
        second.read_until(TAKEN, picture.read_bytes()[-40:])  # the same again, by Textual
        second.quit()
        assert second.written.count(ENTER.encode()) == 1
        assert termios.tcgetattr(second.inside) == second.before
    assert [file.name for file in kept.iterdir()] == [picture.name]


def test_a_terminal_of_another_size_has_no_picture_yet(kept: Path) -> None:
    with console(kept, "broken", columns=90) as other:
        other.read_until(b"Something cannot be imported.")
        assert FRAME not in other.written


def test_a_start_that_fails_gives_the_terminal_back(kept: Path) -> None:
    with console(kept, "broken") as failing:
        failing.read_until(FRAME, LEAVE.encode(), b"Something cannot be imported.")
        failing.process.wait(PATIENCE_S)
        assert termios.tcgetattr(failing.inside) == failing.before


def test_what_is_typed_before_textual_is_there_is_not_shown_and_not_lost(kept: Path) -> None:
    with console(kept) as early:
        early.read_until(FRAME)
        assert not termios.tcgetattr(early.inside)[3] & termios.ECHO
        early.quit(b"no\x07q")  # a request, then out of the line
        assert b"^" not in early.written.partition(TAKEN)[0]


def test_the_newest_pictures_are_kept_where_there_is_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tui.terminal.launch._MOST", 3)
    for columns in range(80, 90):
        monkeypatch.setattr("os.get_terminal_size", lambda fd, columns=columns: os.terminal_size((columns, 24)))
        launch = LaunchPicture(tmp_path / "launch", {"TERM": "xterm"})
        launch.passing("\x1b[1;1H" + "x" * columns)
        launch.keep()
    assert len(list((tmp_path / "launch").iterdir())) == 3
    (tmp_path / "file").touch()
    nowhere = LaunchPicture(tmp_path / "file" / "launch", {})
    nowhere.passing("\x1b[1;1H")
    nowhere.keep()  # no room: nothing is said, the next start begins without it
