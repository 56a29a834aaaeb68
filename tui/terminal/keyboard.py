"""How the bytes of a keyboard are read, whichever terminal they come from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

ESCAPE: Final = b"\x1b"
"""The escape key, and the beginning of every escape sequence."""
READ_BYTES: Final = 4096
IDLE_S: Final = 0.1
"""How often the reading thread looks whether it is to end."""
SEQUENCE_S: Final = 0.03
"""How long to wait for the rest of a sequence, which is not much longer than Textual's parser does."""
_GOES_ON: Final = ("[", "O", "_")
"""How the rest of a sequence begins: of a control sequence, a key of the keypad, a string (ECMA-48, xterm)."""


class LoneEscape:
    """An escape character that came by itself. It is the key, and acts at once; only its place in the queue of keys
    waits until it is known that it does not begin a sequence, torn by a slow line. For one reading thread."""

    def __init__(self, act: Callable[[], None], queue: Callable[[], None]) -> None:
        self._act = act
        self._queue = queue
        self.held = False
        """One is waiting to be queued."""

    def taken(self, text: str) -> str:
        """What remains to be parsed of what has come."""
        held, self.held = self.held, text == "\x1b"
        if held and text.startswith(_GOES_ON):
            return "\x1b" + text
        if held:
            self._queue()
        if self.held:
            self._act()
            return ""
        return text

    def overdue(self) -> None:
        """Nothing has come for :data:`SEQUENCE_S`."""
        if self.held:
            self.held = False
            self._queue()
