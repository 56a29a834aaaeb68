"""A voice for each language: one that says its own well, and one that says the other."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing

from engine.errors import SaysoError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece, Synthesiser, VoiceLost


class ByLanguage:
    """Two voices behind one: one for Chinese or, as usual, for English, and one for the other of both. Without the
    second, or where it does not load, that is only shown, and ``tell`` is told so once."""

    def __init__(
        self,
        own: Synthesiser,
        other: Synthesiser | None,
        tell: Callable[[str], None] = lambda words: None,
        *,
        chinese: bool = False,
    ) -> None:
        """``chinese``: what ``own`` says."""
        self._own = own
        self._other = other
        self._tell = tell
        self._told = False
        self._chinese = chinese

    @property
    def name(self) -> str:
        return self._own.name if self._other is None else f"{self._own.name}, {self._other.name}"

    async def load(self) -> None:
        await self._own.load()
        if (other := self._other) is None:
            return
        try:
            await other.load()
        except VoiceLost:  # the next sentence starts it anew, or tells why it cannot be
            return
        except SaysoError as error:
            self._other, self._told = None, True
            await other.close()
            if self._chinese:
                self._tell(f"English answers are only shown. {error}")
            else:
                self._tell(f"Chinese answers are only shown. {error}")

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        voice = self._own if sentence.chinese == self._chinese else self._other
        if voice is None:
            if not self._told:
                self._told = True
                if self._chinese:
                    self._tell("English answers are only shown: install espeak-ng to hear them.")
                else:
                    self._tell("Chinese answers are only shown: install espeak-ng to hear them.")
            return
        async with aclosing(voice.synthesise(sentence)) as pieces:
            async for piece in pieces:
                yield piece

    async def close(self) -> None:
        for voice in filter(None, (self._own, self._other)):
            await voice.close()
