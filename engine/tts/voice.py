"""The voice protocol, and the voice of text mode: answers are shown, not played."""

from __future__ import annotations

from typing import Protocol


class Voice(Protocol):
    """Says one sentence at a time."""

    @property
    def audible(self) -> bool:
        """False where answers are only shown."""
        ...

    async def say(self, text: str) -> str:
        """Say ``text`` and return what was heard of it. Cancelling stops the sound at once."""
        ...


class SilentVoice:
    """Text mode: what is shown counts as heard."""

    audible = False

    async def say(self, text: str) -> str:
        return text
