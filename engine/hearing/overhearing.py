"""Overhearing: a stop that is said without a wake, while the robot moves or speaks.

What a live source hears is watched for speech. As soon as somebody has said as much as a stop, at the first short
pause, and every half second while they talk on, the newest stretch is recognised in one quick pass, and a stop in it is
told at once in the recogniser's thread, so that stopping waits for no loop. Everything else that people around the
robot say is forgotten: it is neither published nor logged.

Whoever spots words (``engine.wake``) may *suspect* a stop: then the newest stretch is recognised at once, and this once
the recogniser is told which word to expect. That makes it hear the word in noise, but also where it is not, which is
why it never is without a suspicion. Of what is as short as 停 it is not asked for a text, in which it hardly ever
writes the right one of many characters that sound alike, but how likely it is that this was said, and nothing else; and
again a little later, for 听 and 冬 begin many sentences.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.audio.source import FRAME_S, Frame, Samples
from engine.audio.vad import VoiceActivity
from engine.errors import SaysoError
from engine.han import is_chinese

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

SUSPECTED_S = 1.5
"""How much is recognised on a suspicion, s: the word, and what makes it another one."""

SECOND_FRAMES = 9
"""Frames after a suspicion (0.3 s) until somebody who talks on is listened to a second and last time."""

CONFIDENT = 0.55
"""Confidence below which a Chinese stop in the middle of what somebody says may be the beginning of another word: there
is no gap in "你等" and "你能再". At the next pause, with all that was said, it counts whatever the confidence, and in
English it does anyhow: noise can hide a pause, and one English stop in sixteen at 10 dB would be lost."""

SURE_LOGPROB = -1.0
"""A stop that was expected counts from this mean log-probability on when the spotter was sure…"""

DOUBTFUL_LOGPROB = -0.6
"""…and from this one when it was not. Of those that somebody said most do, in noise too; of other words, few."""

SAID: Final[Mapping[str, Sequence[str]]] = {"停": ("停", "停下", "停下来", "停下來", "停止", "别动", "別動")}
"""What may have been said where a phrase is suspected that is known by its likelihood."""

ALONE_FRAMES = 6
"""Frames after such a suspicion (0.2 s) until it shows whether that was all that was said."""

AT_ONCE = -2.0
"""Such a stop counts from this likelihood on while it may be the beginning of more…"""

ALONE = -6.0
"""…and from this one on when it was all. Most stops of three voices are likelier, at 10 dB too; in 26 minutes of talk
by two of them nothing was."""

NEARLY = -7.5
"""Where it was less likely, but more than this, it counts when it is so again in a later look. In noise one in sixteen
such stops is found by that; of 21 minutes of that talk, half of it in noise, nothing else was that likely twice."""

AGAIN_FRAMES = 3
"""Frames (0.1 s) after the look that tells most until that one."""

Verdict = Literal["stop", "nearly", "none", "unknown"]
"""What a stretch of sound held; nearly: another look will tell; unknown: nobody listened to it."""


@dataclass(frozen=True, slots=True)
class Alert:
    """What is listened for without a wake, and who is told. ``is_stop`` and ``on_words`` are called in the recogniser's
    thread."""

    vad: VoiceActivity  # of its own: a detector remembers what it heard
    is_stop: Callable[[str], bool]
    on_words: Callable[[str], None]  # told of the words that hold a stop, as they were recognised


@dataclass(frozen=True, slots=True)
class Stretch:
    """Sound in which somebody speaks; ``ended``: up to a pause, not in the middle."""

    samples: Samples
    ended: bool


@dataclass(frozen=True, slots=True)
class _Look:
    """What the recogniser is asked on a suspicion."""

    samples: Samples  # the newest stretch
    phrases: Sequence[str]
    sure: bool
    later: bool  # long enough after the suspicion for what else was said to be in it
    again: bool  # it was nearly a stop in the look before

    @property
    def likely(self) -> float:
        """The likelihood from which on a short one was said."""
        return NEARLY if self.again else ALONE if self.later else AT_ONCE


@dataclass(slots=True)
class _Suspicion:
    """That somebody has just said one of ``phrases``."""

    phrases: list[str]
    sure: bool
    settled: Callable[[], None]
    likelier: Callable[[], None]
    looks: set[asyncio.Future[Verdict]] = field(default_factory=set)  # that are not over
    looked: int = 0  # looks that are
    due: int | None = ALONE_FRAMES  # frames after which to look at what is short; None: nothing more to be seen
    nearly: bool = False  # it was, in the look that tells most
    held: Stretch | None = None  # what else is to be recognised, but must not be in the way of that
    frames: int = 0  # that have come since

    @property
    def short(self) -> bool:
        """One of them is known by its likelihood."""
        return any(phrase in SAID for phrase in self.phrases)

    @property
    def waits(self) -> bool:
        """It is short, and the look that tells most is not over."""
        return self.short and (self.due is not None or bool(self.looks))

    @property
    def soon(self) -> bool:
        """The look that tells most would wait for the answer to one that is taken now."""
        return self.due is not None and self.due - self.frames <= AGAIN_FRAMES < self.due

    def is_due(self, *, paused: bool) -> bool:
        """It is time to look again; ``paused``: who spoke has just stopped."""
        if self.short:
            return self.due is not None and self.frames >= self.due
        return self.frames >= SECOND_FRAMES or paused

    def is_over(self, *, talking: bool) -> bool:
        """No look is missing but those that are not over."""
        return self.due is None if self.short else self.looked >= (2 if talking else 1)


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
        self._works: set[asyncio.Future[Verdict]] = set()
        self._newest: deque[Frame] = deque(maxlen=_frames(SUSPECTED_S))
        self._suspicion: _Suspicion | None = None

    @property
    def usable(self) -> bool:
        """There is somebody to alert, and it is on. Any thread."""
        return self._on and self._alert is not None

    @property
    def busy(self) -> bool:
        """Something is being recognised, or waits for that."""
        return bool(self._works)

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
        self._settle()

    def suspect(self, phrase: str, settled: Callable[[], None], likelier: Callable[[], None], *, sure: bool) -> None:
        """Somebody has just said ``phrase``, it seems, or it is even ``sure``: find out at once. ``settled`` is called
        when that is known, after whoever is to be alerted was; never, where the recogniser fails or no sound comes any
        more. ``likelier`` is called before that where it becomes more likely, and another look will tell."""
        if not self.usable:
            settled()
            return
        suspicion = self._suspicion
        if suspicion is None:
            suspicion = self._suspicion = _Suspicion([phrase], sure, settled, likelier)
        else:  # the same, or another one: one answer is enough
            suspicion.looked, suspicion.due, suspicion.nearly = 0, ALONE_FRAMES, False
            if not suspicion.short:  # else what is known by its likelihood would be known later each time
                suspicion.frames = 0
            suspicion.sure |= sure
            if phrase not in suspicion.phrases:
                suspicion.phrases.append(phrase)
        if phrase not in SAID or (sure and not suspicion.soon):
            self._look()

    def push(self, frame: Frame, others: Frame | None = None) -> None:
        """Take the next frame of a live source. ``others``: the same, with the robot's own voice faded out, to tell
        whether anybody speaks; what is recognised is ``frame``, which was only subtracted from."""
        alert = self._alert
        if not self._on or alert is None:
            return
        period = self._period
        if self._watched is not period:
            self._watched, self._watch = period, SpeechWatch()
            self._newest.clear()
            alert.vad.reset()
        self._newest.append(frame)
        said = self._watch.push(frame, alert.vad.process(others or frame).speech)
        suspicion = self._suspicion
        if suspicion is not None and suspicion.waits:
            suspicion.held = said or suspicion.held
        elif said is not None:
            self._ask(alert, said)
        if suspicion is not None:
            suspicion.frames += 1
            if not suspicion.looks and suspicion.is_due(paused=said is not None):
                self._look()

    def _look(self) -> None:
        """Recognise the newest stretch with the suspicion in mind."""
        suspicion = self._suspicion
        if self._alert is None or suspicion is None or not self._newest:
            return
        sound = np.concatenate([frame.samples for frame in self._newest])
        phrases, again = suspicion.phrases, suspicion.nearly
        if later := suspicion.short and suspicion.is_due(paused=False):
            suspicion.due, suspicion.frames = None, 0
        if again:
            phrases = [phrase for phrase in phrases if phrase in SAID]
        look = _Look(sound, tuple(phrases), suspicion.sure, later, again)
        suspicion.looks.add(self._ask(self._alert, look))

    def _ask(self, alert: Alert, what: Stretch | _Look) -> asyncio.Future[Verdict]:
        looks = self._suspicion.looks if self._suspicion is not None else set()
        for waiting in tuple(looks) if isinstance(what, _Look) else self._works - looks:
            waiting.cancel()  # of no effect on one that is running
        loop, period = asyncio.get_running_loop(), self._period
        work = loop.run_in_executor(self._worker, self._recognise, alert, what, period)
        self._works.add(work)
        work.add_done_callback(self._over)
        return work

    def _over(self, work: asyncio.Future[Verdict]) -> None:
        """One look or another is over, or was replaced by a newer one."""
        self._works.discard(work)
        suspicion = self._suspicion
        if suspicion is None:
            return
        looked = work in suspicion.looks
        suspicion.looks.discard(work)
        if work.cancelled():
            return
        verdict = work.result()
        if verdict == "unknown":
            self._suspicion = None  # and nobody will ever know
            return
        suspicion.looked += looked
        if verdict == "nearly":
            suspicion.nearly, suspicion.due = True, AGAIN_FRAMES
            suspicion.likelier()
        if verdict == "stop":
            self._settle()
        elif not suspicion.waits and self._alert is not None and suspicion.held is not None:
            self._ask(self._alert, suspicion.held)
            suspicion.held = None
        elif suspicion.is_over(talking=self._watch.talking) and not self._works:
            self._settle()

    def _settle(self) -> None:
        suspicion, self._suspicion = self._suspicion, None
        if suspicion is not None:
            suspicion.settled()

    def _recognise(self, alert: Alert, what: Stretch | _Look, period: object) -> Verdict:
        """In the recogniser's thread: whether there is a stop in the sound, which is told."""

        def dropped() -> bool:
            return self._period is not period

        if dropped():
            return "none"
        samples = what.samples * np.float32(1 / 32768)
        try:
            if isinstance(what, _Look):
                verdict, words = self._expected(alert, samples, dropped, what)
            else:
                verdict, words = self._overheard(alert, samples, dropped, ended=what.ended)
        except SaysoError:
            return "unknown"  # whoever wants to be understood next is told the same
        if dropped():
            return "none"
        if verdict == "stop":
            self._period = object()  # the same word is not told twice
            alert.on_words(words)
        return verdict

    def _overheard(
        self, alert: Alert, samples: NDArray[np.float32], dropped: Callable[[], bool], *, ended: bool
    ) -> tuple[Verdict, str]:
        """Whether there is a stop, and in which words. Raises ``SaysoError``."""
        # no vocabulary: a prompt makes a recogniser hear in noise what it was prompted with
        found = self._recogniser.transcribe(samples, (), dropped, quick=True)
        counts = _is_speech(found) if ended or not is_chinese(found.text) else _is_sure(found)
        return "stop" if counts and alert.is_stop(found.text) else "none", found.text

    def _expected(
        self, alert: Alert, samples: NDArray[np.float32], dropped: Callable[[], bool], look: _Look
    ) -> tuple[Verdict, str]:
        """The same where one is suspected."""
        expected, nearly = [], False
        for phrase in look.phrases:
            ways = SAID.get(phrase)
            likelihood = self._recogniser.likelihood(samples, ways, dropped) if ways is not None else None
            if likelihood is None:
                expected.append(phrase)
            elif likelihood >= look.likely:
                return "stop", phrase
            else:
                nearly |= look.later and likelihood >= NEARLY
        if expected and not dropped():
            found = self._recogniser.transcribe(samples, tuple(expected), dropped, quick=True)
            logprob = SURE_LOGPROB if look.sure else DOUBTFUL_LOGPROB
            if _is_likely(found, logprob) and alert.is_stop(found.text):
                return "stop", found.text
        return "nearly" if nearly else "none", ""


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


def _is_speech(found: Transcript | Rejected) -> bool:
    """A doubtful stop is a stop; sound that is no speech is none."""
    return isinstance(found, Transcript) or found.reason == "low_confidence"


def _is_sure(found: Transcript | Rejected) -> bool:
    """Somebody said it, whatever comes after it."""
    return isinstance(found, Transcript) and found.confidence >= CONFIDENT


def _is_likely(found: Transcript | Rejected, logprob: float) -> bool:
    """Whether what was expected was said, and not only not excluded."""
    return isinstance(found, Transcript) and found.decoding.avg_logprob >= logprob


def _frames(seconds: float) -> int:
    return round(seconds / FRAME_S)
