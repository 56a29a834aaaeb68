"""When to recognise what of the sound in which somebody may say a stop, without a wake.

As soon as somebody has said as much as a stop, at the first short pause, and every half second while they talk on, the
newest stretch is to be recognised.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from engine.audio.source import FRAME_S, Frame, Samples

START_FRAMES = 3
"""Frames of speech in a row (0.1 s) that are no click."""

PAUSE_FRAMES = 2
"""Frames without speech (64 ms) after which a word has ended, as far as one can tell without waiting."""

END_FRAMES = 16
"""Frames without speech (0.5 s) after which what was said before is no context any more."""

FIRST_FRAMES = 11
"""Frames of speech (0.35 s) that are enough for a stop: a pause behind it is noticed 0.1 s later."""

TALKING_FRAMES = 16
"""How often (0.5 s) somebody who talks on is listened to again."""

PRE_ROLL_FRAMES = 10
"""0.3 s from before the first frame of speech: a detector misses soft onsets, and a stop begins with one."""

TALKING_S = 3.0
"""How much of what somebody says who talks on is recognised, s: more takes longer and holds no newer word."""

LONGEST_S = 8.0
"""How much is recognised at a pause, s: the whole sentence, so that "don't stop" is no stop."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Sound in which somebody speaks; ``ended``: up to a pause, not in the middle."""

    samples: Samples
    ended: bool


class SpeechWatch:
    """When to recognise what: a pure state machine over frames and whether there is speech in them."""

    def __init__(self) -> None:
        self._frames: deque[Frame] = deque(maxlen=_frames(LONGEST_S))  # the pre-roll, and the speech so far
        self._speech = 0  # frames of speech in a row, until speech has begun
        self._begun = False
        self._quiet = 0  # frames since the last one with speech
        self._next = 0  # frames until something is to be recognised though there is no pause
        self._said = False  # whether there was speech since the last pause

    @property
    def talking(self) -> bool:
        """Somebody talks, or ended less than a pause ago."""
        return self._begun and self._quiet < PAUSE_FRAMES

    def push(self, frame: Frame, speech: bool) -> Stretch | None:
        """Take the next frame; gives what to recognise when it is time to."""
        self._frames.append(frame)
        if not self._begun:
            self._wait_for_speech(speech)
            return None
        self._next -= 1
        if speech:
            self._quiet, self._said = 0, True
            return self._ask(TALKING_S, ended=False) if self._next <= 0 else None
        self._quiet += 1
        if self._quiet >= END_FRAMES:
            self._begun, self._speech = False, 0
            self._keep(PRE_ROLL_FRAMES)
        elif self._quiet >= PAUSE_FRAMES and self._said:
            self._said = False
            return self._ask(LONGEST_S, ended=True)
        return None

    def _wait_for_speech(self, speech: bool) -> None:
        self._speech = self._speech + 1 if speech else 0
        self._keep(PRE_ROLL_FRAMES + self._speech)
        if self._speech >= START_FRAMES:
            self._begun, self._said = True, True
            self._quiet, self._next = 0, FIRST_FRAMES - self._speech

    def _keep(self, frames: int) -> None:
        while len(self._frames) > frames:
            self._frames.popleft()

    def _ask(self, longest_s: float, *, ended: bool) -> Stretch:
        self._next = TALKING_FRAMES
        newest = list(self._frames)[-_frames(longest_s) :]
        return Stretch(np.concatenate([frame.samples for frame in newest]), ended)


def _frames(seconds: float) -> int:
    return round(seconds / FRAME_S)
