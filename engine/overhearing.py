"""Overhearing: a stop that is said without a wake, while the robot moves or speaks.

What a live source hears is watched for speech. As soon as somebody has said as much as a stop, at the first short
pause, and every half second while they talk on, the newest stretch is recognised in one quick pass, and a stop in it is
told at once in the recogniser's thread, so that stopping waits for no loop. Everything else that people around the
robot say is forgotten: it is neither published nor logged.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from engine.asr.recogniser import Recogniser, Rejected
from engine.audio.source import FRAME_S, Frame, Samples
from engine.audio.vad import VoiceActivity
from engine.errors import ModelError

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
class Alert:
    """What is listened for without a wake, and who is told. ``is_stop`` and ``on_words`` are called in the recogniser's
    thread."""

    vad: VoiceActivity  # of its own: a detector remembers what it heard
    is_stop: Callable[[str], bool]
    on_words: Callable[[str], None]  # told of the words that hold a stop, as they were recognised


class Overhearing:
    """Recognises what is said while it is on; never, where there is nobody to alert. Belongs to the loop's thread.

    ``worker`` is the one thread in which ``recogniser`` works: what waits there is replaced by what is newer, and
    :meth:`drop` takes it out, so that it never delays anything else by more than the decoding that is running.
    """

    def __init__(self, alert: Alert | None, recogniser: Recogniser, worker: Executor) -> None:
        self._alert = alert
        self._recogniser = recogniser
        self._worker = worker
        self._on = False
        self._period = object()  # replaced whenever what was heard before is to be forgotten; in any thread
        self._watched: object = None  # the period that the watch belongs to
        self._watch = SpeechWatch()
        self._works: set[asyncio.Future[None]] = set()

    def switch(self, on: bool) -> None:
        """Listen from now on, or not any more; either way, what was heard before does not count."""
        if on != self._on:
            self._on = on
            self.drop()

    def drop(self) -> None:
        """Forget what was heard and is not told yet."""
        self._period = object()
        for work in tuple(self._works):
            work.cancel()

    def push(self, frame: Frame) -> None:
        """Take the next frame of a live source."""
        alert = self._alert
        if not self._on or alert is None:
            return
        period = self._period
        if self._watched is not period:
            self._watched, self._watch = period, SpeechWatch()
            alert.vad.reset()
        sound = self._watch.push(frame, alert.vad.process(frame).speech)
        if sound is None:
            return
        for waiting in tuple(self._works):
            waiting.cancel()  # of no effect on one that is running
        work = asyncio.get_running_loop().run_in_executor(self._worker, self._recognise, alert, sound, period)
        self._works.add(work)
        work.add_done_callback(self._works.discard)

    def _recognise(self, alert: Alert, sound: Samples, period: object) -> None:
        """In the recogniser's thread."""

        def dropped() -> bool:
            return self._period is not period

        if dropped():
            return
        try:
            # no vocabulary: a prompt makes a recogniser hear in noise what it was prompted with
            found = self._recogniser.transcribe(sound * np.float32(1 / 32768), cancelled=dropped, quick=True)
        except ModelError:
            return  # whoever wants to be understood next is told the same
        if isinstance(found, Rejected) and found.reason != "low_confidence":
            return  # a doubtful stop is a stop; sound that is no speech is none
        if alert.is_stop(found.text) and not dropped():
            self._period = object()  # the same word is not told twice
            alert.on_words(found.text)


class SpeechWatch:
    """When to recognise what: a pure state machine over frames and whether there is speech in them."""

    def __init__(self) -> None:
        self._frames: deque[Frame] = deque(maxlen=_frames(LONGEST_S))  # the pre-roll, and the speech so far
        self._speech = 0  # frames of speech in a row, until speech has begun
        self._begun = False
        self._quiet = 0  # frames since the last one with speech
        self._next = 0  # frames until something is to be recognised though there is no pause
        self._said = False  # whether there was speech since the last pause

    def push(self, frame: Frame, speech: bool) -> Samples | None:
        """Take the next frame; gives the sound to recognise when it is time to."""
        self._frames.append(frame)
        if not self._begun:
            self._wait_for_speech(speech)
            return None
        self._next -= 1
        if speech:
            self._quiet, self._said = 0, True
            return self._ask(TALKING_S) if self._next <= 0 else None
        self._quiet += 1
        if self._quiet >= END_FRAMES:
            self._begun, self._speech = False, 0
            self._keep(PRE_ROLL_FRAMES)
        elif self._quiet >= PAUSE_FRAMES and self._said:
            self._said = False
            return self._ask(LONGEST_S)
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

    def _ask(self, longest_s: float) -> Samples:
        self._next = TALKING_FRAMES
        newest = list(self._frames)[-_frames(longest_s) :]
        return np.concatenate([frame.samples for frame in newest])


def _frames(seconds: float) -> int:
    return round(seconds / FRAME_S)
