"""Which graphics a terminal has: it is asked, and only what it says itself is believed.

First for the size of a character in pixels, and for its device attributes, among which 4 stands for sixel. Only where
these are those of a VT220 or better it is asked whether it has kitty's graphics, in a sequence that older ones would
print. A terminal in a terminal (tmux, screen, zellij) answers for itself and not for the one around it, and is not
asked. One that never answers is shown half blocks as before; nobody waits for it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, Literal

from msgspec import Struct

from tui.graphics.answers import ATTRIBUTES, CELL

GraphicsChoice = Literal["auto", "blocks", "sixel", "kitty"]
"""What the settings say."""
Protocol = Literal["sixel", "kitty"]

MODERN: Final = 60
"""The first device attribute of a terminal like a VT220 or later ones is at least this."""
SIXEL: Final = 4
"""The device attribute of a terminal that shows sixel pictures (DEC STD 070)."""
NESTED: Final = ("TMUX", "STY", "ZELLIJ")
"""Variables that say that the terminal is in another one; over SSH only ``TERM`` does."""
_QUERY: Final = "\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\"
"""May a picture of one pixel be sent? Nothing is shown. (kitty's graphics protocol, "Querying support")"""
_YES: Final = "\x1b_Gi=31;OK\x1b\\"
_SIZE: Final = re.compile(r"\x1b\[6;(\d+);(\d+)t")
_MOST_PIXELS: Final = 100


class Cell(Struct, frozen=True):
    """The size of a character, pixels."""

    width: int
    height: int


class Graphics(Struct, frozen=True):
    """How pictures are sent. ``cell`` is known where ``protocol`` is sixel, which counts in pixels of the screen."""

    protocol: Protocol
    cell: Cell | None = None


def cell_of(columns: int, rows: int, width: int, height: int) -> Cell | None:
    """The size of a character on a terminal of so many, which is so many pixels large; None where that is not said."""
    return _sensible(width // columns, height // rows) if columns and rows else None


def nested(environ: Mapping[str, str]) -> bool:
    """Whether the terminal is one in another one."""
    return any(environ.get(name) for name in NESTED) or environ.get("TERM", "").startswith(("tmux", "screen"))


class Asking:
    """One conversation with a terminal: :meth:`begin` and :meth:`answered` say what it is to be sent next."""

    def __init__(self, choice: GraphicsChoice, environ: Mapping[str, str], cell: Cell | None = None) -> None:
        """``environ`` is that of the process; ``cell`` is what is known without asking."""
        self._choice = choice
        self._alone = not nested(environ) and not environ.get("NO_COLOR")
        self._cell = cell
        self._sixel = self._kitty = self._asked_kitty = False
        self.over = False
        """Nothing is asked any more: :attr:`found` stands."""

    @property
    def found(self) -> Graphics | None:
        """What the terminal has, as far as it is known; None: half blocks."""
        if self._kitty:
            return Graphics("kitty", self._cell)
        return Graphics("sixel", self._cell) if self._sixel and self._cell is not None else None

    def begin(self) -> str:
        """What to send first; nothing where nothing has to be asked."""
        if self._choice == "blocks" or (self._choice == "auto" and not self._alone):
            self.over = True
        elif self._choice == "kitty":
            self._kitty = self.over = True
        elif self._choice == "sixel" and self._cell is not None:
            self._sixel = self.over = True
        return "" if self.over else CELL + ATTRIBUTES

    def answered(self, answer: str) -> str:
        """What to send after this answer."""
        if self.over:
            return ""
        if size := _SIZE.fullmatch(answer):
            self._cell = _sensible(int(size[2]), int(size[1])) or self._cell
        elif answer == _YES:
            self._kitty = self._asked_kitty
        elif answer.startswith("\x1b[?"):
            if self._asked_kitty or self._choice == "sixel":
                self._sixel, self.over = self._sixel or self._choice == "sixel", True
                return ""
            attributes = [int(number) for number in answer[3:-1].split(";") if number]
            self._sixel = SIXEL in attributes[1:]
            if attributes and attributes[0] >= MODERN:
                self._asked_kitty = True
                return _QUERY + ATTRIBUTES
            self.over = True
        return ""


def _sensible(width: int, height: int) -> Cell | None:
    return Cell(width, height) if 2 <= width <= _MOST_PIXELS and 4 <= height <= _MOST_PIXELS else None
