"""A recogniser for tests of timing and of what is made of its answers: it says what the test has written for it, when
the test lets it, and remembers what it was given."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.audio.source import RATE
from engine.errors import SaysoError
from engine.lead import Lead

SURE: Final = Decoding("en", -0.1, 0.02, 1.4, 0.2, 10)
PATIENCE_S: Final = 20
"""How long it waits to be let: a test that never lets it fails then."""


@dataclass(frozen=True, slots=True)
class Given:
    """What a recogniser is given once."""

    samples: NDArray[np.float32]
    vocabulary: tuple[str, ...]
    quick: bool
    thread: str
    lead: Lead | None = None

    @property
    def seconds(self) -> float:
        """The length of the sound, s."""
        return len(self.samples) / RATE


Answer = str | Transcript | Rejected | SaysoError


class Scripted:
    """Gives these answers one after the other, and the last one again and again; a function is asked for what it makes
    of what is given."""

    name = "scripted"
    takes_lead = True

    def __init__(self, *answers: Answer | Callable[[Given], Answer]) -> None:
        self.answers = answers
        self.passes: list[Given] = []
        self.likely: float | None = None
        """What it says of every text…"""
        self.likelier: dict[str, float] = {}
        """…but of these."""
        self.weighed: list[tuple[str, ...]] = []
        self.cancelled: list[bool] = []
        """Of each answer, whether nobody needed it any more when it was given."""
        self.began = threading.Event()
        self.may_answer = threading.Event()
        self.may_answer.set()

    def load(self) -> None: ...

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        answer = self.answers[min(len(self.passes), len(self.answers) - 1)]
        given = Given(samples, tuple(vocabulary), quick, threading.current_thread().name, lead)
        self.passes.append(given)
        self.began.set()
        assert self.may_answer.wait(PATIENCE_S)
        self.cancelled.append(cancelled())
        if callable(answer):
            answer = answer(given)
        if isinstance(answer, SaysoError):
            raise answer
        return Transcript(answer, 0.9, SURE) if isinstance(answer, str) else answer

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        """None, as of those that cannot tell, unless something was chosen."""
        self.weighed.append(tuple(texts))
        return max((self.likelier[text] for text in texts if text in self.likelier), default=self.likely)

    def close(self) -> None: ...
