"""Overhearing: a stop that is said without a wake, while the robot moves or speaks.

What a live source hears is watched for speech (``speech_watch``), which is recognised in quick passes, and a stop in it
is told at once in the recogniser's thread, so that stopping waits for no loop. Everything else that people around the
robot say is forgotten: it is neither published nor logged.

Whoever spots words (``engine.wake``) may *suspect* a stop (``suspicion``): then the newest stretch is recognised at
once, and this once the recogniser is told which word to expect. That makes it hear the word in noise, but also where it
is not, which is why it never is without a suspicion.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.audio.source import FRAME_S, Frame
from engine.audio.vad import VoiceActivity
from engine.errors import SaysoError
from engine.han import is_chinese
from engine.hearing.speech_watch import SpeechWatch, Stretch
from engine.hearing.suspicion import NEARLY, SAID, SUSPECTED_S, Look, Suspicion, Verdict

CONFIDENT = 0.55
"""Confidence below which a Chinese stop in the middle of what somebody says may be the beginning of another word: there
is no gap in "你等" and "你能再". At the next pause, with all that was said, it counts whatever the confidence, and in
English it does anyhow: noise can hide a pause, and one English stop in sixteen at 10 dB would be lost."""

SURE_LOGPROB = -1.0
"""A stop that was expected counts from this mean log-probability on when the spotter was sure…"""

DOUBTFUL_LOGPROB = -0.6
"""…and from this one when it was not. Of those that somebody said most do, in noise too; of other words, few."""


class IsStop(Protocol):
    """Whether a text holds a stop."""

    def __call__(self, text: str, *, ended: bool = True) -> bool:
        """Not ``ended``: somebody talks on, and what is a stop only by itself ("wait") is none yet."""
        ...


@dataclass(frozen=True, slots=True)
class Alert:
    """What is listened for without a wake, and who is told. ``is_stop`` and ``on_words`` are called in the recogniser's
    thread."""

    vad: VoiceActivity  # of its own: a detector remembers what it heard
    is_stop: IsStop
    on_words: Callable[[str], None]  # told of the words that hold a stop, as they were recognised
    unasked: bool = True  # what is said is recognised; else only what a spotter is sure of


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
        self._newest: deque[Frame] = deque(maxlen=round(SUSPECTED_S / FRAME_S))
        self._suspicion: Suspicion | None = None

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
        alert = self._alert
        if not self._on or alert is None or not (sure or alert.unasked):
            settled()
            return
        suspicion = self._suspicion
        if suspicion is None:
            suspicion = self._suspicion = Suspicion([phrase], sure, settled, likelier)
        else:
            suspicion.repeat(phrase, sure=sure)
        if suspicion.is_urgent(phrase, sure=sure):
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
        if said is not None and alert.unasked:
            if suspicion is not None and suspicion.waits:
                suspicion.held = said
            else:
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
        look = suspicion.look(np.concatenate([frame.samples for frame in self._newest]))
        suspicion.looks.add(self._ask(self._alert, look))

    def _ask(self, alert: Alert, what: Stretch | Look) -> asyncio.Future[Verdict]:
        looks = self._suspicion.looks if self._suspicion is not None else set()
        for waiting in tuple(looks) if isinstance(what, Look) else self._works - looks:
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
            suspicion.look_again()
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

    def _recognise(self, alert: Alert, what: Stretch | Look, period: object) -> Verdict:
        """In the recogniser's thread: whether there is a stop in the sound, which is told."""

        def dropped() -> bool:
            return self._period is not period

        if dropped():
            return "none"
        samples = what.samples * np.float32(1 / 32768)
        try:
            if isinstance(what, Look):
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
        return "stop" if counts and alert.is_stop(found.text, ended=ended) else "none", found.text

    def _expected(
        self, alert: Alert, samples: NDArray[np.float32], dropped: Callable[[], bool], look: Look
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


def _is_speech(found: Transcript | Rejected) -> bool:
    """A doubtful stop is a stop; sound that is no speech is none."""
    return isinstance(found, Transcript) or found.reason == "low_confidence"


def _is_sure(found: Transcript | Rejected) -> bool:
    """Somebody said it, whatever comes after it."""
    return isinstance(found, Transcript) and found.confidence >= CONFIDENT


def _is_likely(found: Transcript | Rejected, logprob: float) -> bool:
    """Whether what was expected was said, and not only not excluded."""
    return isinstance(found, Transcript) and found.decoding.avg_logprob >= logprob
