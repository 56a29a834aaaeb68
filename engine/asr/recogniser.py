"""From sound to words: the protocol that every recogniser speaks, and its two answers.

A recogniser either understood something (:class:`Transcript`) or turned the sound down, and then says why
(:class:`Rejected`): sound that is no command must not become one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.errors import ModelError
from engine.lead import Lead

RejectReason = Literal["no_speech", "low_confidence", "too_short", "empty", "artefact"]


@dataclass(frozen=True, slots=True)
class Decoding:
    """How sure the recogniser was, and what it cost."""

    language: str  # ISO 639-1
    avg_logprob: float  # mean log-probability of the tokens
    no_speech_probability: float  # 0…1
    audio_s: float  # length of the sound, s
    decode_s: float  # time it took, s
    window_s: float  # length of the encoder window that was used last, s
    doubtful: bool = False  # a quick pass was made, and another look may find something else
    only_reading: bool = False  # a quick pass was made; another look tells what else may have been said


@dataclass(frozen=True, slots=True)
class Transcript:
    """What was said, as the recogniser writes it."""

    text: str
    confidence: float  # 0…1, geometric mean of the tokens' probabilities
    decoding: Decoding
    others: tuple[str, ...] = ()  # what may have been said instead, nearly as likely, the likelier first


@dataclass(frozen=True, slots=True)
class Rejected:
    """Not taken for speech; ``text`` is what the recogniser would have written."""

    reason: RejectReason
    detail: str  # a sentence for people
    text: str = ""
    decoding: Decoding | None = None


class RecogniserLost(ModelError):
    """What the recogniser lives in is gone, or as good as gone; asked again, it begins anew."""


class Recogniser(Protocol):
    """Turns utterances into text. Blocking, and for one thread at a time; only ``close`` may come from any."""

    takes_lead: bool
    """It can be told what was said right before a sound; all others may hear the end of that in it."""

    @property
    def name(self) -> str:
        """For people: ``whisper-base (int8, 1 thread)``; once it is loaded, with its language and how long it takes."""
        ...

    def load(self) -> None:
        """Load the model and warm it up; the first call of ``transcribe`` does it otherwise.

        Raises ``ModelError``.
        """
        ...

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        """Recognise one utterance.

        ``samples``: shape (n,), 16 kHz, ±1. ``vocabulary``: nouns and names to be expected; never verbs or phrases,
        which a recogniser would hear in silence. ``cancelled`` is asked between stretches of work; once true, the
        result is whatever there is so far and will not be used. ``quick``: no second look, however doubtful the first.
        ``lead``: what was said right before ``samples``; it is no part of the result.
        Raises ``ModelError``.
        """
        ...

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        """How likely it is that one of ``texts`` was said and nothing else: the largest of their log-probabilities.

        ``samples`` and ``cancelled`` as above; the texts are in one language. For a word that is to be told from all
        others: which of several words that sound alike is written as the text, is decided by little. None: that is
        more than this recogniser can tell, or it was cancelled. Raises ``ModelError``.
        """
        ...

    def close(self) -> None:
        """End what runs for this recogniser elsewhere, at once, also in the middle of a decoding. What is asked of one
        that lived elsewhere raises ``ModelError`` from then on."""
        ...
