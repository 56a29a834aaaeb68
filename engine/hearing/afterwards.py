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
from engine.audio.vad import VoiceActivity
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
        self._after: GoingOn | None = None
        self._adding: Transcription | None = None  # of the last request with what was added to it
        self.begun: Utterance | None = None
        """By whoever goes on now."""

    def ended(self, utterance: Utterance) -> None:
        """This has just been said."""
        if self._on_going_on is not None:
            addition = Addition(utterance, self._endpoint) if self._beside is not None else None
            self._after = GoingOn(utterance, self._vad, addition)

    def understood(
        self,
        utterance: Utterance,
        result: events.TranscriptFinal | events.TranscriptRejected,
        on_more: More | None,
    ) -> None:
        """It has no end, and its speaker may still go on; or it is complete, and something may be added, of which
        ``on_more`` is told."""
        after, self._after = self._after, None
        if after is None or after.utterance is not utterance:
            return
        if may_have_no_end(result, self._judge):
            after.awaited = True
        elif isinstance(result, events.TranscriptFinal) and on_more is not None and after.addition is not None:
            first = result.text
            after.told = lambda whole: self._understand(first, whole, on_more)
        else:
            return
        self._after = after

    def forget(self) -> None:
        """Nobody goes on with what was said before."""
        self._after = None
        self.make_way()

    def make_way(self) -> None:
        """Give up what is being recognised. Thread-safe."""
        if (adding := self._adding) is not None:
            adding.cancel()

    def push(self, frame: Frame, plain: Frame, *, own: bool) -> None:
        """A frame of a live source. ``plain``: the same with more of the robot's own voice in it, where it is
        not known yet how that sounds here; ``own``: a word in ``frame`` was the robot's own."""
        after = self._after
        if self._beside is not None:
            heard = self._beside.process(plain)  # always: a detector that has just begun misses who speaks softly
            if after is not None and after.addition is not None and not after.awaited:
                after.addition.push(plain, heard)
        if after is None:
            return
        after.push(frame)
        if after.ago_s is not None or after.is_over:
            self._after = None
        if after.ago_s is not None and self._on_going_on is not None:
            if not own:
                self._on_going_on(min(1.0, after.ago_s))
                self.begun = after.utterance
        elif after.told is not None and after.addition is not None and after.addition.whole is not None:
            after.told(after.addition.whole)

    def _understand(self, first: str, whole: Utterance, on_more: More) -> None:
        """Have the request ``first`` recognised together with what was added, and tell what that was."""
        added: Afterthought | None = None

        def work(cancelled: Callable[[], bool]) -> Transcript | Rejected:
            nonlocal added
            found = self._transcriber.recognise(whole.samples, cancelled, lead=whole.lead)
            if isinstance(found, Transcript) and found.confidence >= UNSURE and not cancelled():
                noticed = self._notice(first, found.text)
                if noticed is not None and (noticed.clear or found.confidence >= CERTAIN):
                    added = noticed
            return found

        def tell(future: asyncio.Future[Found]) -> None:
            found = None if future.cancelled() or adding.is_cancelled else future.result()
            if isinstance(found, Transcript) and added is not None:
                on_more(msgspec.structs.replace(as_final(found), text=added.text), added.adds)

        self._adding = adding = Transcription(work)
        self._transcriber.start(adding).add_done_callback(tell)
