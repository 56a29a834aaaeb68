"""A film of a terminal shows what stood there, and asks whoever plays it nothing."""

from __future__ import annotations

import json
import random
import re

import pyte

from tests.tui.cast import CAST, SIZE
from tests.tui.film import TOGETHER_S, Film

LOOKS = ("\x1b[1m", "\x1b[4;3m", "\x1b[0m", "\x1b[38;2;10;200;30m", "\x1b[48;2;1;2;3m", "\x1b[7m", "\x1b[39;49m")
TEXTS = ("Go to the kitchen.", "去厨房", "▐█▌", "\x1b[2K", "\x1b[?1000h\x1b[5n", "\x1b[2J")


def test_what_is_played_looks_like_what_was_filmed() -> None:
    chance = random.Random(1)
    film, there, here = Film(40, 12), pyte.Screen(40, 12), pyte.Screen(40, 12)
    filmed, played, shown = pyte.ByteStream(there), pyte.Stream(here), 0
    for number in range(300):
        place = f"\x1b[{chance.randint(1, 12)};{chance.randint(1, 40)}H"
        data = (place + chance.choice(LOOKS) + chance.choice(TEXTS)).encode()
        filmed.feed(data)
        film.take(data, number * 2 * TOGETHER_S)
        for frame in film.frames()[shown:]:
            played.feed(frame.written)
            shown += 1
        assert here.display == there.display
        assert all(here.buffer[row][column] == there.buffer[row][column] for row in range(12) for column in range(40))


def test_what_comes_at_once_is_one_frame_and_what_changes_nothing_is_none() -> None:
    film = Film(40, 12)
    for number, data in enumerate((b"going", b" to", b" the kitchen")):
        film.take(data, 100 + number * TOGETHER_S / 2)
    film.take(b"\x1b[?25h\x1b[5n", 101.0)
    film.take(b"\x1b[2;1Hthere", 102.0)
    assert [(round(frame.at, 3), "the" in frame.written) for frame in film.frames()] == [(0.0, True), (2 - 0.05, True)]


def test_the_film_that_is_kept_shows_a_whole_task_and_asks_nothing() -> None:
    header, *frames = map(json.loads, CAST.read_text(encoding="utf-8").splitlines())
    assert (header["version"], header["width"], header["height"]) == (2, *SIZE)
    screen = pyte.Screen(*SIZE)
    stream, states = pyte.Stream(screen), []
    for _, kind, written in frames:
        assert kind == "o"
        assert re.sub(r"\x1b\[[\d;]*[mH]|\x1b\[\?25l|\x1b\[2J", "", written).isprintable()
        stream.feed(written)
        state = next(iter(re.findall(r"\w+", screen.display[0])), "")
        states += [state] if state and [state] != states[-1:] else []
    assert states[0] == "STARTING"
    assert states.count("ACTING") == 2
    assert states[-1] == "READY"
    assert "■ interrupted" in screen.display[2]
