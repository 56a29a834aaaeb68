"""What has sounded, at 16 kHz, by the clock: the last seconds of a loudspeaker, whatever its own rate is."""

from __future__ import annotations

import threading
from math import inf
from typing import Any, Final

import numpy as np
import soxr

from engine.audio.source import RATE, Samples, to_int16

KEPT_S: Final = 10.0
"""How much is kept, s."""
_LATE_S: Final = 0.05  # a block that comes so late does not follow the last one; stamps are no better than that
_DRIFT_S: Final = 0.01  # as far as the device's clock may go its own way before it is set right, in silence


class Sounded:
    """Takes blocks with the time at which each begins to sound. Blocks that follow each other are one sound without
    seams, however much their stamps jitter: whoever looks for an echo of it needs every sample in its place.
    Thread-safe."""

    def __init__(self) -> None:
        self.last = -inf
        """When the last sound that was not silence ended, or will end; of the clock, s."""
        self._ring = np.zeros(round(KEPT_S * RATE), np.int16)
        self._end = 0  # samples of the clock: the ring ends there
        self._resampler: Any = None
        self._from = RATE
        self._next = -inf  # s; the next block should begin to sound then
        self._quiet = True
        self._lock = threading.Lock()

    def add(self, block: Samples, rate: int, at: float) -> None:
        """A block at ``rate`` Hz, which begins to sound at ``at``."""
        with self._lock:
            late = abs(at - self._next)
            if late > _LATE_S or (self._quiet and late > _DRIFT_S) or rate != self._from:
                self._move(round(at * RATE))
                self._resampler = soxr.ResampleStream(rate, RATE, 1, dtype="float32") if rate != RATE else None
                self._from, self._next = rate, at
            self._next += len(block) / rate
            self._quiet = not block.any()
            if not self._quiet:
                self.last = self._next
            if self._resampler is not None:
                block = to_int16(self._resampler.resample_chunk(block.astype(np.float32) / np.float32(32768)))
            self._write(block)

    def between(self, begin: float, end: float) -> Samples:
        """What sounded from ``begin`` to ``end``; silence where nothing did, or nothing is known of it."""
        return self.samples(round(begin * RATE), max(0, round((end - begin) * RATE)))

    def samples(self, first: int, count: int) -> Samples:
        """The same by samples of the clock."""
        whole = np.zeros(count, np.int16)
        with self._lock:
            size = len(self._ring)
            begin, end = max(first, self._end - size), min(first + count, self._end)
            if begin < end:
                whole[begin - first : end - first] = np.take(self._ring, np.arange(begin, end) % size)
        return whole

    def _write(self, block: Samples) -> None:
        self._ring[np.arange(self._end, self._end + len(block)) % len(self._ring)] = block
        self._end += len(block)

    def _move(self, to: int) -> None:
        """The next sample is that one: with silence in between, or in the place of what was to sound there."""
        gap, size = to - self._end, len(self._ring)
        if gap >= size or gap <= -size:
            self._ring[:] = 0
        elif gap > 0:
            self._ring[np.arange(self._end, to) % size] = 0
        else:  # those slots are the oldest from now on
            self._ring[np.arange(to, self._end) % size] = 0
        self._end = to
