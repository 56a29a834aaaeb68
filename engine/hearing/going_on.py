"""Whether somebody goes on whose turn was ended too early: "go to the …", and a second later "… kitchen".

A pause that lasts too long ends a turn, and what was said so far is answered with a question, or thought over. If the
same voice goes on soon after, both pieces are one request: the ears say so, the next turn begins with what has just
been said, and the recogniser gets the sound of both. What was said without an end is waited for like that, or what was
hardly understood, and only once: whoever talks to somebody else after a request of theirs must not be drawn into it.

After a request that was complete ("go to the kitchen" … "and wave") the robot acts, and a voice alone changes nothing.
Whoever goes on even sooner is heard to the end beside that, and what belongs to the request is told then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from config.schema import Endpoint
from engine import events
from engine.audio.endpoint import RESUME_FRAMES, Ended, Endpointer, Utterance
from engine.audio.source import FRAME_S, Frame
from engine.audio.vad import VadResult, VoiceActivity
from engine.hearing.ahead import CERTAIN, NOT_UNDERSTOOD
from engine.hearing.readings import Judge

GOES_ON_S = 1.5
"""After the end of a turn, s: later it is another request, which needs a wake."""

ADDS_S = 0.6
"""The same after a request that was complete: most of such pauses are shorter."""

LONGEST_S = 8.0
"""What is added to a request takes no longer, s; a noise that sounds like a voice may."""

SPEECH_S = 0.25
"""Less of a voice, s, is no word that adds anything."""

PRE_ROLL_FRAMES = 6
"""Heard before a detector is sure of a voice (0.2 s)."""


class Addition:
    """Hears what is added to a request that was complete, ``utterance``, to its end."""

    told: Callable[[Utterance], None] | None = None
    """Who is told of the whole; None: it is not known yet that the request was complete."""

    def __init__(self, utterance: Utterance, settings: Endpoint) -> None:
        patience = {"no_speech_s": ADDS_S, "max_length_s": min(LONGEST_S, settings.max_length_s)}
        self._endpointer = Endpointer(settings.model_copy(update=patience))
        self.utterance = utterance
        self.is_over = False
        self.whole: Utterance | None = None
        """Once it is over: the request with what was added, if there was anything."""

    def push(self, frame: Frame, heard: VadResult) -> None:
        """The next frame after the utterance, and whether there is a voice in it."""
        if self.is_over or not isinstance(found := self._endpointer.push(frame, heard), Ended):
            return
        self.is_over = True
        if found.utterance is not None and found.utterance.speech_s >= SPEECH_S:
            self.whole = joined(self.utterance, found.utterance)


@dataclass(slots=True)
class GoingOn:
    """Watches what comes after ``utterance``. ``vad`` goes on where the utterance ended."""

    utterance: Utterance
    vad: VoiceActivity
    awaited: bool = False
    """It is known by now that the utterance had no end."""
    _frames: int = 0
    _voice: int = 0  # frames of speech in a row
    _since: int | None = None  # frames since somebody went on, with the pre-roll

    @property
    def is_over(self) -> bool:
        """Nobody goes on any more."""
        return self._since is None and self._frames * FRAME_S >= GOES_ON_S

    def push(self, frame: Frame) -> None:
        """The next frame after the utterance."""
        self._frames += 1
        if self._since is not None:
            self._since += 1
            return
        if not self.is_over:
            self._voice = self._voice + 1 if self.vad.process(frame).speech else 0
            if self._voice >= RESUME_FRAMES:
                self._since = self._voice + PRE_ROLL_FRAMES

    @property
    def ago_s(self) -> float | None:
        """How long ago somebody went on, s; None: nobody has, or it is not known to matter."""
        return self._since * FRAME_S if self.awaited and self._since is not None else None


def may_have_no_end(result: events.TranscriptFinal | events.TranscriptRejected, judge: Judge) -> bool:
    """Whether somebody who was understood like this may still have something to say."""
    if isinstance(result, events.TranscriptRejected):
        return result.reason in NOT_UNDERSTOOD
    verdict = judge(result.text)
    return verdict == "incomplete" or (verdict == "unknown" and result.confidence < CERTAIN)


def joined(first: Utterance, second: Utterance) -> Utterance:
    """Both as one."""
    return replace(
        second,
        samples=np.concatenate((first.samples, second.samples)),
        start=first.start,
        lead=first.lead,
        speech_s=first.speech_s + second.speech_s,
    )
