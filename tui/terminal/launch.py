"""The picture that the console begins with, kept from an earlier start: it is on the terminal before Textual is loaded,
which takes a quarter of a second, and two after the machine has had other things to do.

It is what Textual draws first, byte for byte, and says nothing that might not be true any more: frames without anything
in them. There is one for each size and kind of terminal; without one, the console begins without it.
"""

from __future__ import annotations

import contextlib
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from config.writing import write_whole
from engine import __version__

ENTER: Final = "\x1b[?1049h"
"""To the alternate screen; as Textual writes it, by itself."""
LEAVE: Final = "\x1b[?25h\x1b[?1049l"
"""A cursor, and back from the alternate screen."""
_HIDE: Final = "\x1b[?25l"
_HOME: Final = "\x1b[1;1H"
"""A whole picture starts with its first line."""
_LOOKS: Final = ("TERM", "COLORTERM", "NO_COLOR", "TEXTUAL_COLOR_SYSTEM", "LC_ALL", "LC_MESSAGES", "LANG", "LANGUAGE")
"""Environment variables that change the picture."""
_MOST: Final = 12
"""Pictures that are kept, the newest ones."""
_LARGEST: Final = 200_000
"""Of a picture, bytes: 300×100 characters, each with a colour of its own, have fewer."""


class LaunchPicture:
    """The picture for the terminal that is stdout. For one start: each method is called once, but for
    :meth:`passing`; that one and :meth:`keep` in any thread."""

    def __init__(self, folder: Path, environ: Mapping[str, str]) -> None:
        """``folder`` is where pictures are kept; it need not exist."""
        self._file: Path | None = None
        with contextlib.suppress(OSError):  # no terminal
            size = os.get_terminal_size(1)
            looks = "\0".join((__version__, *(environ.get(name, "") for name in _LOOKS)))
            self._file = folder / f"{size.columns}x{size.lines}-{zlib.crc32(looks.encode()):08x}"
        self._shown = b""
        self._first = ""
        self._echoing: list[Any] | None = None  # how the terminal was before

    def show(self) -> None:
        """Show the picture, if there is one; what is typed from now on is not shown."""
        if self._file is None:
            return
        with contextlib.suppress(OSError):
            self._shown = self._file.read_bytes()[:_LARGEST]
        if self._shown:
            self._echo(on=False)
            _write(ENTER.encode() + _HIDE.encode() + self._shown)

    def passing(self, data: str) -> str:
        """What is to be written of ``data``, which Textual wants to write: who goes to the alternate screen is there
        already, and has the terminal from now on. Its first picture is remembered."""
        if data == ENTER and self._shown:
            self._echo(on=True)  # Textual wants to know how it was
            self._shown = b""
            return _HIDE
        if not self._first and data.startswith(_HOME):
            self._first = data
        return data

    def withdraw(self) -> None:
        """Give the terminal back, if Textual has not taken it."""
        if self._shown:
            self._echo(on=True)
            self._shown = b""
            _write(LEAVE.encode())

    def keep(self) -> None:
        """Keep what was drawn first, for the next start; nothing happens where there is no room."""
        picture = self._first.encode()
        if self._file is None or not 0 < len(picture) <= _LARGEST:
            return
        with contextlib.suppress(OSError):
            if self._file.exists() and self._file.read_bytes() == picture:
                return
            write_whole(self._file, picture)
            kept = sorted(self._file.parent.iterdir(), key=lambda file: file.stat().st_mtime, reverse=True)
            for old in kept[_MOST:]:
                old.unlink(missing_ok=True)

    def _echo(self, *, on: bool) -> None:
        try:
            import termios
        except ImportError:  # no POSIX terminal here
            return
        with contextlib.suppress(termios.error):
            if not on:
                self._echoing = termios.tcgetattr(0)
                quiet = termios.tcgetattr(0)
                quiet[3] &= ~termios.ECHO
                termios.tcsetattr(0, termios.TCSANOW, quiet)
            elif self._echoing is not None:
                termios.tcsetattr(0, termios.TCSANOW, self._echoing)
                self._echoing = None


def _write(data: bytes) -> None:
    while data:
        data = data[os.write(1, data) :]
