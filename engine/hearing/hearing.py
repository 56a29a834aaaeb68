"""Hearing: from sound to a transcript. Joins a source, voice activity, endpointing and a recogniser.

What a live source hears (``engine.hearing.intake``) is decoded ahead (``engine.hearing.ahead``), so that the transcript
is ready as soon as the speaker is.

    async with Hearing(...) as hearing:
        heard = await hearing.listen(emit)
        if isinstance(heard, Utterance):
            transcript = await hearing.transcribe(heard, emit)
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Literal, Protocol

import numpy as np

from config.schema import Endpoint, Suppression
from engine import events
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.asr.transcription import Found, Transcription
from engine.audio.echo import EchoCanceller
from engine.audio.endpoint import Ended, Endpointer, Utterance
from engine.audio.gain import Gain
from engine.audio.level import Level, Meter
from engine.audio.source import FRAME_S, Frame, Samples, Source
from engine.audio.vad import VoiceActivity
from engine.bus import Emit
from engine.errors import SaysoError
from engine.hearing.afterwards import Afterwards, More
from engine.hearing.ahead import Decoding, DecodingAhead
from engine.hearing.going_on import GOES_ON_S, joined
from engine.hearing.intake import Intake
from engine.hearing.overhearing import Alert, Overhearing
from engine.hearing.readings import Judge, Notice
from engine.hearing.transcriber import Transcriber, as_event
from engine.lead import Lead

SETTLING_FRAMES = 16
"""How much of a wake word (0.5 s) a detector of voices hears before the request that follows: one that begins in the
middle of a voice misses it in noise, of 300 such requests at 10 and at 5 dB 5 % to the end and 13 % at first."""

LONGEST_PHRASE = 40
"""Characters of what can have been said in the second before a request; whoever sends commands may write more."""


@dataclass(frozen=True, slots=True)
class NothingHeard:
    """Listening ended without an utterance."""

    reason: Literal["no_speech", "source_ended"]
    message: str  # a sentence for people


class Listener(Protocol):
    """Somebody who listens to all that a live source hears; in the loop's thread, which must not be held up."""

    def push(self, samples: Samples) -> None:
        """The next sound: mono, 16 kHz."""
        ...

    def reset(self) -> None:
        """Another source begins."""
        ...


class Hearing:
    """The robot's ears. One listener and one transcription at a time; everything but :meth:`mark` and :attr:`level`
    belongs to the loop's thread.

    ``open_source`` makes the source to begin with; :meth:`hear` puts another in its place. ``vocabulary``: nouns and
    names to expect. ``suppression`` of noise and then ``gain_db`` (a number or "auto") are applied before anything else
    but the taking out of the robot's own voice. ``on_end`` is called, in the loop's thread, when a live source has
    ended or is lost, and ``warn`` of what it tolerates while nobody listens. ``judge`` is asked, in the recogniser's
    thread, whether somebody who pauses has said all, and ``notice`` what was added to a request; ``partials``: words
    are recognised while somebody talks. ``alert`` is told of a stop that is overheard (see :meth:`overhear`).
    ``listener`` gets all that a live source hears. ``echo`` takes the robot's own voice out of what a source hears that
    hears its loudspeaker. ``on_going_on`` is told, in the loop's thread, that somebody goes on whose turn was ended in
    the middle of a sentence, and how long ago (s, up to 1): whoever marks that moment and listens hears both pieces as
    one. ``beside`` hears voices while the robot acts on what was said, for what is added to that; None: nothing is.
    ``prompt``: see ``Transcriber``. Leaving closes the source and the recogniser, whatever it is doing.
    """

    def __init__(
        self,
        open_source: Callable[[], Source],
        vad: VoiceActivity,
        endpoint: Endpoint,
        recogniser: Recogniser,
        *,
        vocabulary: Sequence[str] = (),
        suppression: Suppression = "off",
        gain_db: float | Literal["auto"] = 0.0,
        on_end: Callable[[SaysoError | None], None] = lambda error: None,
        warn: Callable[[str], None] = lambda words: None,
        judge: Judge = lambda text: "unknown",
        notice: Notice = lambda first, whole: None,
        partials: bool = True,
        alert: Alert | None = None,
        listener: Listener | None = None,
        echo: EchoCanceller | None = None,
        on_going_on: Callable[[float], None] | None = None,
        beside: VoiceActivity | None = None,
        prompt: bool = False,
    ) -> None:
        self.vad_name = vad.name
        self._open_source = open_source
        self._vad = vad
        self._endpoint = endpoint
        self._recogniser = recogniser
        self._transcriber = Transcriber(recogniser, vocabulary, judge, prompt=prompt)
        self._intake = Intake(
            endpoint.pre_roll_s,
            self._follow,
            suppression=suppression,
            gain_db=gain_db,
            echo=echo,
            on_end=on_end,
            warn=warn,
        )
        self._ring = self._intake.ring
        self._echo = echo
        self._overhearing = Overhearing(alert, recogniser, self._transcriber.thread)
        self._listener = listener
        self._judge = judge
        self._partials = partials
        self._afterwards = Afterwards(vad, beside, endpoint, self._transcriber, judge, notice, on_going_on)
        self._phrase = ""  # what was said right before the mark
        self._ahead: tuple[Utterance, Decoding] | None = None  # the last utterance, if it is being recognised already

    async def __aenter__(self) -> Hearing:
        """Open the source. Raises ``DeviceError`` or ``AudioFormatError``; :meth:`hear` can still be called then."""
        try:
            await self.hear(self._open_source())
        except SaysoError as error:
            self.lose(error)
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._overhearing.drop()
        self._transcriber.close()
        await self._intake.close()

    @property
    def level(self) -> Level:
        """Newest loudness, for idle display. Any thread."""
        return self._intake.level

    @property
    def recogniser_name(self) -> str:
        """The recogniser, for people."""
        return self._recogniser.name

    @property
    def source_name(self) -> str:
        """The source, for people."""
        return self._intake.source_name

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the source tolerated so far."""
        return self._intake.warnings

    async def hear(self, source: Source, gain: Gain | None = None) -> None:
        """From now on hear ``source``, which is opened here, in the place of the one before, which is closed. Somebody
        who listens goes on listening. ``gain``: that of this source; else it is the usual one, as it was left. Raises
        what opening it raises; then all stays as it was."""
        await self._intake.replace(source, gain)
        self._afterwards.forget()
        if source.live and self._listener is not None:
            self._listener.reset()

    async def load(self) -> None:
        """Load the recogniser in its thread. Raises ``ModelError``; :meth:`transcribe` would raise the same."""
        await self._transcriber.load()

    def mark(self, ago_s: float | None = None, phrase: str = "") -> None:
        """The wake is now: the next :meth:`listen` of a live source begins here, less the pre-roll, or ``ago_s`` (up to
        1 s) ago, when the ``phrase`` ended that woke, however long it takes until it is called (up to 10 s).
        Thread-safe, returns at once."""
        self._afterwards.begun = None
        self._phrase = phrase if ago_s is not None and len(phrase) <= LONGEST_PHRASE else ""
        self._ring.mark(None if ago_s is None else int(ago_s / FRAME_S))  # rather too little than some of a word

    def overhear(self, on: bool) -> None:
        """From now on, or not any more, a stop that a live source hears is told to the ``alert``, in the recogniser's
        thread and without anybody listening. All else that is overheard is forgotten."""
        self._overhearing.switch(on)

    @property
    def overhears(self) -> bool:
        """A stop would be told now. Any thread."""
        return self._overhearing.usable

    @property
    def without_own_voice(self) -> bool:
        """What the robot says is taken out of what is heard now, as far as anybody can tell. Any thread."""
        return self._echo is not None and self._echo.knows

    @property
    def hears_itself(self) -> bool:
        """A word that was heard just now was the robot's own. Any thread."""
        return self._echo is not None and self._echo.alone

    def suspect(self, phrase: str, settled: Callable[[], None], likelier: Callable[[], None], *, sure: bool) -> None:
        """``phrase`` seems to have been said just now: see :meth:`engine.hearing.overhearing.Overhearing.suspect`."""
        self._afterwards.make_way()
        self._overhearing.suspect(phrase, settled, likelier, sure=sure)

    def ask(self, phrase: str, sound: Samples, answer: Callable[[bool | None], None], *, likely: bool) -> None:
        """Find out whether ``sound`` ends with a ``phrase`` that wakes: see :meth:`Transcriber.ask`. Nobody can tell
        while somebody is listened to, nor while the robot's own voice is heard, which may say it. Any thread; returns
        at once."""
        if self._ring.is_listened_to or (self._echo is not None and self._echo.sounds):
            answer(None)
        else:
            self._transcriber.ask(phrase, sound, answer, likely=likely, dropped=lambda: self._ring.is_listened_to)

    async def listen(self, emit: Emit, *, restarted: bool = False) -> Utterance | NothingHeard:
        """Hear one utterance, publishing ``listen.started``, ``listen.level``, ``listen.ended`` and what the source
        tolerated.

        ``listen.ended`` comes exactly once, also when this is cancelled or the device is lost (raises
        ``DeviceError``).
        """
        self._overhearing.drop()  # the recogniser is for who is listened to
        self._drop_ahead()
        self._afterwards.forget()
        begun, self._afterwards.begun = self._afterwards.begun, None
        phrase, self._phrase = self._phrase if self._recogniser.takes_lead else "", ""
        source = self._intake.source
        before = self._ring.listen()
        lead = Lead(phrase, np.concatenate([frame.samples for frame in before])) if phrase and before else None
        emit(events.ListenStarted(source.name, restarted))
        ended = events.ListenEnded("cancelled", 0.0, 0.0)
        try:
            await self._settle(before[-SETTLING_FRAMES:] if lead is not None else ())
            end = await self._find_utterance(source, emit, begun, lead)
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
            for warning in self._intake.untold():
                emit(events.Log("warning", "microphone", warning))
        if heard is not None:
            return heard
        if end.reason == "source_ended":
            return NothingHeard("source_ended", f"The sound of {source.name} ended and nobody spoke.")
        return NothingHeard("no_speech", f"Nobody spoke for {self._endpoint.no_speech_s:g} s.")

    async def transcribe(
        self, utterance: Utterance, emit: Emit, on_more: More | None = None
    ) -> events.TranscriptFinal | events.TranscriptRejected:
        """Recognise an utterance; the result is published and returned. Raises ``ModelError``. ``on_more`` is told, in
        the loop's thread, what somebody adds who goes on though the utterance was complete, and whether it is to be
        done after that or in its place.

        Cancelling returns at once; what is found after that is published as ``transcript.rejected`` with the reason
        ``late``.
        """
        self._overhearing.drop()
        ahead, self._ahead = self._ahead, None
        begun = ahead[1] if ahead is not None and ahead[0] is utterance else None
        result = as_event(await self._transcriber.transcribe(utterance, emit, begun))
        emit(result)
        self._afterwards.understood(utterance, result, on_more)
        if isinstance(result, events.TranscriptFinal) and self._intake.gain.learn(utterance.samples):
            emit(events.Log("debug", "microphone", f"The gain is {self._intake.gain.db:g} dB from now on."))
        return result

    def lose(self, error: SaysoError) -> None:
        """There is no source any more: that is what whoever listens from now on is told."""
        self._intake.lose(error)

    def _follow(self, plain: Frame, taken: Frame) -> None:
        """A frame of a live source, for all who need not be listening: see ``Intake``."""
        self._afterwards.push(taken, taken if self.without_own_voice else plain, own=self.hears_itself)
        if self._listener is not None:
            self._listener.push(plain.samples)
        self._overhearing.push(plain, taken)

    async def _settle(self, before: Sequence[Frame]) -> None:
        """Have the detector of voices begin anew, with what was heard ``before``."""
        self._vad.reset()
        for frame in before:
            self._vad.process(frame)
            await asyncio.sleep(0)  # a millisecond each

    async def _find_utterance(self, source: Source, emit: Emit, begun: Utterance | None, lead: Lead | None) -> Ended:
        """Feed frames to the endpointer until it has an end; what was ``begun``, or a ``lead``, comes before it. Raises
        what the source raises."""
        patience = {} if begun is None else {"no_speech_s": GOES_ON_S}  # it may have been no voice that went on
        endpointer = Endpointer(self._endpoint.model_copy(update=patience), lead)
        meter = Meter()
        work = self._transcriber

        def recognise(samples: Samples, cancelled: Callable[[], bool], quick: bool) -> Transcript | Rejected:
            if begun is None:
                return work.recognise(samples, cancelled, quick, endpointer.lead)
            return work.recognise(np.concatenate((begun.samples, samples)), cancelled, quick, begun.lead)

        def start(transcription: Transcription) -> asyncio.Future[Found]:
            found = work.start(transcription)
            found.add_done_callback(lambda _: self._ring.look_again())
            return found

        def decoding_ahead() -> DecodingAhead:
            return DecodingAhead(recognise, start, self._endpoint, self._judge, emit, partials=self._partials)

        def enough() -> bool:
            return ahead.ends(endpointer)

        ahead = decoding_ahead()
        try:
            while (frame := await self._intake.next_frame(source, enough, self._endpoint.no_speech_s)) is not None:
                vad = self._vad.process(frame)
                if endpointer.lead is not None and ahead.found_nothing:
                    ahead.drop()
                    endpointer.forget()
                    ahead = decoding_ahead()
                ahead.advise(endpointer)
                found = endpointer.push(frame, vad)
                if (level := meter.add(frame, vad, in_speech=endpointer.in_speech)) is not None:
                    emit(level)
                if isinstance(found, Ended):
                    break
                if source.live:  # any other comes faster than it could be recognised
                    ahead.follow(endpointer)
            else:
                found = endpointer.finish()
            if begun is not None:  # if that was only noise, it is still what was said
                heard = begun if found.utterance is None else joined(begun, found.utterance)
                found = replace(found, utterance=heard)
            decoding = ahead.end()
            if found.utterance is not None and decoding is not None:
                self._ahead = found.utterance, decoding
            if found.utterance is not None and begun is None and source.live:
                self._afterwards.ended(found.utterance)
            return found
        finally:
            ahead.drop()

    def _drop_ahead(self) -> None:
        """Nobody has asked for the transcript of the last utterance, and nobody will."""
        ahead, self._ahead = self._ahead, None
        if ahead is not None:
            ahead[1].transcription.cancel()
