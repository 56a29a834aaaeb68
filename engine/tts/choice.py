"""A voice for each language: one that says English well, and one that says the rest."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing

from engine.errors import SaysoError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece, Synthesiser


class ByLanguage:
    """Two voices behind one. Without the second, or where it does not load, what is not English is only shown, and
    ``tell`` is told so once."""

    def __init__(
        self, english: Synthesiser, others: Synthesiser | None, tell: Callable[[str], None] = lambda words: None
    ) -> None:
        self._english = english
        self._others = others
        self._tell = tell
        self._told = False

    @property
    def name(self) -> str:
        return self._english.name if self._others is None else f"{self._english.name}, {self._others.name}"

    async def load(self) -> None:
        await self._english.load()
        if (others := self._others) is None:
            return
        try:
            await others.load()
        except SaysoError as error:
            self._others, self._told = None, True
            await others.close()
            self._tell(f"Chinese answers are only shown. {error}")

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        voice = self._others if sentence.chinese else self._english
        if voice is None:
            if not self._told:
                self._told = True
                self._tell("Chinese answers are only shown: install espeak-ng to hear them.")
            return
        async with aclosing(voice.synthesise(sentence)) as pieces:
            async for piece in pieces:
                yield piece

    async def close(self) -> None:
        for voice in filter(None, (self._english, self._others)):
            await voice.close()
