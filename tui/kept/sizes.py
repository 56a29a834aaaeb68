"""How the panes share the room, kept from one session to the next in a file that only its owner may read.

Keeping it is a comfort: a file that cannot be read, or that holds anything else, costs the comfort alone. Nothing here
waits for the disk in the thread that calls.
"""

from __future__ import annotations

import queue
import stat
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final, Literal, get_args

from config.writing import write_whole
from tui.words import strings

Split = Literal["wide", "compact", "below"]
"""What is divided in two: the columns of a large terminal, those of a small one, and the row of log and turns."""
Shares = Mapping[Split, int]
"""Percent of the room that lies to the left of each border."""

USUAL: Final[Shares] = {"wide": 52, "compact": 58, "below": 48}
LEAST: Final = 28
MOST: Final = 72
STEP: Final = 4
_MAX_BYTES: Final = 1024


def shifted(share: int, steps: int) -> int:
    """A share after its border went so many steps to the right; neither side becomes too small to read."""
    return max(LEAST, min(MOST, share + steps * STEP))


def shares_of(text: str) -> dict[Split, int]:
    """The shares that are written there; what is none is left out. Raises ``ValueError`` when it is no JSON object."""
    import json

    try:
        written = json.loads(text)
    except RecursionError as error:
        raise ValueError(strings.NO_SIZES) from error
    if not isinstance(written, dict):
        raise ValueError(strings.NO_SIZES)
    found = {split: written.get(split) for split in get_args(Split)}
    return {split: share for split, share in found.items() if type(share) is int and LEAST <= share <= MOST}


class SizeFile:
    """Where the shares are kept."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._warn: Callable[[str], object] = lambda why: None
        self._warned = False
        self._waiting: queue.SimpleQueue[Shares | None] = queue.SimpleQueue()
        self._writer: threading.Thread | None = None

    def read(self, warn: Callable[[str], object] = lambda why: None) -> Shares:
        """The shares of the last session, and the usual ones for the rest. Takes as long as the disk does. ``warn`` is
        told once, now or later and then in another thread, why the file cannot be used."""
        self._warn = warn
        try:
            if not stat.S_ISREG(self._path.stat().st_mode):
                raise OSError(strings.NO_FILE.format(self._path))
            with self._path.open("rb") as file:
                return {**USUAL, **shares_of(file.read(_MAX_BYTES).decode())}
        except FileNotFoundError:
            return USUAL
        except ValueError as error:
            self._tell(f"{self._path}: {error}")
        except OSError as error:
            self._tell(str(error))
        return USUAL

    def keep(self, shares: Shares) -> None:
        """Keep these for the next session; returns at once."""
        if self._writer is None:
            self._writer = threading.Thread(target=self._write, name="sizes", daemon=True)
            self._writer.start()
        self._waiting.put(dict(shares))

    def close(self, timeout_s: float = 1.0) -> None:
        """Write what still waits, unless the disk keeps us waiting."""
        if self._writer is not None:
            self._waiting.put(None)
            self._writer.join(timeout_s)

    def _write(self) -> None:
        import json

        while (shares := self._waiting.get()) is not None:
            try:
                write_whole(self._path, json.dumps(shares).encode() + b"\n")
            except OSError as error:
                self._tell(str(error))

    def _tell(self, why: str) -> None:
        if not self._warned:
            self._warned = True
            self._warn(why)
