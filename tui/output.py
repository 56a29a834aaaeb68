"""Where commands print: data to stdout, words for people to stderr.

While an engine runs, lines are written by threads of their own, so that a reader who stalls never holds up the engine,
and one who goes away is noticed once.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

import msgspec

from engine.errors import StorageError

ENDING: Final = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
"""Signals by which a process is asked to end, besides Ctrl-C; each of them would leave what it runs behind."""
HELD_BYTES: Final = 4 << 20
"""How much is kept for a reader of stdout who does not read; then it counts as one who has gone."""
HELD_WORDS: Final = 1 << 16
"""The same for words on stderr, which are lost then, B."""
_LOOK_MS: Final = 500
"""How often a reader who does not read is looked at."""
_AT_ONCE: Final = 4096
"""What a pipe takes without holding up the writer, once it is writable at all (PIPE_BUF of Linux), B."""

_people: list[LineWriter] = []
"""What writes to stderr in the background, while something does."""


def say(text: str, *, wait_s: float = 0.0) -> None:
    """A line for people, on stderr. ``wait_s``: how long it may take, if it is written in the background."""
    if _people:
        _people[-1].write(text.encode(errors="replace"))
        _people[-1].drain(wait_s)
        return
    with contextlib.suppress(OSError, ValueError):
        print(text, file=sys.stderr, flush=True)  # noqa: T201 - this is where commands print


@contextlib.contextmanager
def said_in_background() -> Iterator[None]:
    """Within this, :func:`say` never blocks; what a stalled stderr does not take is lost."""
    writer = LineWriter(2, limit=HELD_WORDS)
    _people.append(writer)
    try:
        yield
    finally:
        _people.remove(writer)
        writer.close(1.0)


def data(text: str) -> None:
    """A line of data, on stdout. Raises :class:`StorageError` when it cannot be written, BrokenPipeError when nobody
    reads it."""
    try:
        print(text, flush=True)  # noqa: T201 - this is where commands print
    except BrokenPipeError:
        raise
    except OSError as error:
        silence_stdout()
        raise StorageError(f"The output cannot be written: {error.strerror or error}.") from error


def json_line(value: Any) -> None:
    """One JSON object on stdout."""
    data(msgspec.json.encode(value).decode())


class LineWriter:
    """Writes lines to a file descriptor in the background. Never through ``sys.stdout``: a thread that waits inside a
    buffered writer holds its lock, and the interpreter aborts at exit over that."""

    def __init__(self, fd: int, on_closed: Callable[[], None] | None = None, *, limit: int = HELD_BYTES) -> None:
        """``limit`` bytes are held for a slow reader. With ``on_closed``, which is then called once, one who is slower
        counts as gone; without, the lines that he misses are lost."""
        self._fd = fd
        self._on_closed = on_closed
        self._limit = limit
        self._lines: deque[bytes] = deque()
        self._held = 0  # bytes in there
        self._ending = False
        self._changed = threading.Condition()
        self.closed = False
        """The reader has gone, or there is no room for more; further lines are dropped."""
        self.trouble = ""
        """Why nothing can be written, where it is not for want of a reader."""
        self._thread = threading.Thread(target=self._run, name=f"lines to {fd}", daemon=True)
        self._thread.start()

    def write(self, line: bytes) -> None:
        """Queue one line, without its newline. Never blocks."""
        with self._changed:
            if self.closed:
                return
            if self._held + len(line) > self._limit:
                self.closed = self._on_closed is not None
                return
            self._lines.append(line + b"\n")
            self._held += len(line) + 1
            self._changed.notify_all()

    def drain(self, timeout: float) -> None:
        """Wait until all is written, for ``timeout`` seconds at most."""
        with self._changed:
            self._changed.wait_for(lambda: not self._held or self.closed, timeout)

    def close(self, timeout: float = 5.0) -> None:
        """Write what is queued, for ``timeout`` seconds at most."""
        with self._changed:
            self._ending = True
            self._changed.notify_all()
        self._thread.join(timeout)

    def _run(self) -> None:
        while (line := self._next()) is not None:
            try:
                self._write(line)
            except OSError as error:
                if not isinstance(error, BrokenPipeError):
                    self.trouble = error.strerror or str(error)
                self.closed = True
            with self._changed:
                self._held -= len(line)
                self._changed.notify_all()
            if self.closed:
                break
        if self.closed and self._on_closed is not None:
            self._on_closed()

    def _next(self) -> bytes | None:
        with self._changed:
            self._changed.wait_for(lambda: self._lines or self._ending)
            return self._lines.popleft() if self._lines else None

    def _write(self, line: bytes) -> None:
        """The whole line, unless the reader is given up meanwhile. Raises OSError."""
        room = select.poll()
        room.register(self._fd, select.POLLOUT)
        while line and not self.closed:
            if room.poll(_LOOK_MS):
                with contextlib.suppress(BlockingIOError):
                    line = line[os.write(self._fd, line[:_AT_ONCE]) :]


def silence_stdout() -> None:
    """Point stdout at nothing after its reader has gone, so that the interpreter's last flush does not fail."""
    with contextlib.suppress(OSError, ValueError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
