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
_ESCAPE: Final = ESCAPE.decode()
_GOES_ON: Final = ("[", "O", "_")
"""How the rest of a sequence begins: of a control sequence, a key of the keypad, a string (ECMA-48, xterm)."""


class LoneEscape:
    """Escape characters with nothing behind them. Each is the key, and acts at once; only their place in the queue of
    keys waits until it is known that the last does not begin a sequence, torn by a slow line. Before them anything may
    have come: a terminal's reports come often, and a busy machine reads them together with a key. For one reading
    thread."""

    def __init__(self, act: Callable[[], None], queue: Callable[[], None]) -> None:
        self._act = act
        self._queue = queue
        self.held = 0
        """So many are waiting to be queued."""

    def taken(self, text: str) -> str:
        """What remains to be parsed of what has come."""
        if self.held and text.startswith(_GOES_ON):
            self.held -= 1
            text = _ESCAPE + text
        self.overdue()
        if len(text) >= READ_BYTES:  # there is more, and an escape character at its end may begin something
            return text
        rest = text.rstrip(_ESCAPE)
        self.held = len(text) - len(rest)
        for _ in range(self.held):
            self._act()
        return rest

    def overdue(self) -> None:
        """Nothing has come for :data:`SEQUENCE_S`."""
        while self.held:
            self.held -= 1
            self._queue()
