"""An answer that comes in pieces: what may be heard of it, at once, and in the end the whole.

Some models think aloud first, between ``<think>`` and ``</think>``; that is no part of the answer. And no piece, nor
several together, ever holds the key with which the answer was asked for. A character that came in two halves
(surrogates) is whole when it is passed on; half a character alone is no text.
"""

from __future__ import annotations

from typing import Final

from engine.llm.chat import Hear
from engine.strict_json import is_text

MASK: Final = "********"
_OPEN: Final = "<think>"
_CLOSE: Final = "</think>"


class Streamed:
    """One answer while it comes."""

    def __init__(self, hear: Hear, secret: str = "") -> None:
        self._hear = hear
        self._secret = secret
        self._held = ""  # came, and cannot be passed on yet
        self._passed: list[str] = []
        self._thinking: bool | None = None  # None: too little came to know
        self.begun = False
        """Whether anything came."""

    def add(self, piece: str) -> None:
        """Raises ``ValueError`` for what is no text."""
        if not piece:
            return
        self.begun = True
        self._held += piece
        if self._thinking is None:
            start = self._held.lstrip()
            if len(start) < len(_OPEN) and _OPEN.startswith(start):
                return
            self._thinking = start.startswith(_OPEN)
        if self._thinking:
            _, closed, rest = self._held.partition(_CLOSE)
            if not closed:
                self._held = self._held[-len(_CLOSE) :]
                return
            self._thinking, self._held = False, rest
        self._held = self._held.replace(self._secret, MASK) if self._secret else self._held
        kept = self._tail()
        self._pass_on(self._held[: len(self._held) - kept])
        self._held = self._held[len(self._held) - kept :]

    def replace(self, text: str) -> None:
        """The service takes back what it said, and says this instead."""
        self._passed.clear()
        self._held, self._thinking = "", None
        self.add(text)

    def whole(self) -> str:
        """The answer, now that nothing more comes, without the spaces around it; empty where there is none. Raises
        ``ValueError`` for what is no text."""
        if not self._thinking:
            self._pass_on(self._held)
        self._held = ""
        return "".join(self._passed).strip()

    def _tail(self) -> int:
        """How many signs at the end may be the beginning of the secret, or of a character."""
        half = int("\ud800" <= self._held[-1:] <= "\udbff")
        longest = min(len(self._secret) - 1, len(self._held))
        return next((n for n in range(longest, 0, -1) if self._secret.startswith(self._held[-n:])), half)

    def _pass_on(self, text: str) -> None:
        if text:
            if not is_text(text):
                text = text.encode("utf-16", "surrogatepass").decode("utf-16")  # halves that belong together join
            self._passed.append(text)
            self._hear(text)
