"""The event log: every event of a session as JSON lines in the user's state folder.

Each line is one ``write`` to an unbuffered file, so a crash of the process loses nothing that was published. Files
are readable by their owner alone. A full disk or a lost folder ends the log, is reported once, and never ends the
session.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from config.private import private_folder
from engine.errors import StorageError
from engine.events import Event, to_json

SUFFIX = ".jsonl"


class EventLog:
    """Appends events to ``FOLDER/SESSION.jsonl``; goes on in ``SESSION.2.jsonl`` beyond ``max_bytes``. Each new file
    makes the oldest ones in the folder go, so that ``keep`` stay."""

    def __init__(self, folder: Path, session: str, *, max_bytes: int, keep: int) -> None:
        self._folder = folder
        self._session = session
        self._max_bytes = max_bytes
        self._keep = keep
        self._part = 0
        self._size = 0
        self._fd: int | None = None
        self.on_error: Callable[[StorageError], None] | None = None

    def open(self) -> Path:
        """Create the first file. Raises :class:`StorageError`."""
        try:
            private_folder(self._folder)
            return self._next_file()
        except OSError as error:
            self.close()
            raise self._trouble(error) from error

    def write(self, event: Event) -> None:
        """Append one event; a subscriber of the bus."""
        if self._fd is None:
            return
        line = to_json(event) + b"\n"
        try:
            if self._size + len(line) > self._max_bytes:
                self._next_file()
            if os.write(self._fd, line) < len(line):
                os.ftruncate(self._fd, self._size)  # no half line for a reader to stumble over
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._size += len(line)
        except OSError as error:
            self.close()
            if self.on_error is not None:
                self.on_error(self._trouble(error))

    def close(self) -> None:
        """Close the file; writing afterwards does nothing."""
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def _next_file(self) -> Path:
        self.close()
        self._part += 1
        name = self._session if self._part == 1 else f"{self._session}.{self._part}"
        path = self._folder / f"{name}{SUFFIX}"
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
        self._size = 0
        self._prune(path)
        return path

    def _prune(self, newest: Path) -> None:
        """Remove the oldest files beyond ``keep``, own ones included. Other engines may do so at the same time."""
        ages = {}
        for file in self._folder.glob(f"*{SUFFIX}"):
            with suppress(FileNotFoundError):
                ages[file] = file.stat().st_mtime_ns
        ages.pop(newest, None)
        old = sorted(ages, key=lambda file: ages[file])
        for file in old[: max(0, len(old) + 1 - self._keep)]:
            file.unlink(missing_ok=True)

    def _trouble(self, error: OSError) -> StorageError:
        return StorageError(
            f"The event log in {self._folder} cannot be written: {error.strerror}.",
            hint="Free some space or set SAYSO_STATE_DIR; this session goes on without a log.",
        )
