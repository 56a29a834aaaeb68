"""Lines that are written in the background hold nobody up, and cost no more memory than they may."""

from __future__ import annotations

import os
import select
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

from engine.errors import StorageError
from tui import output
from tui.output import LineWriter, data, said_in_background, say

LINE = b"x" * 999


@contextmanager
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    with ExitStack() as stack:
        stack.callback(os.close, reading)
        stack.callback(os.close, writing)
        yield reading, writing


def test_a_reader_who_holds_the_output_open_and_does_not_read_counts_as_gone() -> None:
    gone = threading.Event()
    with pipe() as (_, writing):
        writer = LineWriter(writing, gone.set, limit=200_000)  # more than the pipe takes by itself
        for _ in range(400):
            writer.write(LINE)
        assert writer.closed
        assert gone.wait(30)
        writer.close(30)


def test_a_reader_who_is_slow_gets_every_line() -> None:
    gone = threading.Event()
    with pipe() as (reading, writing):
        writer = LineWriter(writing, gone.set, limit=400_000)
        for _ in range(300):
            writer.write(LINE)
        got = b""
        while len(got) < 300 * 1000:
            got += os.read(reading, 65536)
        writer.close(30)
        assert got == (LINE + b"\n") * 300
        assert not gone.is_set()


def test_lines_go_through_a_pipe_that_does_not_wait_by_itself() -> None:
    with pipe() as (reading, writing):
        os.set_blocking(writing, False)
        writer = LineWriter(writing, limit=400_000)
        for _ in range(300):
            writer.write(LINE)
        got = 0
        while got < 300 * 1000:
            got += len(os.read(reading, 65536))
        writer.close(30)


def test_a_reader_who_has_gone_is_told_of_once() -> None:
    told: list[bool] = []
    reading, writing = os.pipe()
    os.close(reading)
    writer = LineWriter(writing, lambda: told.append(True))
    writer.write(LINE)
    writer.close(30)
    writer.write(LINE)
    os.close(writing)
    assert told == [True]


def test_words_that_a_stalled_stderr_does_not_take_are_lost_and_hold_nobody_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pipe() as (reading, writing):
        monkeypatch.setattr(output, "LineWriter", lambda fd, *, limit: LineWriter(writing, limit=limit))
        with said_in_background():
            for _ in range(1000):
                say("x" * 999)  # a thousand times more than the pipe takes: returning is the test
            assert select.select([reading], [], [], 30)[0]  # written in a thread of its own
            first = os.read(reading, 1000)
        assert first == LINE + b"\n"


def test_output_for_which_there_is_no_room_is_an_error_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:  # noqa: PTH123
        monkeypatch.setattr("sys.stdout", full)
        with pytest.raises(StorageError, match="No space left"):
            data("a line")
