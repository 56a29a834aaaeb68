"""What a terminal answers when it is asked what it can do, taken out of what is typed.

An answer may be longer than any key, and kitty's has an escape character in its middle: Textual's parser would deal
both out as keys that were typed. So answers are taken out before anything is parsed, and while one may still come, what
may be the beginning of one is held back: for a moment where it may be a key as well, longer where nobody types such a
thing. Who asks puts a request for the device attributes last, which every terminal answers: then all answers are there,
and from then on nothing is looked at or held back any more.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Final

ATTRIBUTES: Final = "\x1b[c"
"""Primary device attributes (DA1, ECMA-48 8.3.24): asks for the level of the terminal and what it has."""
CELL: Final = "\x1b[16t"
"""Asks for the size of a character, pixels (xterm)."""

_ANSWER: Final = re.compile(r"\x1b\[\?[\d;]*c|\x1b\[6;\d+;\d+t|\x1b_G[^\x1b]{0,200}\x1b\\")
_BEGINNING: Final = re.compile(r"\x1b(?:\[(?:\?[\d;]*|6(?:;\d*){0,2})?|_(?:G[^\x1b]{0,200}\x1b?)?)?\Z")
_LAST: Final = re.compile(r"\x1b\[\?[\d;]*c\Z")
_UNTYPED: Final = re.compile(r"\x1b\[\?|\x1b\[6;|\x1b_G")
"""No key begins like this."""

KEY_S: Final = 0.03
"""How long to hold back what may be a key as well."""
ANSWER_S: Final = 1.0
"""How long to wait for the rest of an answer that a slow line has torn."""


class Answers:
    """Takes answers out of a stream of text, and tells each to ``on_answer``. For one reading thread."""

    def __init__(self, on_answer: Callable[[str], object], clock: Callable[[], float] = time.monotonic) -> None:
        """``clock`` is monotonic seconds."""
        self._on_answer = on_answer
        self._clock = clock
        self._awaited = 0  # requests for device attributes without an answer
        self._held = ""
        self._until = 0.0

    @property
    def awaited(self) -> bool:
        """Answers are still to come."""
        return self._awaited > 0

    @property
    def held(self) -> bool:
        """Something is held back."""
        return bool(self._held)

    def expect(self) -> None:
        """To be called before a request for the device attributes is sent; thread-safe."""
        self._awaited += 1

    def taken(self, text: str) -> str:
        """What remains to be parsed of what has come."""
        if not self._awaited and not self._held:
            return text
        text, self._held = self._held + text, ""
        rest, at = "", 0
        for found in _ANSWER.finditer(text):
            rest, at = rest + text[at : found.start()], found.end()
            if _LAST.match(found[0]):
                self._awaited = max(0, self._awaited - 1)
            self._on_answer(found[0])
        rest += text[at:]
        if self._awaited and (beginning := _BEGINNING.search(rest)):
            rest, self._held = rest[: beginning.start()], beginning[0]
            self._until = self._clock() + (ANSWER_S if _UNTYPED.match(self._held) else KEY_S)
        return rest

    def overdue(self) -> str:
        """What was held back and has waited long enough: it was typed after all."""
        if not self._held or self._clock() < self._until:
            return ""
        rest, self._held = self._held, ""
        return rest
