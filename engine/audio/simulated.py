"""A microphone for machines without one: somebody in a slightly noisy room says the demo commands, over and over.

The room's noise and the pauses come from a seed, so that every run sounds the same. Time passes as on a real
microphone, by the clock of the running loop.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

import numpy as np

from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Pacer, Samples
from engine.audio.wav import read_wav
from engine.errors import AudioFormatError


class SimulatedMicrophone:
    """Loops over recordings, with noise. Opening raises ``AudioFormatError`` when a recording cannot be read."""

    live = True
    warnings: tuple[str, ...] = ()

    def __init__(
        self,
        speech: Sequence[Path],
        *,
        every_s: float | None = 8.0,
        noise_db: float = -55.0,
        seed: int = 0,
        name: str = "simulated microphone",
    ) -> None:
        """``every_s``: silence between two utterances, s (±25 %); None: only when told by :meth:`speak`.

        ``noise_db``: level of the noise, dB relative to full scale.
        """
        if not speech:
            raise AudioFormatError("The simulated microphone has no recordings to play.")
        self.name = name
        self._paths = tuple(speech)
        self._recordings: tuple[Samples, ...] = ()
        self._every_s = every_s
        self._noise = 32768 * 10 ** (noise_db / 20)
        self._random = np.random.default_rng(seed)
        self._pacer = Pacer()
        self._frames = 0
        self._next = 0  # index of the recording that comes next
        self._rest = np.empty(0, np.int16)  # what is still to be played of the present one
        self._pause = 0  # frames until the next
        self._told = False
        self._open = False

    async def __aenter__(self) -> SimulatedMicrophone:
        self._recordings = await asyncio.to_thread(lambda: tuple(read_wav(path) for path in self._paths))
        self._pause = self._draw_pause()
        self._open = True
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open = False

    def __aiter__(self) -> SimulatedMicrophone:
        return self

    async def __anext__(self) -> Frame:
        await self._pacer.wait()
        if not self._open:
            raise StopAsyncIteration
        self._frames += 1
        return Frame(self._mix(), self._frames * FRAME_S)

    def speak(self) -> Path:
        """Begin the next utterance in the next frame; says which it is. Call it in the loop's thread."""
        self._rest = self._rest[:0]
        self._told = True
        return self._paths[self._next]

    def _mix(self) -> Samples:
        if not len(self._rest):
            due = self._every_s is not None and self._pause <= 0
            if self._told or due:
                self._rest = self._recordings[self._next]
                self._next = (self._next + 1) % len(self._recordings)
                self._pause = self._draw_pause()
                self._told = False
            else:
                self._pause -= 1
        noise = self._random.normal(0.0, self._noise, FRAME_SAMPLES)
        voice, self._rest = self._rest[:FRAME_SAMPLES], self._rest[FRAME_SAMPLES:]
        noise[: len(voice)] += voice
        mixed: Samples = np.clip(np.rint(noise), -32768, 32767).astype(np.int16)
        return mixed

    def _draw_pause(self) -> int:
        """Frames of silence before the next utterance."""
        if self._every_s is None:
            return 0
        return round(self._every_s * self._random.uniform(0.75, 1.25) * RATE / FRAME_SAMPLES)
