"""Wake words: spotters that hear a phrase in the sound, and the thread in which they listen.

The thread is their own, so that whoever reads the microphone does nothing but hand frames over, and the wake acts in
the moment in which the phrase is known, whatever else the engine does. A spotter says how long ago the phrase ended;
what was said since then belongs to the request, the phrase itself does not. Of what it is not sure of, somebody is
asked who understands words, and the wake waits for the answer; the request does not, for its beginning is known.
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
    sure: bool = True  # False: it may well have been something else


Ask = Callable[[str, NDArray[np.int16], Callable[[], None]], None]
"""Asks somebody whether a phrase is what a sound (mono, 16 kHz) ends with, who calls back if it is, in any thread."""


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

    def is_over(self, at: int) -> bool:
        """Whether a detection at this sample would be a new one."""
        return at >= self._quiet_until

    def lets(self, at: int) -> bool:
        """Whether a detection at this sample is a new one."""
        if not self.is_over(at):
            return False
        self._quiet_until = at + self._samples
        return True


class Detections:
    """Which detections of a phrase are new ones. Those that are sure and those that are not count each for themselves:
    a doubtful one is often followed by one that is sure."""

    def __init__(self) -> None:
        self._sure, self._doubtful = Refractory(), Refractory()

    def lets(self, at: int, *, sure: bool) -> bool:
        """Whether one at this sample is new."""
        return (self._sure if sure else self._doubtful).lets(at)


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
        ask: Ask = lambda phrase, sound, said: None,
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
        self._woken = 0  # times
        self._answered = -1  # the sample of the newest detection that was found to be one
        self._waking = threading.Lock()
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
        refractory, asked = Refractory(), Refractory()
        heard = 0  # samples since the last reset
        newest = np.zeros(0, np.int16)  # of what was heard
        try:
            while not self._closed:
                samples = self._sound.get()
                if samples is None or self._is_behind(samples):
                    heard, newest, refractory, asked = 0, newest[:0], Refractory(), Refractory()
                    self._answered = -1
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
                        if not spotted.sure:
                            if refractory.is_over(spotted.at) and asked.lets(spotted.at):
                                sound = newest[: len(newest) - (heard - spotted.at)][-round(ASKED_S * RATE) :]
                                self._ask(spotted.phrase, sound, self._unless_woken(spotted, ago))
                        elif refractory.lets(spotted.at) and self._is_first(spotted.at):
                            self._wake(Wake("word", spotted.phrase, ago_s=ago))
        except Exception as error:  # noqa: BLE001 - nobody listens for the word any more: that must be told
            self._closed = True
            self._fail(error)

    def _is_first(self, at: int) -> bool:
        """Whether whoever was asked has not woken for the same phrase; from now on it is too late for that."""
        with self._waking:
            if 0 <= self._answered <= at < self._answered + REFRACTORY_S * RATE:
                return False
            self._woken += 1
            return True

    def _unless_woken(self, spotted: Spotted, ago_s: float) -> Callable[[], None]:
        """Wakes, unless somebody was sure meanwhile; in any thread."""
        before, began = self._woken, time.monotonic()

        def wake() -> None:
            with self._waking:
                if self._woken != before:
                    return
                self._woken += 1
                self._answered = spotted.at
            self._wake(Wake("word", spotted.phrase, ago_s=min(1.0, ago_s + time.monotonic() - began)))

        return wake

    def _is_behind(self, samples: NDArray[np.int16]) -> bool:
        """Whether so much waits that this piece is dropped: late wakes are worse than none."""
        if self._sound.qsize() * len(samples) <= BEHIND_S * RATE:
            return False
        self.dropped += 1
        return True
