"""The wake words that microWakeWord knows (https://github.com/kahrendt/microWakeWord, Apache-2.0): networks that were
made for microcontrollers, and cost a five-hundredth of a processor here.
"""

from __future__ import annotations

import importlib.util
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import ModelError
from engine.wake.words import NO_DOUBTS, RATE, Detections, Doubts, Spotted

PHRASES: Final = {"hey jarvis": "HEY_JARVIS", "okay nabu": "OKAY_NABU", "alexa": "ALEXA", "hey mycroft": "HEY_MYCROFT"}
"""What it knows, and what the library calls that."""

DELAY: Final = round(0.14 * RATE)
"""How long before it is sure the phrase has ended, samples: the median over voices."""
SOONER: Final = {"hey jarvis": 3}
"""Of how many steps the mean has to be above the threshold, where that is fewer than its makers' five: with each one
less the phrase is known a step sooner. With five and with three alike, "hey jarvis" came above 0.8 once in
2.6 h of announcements, music and talk, and as many voices were heard."""
CUTOFF: Final = {"hey jarvis": 0.8}
"""The mean from which it counts, where that is less than its makers' 0.97: with that, 69 % of "hey jarvis" in front of
a request were heard in 28 English voices, and now 84 % (of 26 with an accent 38 and 62 %), for one false alarm in
2.6 h."""
STEP: Final = round(0.03 * RATE)
"""Samples between two answers of a network."""
CHUNK: Final = RATE // 100

INSTALL: Final = "pip install 'sayso[wake]' (Linux with glibc 2.35 or newer, macOS)"


def is_installed() -> bool:
    return importlib.util.find_spec("pymicro_wakeword") is not None


class MicroSpotter:
    """Hears one of :data:`PHRASES`."""

    _waiting: NDArray[np.int16]  # less than a chunk
    _heard: int  # samples
    _detections: Detections
    _delay: int  # samples, see DELAY

    def __init__(self, phrase: str, threshold: float | None = None, doubts: Doubts = NO_DOUBTS) -> None:
        """Load it; ``threshold``: another than the usual one. Raises ``ModelError``."""
        try:
            import pymicro_wakeword as library

            word: Any = library.MicroWakeWord.from_builtin(library.Model[PHRASES[phrase]])
            steps = SOONER.get(phrase, word.sliding_window_size)
            self._word: Any = library.MicroWakeWord(  # how many steps it goes by is settled when it is made
                word.id,
                wake_word=word.wake_word,
                tflite_model=word.tflite_model,
                probability_cutoff=CUTOFF.get(phrase, word.probability_cutoff) if threshold is None else threshold,
                sliding_window_size=steps,
                trained_languages=word.trained_languages,
                libtensorflowlite_c_path=word.libtensorflowlite_c_path,
            )
            self._library = library
        except (ImportError, OSError, ValueError, AttributeError, TypeError) as error:  # or it is another version
            raise ModelError(f"“{phrase}” cannot be listened for: {error}.", hint=INSTALL) from error
        self._cutoff = self._word.probability_cutoff
        self._doubts = doubts
        self._delay = DELAY - (word.sliding_window_size - steps) * STEP
        self.phrases = (phrase,)
        self._begin()

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        found = []
        self._waiting = np.concatenate((self._waiting, samples))
        while len(self._waiting) >= CHUNK:
            chunk, self._waiting = self._waiting[:CHUNK], self._waiting[CHUNK:]
            self._heard += CHUNK
            for features in self._features.process_streaming(chunk.tobytes()):
                mean = self._word.process_streaming_prob(features) or 0.0
                if (spotted := self._detections.take(self._heard, mean)) is not None:
                    found.append(spotted)
        return found

    def reset(self) -> None:
        self._word.reset()
        self._begin()

    def _begin(self) -> None:
        self._features = self._library.MicroWakeWordFeatures()
        self._waiting = np.zeros(0, np.int16)
        self._heard = 0
        self._detections = Detections(self.phrases[0], self._cutoff, self._delay, self._doubts)
