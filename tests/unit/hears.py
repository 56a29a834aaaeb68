"""Ears that a test listens with: what they hear is pushed, and what they publish is kept."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Literal

import numpy as np

from config.schema import Endpoint, Suppression, Vad
from engine import events
from engine.asr.recogniser import Rejected, Transcript
from engine.audio.endpoint import Utterance
from engine.audio.pipe import PushSource
from engine.audio.source import FRAME_SAMPLES, RATE, Samples, Source
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import ModelError, SaysoError
from engine.hearing.hearing import Hearing
from tests import recogniser

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
ENDPOINT = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=2
)
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")


def quiet(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 5, round(seconds * RATE)).astype(np.int16)


class Scripted(recogniser.Scripted):
    """A recogniser that answers when the test lets it: what a test of timing cannot have from a real one."""

    def __init__(self, answer: Transcript | Rejected | SaysoError | None = None) -> None:
        super().__init__(answer or "Go to the kitchen.")

    def load(self) -> None:
        if isinstance(self.answers[0], ModelError):
            raise self.answers[0]


class Ears:
    """A Hearing and what it published."""

    def __init__(self, hearing: Hearing, recogniser: Scripted) -> None:
        self.hearing = hearing
        self.recogniser = recogniser
        self.published: list[events.Event] = []
        bus = Bus(SystemClock())
        bus.subscribe(self.published.append)
        self.emit = bus.bound(turn=None, epoch=7)

    @property
    def kinds(self) -> list[str]:
        """Of all events but those that come again and again while somebody speaks."""
        again = ("listen.level", "transcript.partial")
        return [event.kind for event in self.published if event.kind not in again]

    def last(self) -> events.Body:
        return self.published[-1].body

    async def recogniser_is_idle(self) -> None:
        """Wait until the recogniser's thread has done what waits there."""
        await asyncio.get_running_loop().run_in_executor(self.hearing._transcriber.thread, lambda: None)


@asynccontextmanager
async def ears(
    open_source: Callable[[], Source],
    recogniser: Scripted | None = None,
    *,
    suppression: Suppression = "off",
    gain_db: float | Literal["auto"] = 0.0,
    on_end: Callable[[SaysoError | None], None] = lambda error: None,
    warn: Callable[[str], None] = lambda words: None,
) -> AsyncIterator[Ears]:
    recogniser = recogniser or Scripted()
    hearing = Hearing(
        open_source,
        make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)),
        ENDPOINT,
        recogniser,
        vocabulary=("kitchen",),
        suppression=suppression,
        gain_db=gain_db,
        on_end=on_end,
        warn=warn,
    )
    async with hearing:
        yield Ears(hearing, recogniser)


def pushed(*sounds: Samples, end: bool = False) -> PushSource:
    """A live source that has this to say."""
    source = PushSource()
    source.push(np.concatenate(sounds).tobytes())
    if end:
        source.finish()
    return source


async def all_read() -> None:
    """Let the background reader take what there is, up to 20 s: a frame at every turn of the loop."""
    for _ in range(20 * RATE // FRAME_SAMPLES):
        await asyncio.sleep(0)


def an_utterance() -> Utterance:
    return Utterance(COMMAND, 0.0, len(COMMAND) / RATE, 1.0)
