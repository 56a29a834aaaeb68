"""The console over a slow line, on a real (pseudo-)terminal that draws what arrives and reports it."""

from __future__ import annotations

import fcntl
import os
import queue
import random
import select
import struct
import termios
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from tests.tui.line import SlowLine
from tests.tui.test_terminal import Session, session
from tests.tui.told import PATIENCE_S
from tests.tui.unshown import unshown
from tui.terminal.driver import listening_driver

RATE = 20_000


@contextmanager
def slow_session(*, rate: float = RATE, reports: bool = True, before: str = "") -> Iterator[tuple[Session, SlowLine]]:
    """``before``: what is run in its process before the console."""
    with session(before=before) as console:
        line = SlowLine(console.terminal, 120, 40, rate=rate, reports=reports)
        try:
            yield console, line
        finally:
            line.close()


def frames(console: Session, count: int) -> None:
    """Wait until the console has looked at the robot so many times more, to draw it."""
    while select.select([console.told], [], [], 0)[0]:
        console.next_line()
    while count:
        count -= console.next_line() == "frame"


def compact(line: SlowLine) -> bool:
    """The console is laid out for 80×24."""
    top, second, *_, last = line.screen.display
    return (
        top.startswith(" ○ READY")
        and second.startswith("╭─ Conversation")
        and second.endswith("╮")
        and "Map" in second
        and last.startswith(" ›")
    )


def test_a_line_that_stalls_holds_a_few_frames_and_escape_does_not_wait_for_it() -> None:
    with slow_session() as (console, line):
        line.until(lambda: "LISTENING" in line.text and line.asked > 3)
        line.stalled, line.most_frames = True, 0
        frames(console, 30)
        assert 1 <= line.most_frames <= 6, "thirty were due"
        os.write(console.terminal, b"\x1b")
        assert console.next_command() == "interrupt"
        assert line.waiting, "the line has not moved"
        line.stalled = False
        line.until(lambda: "READY" in line.text)


def test_a_slow_line_never_holds_a_queue_of_old_frames() -> None:
    with slow_session() as (console, line):
        line.until(lambda: "LISTENING" in line.text and line.asked > 3)
        line.most_frames, asked = 0, line.asked
        line.until(lambda: line.asked > asked + 20)
        assert line.most_frames == 1
        os.write(console.terminal, b"\x1b")
        assert console.next_command() == "started"
        assert console.next_command() == "interrupt"
        line.until(lambda: "READY" in line.text)


def test_a_bad_line_is_spared_and_the_console_says_so() -> None:
    with slow_session(before="import tui.terminal.link; tui.terminal.link.CALM_S = 1.0") as (_, line):
        line.until(lambda: "LISTENING" in line.text)
        line.rate = 1_500
        line.until(lambda: "ms a frame" in line.text and "kB/s" in line.text)
        line.rate = 1_000_000
        line.until(lambda: "good again" in line.text and "kB/s" not in line.text)


def test_a_terminal_that_never_reports_is_drawn_on_all_the_same() -> None:
    with slow_session(rate=10 * RATE, reports=False) as (console, line):
        line.until(lambda: "LISTENING" in line.text)
        sent = line.sent
        line.until(lambda: line.sent > sent + 10_000)
        os.write(console.terminal, b"\x07i")  # to the panes, where letters are keys
        line.until(lambda: "delay unknown" in line.text)


def test_a_storm_of_sizes_ends_in_the_layout_of_the_last_one() -> None:
    sizes = random.Random(7)
    with slow_session(rate=10 * RATE) as (console, line):
        line.until(lambda: "LISTENING" in line.text)
        os.write(console.terminal, b"\x1b")
        line.until(lambda: "READY" in line.text)
        for _ in range(200):
            size = sizes.randint(1, 60), sizes.randint(1, 200)
            fcntl.ioctl(console.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", *size, 0, 0))
        fcntl.ioctl(console.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        line.resize(80, 24)
        line.until(lambda: compact(line) and line.quiet)
        assert line.most_frames <= 2, "sizes that were over were not drawn"
        left = line.text
        os.write(console.terminal, b"?")
        line.until(lambda: "Keys" in line.text)
        os.write(console.terminal, b"?")  # draws everything anew
        line.until(lambda: compact(line) and line.quiet)
        assert line.text == left, "nothing of another size was left"
        os.write(console.terminal, b"\x1b")
        while console.next_command() != "interrupt":
            pass


def test_a_report_is_no_key_and_an_escape_key_before_it_acts_once() -> None:
    acted: queue.SimpleQueue[str] = queue.SimpleQueue()
    inside, outside = os.pipe()

    driver = listening_driver(unshown(inside, acted), acted.put, on_report=lambda: acted.put("report"))()  # type: ignore[call-arg]
    thread = threading.Thread(target=driver.run_input_thread)
    thread.start()
    for pieces, wanted in (
        ((b"\x1b[0n",), ["report"]),
        ((b"a\x1b[0nb\x1b[3n",), ["a", "(a)", "report", "b", "(b)", "report"]),
        ((b"\x1b[0", b"nc"), ["report", "c", "(c)"]),  # torn apart by the line
        ((b"\x1b",), ["escape"]),
        ((b"\x1b[0n",), ["(escape)", "report"]),
        ((b"\x1b[27u",), ["escape", "(escape)"]),
    ):
        for piece in pieces:
            os.write(outside, piece)
        assert sorted(acted.get(timeout=PATIENCE_S) for _ in wanted) == sorted(wanted)
    assert acted.empty()
    os.close(outside)
    thread.join(PATIENCE_S)
    os.close(inside)
    assert not thread.is_alive()
