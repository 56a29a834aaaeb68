"""The voice protocol, and the voice of text mode: answers are shown, not played."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, Protocol


class Voice(Protocol):
    """Says one sentence at a time."""

    @property
    def audible(self) -> bool:
        """False where answers are only shown."""
        ...

    def say(self, text: str, heard: Callable[[str], None]) -> Coroutine[Any, Any, None]:
        """Say ``text``; returns when all of it was played. Cancelling stops the sound at once, and so does whoever
        silences the voice from elsewhere between this call and the end.

        ``heard`` is called, in the loop's thread, after every word that was played, with everything played so far: the
        beginning of ``text`` up to that word. What it was called with last is what people heard, however this ends.
        """
        ...


class SilentVoice:
    """Text mode: what is shown counts as heard."""

    audible = False

    async def say(self, text: str, heard: Callable[[str], None]) -> None:
        """Show all of it at once."""
        heard(text)
