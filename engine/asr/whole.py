"""Whole recordings: words with their times, to be read rather than acted on.

An utterance of a conversation ends where the speaker pauses, and is decoded alone. A recording is decoded as one: what
comes before a pause helps to understand what comes after it, and no word is lost where it was cut.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.asr.recogniser import Recogniser, Rejected, Transcript


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a recording, as the recogniser divides it."""

    start: float  # s from the beginning
    end: float
    found: Transcript | Rejected


class WholeRecogniser(Recogniser, Protocol):
    """A recogniser that also takes recordings of any length."""

    def stretches(self, samples: NDArray[np.float32], vocabulary: Sequence[str] = ()) -> Iterator[Stretch]:
        """What is said in a recording, in order. ``samples`` and ``vocabulary`` as for ``transcribe``. Raises
        ``SaysoError``."""
        ...
