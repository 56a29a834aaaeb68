"""Spotting phrases by trained heads: one embedding for all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from engine.wake.embedding import RATE, SPAN, STEP, Embedding, Stacks, Stream
from engine.wake.head import Head
from engine.wake.words import NO_DOUBTS, Detections, Doubts, Spotted


class TrainedSpotter:
    """Hears the phrases of its heads."""

    _rows: list[Stacks]  # the newest

    def __init__(
        self,
        embedding: Embedding,
        heads: Sequence[Head],
        threshold: float | None = None,
        doubts: Mapping[str, Doubts] | None = None,
    ) -> None:
        """``threshold`` is in the place of that of each head; ``doubts``: of which phrases it need not be sure."""
        self._heads = tuple(heads)
        self._thresholds = [head.threshold if threshold is None else threshold for head in heads]
        self._doubts = dict(doubts or {})
        self._most = max((head.steps for head in heads), default=1)
        self._stream = Stream(embedding)
        self.reset()

    @property
    def phrases(self) -> tuple[str, ...]:
        return tuple(head.phrase for head in self._heads)

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        found = []
        for stack in self._stream.push(samples):
            at = SPAN + self._steps * STEP
            self._steps += 1
            self._rows = [*self._rows, stack][-self._most :]
            for head, detections in zip(self._heads, self._detections, strict=True):
                probability = float(head.probabilities(np.concatenate(self._rows[-head.steps :]))[-1])
                if (spotted := detections.take(at, probability)) is not None:
                    found.append(spotted)
        return found

    def reset(self) -> None:
        self._stream.reset()
        self._steps = 0
        self._rows = []
        self._detections = [
            Detections(
                head.phrase, threshold, max(0, round(head.delay_s * RATE)), self._doubts.get(head.phrase, NO_DOUBTS)
            )
            for head, threshold in zip(self._heads, self._thresholds, strict=True)
        ]
