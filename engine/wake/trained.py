"""Spotting phrases by trained heads: one embedding for all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.wake.embedding import RATE, SPAN, STEP, Embedding, Stacks, Stream
from engine.wake.head import Head
from engine.wake.words import Detections, Spotted

NO_DOUBTS: Final[Mapping[str, float]] = {}


class TrainedSpotter:
    """Hears the phrases of its heads."""

    _rows: list[Stacks]  # the newest

    def __init__(
        self,
        embedding: Embedding,
        heads: Sequence[Head],
        threshold: float | None = None,
        doubts: Mapping[str, float] = NO_DOUBTS,
    ) -> None:
        """``threshold`` is in the place of that of each head. A phrase for which ``doubts`` has a lower one is spotted
        from there on, and then it is not sure."""
        self._heads = tuple(heads)
        self._thresholds = [head.threshold if threshold is None else threshold for head in heads]
        self._doubts = [doubts.get(head.phrase, 1.0) for head in heads]
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
            for index, head in enumerate(self._heads):
                probability = float(head.probabilities(np.concatenate(self._rows[-head.steps :]))[-1])
                sure = probability >= self._thresholds[index]
                if (sure or probability >= self._doubts[index]) and self._detections[index].lets(at, sure=sure):
                    found.append(Spotted(head.phrase, at, at - max(0, round(head.delay_s * RATE)), sure))
        return found

    def reset(self) -> None:
        self._stream.reset()
        self._steps = 0
        self._rows = []
        self._detections = [Detections() for _ in self._heads]
