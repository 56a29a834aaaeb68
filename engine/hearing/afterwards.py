"""What comes after an utterance, while nobody listens any more: its speaker may go on (``engine.hearing.going_on``).

Whoever had not said all is told of at once, and the next turn begins with what has been said. What is added to a
request that was complete is recognised together with it, beside whatever the robot does by then, and told once it is
known.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import msgspec

from config.schema import Endpoint
from engine import events
from engine.asr.recogniser import Rejected, Transcript
from engine.asr.transcription import Found, Transcription
from engine.audio.endpoint import Utterance
from engine.audio.source import Frame
from engine.audio.vad import VadResult, VoiceActivity
from engine.hearing.ahead import CERTAIN, UNSURE
from engine.hearing.going_on import Addition, GoingOn, may_have_no_end
from engine.hearing.readings import Afterthought, Judge, Notice
from engine.hearing.transcriber import Transcriber, as_final

More = Callable[[events.TranscriptFinal, bool], None]
"""Is told what was added to a request, and whether it is to be done after that, or in its place."""


class Afterwards:
    """Follows the newest utterance of a live source. Belongs to the loop's thread, but for :meth:`make_way`.

    ``judge`` and ``notice`` are asked in the recogniser's thread; ``on_going_on`` and ``beside``: see ``Hearing``.
    """

    def __init__(
        self,
        vad: VoiceActivity,
        beside: VoiceActivity | None,
        endpoint: Endpoint,
        transcriber: Transcriber,
        judge: Judge,
        notice: Notice,
        on_going_on: Callable[[float], None] | None,
    ) -> None:
        self._vad = vad
        self._beside = beside
        self._endpoint = endpoint
        self._transcriber = transcriber
        self._judge = judge
        self._notice = notice
        self._on_going_on = on_going_on
        self._going_on: GoingOn | None = None
        self._addition: Addition | None = None
        self._adding: Transcription | None = None  # of the last request with what was added to it
        self.begun: Utterance | None = None
        """By whoever goes on now."""

    def ended(self, utterance: Utterance) -> None:
        """This has just been said."""
        if self._on_going_on is not None:
            self._going_on = GoingOn(utterance, self._vad)
            self._addition = Addition(utterance, self._endpoint) if self._beside is not None else None

    def understood(
        self,
        utterance: Utterance,
        result: events.TranscriptFinal | events.TranscriptRejected,
        on_more: More | None,
    ) -> None:
        """It has no end, and its speaker may still go on; or it is complete, and something may be added, of which
        ``on_more`` is told."""
        going_on, self._going_on = self._going_on, None
        addition, self._addition = self._addition, None
        if may_have_no_end(result, self._judge):
            if going_on is not None and going_on.utterance is utterance:
                going_on.awaited = True
                self._going_on = going_on
            return
        if addition is None or addition.utterance is not utterance or on_more is None:
            return
        if isinstance(result, events.TranscriptFinal):
            first = result.text
            addition.told = lambda whole: self._understand(first, whole, on_more)
            self._addition = addition

    def forget(self) -> None:
        """Nobody goes on with what was said before."""
        self._going_on = self._addition = None
        self.make_way()

    def make_way(self) -> None:
        """Give up what is being recognised. Thread-safe."""
        if (adding := self._adding) is not None:
            adding.cancel()

    def push(self, frame: Frame, plain: Frame, *, own: bool) -> None:
        """A frame of a live source. ``plain``: the same with more of the robot's own voice in it, where it is
        not known yet how that sounds here; ``own``: a word in ``frame`` was the robot's own."""
        if self._beside is not None:
            heard = self._beside.process(plain)  # always: a detector that has just begun misses who speaks softly
            self._hear_more(plain, heard)
        if (going_on := self._going_on) is None or self._on_going_on is None:
            return
        going_on.push(frame)
        if going_on.ago_s is not None or going_on.is_over:
            self._going_on = None
        if going_on.ago_s is not None and not own:
            self._on_going_on(min(1.0, going_on.ago_s))
            self.begun = going_on.utterance

    def _hear_more(self, frame: Frame, heard: VadResult) -> None:
        """A frame, for what may be added."""
        if (addition := self._addition) is None:
            return
        addition.push(frame, heard)
        if not addition.is_over:
            return
        if addition.whole is None:
            self._addition = None
        elif addition.told is not None:
            self._addition = None
            addition.told(addition.whole)

    def _understand(self, first: str, whole: Utterance, on_more: More) -> None:
        """Have the request ``first`` recognised together with what was added, and tell what that was."""
        added: Afterthought | None = None

        def work(cancelled: Callable[[], bool]) -> Transcript | Rejected:
            nonlocal added
            found = self._transcriber.recognise(whole.samples, cancelled, lead=whole.lead)
            if not cancelled():
                added = added_to(first, found, self._notice)
            return found

        def tell(future: asyncio.Future[Found]) -> None:
            found = None if future.cancelled() or adding.is_cancelled else future.result()
            if isinstance(found, Transcript) and added is not None:
                on_more(msgspec.structs.replace(as_final(found), text=added.text), added.adds)

        self._adding = adding = Transcription(work)
        self._transcriber.start(adding).add_done_callback(tell)


def added_to(first: str, found: Found, notice: Notice) -> Afterthought | None:
    """What was added to the request ``first``, where the transcript of both was heard well enough."""
    if not isinstance(found, Transcript) or found.confidence < UNSURE:
        return None
    noticed = notice(first, found.text)
    return noticed if noticed is not None and (noticed.clear or found.confidence >= CERTAIN) else None
