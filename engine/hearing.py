"""Hearing: from sound to a transcript. Joins a source, voice activity, endpointing and a recogniser.

A live source is read all the time, so that the moment before the wake is not lost and the level meter lives; other
sources are read only while somebody listens, and go on where they stopped. One worker thread waits for the recogniser
(an engine's decodes in a process of its own): loading and decoding queue up there, and a decoding that nobody waits for
any more ends as ``transcript.rejected`` with the reason ``late``, in the turn and epoch that it belonged to.

    async with Hearing(...) as hearing:
        heard = await hearing.listen(emit)
        if isinstance(heard, Utterance):
            transcript = await hearing.transcribe(heard, emit)
"""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Literal

import numpy as np

from config.schema import Endpoint
from engine import events
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.audio.endpoint import Ended, Endpointer, Utterance
from engine.audio.level import SILENT, Meter, loudness
from engine.audio.ring import Ring
from engine.audio.source import FRAME_S, Frame, Source
from engine.audio.vad import VoiceActivity
from engine.bus import Emit
from engine.errors import SaysoError
from engine.overhearing import Alert, Overhearing


@dataclass(frozen=True, slots=True)
class NothingHeard:
    """Listening ended without an utterance."""

    reason: Literal["no_speech", "source_ended"]
    message: str  # a sentence for people


class Hearing:
    """The robot's ears. One listener and one transcription at a time; everything but :meth:`mark` and :attr:`level`
    belongs to the loop's thread.

    ``open_source`` makes the source; it is called again when a live one was lost and somebody listens. ``vocabulary``:
    nouns and names to expect. ``gain_db`` is applied before anything else. ``on_lost`` is called, in the loop's
    thread, at the moment a live source is lost. ``alert`` is told of a stop that is overheard (see :meth:`overhear`).
    Leaving closes the source and the recogniser, whatever it is doing.
    """

    def __init__(
        self,
        open_source: Callable[[], Source],
        vad: VoiceActivity,
        endpoint: Endpoint,
        recogniser: Recogniser,
        *,
        vocabulary: Sequence[str] = (),
        gain_db: float = 0.0,
        on_lost: Callable[[SaysoError], None] | None = None,
        alert: Alert | None = None,
    ) -> None:
        self.level = SILENT
        """Newest loudness, for idle display; a frozen value that is replaced, so any thread may read it."""
        self.vad_name = vad.name
        self._open_source = open_source
        self._vad = vad
        self._endpoint = endpoint
        self._recogniser = recogniser
        self._vocabulary = tuple(vocabulary)
        self._gain = 10 ** (gain_db / 20)
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="recogniser")
        self._open = AsyncExitStack()
        self._source: Source | None = None
        self._pump: asyncio.Task[None] | None = None
        self._ring = Ring(math.ceil(endpoint.pre_roll_s / FRAME_S))
        self._on_lost = on_lost
        self._overhearing = Overhearing(alert, recogniser, self._worker)
        self._pending: set[asyncio.Future[Transcript | Rejected | SaysoError]] = set()
        self._closed = False

    async def __aenter__(self) -> Hearing:
        """Open the source. Raises ``DeviceError`` or ``AudioFormatError``."""
        await self._reopen()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closed = True
        self._overhearing.drop()
        for work in tuple(self._pending):
            work.cancel()  # or its end would be reported to a loop that may be closed by then
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._recogniser.close()  # the worker's thread comes back by that
        await self._close_source()

    @property
    def recogniser_name(self) -> str:
        """The recogniser, for people."""
        return self._recogniser.name

    @property
    def source_name(self) -> str:
        """The source, for people."""
        return self._source.name if self._source is not None else "no sound source"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the source tolerated."""
        return self._source.warnings if self._source is not None else ()

    async def load(self) -> None:
        """Load the recogniser in its thread. Raises ``ModelError``; :meth:`transcribe` would raise the same."""
        await asyncio.get_running_loop().run_in_executor(self._worker, self._recogniser.load)

    def mark(self) -> None:
        """The wake is now: the next :meth:`listen` of a live source begins here, less the pre-roll, however long it
        takes until it is called (up to 10 s). Thread-safe, returns at once."""
        self._ring.mark()

    def overhear(self, on: bool) -> None:
        """From now on, or not any more, a stop that a live source hears is told to the ``alert``, in the recogniser's
        thread and without anybody listening. All else that is overheard is forgotten."""
        self._overhearing.switch(on)

    async def listen(self, emit: Emit, *, restarted: bool = False) -> Utterance | NothingHeard:
        """Hear one utterance, publishing ``listen.started``, ``listen.level`` and ``listen.ended``.

        ``listen.ended`` comes exactly once, also when this is cancelled or the device is lost (raises
        ``DeviceError``).
        """
        self._overhearing.drop()  # the recogniser is for who is listened to
        source = self._source
        if source is None or self._ring.error is not None:  # lost: perhaps it is plugged in again
            source = await self._reopen()
        self._ring.listen()
        emit(events.ListenStarted(source.name, restarted))
        ended = events.ListenEnded("cancelled", 0.0, 0.0)
        try:
            end = await self._find_utterance(source, emit)
            heard = end.utterance
            ended = events.ListenEnded(
                end.reason, heard.duration if heard is not None else 0.0, heard.speech_s if heard is not None else 0.0
            )
        except SaysoError:
            ended = events.ListenEnded("device_lost", 0.0, 0.0)
            raise
        finally:
            self._ring.release()
            emit(ended)
        if heard is not None:
            return heard
        if end.reason == "source_ended":
            return NothingHeard("source_ended", f"The sound of {source.name} ended and nobody spoke.")
        return NothingHeard("no_speech", f"Nobody spoke for {self._endpoint.no_speech_s:g} s.")

    async def transcribe(self, utterance: Utterance, emit: Emit) -> events.TranscriptFinal | events.TranscriptRejected:
        """Recognise an utterance; the result is published and returned. Raises ``ModelError``.

        Cancelling returns at once. The worker stops at the next stretch of work, and what it found by then is
        published as ``transcript.rejected`` with the reason ``late``.
        """
        self._overhearing.drop()
        samples = utterance.samples * np.float32(1 / 32768)
        job = _Job(
            lambda cancelled: self._recogniser.transcribe(samples, self._vocabulary, cancelled),
            lambda late: self._report_late(late, emit),
        )
        work = asyncio.get_running_loop().run_in_executor(self._worker, job.run)
        self._pending.add(work)
        work.add_done_callback(self._pending.discard)
        try:
            found = await asyncio.shield(work)  # the work goes on; only the wait for it can be cancelled
        except asyncio.CancelledError:
            job.cancel()
            raise
        if isinstance(found, SaysoError):
            raise found
        result = _as_event(found)
        emit(result)
        return result

    async def _find_utterance(self, source: Source, emit: Emit) -> Ended:
        """Feed frames to the endpointer until it has an end. Raises what the source raises."""
        self._vad.reset()
        endpointer = Endpointer(self._endpoint)
        meter = Meter()
        while (frame := await self._next_frame(source)) is not None:
            vad = self._vad.process(frame)
            found = endpointer.push(frame, vad)
            if (level := meter.add(frame, vad, in_speech=endpointer.in_speech)) is not None:
                emit(level)
            if isinstance(found, Ended):
                return found
        return endpointer.finish()

    async def _next_frame(self, source: Source) -> Frame | None:
        """The next frame, or None at the end: of the source, or of patience with a live one that delivers nothing."""
        if source.live:
            try:
                async with asyncio.timeout(self._endpoint.no_speech_s):
                    return await self._ring.get()
            except TimeoutError:
                return None
        frame = await anext(source, None)
        return self._taken(frame) if frame is not None else None

    def _taken(self, frame: Frame) -> Frame:
        """Every frame passes here once: gain and level."""
        if self._gain != 1.0:
            louder = np.clip(frame.samples * self._gain, -32768, 32767).astype(np.int16)
            frame = Frame(louder, frame.end)
        self.level = loudness([frame])
        return frame

    async def _reopen(self) -> Source:
        await self._close_source()
        source = self._open_source()
        await self._open.enter_async_context(source)
        self._source = source
        if source.live:
            self._ring.restart()
            self._pump = asyncio.create_task(self._keep_reading(source), name="hearing")
        return source

    async def _close_source(self) -> None:
        pump, self._pump, self._source = self._pump, None, None
        outcome: object = None
        if pump is not None:
            pump.cancel()
            (outcome,) = await asyncio.gather(pump, return_exceptions=True)
        await self._open.aclose()
        if isinstance(outcome, Exception):  # a fault of ours, not of the device: those went to the listener
            raise outcome

    async def _keep_reading(self, source: Source) -> None:
        """The task that reads a live source until it ends or is lost."""
        error: SaysoError | None = None
        try:
            async for frame in source:
                taken = self._taken(frame)
                self._ring.put(taken)
                self._overhearing.push(taken)
        except SaysoError as lost:
            error = lost
            if self._on_lost is not None:
                self._on_lost(lost)
        finally:
            self.level = SILENT
            self._ring.end(error)

    def _report_late(self, found: Transcript | Rejected | SaysoError, emit: Emit) -> None:
        """A transcription came to its end after it was cancelled; called in any thread."""
        if self._closed:
            return
        if isinstance(found, SaysoError):
            emit(events.TranscriptRejected("late", f"The transcription was cancelled and failed: {found}"))
        else:
            emit(events.TranscriptRejected("late", "The transcription was cancelled before it ended.", found.text))


class _Job:
    """One transcription in the worker thread. Its result is either used or late: never both, never neither."""

    def __init__(
        self,
        work: Callable[[Callable[[], bool]], Transcript | Rejected],
        late: Callable[[Transcript | Rejected | SaysoError], None],
    ) -> None:
        self._work = work
        self._late = late
        self._lock = threading.Lock()
        self._cancelled = False
        self._found: Transcript | Rejected | SaysoError | None = None

    def run(self) -> Transcript | Rejected | SaysoError:
        """In the worker thread. An error is a result too: raised, nobody might be there to see it."""
        found: Transcript | Rejected | SaysoError
        if self._cancelled:
            found = Rejected("empty", "It was cancelled before it began.")
        else:
            try:
                found = self._work(lambda: self._cancelled)
            except SaysoError as error:
                found = error
        with self._lock:
            self._found = found
            late = self._cancelled
        if late:
            self._late(found)
        return found

    def cancel(self) -> None:
        """In the loop's thread: nobody waits for the result any more."""
        with self._lock:
            self._cancelled = True
            found = self._found
        if found is not None:
            self._late(found)


def _as_event(found: Transcript | Rejected) -> events.TranscriptFinal | events.TranscriptRejected:
    if isinstance(found, Rejected):
        return events.TranscriptRejected(found.reason, found.detail, found.text)
    decoding = found.decoding
    return events.TranscriptFinal(
        text=found.text,
        source="speech",
        language=decoding.language,
        confidence=found.confidence,
        avg_logprob=decoding.avg_logprob,
        no_speech_probability=decoding.no_speech_probability,
        audio_s=decoding.audio_s,
        decode_s=decoding.decode_s,
    )
