"""When an utterance starts and ends: a pure state machine over frames and their voice activity.

Time is the number of frames that were pushed; nothing is read from outside, so that the same frames always give the
same utterance. An utterance starts once enough speech came in a row, and is given a pre-roll from before that, because
a word begins before a detector is sure of it. It ends after enough silence, or at its greatest length, which also ends
it in a noise that sounds like speech for ever. How much silence is enough, whoever knows what was said can say anew in
every pause (:meth:`Endpointer.wait`), or that none is needed (:meth:`Endpointer.conclude`), and need not wait for
another frame where that was all (:attr:`Endpointer.is_over`). And where it was no utterance at all, they say so, and it
is waited for one as before (:meth:`Endpointer.forget`).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np

from config.schema import Endpoint
from engine.audio.source import FRAME_S, RATE, Frame, Samples
from engine.audio.vad import VadResult
from engine.lead import Lead

TAIL_S = 0.2
"""Silence that is left at an utterance's end, s: recognisers drop last consonants that touch the edge."""

RESUME_FRAMES = 3
"""Frames of speech in a row (0.1 s) that break a silence: fewer are a click, or a spike of the detector in noise."""

FADING = 0.8
"""Probability of speech below which a word may be at its end: in noise it falls for 0.1 s and more before a detector
with hysteresis calls it a pause, and within words it seldom does."""

FADE_FRAMES = 4
"""So much of that (0.13 s) may belong to the pause that it ends in: at 10 dB a voice is over 0.12 s before the pause is
noticed, and 0.03 s before it fades (medians of 65 recordings)."""

EndReason = Literal["silence", "max_length", "source_ended", "no_speech"]


@dataclass(frozen=True, slots=True, eq=False)
class Utterance:
    """What was said, as sound."""

    samples: Samples  # shape (n,), 16 kHz, from the pre-roll to the tail
    start: float  # stream time of the first sample, s
    end: float  # stream time after the last sample, s
    speech_s: float  # frames judged to be speech, s
    lead: Lead | None = None  # what was said right before it, where that is known

    @property
    def duration(self) -> float:
        """Length of the sound, s."""
        return len(self.samples) / RATE


@dataclass(frozen=True, slots=True)
class Started:
    """Speech is confirmed; it began at stream time ``at`` (s)."""

    at: float


@dataclass(frozen=True, slots=True)
class Ended:
    """The machine is done. ``utterance`` is None when nobody spoke."""

    reason: EndReason
    utterance: Utterance | None


class Endpointer:
    """Finds one utterance. Push frames until it answers ``Ended``; then make another one.

    Lengths of the settings are rounded to whole frames, up for the silence and the pre-roll, down for the greatest
    length. ``silence_s`` and ``no_speech_s`` only run out in a frame without speech, so that a word that begins just
    then is heard. ``lead`` is what was said right before the first frame; it is of no account for an utterance that
    begins later.
    """

    def __init__(self, settings: Endpoint, lead: Lead | None = None) -> None:
        self._lead = lead
        self._start_frames = _frames_up(settings.start_s)
        self._usual_silence = self._silence_frames = _frames_up(settings.silence_s)
        self._max_frames = max(self._start_frames, _frames_down(settings.max_length_s))
        self._no_speech_frames = _frames_up(settings.no_speech_s)
        self._tail_frames = min(_frames_up(TAIL_S), self._usual_silence)
        pre_roll = _frames_up(settings.pre_roll_s)
        self._before: deque[Frame] = deque(maxlen=pre_roll)  # pre-roll; frames enter when no speech run holds them
        self._run: list[Frame] = []  # speech in a row that is not confirmed yet
        self._frames: list[Frame] = []  # the utterance, with its pre-roll
        self._pre_roll = 0  # how many of them are pre-roll
        self._pushed = 0
        self._silence = 0  # frames since speech was last certain
        self._resumed = 0  # speech frames in a row within that silence
        self._speech = 0
        self._faded = 0  # frames for which the voice has been fading, or was when it paused
        self._fade_counts = False
        self._concluded = False
        self._ended = False

    @property
    def in_speech(self) -> bool:
        """Between ``Started`` and ``Ended``."""
        return bool(self._frames) and not self._ended

    @property
    def pause(self) -> int:
        """Frames of the pause so far, 0 while somebody speaks. A click in it does not end it."""
        return self._silence

    @property
    def fading(self) -> bool:
        """Somebody speaks, and may be about to pause."""
        return self._faded > 0 and not self._silence

    @property
    def is_over(self) -> bool:
        """Somebody has spoken, and no more silence is waited for: :meth:`finish` ends that as the next frame would."""
        word = self._resumed > 0  # that has just begun: it is heard first
        fade = min(self._faded, FADE_FRAMES) if self._fade_counts else 0
        silent = self._silence > 0 and self._silence + fade >= self._silence_frames and not word
        return self.in_speech and (silent or self._concluded)

    @property
    def lead(self) -> Lead | None:
        """What was said right before the utterance, once that has begun."""
        return self._lead if self._frames else None

    @property
    def so_far(self) -> Samples:
        """The sound of the utterance up to now, with its pre-roll and the pause."""
        return np.concatenate([frame.samples for frame in self._frames])

    def wait(self, silence_s: float, *, with_fade: bool = False) -> None:
        """In this pause, so much silence ends the utterance, and ``with_fade`` so does less after a voice that faded;
        in the next one it is as usual again."""
        self._silence_frames = _frames_up(silence_s)
        self._fade_counts = with_fade

    def conclude(self) -> None:
        """All has been said: the next frame ends the utterance, whatever is heard in it."""
        self._concluded = True

    def forget(self) -> None:
        """What somebody has said so far was no utterance: wait for one, no longer than if nothing had been said."""
        new = len(self._frames) - self._resumed  # a word that has just begun may be it
        self._before.extend(self._frames[:new])
        self._run, self._frames = self._frames[new:], []
        self._silence_frames = self._usual_silence
        self._silence = self._resumed = self._speech = 0
        self._faded, self._fade_counts, self._concluded = 0, False, False
        self._lead = None

    def push(self, frame: Frame, vad: VadResult) -> Started | Ended | None:
        """Take the next frame. Raises ``RuntimeError`` after the end."""
        if self._ended:
            raise RuntimeError("the utterance has ended; every utterance needs an Endpointer of its own")
        self._pushed += 1
        return self._during(frame, vad) if self._frames else self._waiting(frame, vad)

    def finish(self) -> Ended:
        """No frame comes any more, since enough has been heard or the source has ended: so does the utterance."""
        if not self._frames and self._run:  # a word cut off by the end of the sound
            self._begin()
        return self._end("silence" if self.is_over else "source_ended", trim=True)

    def _waiting(self, frame: Frame, vad: VadResult) -> Started | Ended | None:
        if vad.speech:
            self._run.append(frame)
            if len(self._run) < self._start_frames:
                return None
            self._begin()
            return Started(self._frames[self._pre_roll].end - FRAME_S)
        self._before.extend(self._run)
        self._run.clear()
        self._before.append(frame)
        return self._end("no_speech", trim=False) if self._pushed >= self._no_speech_frames else None

    def _begin(self) -> None:
        self._pre_roll = len(self._before)
        self._speech = len(self._run)
        self._frames = [*self._before, *self._run]
        if len(self._frames) < self._pushed:
            self._lead = None  # there was a pause

    def _during(self, frame: Frame, vad: VadResult) -> Ended | None:
        self._frames.append(frame)
        self._speech += vad.speech
        self._resumed = self._resumed + 1 if vad.speech else 0
        if self._resumed >= RESUME_FRAMES or (vad.speech and not self._silence):
            faded = 0 if self._silence else self._faded  # before a pause that is over by now
            self._silence = 0
            self._silence_frames, self._fade_counts = self._usual_silence, False
            self._faded = faded + 1 if vad.probability < FADING else 0
        else:
            self._silence += 1
        if self.is_over:
            return self._end("silence", trim=True)
        if len(self._frames) - self._pre_roll >= self._max_frames:
            return self._end("max_length", trim=False)
        return None

    def _end(self, reason: EndReason, *, trim: bool) -> Ended:
        self._ended = True
        if not self._frames:
            return Ended(reason, None)
        surplus = max(0, self._silence - self._tail_frames) if trim else 0
        kept = self._frames[: len(self._frames) - surplus]
        return Ended(
            reason,
            Utterance(
                samples=np.concatenate([frame.samples for frame in kept]),
                start=kept[0].end - FRAME_S,
                end=kept[-1].end,
                speech_s=self._speech * FRAME_S,
                lead=self._lead,
            ),
        )


def _frames_up(seconds: float) -> int:
    """Whole frames that last at least ``seconds``; a rounding error is no frame."""
    return math.ceil(seconds / FRAME_S - 1e-9)


def _frames_down(seconds: float) -> int:
    return math.floor(seconds / FRAME_S + 1e-9)
