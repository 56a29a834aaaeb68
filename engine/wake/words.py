"""Wake words: spotters that hear a phrase in the sound, and the thread in which they listen.

The thread is their own, so that whoever reads the microphone does nothing but hand frames over, and the wake acts in
the moment in which the phrase is known, whatever else the engine does. A spotter says how long ago the phrase ended;
what was said since then belongs to the request, the phrase itself does not. Where it is not sure, somebody is asked who
understands words, and the wake waits for the answer; the request does not, for its beginning is known. Where nobody
can be asked, the spotter's own opinion counts.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.commands import Wake
from engine.scheduling import raise_priority

RATE: Final = 16_000  # Hz
REFRACTORY_S: Final = 1.0
"""A phrase that is heard again so soon is the same one, s."""
ASKED_S: Final = 1.5
"""How much of the sound up to a detection is given to whoever is asked about it, s."""
BEHIND_S: Final = 10.0
"""With so much sound waiting, the machine cannot keep up, and the oldest is dropped."""


@dataclass(frozen=True, slots=True)
class Spotted:
    """A phrase was heard."""

    phrase: str
    at: int  # samples since the spotter's last reset, where it was known
    ended: int  # likewise, where the phrase ended
    likely: bool = True  # more likely than not: it counts where nobody can tell
    sure: bool = True  # nobody need be asked


Answer = Callable[[bool | None], None]
"""Whether a phrase was said; None: nobody can tell."""
Ask = Callable[[Spotted, NDArray[np.int16], Answer], None]
"""Asks somebody whether what was spotted is what a sound (mono, 16 kHz) ends with. The answer comes once, in any
thread; never, if the end comes before."""


def asked_about(sound: NDArray[np.int16], at: int) -> NDArray[np.int16]:
    """What of a sound is given to whoever is asked about a detection at this sample of it."""
    return sound[:at][-round(ASKED_S * RATE) :]


class Spotter(Protocol):
    """Hears one or several phrases. Belongs to one thread; what it finds does not depend on how sound is cut."""

    @property
    def phrases(self) -> Sequence[str]:
        """What it listens for."""
        ...

    def push(self, samples: NDArray[np.int16]) -> Sequence[Spotted]:
        """Take the next sound: mono, 16 kHz."""
        ...

    def reset(self) -> None:
        """What comes next has nothing to do with what came before."""
        ...


class Refractory:
    """Lets the first of several detections through."""

    def __init__(self, seconds: float = REFRACTORY_S) -> None:
        self._samples = round(seconds * RATE)
        self._quiet_until = 0
        self._lock = threading.Lock()

    def is_over(self, at: int) -> bool:
        """Whether a detection at this sample would be a new one."""
        return at >= self._quiet_until

    def lets(self, at: int) -> bool:
        """Whether a detection at this sample is a new one. Any thread."""
        with self._lock:
            if not self.is_over(at):
                return False
            self._quiet_until = at + self._samples
            return True


@dataclass(frozen=True, slots=True)
class Doubts:
    """Between which probabilities a spotter is not sure of a phrase."""

    above: float = 1.0
    below: float = 0.0


NO_DOUBTS: Final = Doubts()


class Detections:
    """What a spotter tells of a phrase whose probability it knows. From the ``threshold`` on it is likely; ``delay``:
    how long before it is known the phrase has ended, samples. What it is surer of counts as new: a doubtful detection
    is often followed by one that is sure."""

    def __init__(self, phrase: str, threshold: float, delay: int, doubts: Doubts = NO_DOUBTS) -> None:
        self._phrase = phrase
        self._threshold = threshold
        self._delay = delay
        self._doubts = doubts
        self._lately = (Refractory(), Refractory(), Refractory())

    def take(self, at: int, probability: float) -> Spotted | None:
        """What is to be told of how probable the phrase is at this sample."""
        likely = probability >= self._threshold
        sure = likely and probability >= self._doubts.below
        if not (likely or probability >= self._doubts.above) or not self._lately[likely + sure].lets(at):
            return None
        return Spotted(self._phrase, at, at - self._delay, likely, sure)


class WordListener:
    """Listens in a thread of its own until it is closed. ``wake``, ``suspect`` and ``fail`` are called in that thread.

    :meth:`push` and :meth:`reset` may be called from any one thread and return at once.
    """

    def __init__(
        self,
        spotters: Sequence[Spotter],
        wake: Callable[[Wake], None],
        fail: Callable[[Exception], None],
        *,
        prompt: bool,
        suspect: Callable[[Spotted], None] = lambda spotted: None,
        ask: Ask = lambda spotted, sound, answer: answer(None),
        stops: Collection[str] = (),
    ) -> None:
        """``suspect`` is told of the phrases that are ``stops``; the others wake, if the spotter is sure, or whoever is
        asked (``ask``). ``fail`` is told of the fault that ended listening; ``prompt``: the thread goes before others,
        where the system allows it."""
        self._spotters = tuple(spotters)
        self._wake = wake
        self._fail = fail
        self._prompt = prompt
        self._suspect = suspect
        self._ask = ask
        self._stops = frozenset(stops)
        self._sound: SimpleQueue[NDArray[np.int16] | None] = SimpleQueue()
        self._closed = False
        self._thread: threading.Thread | None = None
        self.dropped = 0
        """Pieces of sound that nobody had time to listen to."""

    @property
    def phrases(self) -> tuple[str, ...]:
        """What wakes."""
        return tuple(phrase for spotter in self._spotters for phrase in spotter.phrases if phrase not in self._stops)

    def start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="wake-words", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End. Not in the listener's own thread."""
        self._closed = True
        self._sound.put(None)
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def push(self, samples: NDArray[np.int16]) -> None:
        """The next sound of the source."""
        if not self._closed:
            self._sound.put(samples)

    def reset(self) -> None:
        """Another source begins."""
        self._sound.put(None)

    def _run(self) -> None:
        if self._prompt:
            raise_priority()
        refractory = Refractory()
        heard = 0  # samples since the last reset
        newest = np.zeros(0, np.int16)  # of what was heard
        try:
            while not self._closed:
                samples = self._sound.get()
                if samples is None or self._is_behind(samples):
                    heard, newest, refractory = 0, newest[:0], Refractory()
                    for spotter in self._spotters:
                        spotter.reset()
                    continue
                heard += len(samples)
                newest = np.concatenate((newest, samples))[-round(ASKED_S * RATE) - len(samples) :]
                for spotter in self._spotters:
                    for spotted in spotter.push(samples):
                        if spotted.phrase in self._stops:
                            self._suspect(spotted)
                            continue
                        waiting = self._sound.qsize() * len(samples)
                        ago = max(0.0, (heard + waiting - spotted.ended) / RATE)
                        wake = self._waking(spotted, ago, refractory)
                        if spotted.sure:
                            wake(True)
                        elif refractory.is_over(spotted.at):
                            self._ask(spotted, asked_about(newest, len(newest) - (heard - spotted.at)), wake)
        except Exception as error:  # noqa: BLE001 - nobody listens for the word any more: that must be told
            self._closed = True
            self._fail(error)

    def _waking(self, spotted: Spotted, ago_s: float, refractory: Refractory) -> Answer:
        """Wakes if the answer is yes and nothing has woken for the same phrase; in any thread."""
        began = time.monotonic()

        def wake(said: bool | None) -> None:
            if (spotted.likely if said is None else said) and refractory.lets(spotted.at):
                self._wake(Wake("word", spotted.phrase, ago_s=min(1.0, ago_s + time.monotonic() - began)))

        return wake

    def _is_behind(self, samples: NDArray[np.int16]) -> bool:
        """Whether so much waits that this piece is dropped: late wakes are worse than none."""
        if self._sound.qsize() * len(samples) <= BEHIND_S * RATE:
            return False
        self.dropped += 1
        return True
