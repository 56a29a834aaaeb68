"""How a loudspeaker sounds in a microphone, learnt while it sounds: an adaptive filter that predicts the echo.

A Kalman filter in the frequency domain, in partitions (Enzner and Vary 2006; Kuech, Mabande and Enzner 2014). It weighs
each step by how unsure it is of the room and by how loud everything else is, so that somebody who talks over the
loudspeaker neither spoils what it has learnt nor is touched by it: what it predicts is subtracted, and nothing else is
done to the sound. Suppressors, which go on from there, cost the words that they are to save.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

BLOCK: Final = 256
"""Samples that are predicted at a time: 16 ms."""
PARTITIONS: Final = 16
"""Of a block each: echoes that come up to 0.26 s after what is played can be learnt."""
BINS: Final = BLOCK + 1

_KEEPS: Final = 0.997**2  # of what it knows, a block: rooms change when people walk about
_OTHERS: Final = 1.0  # weight of what the microphone hears besides
_SMOOTHING: Final = 0.5

Sound = NDArray[np.float32]
"""±1."""
Spectrum = NDArray[np.complex64]


class EchoPath:
    """The way from a loudspeaker to a microphone. Belongs to one thread."""

    def __init__(self) -> None:
        self._played = np.zeros((PARTITIONS, BINS), np.complex64)  # spectra of the newest blocks, newest first
        self._path = np.zeros((PARTITIONS, BINS), np.complex64)
        self._doubt = np.ones((PARTITIONS, BINS), np.float32)  # variance of what it knows
        self._before = np.zeros(BLOCK, np.float32)
        self._others = np.zeros(BINS, np.float32)

    @property
    def path(self) -> Spectrum:
        """What it has learnt, (PARTITIONS, BINS)."""
        return self._path

    @property
    def power(self) -> NDArray[np.float32]:
        """Of what was played, (PARTITIONS, BINS), the newest first."""
        return np.asarray(self._played.real**2 + self._played.imag**2)

    def shift(self, samples: int) -> None:
        """What was learnt holds for a reference that comes so many samples later from now on (or earlier: < 0)."""
        whole = np.fft.irfft(self._path, axis=1)[:, :BLOCK].reshape(-1)
        moved = np.zeros_like(whole)
        samples = max(-len(whole), min(len(whole), samples))
        if samples >= 0:
            moved[: len(whole) - samples] = whole[samples:]
        else:
            moved[-samples:] = whole[: len(whole) + samples]
        parts = np.pad(moved.reshape(PARTITIONS, BLOCK), ((0, 0), (0, BLOCK)))
        self._path = np.fft.rfft(parts, axis=1).astype(np.complex64)
        self.begin()

    def begin(self) -> None:
        """What comes next does not follow what was played before."""
        self._played[:] = 0
        self._before = np.zeros(BLOCK, np.float32)

    def doubt(self) -> None:
        """The room may be another one: learn as fast as at the beginning, from what is known."""
        self._doubt[:] = 1.0

    def predict(self, played: Sound) -> Sound:
        """The echo in the microphone while the next block, shape (BLOCK,), is played."""
        self._played = np.roll(self._played, 1, axis=0)
        self._played[0] = np.fft.rfft(np.concatenate((self._before, played)))
        self._before = played
        whole = np.fft.irfft(np.einsum("pk,pk->k", self._played, self._path))
        return whole[BLOCK:].astype(np.float32, copy=False)

    def learn(self, left: Sound) -> None:
        """Take what the microphone heard besides the prediction."""
        error = np.fft.rfft(np.concatenate((np.zeros(BLOCK, np.float32), left)))
        loud = np.asarray(error.real**2 + error.imag**2, np.float32)
        self._others = _SMOOTHING * self._others + (1 - _SMOOTHING) * loud
        power = self.power
        certain = np.sum(power * self._doubt, axis=0) + 2 * _OTHERS * np.maximum(self._others, loud) + 1e-10
        step = self._doubt / certain
        change = np.fft.irfft(step * np.conj(self._played) * error, axis=1)
        change[:, BLOCK:] = 0  # a filter of a block each, not a circle of two
        self._path += np.fft.rfft(change, axis=1)
        self._doubt = _KEEPS * (1 - 0.5 * step * power) * self._doubt + (1 - _KEEPS) * (
            self._path.real**2 + self._path.imag**2
        )
