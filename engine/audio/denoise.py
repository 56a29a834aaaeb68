"""Less noise, for whoever asks for it: the noise suppressor of WebRTC, which takes away what sounds steadily.

Off is the default, and right nearly everywhere: what is taken from the voice along with the noise costs the recogniser
more than the noise did. Beside a fan at 10 dB 14 % of the words are wrong in place of 12; only where it is as loud as
the voice they are 71 % in place of 74 (``sayso bench asr --noise fan --snr 0``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from config.schema import Suppression
from engine.audio.source import RATE, Frame

LEVELS: Final[dict[Suppression, int]] = {"low": 0, "moderate": 1, "high": 2}
"""How WebRTC numbers what takes away 6, 12 or 18 dB."""

BLOCK: Final = RATE // 100
"""Samples that the library takes at a time (10 ms). Of more, it fills the last block up with silence each time."""

LATE: Final = 128
"""Samples (8 ms) by which the sound comes later, so that there are enough for every frame of whole blocks."""

INSTALL: Final = "pip install 'sayso[denoise]'"


def usable(level: Suppression, warn: Callable[[str], None]) -> Suppression:
    """The level, or "off" where the library is not here, which is told."""
    if level == "off":
        return level
    try:
        import pywebrtc_audio  # noqa: F401 (only whether it can be)
    except ImportError as error:
        warn(f"Noise is not suppressed: {error}. To have that: {INSTALL}")
        return "off"
    return level


class NoiseSuppressor:
    """Takes noise out of the frames of one source, one after the other. Belongs to one thread."""

    def __init__(self, level: Suppression) -> None:
        """Of ``level``, which is :func:`usable`."""
        self._level = level
        self.reset()

    def reset(self) -> None:
        """Another source begins, in another noise."""
        self._waiting: NDArray[np.int16] = np.zeros(0, np.int16)  # less than a block
        self._ready: NDArray[np.int16] = np.zeros(LATE, np.int16)
        self._library: Any = None
        if self._level != "off":
            import pywebrtc_audio

            self._library = pywebrtc_audio.AudioProcessor(
                sample_rate=RATE, noise_suppression=True, ns_level=LEVELS[self._level]
            )

    def apply(self, frame: Frame) -> Frame:
        """The frame with less noise, and 14 ms later: what was waited for, and what the library itself takes."""
        if self._library is None:
            return frame
        sound = np.concatenate((self._waiting, frame.samples))
        whole = len(sound) // BLOCK * BLOCK
        self._waiting = sound[whole:]
        ready = self._ready
        if whole:
            ready = np.concatenate((ready, self._library.process(sound[:whole])))
        count = len(frame.samples)
        self._ready = ready[count:]
        return replace(frame, samples=ready[:count])
