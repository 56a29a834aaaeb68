"""The one thread in which a recogniser works, and what becomes of its work when whoever waited for it no longer does.

Loading and decoding queue up in that thread (an engine's recogniser decodes in a process of its own, and the thread
waits for it). A transcription that nobody waits for any more ends as ``transcript.rejected`` with the reason ``late``,
in the turn and epoch that it belonged to.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Sequence

import numpy as np

from engine import events
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.asr.transcription import Found, Transcription
from engine.audio.endpoint import Utterance
from engine.audio.source import Samples
from engine.bus import Emit
from engine.errors import ModelError, SaysoError
from engine.hearing.ahead import Decoding
from engine.hearing.near_sounding import heard_as_command
from engine.hearing.readings import Judge, sensible
from engine.lead import Lead
from engine.scheduling import workers

SAID = -18.0
"""Likelihood from which a phrase was said that is suspected. In 2.2 h of announcements and music nothing that a spotter
took for one came above -22; all but a few of what natural voices said do, down to 5 dB, and so do "hey travis" and
"hey siso"."""
LIKELY_SAID = -23.5
"""Likelihood from which a phrase was said that is likely anyhow: the two in the same recordings that were none came to
-25 and -29."""
LESS_FITS = 3.0
"""By so much a phrase may be less likely than what is left of it without its first words: it is longer, and each word
that noise covers costs. Of 50 times that "jarvis" alone was taken for "hey jarvis", in 30 synthetic voices down to
5 dB, it was likelier by 4.5 and more; in 3 of 261 was "hey jarvis" less likely than that by more than 3."""


class Transcriber:
    """Belongs to the loop's thread, but for :meth:`recognise`. ``vocabulary``: nouns and names to expect. ``judge`` is
    asked, in the recogniser's thread, which of several readings can be meant. ``prompt``: those that stop the robot may
    have to wait for that thread (``engine.scheduling.prefer``)."""

    def __init__(self, recogniser: Recogniser, vocabulary: Sequence[str], judge: Judge, *, prompt: bool) -> None:
        self.thread = workers("recogniser", 1, prompt=prompt)
        self._recogniser = recogniser
        self._vocabulary = tuple(vocabulary)
        self._judge = judge
        self._pending: set[asyncio.Future[Found]] = set()
        self._loaded = self._closed = False

    async def load(self) -> None:
        """Load the recogniser. Raises ``ModelError``; :meth:`transcribe` would raise the same."""
        await asyncio.get_running_loop().run_in_executor(self.thread, self._recogniser.load)
        self._loaded = True

    def close(self) -> None:
        """End what runs, and publish nothing of it."""
        self._closed = True
        for work in tuple(self._pending):
            work.cancel()  # or its end would be reported to a loop that may be closed by then
        self.thread.shutdown(wait=False, cancel_futures=True)
        self._recogniser.close()  # the thread comes back by that

    def recognise(
        self, samples: Samples, cancelled: Callable[[], bool], quick: bool = False, lead: Lead | None = None
    ) -> Transcript | Rejected:
        """In the recogniser's thread. What only a quick look was taken at is left as it was found."""
        sound = samples * np.float32(1 / 32768)
        found = self._recogniser.transcribe(sound, self._vocabulary, cancelled, quick=quick, lead=lead)
        if quick or cancelled():
            return found
        return heard_as_command(sensible(found, self._judge), self._judge, self._vocabulary)

    def ask(
        self,
        phrase: str,
        sound: Samples,
        answer: Callable[[bool | None], None],
        *,
        likely: bool,
        dropped: Callable[[], bool] = lambda: False,
    ) -> None:
        """Have ``answer`` told whether ``sound`` ends with ``phrase``, in the recogniser's thread; at once, with None,
        if nobody can tell: the recogniser is not there (yet), or somebody waits for it. ``likely``: so it seems
        anyhow. ``dropped``: nobody needs to know any more. Thread-safe."""
        if not self._loaded or self._pending:
            answer(None)
            return

        def look() -> None:
            said = None
            with contextlib.suppress(SaysoError):  # whoever wants to be understood next is told the same
                said = None if dropped() else ends_with(self._recogniser, phrase, sound, likely=likely)
            answer(said)

        with contextlib.suppress(RuntimeError):  # it has been closed
            self.thread.submit(look)

    def start(self, transcription: Transcription) -> asyncio.Future[Found]:
        """Have it run in the recogniser's thread, after what waits there."""
        if self._closed:  # while somebody still listened
            closed: asyncio.Future[Found] = asyncio.get_running_loop().create_future()
            closed.set_result(ModelError("The recogniser has been closed."))
            return closed
        work = asyncio.get_running_loop().run_in_executor(self.thread, transcription.run)
        self._pending.add(work)
        work.add_done_callback(self._pending.discard)
        return work

    async def transcribe(self, utterance: Utterance, emit: Emit, begun: Decoding | None) -> Transcript | Rejected:
        """Recognise an utterance, or wait for whoever has ``begun`` with it. Raises ``ModelError``.

        Cancelling returns at once. The recogniser stops at the next stretch of work, and what it found by then is
        published as late.
        """
        if begun is not None and begun.future is not None:
            found = await self._awaited(begun.transcription, begun.future, emit)
            if not begun.is_doubtful:
                return _used(found)
        samples, lead = utterance.samples, utterance.lead
        transcription = Transcription(lambda cancelled: self.recognise(samples, cancelled, lead=lead))
        return _used(await self._awaited(transcription, self.start(transcription), emit))

    async def _awaited(self, transcription: Transcription, work: asyncio.Future[Found], emit: Emit) -> Found:
        try:
            return await asyncio.shield(work)  # the work goes on; only the wait for it can be cancelled
        except asyncio.CancelledError:
            transcription.cancel(lambda late: self._report_late(late, emit))
            raise

    def _report_late(self, found: Found, emit: Emit) -> None:
        """A transcription came to its end after it was cancelled; called in any thread."""
        if self._closed:
            return
        if isinstance(found, SaysoError):
            emit(events.TranscriptRejected("late", f"The transcription was cancelled and failed: {found}"))
        else:
            emit(events.TranscriptRejected("late", "The transcription was cancelled before it ended.", found.text))


def as_event(found: Transcript | Rejected) -> events.TranscriptFinal | events.TranscriptRejected:
    """How a result is published."""
    if isinstance(found, Rejected):
        return events.TranscriptRejected(found.reason, found.detail, found.text)
    return as_final(found)


def as_final(found: Transcript) -> events.TranscriptFinal:
    """The same of what was understood."""
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


def _used(found: Found) -> Transcript | Rejected:
    if isinstance(found, SaysoError):
        raise found
    return found


def ends_with(recogniser: Recogniser, phrase: str, sound: Samples, *, likely: bool) -> bool | None:
    """Whether a recogniser thinks that this was said, which is ``likely`` anyhow or not; None: it cannot tell. The
    phrase is also compared with what is left of it without its first words: where a speaker says "jarvis" alone, "hey
    jarvis" is likely as well. Raises ``SaysoError``."""
    heard = sound * np.float32(1 / 32768)
    likelihood = recogniser.likelihood(heard, _written(phrase))
    if likelihood is None or likelihood < (LIKELY_SAID if likely else SAID):
        return None if likelihood is None else False
    ends = [_written(end) for end in _ends_of(phrase)]
    less = recogniser.likelihood(heard, [way for ways in ends for way in ways]) if ends else None
    return less is None or likelihood >= less - LESS_FITS


def _ends_of(phrase: str) -> list[str]:
    """What is left of a phrase without its first word, its first two words, and so on."""
    words = phrase.split()
    return [" ".join(words[start:]) for start in range(1, len(words))]


def _written(phrase: str) -> Sequence[str]:
    """The ways in which a recogniser writes it."""
    words = phrase.title().split()
    return tuple(dict.fromkeys((phrase, phrase.capitalize(), " ".join(words), ", ".join(words))))
