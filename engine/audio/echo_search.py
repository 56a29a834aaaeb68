"""Where the echo of what is played is, and how two clocks drift apart: by correlation."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np

from engine.audio.echo_path import BINS, BLOCK, Sound, Spectrum
from engine.audio.source import FRAME_SAMPLES


class Search:
    """How late the echo is, by the correlation of what is played and heard in the last second, both whitened."""

    WINDOW: Final = 1 << 14
    """Samples: 1.02 s."""
    EVERY: Final = 8
    """Frames between two looks."""
    CLEAR: Final = 12.0
    """How far the correlation at the delay must stand out, in standard deviations."""
    ALIKE: Final = 16
    """What was found twice, so many samples apart at most, is there."""
    LASTS: Final = 16
    """Looks (4 s of sound) for which what was found counts."""
    APART: Final = WINDOW // FRAME_SAMPLES // EVERY
    """Looks between two windows that have nothing in common."""
    EARLIEST: Final = -640
    LONGEST: Final = 10_000
    """Between these samples it is looked for: -40 ms to 0.62 s."""
    QUIET: Final = 1e-7
    """No echo is looked for of what is no louder than that, of ±1, squared."""
    FADE: Final = 1024

    def __init__(self) -> None:
        self._past: deque[Sound] = deque(maxlen=self.WINDOW // FRAME_SAMPLES)
        self._own: deque[Sound] = deque(maxlen=self.WINDOW // FRAME_SAMPLES)
        self._places: deque[int | None] = deque(maxlen=self.LASTS)  # that were found, look by look
        self.evident = False
        """An echo was found in one place in two windows of the last seconds that have nothing in common: two voices may
        sound alike for a moment, and then there is none."""
        self.begin()

    def begin(self) -> None:
        """What comes next does not follow what came before."""
        self._past.clear()
        self._own.clear()
        self._wait = self.EVERY
        self._found: int | None = None

    def push(self, heard: Sound, played: Sound) -> int | None:
        """Take the next sound; samples from what is played to its echo, when that is clear."""
        self._past.append(heard)
        self._own.append(played)
        self._wait -= 1
        if self._wait > 0:
            return None
        self._wait = self.EVERY
        mine = np.concatenate(self._own)
        if np.mean(mine**2) < self.QUIET:
            return None
        size, fade = 2 * self.WINDOW, np.ones(len(mine), np.float32)
        fade[: self.FADE] = np.linspace(0, 1, self.FADE)  # both are cut at the same moment, and that is no echo
        fade[-self.FADE :] = fade[: self.FADE][::-1]
        cross = np.fft.rfft(np.concatenate(self._past) * fade, size) * np.conj(np.fft.rfft(mine * fade, size))
        cross[: size // 80] = 0  # below 200 Hz a room hums
        found = np.fft.irfft(cross / (np.abs(cross) + 1e-12), size)
        delays = np.concatenate((found[self.EARLIEST :], found[: self.LONGEST]))
        peak = int(np.argmax(np.abs(delays)))
        before, self._found = self._found, None
        if abs(delays[peak]) >= self.CLEAR * delays.std():
            self._found = peak + self.EARLIEST
        self._places.append(self._found)
        self.evident = self._lasts()
        if before is None or self._found is None or abs(self._found - before) >= self.ALIKE:
            return None
        return self._found

    def _lasts(self) -> bool:
        found = [(look, place) for look, place in enumerate(self._places) if place is not None]
        return any(
            late - early >= self.APART and abs(here - there) < self.ALIKE
            for early, there in found
            for late, here in found
        )


def shift_between(before: Spectrum, after: Spectrum) -> float:
    """How many samples later the echo comes by the second of two paths (BINS or more, least squares over phases)."""
    cross = np.sum(after * np.conj(before), axis=0)
    weight = np.abs(cross)
    bins = np.arange(BINS)
    total = float(np.sum(weight * bins**2))
    if total <= 0:
        return 0.0
    return -float(np.sum(weight * bins * np.angle(cross)) / total) * 2 * BLOCK / (2 * np.pi)
