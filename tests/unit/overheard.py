"""What overhearing is tried with: sounds, and ears that take them frame by frame from nobody but the test."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from config.schema import Vad
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, Samples
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from engine.errors import ModelError
from engine.hearing.overhearing import Alert, Overhearing
from engine.planner.phrases.stopping import is_stop
from tests.recogniser import Scripted

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
STOP = read_wav(SPEECH / "stop.wav")
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")
LONG = read_wav(SPEECH / "go_to_the_bedroom_then_turn_around.wav")
VAD = Vad(backend="auto", gate_mode=3, threshold=0.5)
DECODING = Decoding("en", -0.1, 0.02, 1.0, 0.1, 10)


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


class Listening(Scripted):
    """Ears with a suspicion: whether it was settled, and what the recogniser was asked."""

    def __init__(self, *answers: Transcript | Rejected | ModelError | str, unasked: bool = True) -> None:
        super().__init__(*answers)
        self.likelihoods: Sequence[float] = ()
        """One after the other; the last one again and again. Empty: it cannot tell."""
        self.weighed: list[tuple[str, ...]] = []
        self.on_weighing: Callable[[], None] = lambda: None
        self.settled = self.likelier = 0
        self.told: list[str] = []
        self._worker = ThreadPoolExecutor(1)
        self._frames = 0
        alert = Alert(make_vad(VAD), is_stop, self.told.append, unasked)
        self.overhearing = Overhearing(alert, self, self._worker)
        self.overhearing.switch(True)

    @property
    def expected(self) -> list[tuple[str, ...]]:
        """What each quick pass was told to expect."""
        assert all(given.quick for given in self.passes)
        return [given.vocabulary for given in self.passes]

    async def hear(self, sound: Samples) -> None:
        """Take a piece of sound, and let all of it be recognised that is to be."""
        for at in range(0, len(sound) - FRAME_SAMPLES + 1, FRAME_SAMPLES):
            self._frames += 1
            self.overhearing.push(Frame(sound[at : at + FRAME_SAMPLES], self._frames * FRAME_S))
            await self.rest()

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        self.weighed.append(tuple(texts))
        self.on_weighing()
        count = len(self.likelihoods)
        return self.likelihoods[min(len(self.weighed), count) - 1] if count else None

    def suspect(self, phrase: str = "stop", *, sure: bool = True) -> None:
        def settled() -> None:
            self.settled += 1

        def likelier() -> None:
            self.likelier += 1

        self.overhearing.suspect(phrase, settled, likelier, sure=sure)

    async def rest(self) -> None:
        """Until nothing is being recognised, unless it may not be answered."""
        while self.overhearing.busy and self.may_answer.is_set():
            await asyncio.get_running_loop().run_in_executor(self._worker, lambda: None)
            await asyncio.sleep(0)

    @property
    def hinted(self) -> int:
        """How often the recogniser was told what to expect."""
        return self.expected.count(("stop",))


def suspecting(
    scenario: Callable[[Listening], Awaitable[None]],
    *answers: Transcript | Rejected | ModelError | str,
    unasked: bool = True,
) -> None:
    """Run a scenario in which the recogniser has these answers, the last one for ever."""

    async def main() -> None:
        ears = Listening(*answers, unasked=unasked)
        try:
            await scenario(ears)
        finally:
            ears.may_answer.set()
            ears._worker.shutdown()

    asyncio.run(main())
