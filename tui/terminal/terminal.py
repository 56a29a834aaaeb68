"""Whether the console can be drawn here at all, and how large a terminal it wants."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Final, Literal

from tui.graphics.asking import Cell, cell_of
from tui.words import strings

MIN_COLUMNS: Final = 60
MIN_ROWS: Final = 16
SHORT_ROWS: Final = 22
"""With fewer rows, plan and figures give their room to conversation and map."""
TALL_ROWS: Final = 46
"""From so many rows a wide terminal has room for the camera and the log."""
COMPACT_COLUMNS: Final = 80
"""With fewer columns there is room for one column of panes."""
WIDE_COLUMNS: Final = 110
WIDE_ROWS: Final = 32

Layout = Literal["tiny", "narrow", "compact", "wide"]


def layout_for(columns: int, rows: int) -> Layout:
    """The arrangement of panes for a terminal of this many characters."""
    if columns < MIN_COLUMNS or rows < MIN_ROWS:
        return "tiny"
    if columns < COMPACT_COLUMNS:
        return "narrow"
    return "wide" if columns >= WIDE_COLUMNS and rows >= WIDE_ROWS else "compact"


def too_small(columns: int, rows: int, keys: str) -> str:
    """What to say on a terminal that is too small, with the ``keys`` that act; shorter where not even that fits."""
    if columns < 24 or rows < 6:
        return strings.TOO_SMALL_SHORT.format(columns=columns, rows=rows)
    need = strings.TOO_SMALL.format(min_columns=MIN_COLUMNS, min_rows=MIN_ROWS, columns=columns, rows=rows)
    return f"{need}\n\n{keys}"


def cell_here() -> Cell | None:
    """The size of a character of this terminal, where the system knows it; over SSH it often does."""
    try:
        from fcntl import ioctl
        from termios import TIOCGWINSZ

        rows, columns, width, height = struct.unpack("HHHH", ioctl(1, TIOCGWINSZ, bytes(8)))
    except (ImportError, OSError):  # no POSIX terminal here
        return None
    return cell_of(columns, rows, width, height)


def over_ssh(environ: Mapping[str, str]) -> bool:
    """Whether the terminal is somewhere else, where pictures may cost too much."""
    return any(name in environ for name in ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT"))


def why_not_usable(
    environ: Mapping[str, str], stdin_isatty: bool, stdout_isatty: bool, stderr_isatty: bool = True
) -> str | None:
    """A sentence for a person when the console cannot run here, else None. (Textual draws on standard error.)

    The command line asks before anything of the console is imported. A small window is no reason: it can grow.
    """
    for stream, is_terminal in zip(strings.STREAMS, (stdin_isatty, stdout_isatty, stderr_isatty), strict=True):
        if not is_terminal:
            return strings.NOT_A_TERMINAL.format(stream=stream)
    term = environ.get("TERM", "")
    if term in ("", "dumb", "unknown"):
        return strings.DUMB_TERMINAL.format(term=term or "not set")
    return None
