"""Lines that come at once from a terminal that does not mark what is pasted: one submission, and each is done."""

from __future__ import annotations

import os

import pytest
from textual import events
from textual._xterm_parser import XTermParser

from engine.commands import Interrupt, Say
from tests.tui.desk import console
from tests.tui.test_terminal import session
from tui.terminal.bursts import Burst, Bursts

THREE = "beep\rdance\rnod\r"


PAUSE_S = 0.05
TYPED_S = 0.08


def queued(*reads: str, every: float = TYPED_S, pause: float = PAUSE_S) -> list[str]:
    """What becomes of these reads, one ``every`` so many seconds, behind which nothing comes; without more for a
    ``pause``, nothing is held any longer. Keys by their names, bursts by their text."""
    now = 0.0
    parser, bursts, found = XTermParser(), Bursts(lambda: now), []
    for read in reads:
        found += bursts.taken(parser.feed(read))
        now += every
        if every >= pause:
            found += bursts.overdue()
    found += bursts.overdue()
    return [
        one.text if isinstance(one, Burst) else one.key if isinstance(one, events.Key) else type(one).__name__
        for one in found
    ]


@pytest.mark.parametrize(
    ("reads", "found"),
    [
        (["go\rnod\r"], ["go\nnod\n"]),
        (["go\rn"], ["go\nn"]),
        (["去厨房\r停下\r"], ["去厨房\n停下\n"]),
        (["go\r\rnod\r"], ["go\n\nnod\n"]),
        (["go\r\n\r\nnod\r\n"], ["go\n\n\n\nnod\n\n"]),
        (["\r\rgo\r  \rnod\r"], ["\n\ngo\n  \nnod\n"]),
        (["go\r"], ["g", "o", "enter"]),
        (["\r\r"], ["enter", "enter"]),
        (["go\r\r"], ["g", "o", "enter", "enter"]),
        (["g", "o", "\r"], ["g", "o", "enter"]),
        (["go\rnod\r\x1b[A"], ["go\nnod\n", "up"]),
        (["\x1b[200~go\rnod\x1b[201~"], ["Paste"]),
    ],
    ids=str,
)
def test_text_right_behind_an_enter_makes_a_burst(reads: list[str], found: list[str]) -> None:
    assert queued(*reads) == found


@pytest.mark.parametrize(
    ("reads", "found"),
    [
        (["go\rno", "d\rbee", "p\r"], ["go\nnod\nbeep\n"]),
        (["go\r", "\r", "nod\r"], ["go\n\nnod\n"]),
        (["go\r", "nod\r"], ["go\nnod\n"]),
        ([*"go\r\rnod\rbeep\r"], ["g", "o", "\n\nnod\nbeep\n"]),
        ([*"go\r"], ["g", "o", "enter"]),
        (["go\r", "\x1b[A", "nod\r"], ["g", "o", "enter", "up", "n", "o", "d", "enter"]),
    ],
    ids=str,
)
def test_a_paste_may_come_in_many_reads(reads: list[str], found: list[str]) -> None:
    assert queued(*reads, every=0.002) == found


def test_who_goes_on_typing_after_an_enter_pastes_nothing() -> None:
    assert queued(*"go\rnod\r") == ["g", "o", "enter", "n", "o", "d", "enter"]
    assert queued("go\r", "nod\r") == ["g", "o", "enter", "n", "o", "d", "enter"]


def keys(text: str) -> list[events.Key]:
    found = list(XTermParser().feed(text))
    assert all(isinstance(key, events.Key) for key in found)
    return found  # type: ignore[return-value]


def burst(text: str) -> Burst:
    return Burst(keys(text), text.replace("\r", "\n"))


async def test_all_of_it_is_sent_at_once_and_what_is_behind_the_last_enter_stays_in_the_line() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"be")
        desk.app.post_message(burst("ep\rdance\rno"))
        await desk.settled()
        assert desk.engine.sent == [Say("beep", then=("dance",))]
        assert desk.app.main.line.value == "no"
        await desk.press(*"d", "enter")
        assert desk.engine.sent[1:] == [Say("nod")]


@pytest.mark.parametrize("stop", ["stop", "停", "emergency stop"])
async def test_a_stop_among_the_lines_is_sent_with_them_and_the_engine_lets_it_wait_for_none(stop: str) -> None:
    async with console(in_line=True) as desk:
        desk.app.post_message(burst(f"beep\r\r{stop}\rnod\r"))
        await desk.settled()
        assert desk.engine.sent == [Say("beep", then=(stop, "nod"))]


async def test_a_burst_behind_text_that_stands_in_the_line_ends_that_line() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"beep")
        desk.app.post_message(burst("\r\rdance\rno"))
        await desk.settled()
        assert desk.engine.sent == [Say("beep", then=("dance",))]
        assert desk.app.main.line.value == "no"


async def test_outside_the_line_they_are_keys() -> None:
    async with console(in_line=True) as desk:
        await desk.press("ctrl+g")
        desk.app.post_message(burst("/go\rnod\r"))
        await desk.settled()
        assert desk.engine.sent == [Say("go"), Say("nod")]


def test_a_console_on_a_terminal_sends_what_came_in_one_read_as_one_command() -> None:
    with session() as terminal:
        terminal.read_until(b"LISTENING")
        assert terminal.next_command() == "started"
        os.write(terminal.terminal, THREE.encode())
        assert terminal.next_command() == "say"
        os.write(terminal.terminal, b"\x1b")
        assert terminal.next_command() == Interrupt.do
