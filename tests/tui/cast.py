"""Films the console doing a whole task: ``python -m tests.tui.cast``.

A real console in a pseudo-terminal, a real engine, simulated physics in real time. ``screenshots/sayso.cast`` is for
asciinema, ``screenshots/sayso.webp`` for the README.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

from tests.e2e.terminal import Terminal, console
from tests.tui.film import Film, asciicast, moving_picture
from tests.tui.pictures import SCREENSHOTS

CAST = SCREENSHOTS / "sayso.cast"
MOVING = SCREENSHOTS / "sayso.webp"
SIZE = (120, 40)


class Person:
    """Somebody at that terminal, who types no faster than people do and looks before going on."""

    def __init__(self, terminal: Terminal) -> None:
        self._terminal = terminal

    def look(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self._terminal.until(lambda: time.monotonic() > end)

    def press(self, keys: str) -> None:
        self._terminal.type(keys)
        self.look(0.8)

    def ask(self, text: str) -> None:
        for letter in text:
            self._terminal.type(letter)
            self.look(0.05)
        self.press("\r")

    def until(self, words: str) -> None:
        self._terminal.until(lambda: words in self._terminal.text)


def play(person: Person) -> None:
    """The task."""
    person.until("✓ robot")
    person.look(1.0)
    person.ask("go to the kitchen, pick up the green box and raise your arm")
    person.until("ACTING")
    person.until("READY")
    person.look(2.0)
    person.ask("put it in the bedroom")  # the line has the keyboard still
    person.until("ACTING")
    person.look(5.0)
    person.press("\x1b")
    person.until("READY")
    person.look(2.0)
    person.press("\x07\r")  # out of the line: the whole turn
    person.look(3.0)


def main() -> None:
    os.environ |= {"COLORTERM": "truecolor", "TEXTUAL_ANIMATIONS": "none"}
    film = Film(*SIZE)
    with (
        tempfile.TemporaryDirectory() as folder,
        console(state=Path(folder), columns=SIZE[0], rows=SIZE[1]) as terminal,
    ):
        terminal.on_output = lambda data: film.take(data, time.monotonic())
        play(Person(terminal))
        terminal.on_output = lambda data: None  # the end stays on the screen
        terminal.type("\x03")
        terminal.wait()
    frames = film.frames()
    told = asciicast(frames, *SIZE)
    for where in (folder, str(Path.home()), str(Path.cwd())):
        assert where not in told, f"the film tells {where}"
    CAST.write_text(told, encoding="utf-8")
    MOVING.write_bytes(moving_picture(frames, *SIZE))
    sizes = [f"{file.name} {file.stat().st_size // 1024} KiB" for file in (CAST, MOVING)]
    print(f"{frames[-1].at:.0f} s, {len(frames)} frames: {', '.join(sizes)}")


if __name__ == "__main__":
    main()
