"""The console on a (pseudo-)terminal that has graphics, or says so, or never answers: what a person would see there."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import numpy as np
import pyte
import pytest
from textual.geometry import Region

from tests.tui.paper import CELL, Paper, far_off
from tests.tui.scripted import sight_of
from tui.graphics.asking import GraphicsChoice, Protocol
from tui.terminal.link import ASK, REPORT

PROGRAM = """
import sys
from dataclasses import replace
import tui.terminal.link
from tests.tui.scripted import ScriptedEngine, flat, robot_at, sight_of
from tui.app import run_console

tui.terminal.link._DELAYS = (0.0, float(sys.argv[2]), 60.0)
sight = replace(sight_of(), objects=())

def start(dress):
    dress("sayso-dark", 30, camera="on", graphics=sys.argv[1])
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    engine.on_look = lambda deliver: deliver(sight)
    return engine

sys.exit(run_console(start))
"""
PICTURE = sight_of().picture.rgb
PATIENCE_S = 30
TOKEN = re.compile(r"\x1b[P_].*?\x1b\\|\x1b\[[0-?]*[ -/]*[@-~]|\x1b[^P_\[]|[^\x1b]+", re.DOTALL)
SIXEL = {"\x1b[16t": "\x1b[6;20;10t", "\x1b[c": "\x1b[?64;1;2;4;6;9;15;16;17;18;21;22;28c"}
KITTY = {"\x1b[c": "\x1b[?62;52;c", "a=q": "\x1b_Gi=31;OK\x1b\\"}


class Glass(pyte.Screen):
    """Text, on the same screen as pictures."""

    def __init__(self, columns: int, rows: int, paper: Paper) -> None:
        super().__init__(columns, rows)
        self.paper = paper

    def draw(self, data: str) -> None:
        column, row = self.cursor.x, self.cursor.y
        super().draw(data)
        self.paper.overwrite(Region(column, row, max(1, self.cursor.x - column), 1))


class Window:
    """A terminal window with the console in it."""

    def __init__(self, fd: int, pid: int, answers: dict[str, str]) -> None:
        self.fd = fd
        self.pid = pid
        self.pictures: list[int] = []  # bytes of each sequence with a picture
        self._answers = answers
        self._rest = ""
        self.resize(120, 40)

    def resize(self, columns: int, rows: int) -> None:
        self.paper = Paper(columns, rows)
        self.glass = Glass(columns, rows, self.paper)
        self._stream = pyte.Stream(self.glass)
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    @property
    def text(self) -> str:
        return "\n".join(self.glass.display)

    def type(self, keys: str) -> None:
        os.write(self.fd, keys.encode())

    def until(self, seen: Callable[[], object], what: str = "") -> None:
        end = time.monotonic() + PATIENCE_S
        while not seen():
            assert time.monotonic() < end, f"{what} not seen:\n{self.text}"
            if select.select([self.fd], [], [], 0.05)[0]:
                try:
                    self._read()
                except OSError:
                    raise AssertionError(f"ended before {what}:\n{self.text}") from None

    def wait(self) -> int:
        """To the end."""
        with suppress(OSError):
            while True:
                self._read()
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])

    def _read(self) -> None:
        data = self._rest + os.read(self.fd, 65536).decode(errors="replace")
        at = 0
        for token in TOKEN.finditer(data):
            if token.start() != at:
                break
            at = token.end()
            self._take(token[0])
        self._rest = data[at:]

    def _take(self, token: str) -> None:
        for question, answer in self._answers.items():
            if token == question or (question == "a=q" and token.startswith("\x1b_G") and "a=q" in token):
                self.type(answer)
        if token == ASK:
            self.type(REPORT[0])
        elif token.startswith(("\x1bP", "\x1b_")):
            if "a=q" not in token:
                self.pictures.append(len(token))
                self.paper.take(self.glass.cursor.x, self.glass.cursor.y, token)
        else:
            self._stream.feed(token)


@contextmanager
def window(answers: dict[str, str], choice: GraphicsChoice = "auto", *, bad_s: float = 30.0) -> Iterator[Window]:
    """``bad_s``: the line is bad from such a delay on; by itself, that of a busy machine is good."""
    pid, fd = pty.fork()
    if pid == 0:
        inherited = {name: value for name, value in os.environ.items() if name not in ("TMUX", "STY", "NO_COLOR")}
        program = [sys.executable, "-c", PROGRAM, choice, str(bad_s)]
        os.execve(program[0], program, {**inherited, "TERM": "xterm-256color", "COLORTERM": "truecolor"})
    try:
        yield Window(fd, pid, answers)
    finally:
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        os.close(fd)


def sees(console: Window) -> bool:
    """The whole picture of the camera is on the screen, and nothing in its place."""
    seen = console.paper.all
    return seen is not None and min(seen.shape[:2]) > 60 and far_off(np.ascontiguousarray(seen), PICTURE) < 0.06


def blocks(console: Window) -> bool:
    """The camera's pane, or what one sees of it, shows characters (on 120 × 40)."""
    return sum(line[62:118].count("▀") for line in console.glass.display[17:31]) > 20


def nothing(console: Window) -> bool:
    """No picture is left."""
    return console.paper.all is None


@pytest.mark.parametrize(("protocol", "answers"), [("sixel", SIXEL), ("kitty", KITTY)])
def test_a_terminal_with_graphics_shows_the_picture_wherever_it_belongs_and_nowhere_else(
    protocol: Protocol, answers: dict[str, str]
) -> None:
    with window(answers) as console:
        console.until(lambda: sees(console), "the picture")
        assert bool(console.paper.placed) == (protocol == "kitty")
        console.type("\x07")  # out of the line, where letters are text
        for there, back in (("?", "?"), ("1z", "z"), ("t", "t"), ("c", "c")):
            console.type(there)
            if there != "t":  # which opens a pane beside it
                console.until(lambda: nothing(console), f"{there} without a picture")
            console.type(back)
            console.until(lambda: sees(console), f"the picture after {back}")
        console.type("\x10")  # the palette lies over it
        console.until(lambda: nothing(console) and blocks(console), "half blocks")
        console.type("\x10")
        console.until(lambda: sees(console) and not blocks(console), "the picture after the palette")
        console.resize(100, 30)
        console.until(lambda: sees(console), "the picture on a smaller terminal")
        assert max(console.pictures) < 12_000
        console.type("q")
        assert console.wait() == 0
        assert not console.paper.placed
        assert console.paper.cell == CELL


def test_a_terminal_that_never_answers_shows_half_blocks_and_nobody_waits_for_it() -> None:
    with window({}) as console:
        console.until(lambda: blocks(console), "half blocks")
        console.type("\x07?")
        console.until(lambda: "Keys" in console.text, "help")
        console.type("?")
        console.until(lambda: "Keys" not in console.text and blocks(console), "half blocks again")
        console.type("q")
        assert console.wait() == 0
        assert not console.pictures


def test_pixels_that_somebody_has_chosen_are_sent_without_a_question() -> None:
    with window({}, "kitty") as console:
        console.until(lambda: sees(console), "the picture")


def test_over_a_bad_line_characters_are_sent() -> None:
    with window(KITTY, bad_s=0.0) as console:
        console.until(lambda: "kB/s" in console.text, "a bad line")
        console.until(lambda: blocks(console) and nothing(console), "half blocks")
        console.type("\x07q")
        assert console.wait() == 0
        assert nothing(console)
