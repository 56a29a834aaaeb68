"""How somebody who was woken listens, on a clock of its own: as an engine does it, frame by frame with decoding ahead.

The recogniser's passes take, one after the other, the time that such a pass took at the beginning, the fastest of
several: what else this machine does later changes nothing. Processor time would be too much, since a pass has more than
one thread at times.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from config.schema import Settings
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.asr.transcription import Found, Transcription
from engine.asr.whisper import FULL_WINDOW_S
from engine.audio.endpoint import Ended, Endpointer, Utterance
from engine.audio.source import FRAME_S, RATE, Frame, Samples
from engine.audio.vad import VoiceActivity, make_vad
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import SaysoError
from engine.hearing.afterwards import added_to
from engine.hearing.ahead import DecodingAhead
from engine.hearing.going_on import GOES_ON_S, Addition, GoingOn, joined, may_have_no_end
from engine.hearing.near_sounding import heard_as_command
from engine.hearing.readings import Afterthought, sensible
from engine.hearing.transcriber import as_event
from engine.parts.loading import make_recogniser, vocabulary
from engine.plan import Action, Plan
from engine.planner.build import build_planner, build_registry
from engine.planner.planner import Planner
from engine.planner.request import PlanRequest
from tests.bench.speech import clips


@dataclass(frozen=True, slots=True)
class Price:
    """What passes cost, s: the fastest of several of a command in each window."""

    quick: float
    second: float  # a second look alone, with the full window

    @classmethod
    def of(cls, settings: Settings, tries: int = 5) -> Price:
        """Measure it."""
        command = next(clip.samples for clip in clips() if clip.snr_db is None and 1.5 <= len(clip.samples) / RATE <= 3)
        nouns = vocabulary(settings)
        costs = []
        for window_s in (settings.asr.window_s, FULL_WINDOW_S):
            asr = settings.asr.model_copy(update={"window_s": window_s})
            recogniser = make_recogniser(settings.model_copy(update={"asr": asr}))
            recogniser.load()
            took = []
            for shift in range(tries):  # the same sound would not be encoded again
                sound = np.roll(command, shift * 160) * np.float32(1 / 32768)
                began = time.perf_counter()
                recogniser.transcribe(sound, nouns, quick=True)
                took.append(time.perf_counter() - began)
            costs.append(min(took))
        return cls(*costs)

    def paid(self, found: Found, window_s: float) -> float:
        """What this pass cost; one that was cancelled in time is free."""
        if isinstance(found, SaysoError) or found.decoding is None:
            return 0.0
        return self.quick if found.decoding.window_s == window_s else self.second  # the quick one was paid for


class Clockwork:
    """The recogniser's thread on the recording's clock: what is asked at one time is answered that much later."""

    def __init__(self, cost: Callable[[Found], float]) -> None:
        self._cost = cost
        self.now = 0.0
        self._free = 0.0
        self._waiting: deque[tuple[float, Transcription, asyncio.Future[Found]]] = deque()
        self._running: deque[tuple[float, Found, asyncio.Future[Found]]] = deque()

    def start(self, transcription: Transcription) -> asyncio.Future[Found]:
        future: asyncio.Future[Found] = asyncio.get_running_loop().create_future()
        self._waiting.append((self.now, transcription, future))
        return future

    async def until(self, at: float, enough: Callable[[], bool] = lambda: False) -> bool:
        """Let it be ``at`` s, or the moment of the first answer that is ``enough``, which is told; whatever is
        recognised by then is answered."""
        self.now = at
        while (self._waiting and max(self._free, self._waiting[0][0]) <= at) or self._running:
            if self._running:
                done, found, future = self._running[0]
                if done > at:
                    return False
                self._running.popleft()
                future.set_result(found)
                await asyncio.sleep(0)
                if enough():
                    self.now = done
                    return True
            else:
                asked, transcription, future = self._waiting.popleft()
                found = transcription.run()
                self._free = max(self._free, asked) + self._cost(found)
                self._running.append((self._free, found, future))
        return False

    async def answered(self, future: asyncio.Future[Found]) -> float:
        """When the answer is there, s."""
        while not future.done():
            await self.until(self.now + 0.001)
        return self.now


@dataclass(frozen=True, slots=True)
class Heard:
    """One turn: when it ended, when its transcript was there (stream time, s), and what it was."""

    ended: float
    ready: float
    utterance: Utterance | None = None
    result: Found | None = None

    @property
    def text(self) -> str:
        """The transcript; empty where none was taken."""
        return self.result.text if isinstance(self.result, Transcript) else ""


@dataclass(frozen=True, slots=True)
class Ears:
    """What listens, put together as an engine does it."""

    settings: Settings
    vad: VoiceActivity
    recogniser: Recogniser
    planner: Planner
    nouns: tuple[str, ...]

    @classmethod
    def of(cls, settings: Settings) -> Ears:
        """Load them."""
        recogniser = make_recogniser(settings)
        recogniser.load()
        planner = build_planner(settings, build_registry(settings))
        return cls(settings, make_vad(settings.vad), recogniser, planner, vocabulary(settings))

    async def listen(self, clock: Clockwork, sound: Iterable[Frame], begun: Utterance | None = None) -> Heard:
        """One turn; what was ``begun`` comes before it."""
        patience = {} if begun is None else {"no_speech_s": GOES_ON_S}
        endpointer = Endpointer(self.settings.endpoint.model_copy(update=patience))
        emit = Bus(SystemClock()).bound(turn=None, epoch=0)

        def recognise(samples: Samples, cancelled: Callable[[], bool], quick: bool = False) -> Transcript | Rejected:
            whole = samples if begun is None else np.concatenate((begun.samples, samples))
            return self._recognise(whole, cancelled, quick)

        ahead = DecodingAhead(recognise, clock.start, self.settings.endpoint, self.planner.completeness, emit)
        self.vad.reset()
        for frame in sound:
            await clock.until(frame.end)
            ahead.advise(endpointer)
            found = endpointer.push(frame, self.vad.process(frame))
            if isinstance(found, Ended):
                break
            ahead.follow(endpointer)
            if await clock.until(frame.end + FRAME_S, lambda: ahead.ends(endpointer)):
                found = endpointer.finish()
                break
        else:
            found = endpointer.finish()
        ended, utterance = clock.now, found.utterance
        if begun is not None:
            utterance = begun if utterance is None else joined(begun, utterance)
        if utterance is None:
            return Heard(ended, ended)
        samples = utterance.samples
        whole = ahead.end()
        if whole is not None and whole.future is not None:
            ready = await clock.answered(whole.future)
            if not whole.is_doubtful:
                return Heard(ended, ready, utterance, whole.future.result())
        last = clock.start(Transcription(lambda cancelled: self._recognise(samples, cancelled)))
        return Heard(ended, await clock.answered(last), utterance, last.result())

    async def go_on(self, clock: Clockwork, first: Heard, sound: Iterator[Frame]) -> Heard | None:
        """What is understood when the speaker goes on after a turn was cut; None where that is not waited for."""
        if first.utterance is None or not isinstance(first.result, Transcript | Rejected):
            return None
        after = GoingOn(first.utterance, self.vad)
        unfinished = may_have_no_end(as_event(first.result), self.planner.completeness)
        kept: list[Frame] = []
        for frame in sound:
            kept.append(frame)
            after.push(frame)
            after.awaited = unfinished and frame.end >= first.ready
            if after.is_over:
                return None
            if after.ago_s is not None:
                since = kept[-int(min(1.0, after.ago_s) / FRAME_S) :]
                return await self.listen(clock, chain(since, sound), first.utterance)
        return None

    async def add(self, clock: Clockwork, first: Heard, sound: Iterator[Frame]) -> Afterthought | None:
        """What is added by a speaker who goes on though the request was complete."""
        if first.utterance is None:
            return None
        addition = Addition(first.utterance, self.settings.endpoint)
        for frame in sound:
            addition.push(frame, self.vad.process(frame))
            if addition.is_over:
                break
        if (whole := addition.whole) is None:
            return None
        pending = clock.start(Transcription(lambda cancelled: self._recognise(whole.samples, cancelled)))
        await clock.answered(pending)
        return added_to(first.text, pending.result(), self.planner.afterthought)

    def _recognise(self, samples: Samples, cancelled: Callable[[], bool], quick: bool = False) -> Transcript | Rejected:
        found = self.recogniser.transcribe(samples * np.float32(1 / 32768), self.nouns, cancelled, quick=quick)
        judge = self.planner.completeness
        return found if quick else heard_as_command(sensible(found, judge), judge, self.nouns)


async def planned(planner: Planner, text: str) -> tuple[Action, ...]:
    """What the robot would do without large models; nothing where it would ask or give up."""
    found = await planner.plan(PlanRequest(text, spoken=True))
    return found.actions if isinstance(found, Plan) else ()
