"""Wake words: spotters that hear a phrase in the sound, and the thread in which they listen.

The thread is their own, so that whoever reads the microphone does nothing but hand frames over, and the wake acts in
the moment in which the phrase is known, whatever else the engine does. A spotter says how long ago the phrase ended;
what was said since then belongs to the request, the phrase itself does not.
"""

from __future__ import annotations

import threading
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
BEHIND_S: Final = 10.0
"""With so much sound waiting, the machine cannot keep up, and the oldest is dropped."""


@dataclass(frozen=True, slots=True)
class Spotted:
    """A phrase was heard."""

    phrase: str
    at: int  # samples since the spotter's last reset, where it was known
    ended: int  # likewise, where the phrase ended
    sure: bool = True  # False: it may well have been something else


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

    def lets(self, at: int) -> bool:
        """Whether a detection at this sample is a new one."""
        if at < self._quiet_until:
            return False
        self._quiet_until = at + self._samples
        return True


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
        stops: Collection[str] = (),
    ) -> None:
        """``suspect`` is told of the phrases that are ``stops``; the others wake. ``fail`` is told of the fault that
        ended listening; ``prompt``: the thread goes before others, where the system allows it."""
        self._spotters = tuple(spotters)
        self._wake = wake
        self._fail = fail
        self._prompt = prompt
        self._suspect = suspect
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
        try:
            while not self._closed:
                samples = self._sound.get()
                if samples is None or self._is_behind(samples):
                    heard, refractory = 0, Refractory()
                    for spotter in self._spotters:
                        spotter.reset()
                    continue
                heard += len(samples)
                for spotter in self._spotters:
                    for spotted in spotter.push(samples):
                        if spotted.phrase in self._stops:
                            self._suspect(spotted)
                        elif refractory.lets(spotted.at):
                            waiting = self._sound.qsize() * len(samples)
                            ago = max(0.0, (heard + waiting - spotted.ended) / RATE)
                            self._wake(Wake("word", spotted.phrase, ago_s=ago))
        except Exception as error:  # noqa: BLE001 - nobody listens for the word any more: that must be told
            self._closed = True
            self._fail(error)

    def _is_behind(self, samples: NDArray[np.int16]) -> bool:
        """Whether so much waits that this piece is dropped: late wakes are worse than none."""
        if self._sound.qsize() * len(samples) <= BEHIND_S * RATE:
            return False
        self.dropped += 1
        return True
