"""From a sentence to its sound: the protocol that every voice speaks, and how one knows which words have been said.

Sound comes in pieces, the first as soon as there is one. A voice that knows when each word ends says so; for one that
does not, :class:`Timing` estimates it from the length of the words and of the sound.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import AsyncGenerator
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.errors import ModelError
from engine.tts.sentences import Sentence, Word

Samples = NDArray[np.int16]
"""Mono sound."""

PACE: Final = 14.0
"""Characters that are said in a second, as long as nothing better is known."""
QUIET: Final = 0.02
"""Below this share of its loudest sample, the end of a sentence is silence."""
_DIGIT, _PAUSE = 4, 3  # how many letters the name of a digit, and the breath at a comma, count as


class VoiceLost(ModelError):
    """Whatever made the sound has gone or hangs; a new one may do better."""


@dataclass(frozen=True, slots=True)
class Said:
    """``count`` words of the sentence have been said ``at`` seconds after its sound began."""

    count: int
    at: float


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Some of a sentence's sound."""

    samples: Samples
    rate: int  # Hz; the same in all pieces of a sentence
    said: tuple[Said, ...] = ()  # as far as the voice knows, in order; may concern sound that is still to come


class Synthesiser(Protocol):
    """A voice that makes sound, and plays none. Belongs to one loop, one sentence at a time."""

    @property
    def name(self) -> str:
        """For people: ``piper (en_US-joe-medium)``."""
        ...

    async def load(self) -> None:
        """Get ready, so that the first sentence comes soon. Raises ``SaysoError``; ``VoiceLost`` where it may be worth
        while to try again."""
        ...

    def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        """The sound of a sentence, as it comes; nothing for one that this voice cannot say. Whoever has heard enough
        closes the iterator. Raises ``SaysoError``."""
        ...

    async def close(self) -> None:
        """Leave nothing of it behind."""
        ...


class Timing:
    """Which words of a sentence have been said after so much of its sound."""

    def __init__(self, sentence: Sentence) -> None:
        weights = [_weight(word) for word in sentence.words]
        self._shares = np.cumsum(weights) / max(1, sum(weights))  # of the sound, up to the end of each word
        self._estimate = float(sum(weights)) / PACE  # s
        self._known: list[Said] = []
        self._pieces: list[Samples] = []
        self._rate = 0
        self._whole = False

    def add(self, piece: Piece) -> None:
        """Some more of the sound."""
        self._known += piece.said
        self._pieces.append(piece.samples)
        self._rate = piece.rate

    def finish(self) -> None:
        """That was all of it."""
        self._whole = True
        if self._rate:
            sound = np.concatenate(self._pieces)
            self._estimate = _voiced(sound) / self._rate
        self._pieces.clear()

    def said(self, seconds: float) -> int:
        """How many words."""
        if self._known:
            index = bisect_right(self._known, seconds, key=lambda said: said.at)
            return self._known[index - 1].count if index else 0
        share = seconds / self._estimate if self._estimate > 0 else 1.0
        count = int(np.searchsorted(self._shares, min(share, 1.0) + 1e-9, side="right"))
        return count if self._whole else min(count, len(self._shares) - 1)  # more may be to come than one thinks


def _weight(word: Word) -> int:
    letters = sum(_DIGIT if char.isdigit() else char.isalnum() for char in word.said)
    pause = _PAUSE if word.said and not word.said[-1].isalnum() else 0
    return (letters * 3 if any("\u3400" <= char <= "\u9fff" for char in word.said) else letters) + pause


def _voiced(sound: Samples) -> int:
    """Samples up to the end of the last one that can be heard."""
    if not len(sound):
        return 0
    loud = np.flatnonzero(np.abs(sound.astype(np.int32)) > QUIET * np.abs(sound.astype(np.int32)).max())
    return int(loud[-1]) + 1 if len(loud) else len(sound)
