"""Decoding ahead: what was said is recognised before it is clear whether that was all.

In every pause the utterance so far is recognised as if it were whole, in a quick pass, and in a thorough one where that
leaves a doubt. If nobody goes on, that is the transcript, and it is ready when the silence is. What it says also tells
how long to wait: not long after a complete command, longer after "go to the", and as long as it takes while it is not
known what was said, since nothing could be done before that. While somebody talks, a quick pass every half second shows
the words so far. Where a voice fades, in noise long before the pause, a pass begins; it serves this pause if one comes,
and is given up if the voice goes on.

In noise a detector of voices hears somebody go on who has ended. Words tell: a complete command to which 0.4 s of sound
added none has been said, and the turn ends; so it does after anything else to which as much sound added none as a pause
of its own would take, and a little more.

One thing is recognised at a time. What is overtaken before it began is cancelled, and has no effect.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from config.schema import Endpoint
from engine import events
from engine.asr.agreement import Agreement, normalised_words
from engine.asr.recogniser import Rejected, Transcript
from engine.asr.transcription import Found, Transcription, deserves_another_look
from engine.audio.endpoint import Endpointer
from engine.audio.source import FRAME_S, Samples
from engine.bus import Emit
from engine.hearing.readings import Completeness, Judge, makes_no_sense, sensible

PAUSE_FRAMES = 1
"""Frames without speech (32 ms) after which somebody may have ended. With two, fewer passes are for nothing, and
commands are understood that much later."""

BURST_FRAMES = 7
"""What began this shortly (0.2 s) before has heard all but the end of a word: a pause is 32 ms of it, and a detector of
voices takes another 0.1 s to notice one. "Box" has two pauses; what was found in the first is asked first."""

FADING_FRAMES = 6
"""Speech (0.2 s) before which no word is at its end: its beginning looks the same."""

FADED_FRAMES = 3
"""What follows in a voice that fades (0.1 s) and may be missing for all to have been heard."""

FIRST_FRAMES = 32
"""Speech (1 s) after which somebody talks on: most commands are over by then, and nothing delays their last pass."""

TALKING_FRAMES = 16
"""How often (0.5 s) the words of somebody who talks on are shown, at most…"""

REST = 3
"""…and how much longer than a pass it takes until the next: the pass of a pause waits for the one that is running."""

CONFIRM_S = 0.4
"""Sound to which a recogniser finds no more words, s: even a short one takes less, and is written down."""

CONFIRM_MORE_S = 0.3
"""So much more of it than of silence, s, ends what is no complete command: some of what is heard may be a voice."""

UNSURE = 0.55
"""Confidence below which a text that is no command says little about what was said: words are missing, or wrong."""

CERTAIN = 0.7
"""Confidence below which a complete command may be the beginning of another, or be made of one: in noise, and after a
thorough look, more silence has to follow it. What makes no sense may be the half of something that does."""

CAUTION = 2 / 3
"""How far that is from the usual silence towards that after a command: of 139 recordings at 10 and at 5 dB, with and
without pauses, as many were cut off as with the usual one."""

NOT_UNDERSTOOD = ("low_confidence", "no_speech")
"""A voice was heard, and no words: in noise, the first half of a sentence alone sounds like that."""


class Decoding:
    """One pass over the utterance so far; ``verdict`` counts once it is over."""

    def __init__(
        self,
        sound: Samples,
        at: int,
        recognise: Callable[[Callable[[], bool]], Transcript | Rejected],
        judge: Judge,
        *,
        quick: bool,
    ) -> None:
        self.sound = sound
        self.at = at  # where the sound ends, in frames of the utterance
        self.quick = quick
        self.words: list[str] = []  # once it is over, and understood something
        self.frames = 0  # that came while it lasted
        self._recognise = recognise
        self._judge = judge
        self.transcription = Transcription(self._work)
        self.verdict: Completeness = "unknown"
        self._may_be_misread = False
        self.future: asyncio.Future[Found] | None = None

    @property
    def is_over(self) -> bool:
        return self.future is not None and self.future.done() and not self.future.cancelled()

    @property
    def is_certain(self) -> bool:
        """What was understood in one look is what was said."""
        found = self.future.result() if self.is_over and self.future is not None else None
        return self.quick and isinstance(found, Transcript) and found.confidence >= CERTAIN

    @property
    def is_doubtful(self) -> bool:
        """It is over, and was too quick to be the last word, unless that is a command to the letter. What makes no
        sense may have been another word."""
        if not self.is_over or self.future is None or self.verdict == "complete":
            return False
        return self._may_be_misread or deserves_another_look(self.future.result())

    def _work(self, cancelled: Callable[[], bool]) -> Transcript | Rejected:
        """In the recogniser's thread."""
        found = sensible(self._recognise(cancelled), self._judge)
        if isinstance(found, Transcript) and not cancelled():
            self.words = normalised_words(found.text)
            self.verdict = self._judge(found.text)
            senseless = makes_no_sense(found.text, self._judge)
            self._may_be_misread = found.decoding.only_reading and senseless
            if found.decoding.doubtful and any(sign.isdigit() for sign in found.text):
                self.verdict = "unknown"  # a wrong number makes a command, too; wrong words hardly ever do
            elif self.verdict == "unknown" and found.confidence < (CERTAIN if senseless else UNSURE):
                self.verdict = "incomplete"  # the first half of a sentence is harder to understand than all of it
        elif isinstance(found, Rejected) and found.reason in NOT_UNDERSTOOD:
            self.verdict = "incomplete"
        return found


class DecodingAhead:
    """Follows one utterance. Belongs to the loop's thread; ``recognise`` and ``judge`` are called in the recogniser's.

    ``recognise`` gets the sound, whom to ask whether it is still needed, and whether one quick pass will do; ``start``
    has a transcription run in the recogniser's thread. Without ``partials`` nothing is recognised while somebody talks.
    """

    def __init__(
        self,
        recognise: Callable[[Samples, Callable[[], bool], bool], Transcript | Rejected],
        start: Callable[[Transcription], asyncio.Future[Found]],
        settings: Endpoint,
        judge: Judge,
        emit: Emit,
        *,
        partials: bool = True,
    ) -> None:
        self._recognise = recognise
        self._start = start
        self._judge = judge
        self._emit = emit
        self._partials = partials
        self._silence_s: dict[Completeness, float] = {
            "complete": min(settings.complete_s, settings.silence_s),
            "incomplete": max(settings.incomplete_s, settings.silence_s),
            "unknown": settings.silence_s,
        }
        self._stable_s = {
            verdict: CONFIRM_S if verdict == "complete" else silence_s + CONFIRM_MORE_S
            for verdict, silence_s in self._silence_s.items()
        }
        usual = self._silence_s["unknown"]
        self._uncertain_s = usual - CAUTION * (usual - self._silence_s["complete"])
        self._agreement = Agreement()
        self._shown = ("", 0)
        self._until_next = FIRST_FRAMES  # frames of speech until something is recognised though there is no pause
        self._heard = 0  # frames of the utterance
        self._newest: Decoding | None = None
        self._early: Decoding | None = None  # one that began when a pause seemed to come
        self._whole: Decoding | None = None  # the one of the present pause
        self._stable: Decoding | None = None  # the first in which the words were found that are the newest
        self._confirmed: Decoding | None = None  # a later one that found no more

    def advise(self, endpointer: Endpointer) -> None:
        """Before a frame: tell the endpointer how long the present pause has to be, or that it needs none."""
        if self._confirmed is not None:
            self._whole = self._confirmed
            endpointer.conclude()
        elif self._whole is not None:
            known = self._whole.is_over and not self._whole.is_doubtful
            verdict = self._whole.verdict if known else "incomplete"
            uncertain = verdict == "complete" and not self._whole.is_certain
            silence_s = self._uncertain_s if uncertain else self._silence_s[verdict]
            endpointer.wait(silence_s, with_fade=verdict == "complete")

    @property
    def found_nothing(self) -> bool:
        """Nothing was said before the present pause, but what is known to have been said before that."""
        whole = self._whole
        if whole is None or whole.future is None or not whole.is_over or whole.is_doubtful:
            return False
        found = whole.future.result()
        return isinstance(found, Rejected) and found.reason == "no_speech"

    def ends(self, endpointer: Endpointer) -> bool:
        """Between two frames: by what is known now, the utterance is over, and need not wait for the next one."""
        self.advise(endpointer)
        return endpointer.is_over

    def follow(self, endpointer: Endpointer) -> None:
        """After a frame that did not end the utterance: recognise what there is, if it is time to."""
        if not endpointer.in_speech:
            return
        self._heard += 1
        if self._newest is not None and not self._newest.is_over:
            self._newest.frames += 1
        if endpointer.pause >= PAUSE_FRAMES:
            if self._whole is None:
                self._whole = self._just_begun()
            if self._whole is None or self._is_outdated(self._whole, endpointer):
                self._whole = self._begin(endpointer.so_far, self._heard)
            elif self._whole.is_doubtful:
                self._whole = self._begin(self._whole.sound, self._whole.at, quick=False)
        elif endpointer.pause == 0:
            if self._whole is not None:
                self._overtake(self._whole)
                self._whole = None
            self._until_next -= 1
            if self._early is not None and not endpointer.fading:
                self._early.transcription.cancel()  # the word went on
                self._early = None
            idle = self._newest is None or self._newest.is_over
            if idle and self._seems_to_end(endpointer):
                self._early = self._begin(endpointer.so_far, self._heard)
            elif idle and ((self._partials and self._until_next <= 0) or self._may_be_confirmed):
                self._begin(endpointer.so_far, self._heard)

    def end(self) -> Decoding | None:
        """The utterance has ended: what recognises it whole, if that has begun. Nothing is shown any more."""
        whole, self._whole = self._whole, None
        newest, self._newest = self._newest, None
        if newest is not None and newest is not whole:
            newest.transcription.cancel()
        return whole

    def drop(self) -> None:
        """Nobody wants to know any more."""
        if (whole := self.end()) is not None:
            whole.transcription.cancel()

    def _just_begun(self) -> Decoding | None:
        """A pass that has heard all before this pause but the end of a word."""
        newest = self._newest
        if newest is None or newest.transcription.is_cancelled or self._heard - newest.at > BURST_FRAMES:
            return None
        return newest

    def _is_outdated(self, decoding: Decoding, endpointer: Endpointer) -> bool:
        """It did not hear all up to this pause, and found no command in what it heard."""
        heard = decoding.at + (FADED_FRAMES if decoding is self._early else 0)
        missed = heard < self._heard - endpointer.pause + PAUSE_FRAMES
        return missed and decoding.is_over and decoding.verdict != "complete"

    def _seems_to_end(self, endpointer: Endpointer) -> bool:
        """A pause seems to come, for the first time since somebody was sure to speak."""
        return self._partials and endpointer.fading and self._early is None and self._heard >= FADING_FRAMES

    @property
    def _may_be_confirmed(self) -> bool:
        return self._stable is not None and self._has_lasted(self._stable, self._heard)

    def _has_lasted(self, stable: Decoding, until: int) -> bool:
        """No words came after those since so long, in frames of the utterance, that none will."""
        return (until - stable.at) * FRAME_S >= self._stable_s[stable.verdict]

    def _begin(self, sound: Samples, at: int, *, quick: bool = True) -> Decoding:
        if self._newest is not None:
            self._overtake(self._newest)
        recognise = self._recognise
        decoding = Decoding(sound, at, lambda cancelled: recognise(sound, cancelled, quick), self._judge, quick=quick)
        self._newest, self._until_next = decoding, TALKING_FRAMES
        decoding.future = self._start(decoding.transcription)
        decoding.future.add_done_callback(lambda future: self._weigh(decoding, future))
        decoding.future.add_done_callback(lambda future: self._show(decoding, future))
        return decoding

    def _overtake(self, decoding: Decoding) -> None:
        """There is more sound by now. A quick pass that has begun cannot be stopped; what it finds may still serve."""
        if not decoding.quick or not decoding.transcription.has_begun:
            decoding.transcription.cancel()

    def _weigh(self, decoding: Decoding, future: asyncio.Future[Found]) -> None:
        """What it found makes certain that this is all, or it is something else, or nothing."""
        if future.cancelled() or decoding.transcription.is_cancelled:
            return
        stable = self._stable
        if not decoding.words or stable is None or stable.words != decoding.words:
            self._stable = decoding if decoding.words else None
            return
        only_a_comma_more = stable.verdict == "complete" and decoding.verdict == "unknown"
        if only_a_comma_more and not deserves_another_look(future.result()):
            decoding.verdict = "complete"
        if decoding.verdict != stable.verdict:
            self._stable = decoding
        elif self._has_lasted(stable, decoding.at):
            self._confirmed = decoding

    def _show(self, decoding: Decoding, future: asyncio.Future[Found]) -> None:
        if decoding is not self._newest or future.cancelled():
            return
        self._until_next = max(TALKING_FRAMES, REST * decoding.frames) - decoding.frames
        found = future.result()
        if not isinstance(found, Transcript):
            return
        shown = (found.text, self._agreement.add(found.text))
        if shown != self._shown:
            self._shown = shown
            self._emit(events.TranscriptPartial(*shown))
