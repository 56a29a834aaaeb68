"""What was typed, kept from one session to the next in a file that only its owner may read, one request a line; and
once more behind a tab where nothing was made of it, so that nobody is offered it again.

Keeping it is a comfort: a full disk, a folder that cannot be written or a file that is no text costs the
comfort alone. Nothing here waits for the disk in the thread that calls.
"""

from __future__ import annotations

import os
import queue
import stat
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from config.private import make_folders
from config.writing import write_whole

MAX_REQUESTS: Final = 200
"""As many are recalled."""
MAX_LINE: Final = 1000
"""Characters of one of them."""
_IN_VAIN: Final = "\t"
"""Stands before a request of which nothing was made."""
_MAX_BYTES: Final = 256 * 1024
"""A longer file is cut down to what is recalled the next time that it is read."""


class RequestHistory:
    """The requests of earlier sessions, and a place for those to come."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._warn: Callable[[str], object] = lambda why: None
        self._warned = False
        self._waiting: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._writer: threading.Thread | None = None
        self.earlier: tuple[str, ...] = ()
        """The newest last."""
        self.in_vain: frozenset[str] = frozenset()
        """Those of them of which nothing was made the last time: they were refused, or not understood."""

    def read(self, warn: Callable[[str], object] = lambda why: None) -> None:
        """Read what was typed in earlier sessions. Takes as long as the disk does. ``warn`` is told once, now or later
        and then in another thread, why the file cannot be used."""
        self._warn = warn
        try:
            if not stat.S_ISREG(self._path.stat().st_mode):
                self._tell(f"{self._path} is no file")
                return
            with self._path.open("rb") as file:
                size = os.fstat(file.fileno()).st_size
                file.seek(max(0, size - _MAX_BYTES))
                data = file.read(_MAX_BYTES)
            lines = data.decode(errors="replace").splitlines()[1 if size > _MAX_BYTES else 0 :]
            self._sort(lines)
            if size > _MAX_BYTES or len(lines) > 2 * MAX_REQUESTS:
                self._rewrite()
        except FileNotFoundError:
            return
        except OSError as error:
            self._tell(str(error))

    def _sort(self, lines: Sequence[str]) -> None:
        """What was asked for, and of what of it nothing was made the last time."""
        requests: list[str] = []
        in_vain: set[str] = set()
        for line in lines:
            if not (request := _clean(line)):
                continue
            if line.startswith(_IN_VAIN):
                in_vain.add(request)
            else:
                requests.append(request)
                in_vain.discard(request)
        self.earlier = tuple(requests[-MAX_REQUESTS:])
        self.in_vain = frozenset(in_vain.intersection(self.earlier))

    def add(self, request: str) -> None:
        """Keep a request; returns at once."""
        self._append("", request)

    def mark(self, request: str) -> None:
        """Keep that nothing was made of a request that was added; returns at once."""
        self._append(_IN_VAIN, request)

    def _append(self, mark: str, request: str) -> None:
        if not (line := _clean(request)):
            return
        if self._writer is None:
            self._writer = threading.Thread(target=self._write, name="history", daemon=True)
            self._writer.start()
        self._waiting.put(mark + line)

    def close(self, timeout_s: float = 1.0) -> None:
        """Write what still waits, unless the disk keeps us waiting."""
        if self._writer is not None:
            self._waiting.put(None)
            self._writer.join(timeout_s)

    def _write(self) -> None:
        while (line := self._waiting.get()) is not None:
            try:
                make_folders(self._path.parent)
                flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NONBLOCK  # a pipe of this name holds nobody up
                number = os.open(self._path, flags, 0o600)
                with os.fdopen(number, "ab", buffering=0) as file:
                    if not stat.S_ISREG(os.fstat(number).st_mode):
                        raise OSError(f"{self._path} is no file")
                    os.fchmod(number, 0o600)
                    file.write(f"{line}\n".encode())
            except OSError as error:
                self._tell(str(error))

    def _rewrite(self) -> None:
        """The file with what is recalled alone. Raises ``OSError``."""
        lines = (*self.earlier, *(_IN_VAIN + line for line in sorted(self.in_vain)))
        write_whole(self._path, "".join(f"{line}\n" for line in lines).encode())

    def _tell(self, why: str) -> None:
        if not self._warned:
            self._warned = True
            self._warn(why)


def _clean(line: str) -> str:
    """One line of text that disturbs no terminal; nothing for what is none."""
    line = line.strip()
    if len(line) > MAX_LINE or "\N{REPLACEMENT CHARACTER}" in line:
        return ""
    return line if line.isprintable() else ""
