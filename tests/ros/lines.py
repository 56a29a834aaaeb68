"""Programs of the tests that speak JSON lines: what they are told goes to their standard input, and what they tell
comes from their standard output."""

from __future__ import annotations

import base64
import contextlib
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

Line = dict[str, Any]
LEAVE_S = 10.0
"""In which a program that is told to end has ended."""


def write(line: Mapping[str, Any]) -> None:
    """Tell one thing, from any thread of such a program."""
    text = json.dumps(line, default=_plain)
    with _WRITING:
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


def read() -> Iterator[Line]:
    """What the program is told, until there is no more."""
    for text in sys.stdin:
        yield json.loads(text, object_hook=_rich)


class Program:
    """A child that speaks so. ``heard`` gets each line, in a thread of its own; without it nothing is heard."""

    def __init__(
        self, command: Sequence[str | Path], surroundings: Mapping[str, str], heard: Callable[[Line], object] | None
    ) -> None:
        self._heard = heard
        self._writing = threading.Lock()
        self.process = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=dict(surroundings),
        )
        self._hearing = threading.Thread(target=self._hear, name=f"lines of {command[-1]}", daemon=True)
        self._hearing.start()

    def tell(self, line: Mapping[str, Any]) -> None:
        """Tell it something; nothing happens where it has ended."""
        assert self.process.stdin is not None
        text = json.dumps(line, default=_plain)
        with self._writing, contextlib.suppress(BrokenPipeError, ValueError):  # it is gone, or being closed
            self.process.stdin.write(text + "\n")
            self.process.stdin.flush()

    def close(self) -> None:
        """Have it end, and wait until it has."""
        assert self.process.stdin is not None
        with self._writing, contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        try:
            self.process.wait(LEAVE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self._ended()

    def kill(self) -> None:
        """End it at once, as a crash does."""
        self.process.kill()
        self._ended()

    def _ended(self) -> None:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.wait()
        self._hearing.join()
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.stdout.close()

    def _hear(self) -> None:
        assert self.process.stdout is not None
        for text in self.process.stdout:
            if self._heard is not None:
                self._heard(json.loads(text, object_hook=_rich))


_WRITING = threading.Lock()


def _plain(value: object) -> object:
    if isinstance(value, bytes | bytearray):
        return {"octets": base64.b64encode(value).decode()}
    return value.tolist()  # type: ignore[attr-defined]  # of numpy or array


def _rich(found: Line) -> object:
    return base64.b64decode(found["octets"]) if found.keys() == {"octets"} else found
