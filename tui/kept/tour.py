"""Whether somebody sits here for the first time, who is told three things: until a request was made, and never again.

Remembering it is a comfort: where the folder cannot be written, the tour is shown once more.
"""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path

from config.private import make_folders


class Tour:
    """Remembers in a file that somebody has been here."""

    def __init__(self, path: Path, *signs: Path) -> None:
        """``signs``: other files that are there only once somebody has asked for something."""
        self._path = path
        self._signs = signs
        self._writer: threading.Thread | None = None
        self.due = False
        """Somebody needs it."""

    def read(self) -> bool:
        """Whether somebody needs it. Takes as long as the disk does."""
        with contextlib.suppress(OSError):
            self.due = not any(path.exists() for path in (self._path, *self._signs))
        return self.due

    def end(self) -> None:
        """Somebody has asked for something; returns at once."""
        if not self.due:
            return
        self.due = False
        self._writer = threading.Thread(target=self._write, name="tour", daemon=True)
        self._writer.start()

    def close(self, timeout_s: float = 1.0) -> None:
        """Write what still waits, unless the disk keeps us waiting."""
        if self._writer is not None:
            self._writer.join(timeout_s)

    def _write(self) -> None:
        with contextlib.suppress(OSError):
            make_folders(self._path.parent)
            self._path.touch(mode=0o600)
