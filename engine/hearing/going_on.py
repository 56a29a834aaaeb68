"""Whether somebody goes on whose turn was ended too early: "go to the …", and a second later "… kitchen".

A pause that lasts too long ends a turn, and what was said so far is answered with a question, or thought over. If the
same voice goes on soon after, both pieces are one request: the ears say so, the next turn begins with what has just
been said, and the recogniser gets the sound of both.

Only what was said without an end is waited for, or what was hardly understood, and only once: whoever talks to somebody
else after a request of theirs must not be drawn into it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from engine import events
from engine.audio.endpoint import RESUME_FRAMES, Utterance
from engine.audio.source import FRAME_S, Frame
from engine.audio.vad import VoiceActivity
from engine.hearing.ahead import CERTAIN, NOT_UNDERSTOOD
from engine.hearing.readings import Judge

GOES_ON_S = 1.5
"""After the end of a turn, s: later it is another request, which needs a wake."""

PRE_ROLL_FRAMES = 6
"""Heard before a detector is sure of a voice (0.2 s)."""


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
