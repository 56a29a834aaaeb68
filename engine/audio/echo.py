"""The robot does not hear itself: what its loudspeaker plays is taken out of what its microphone hears.

An adaptive filter (``engine.audio.echo_path``) subtracts the echo that it predicts and leaves everybody else's words as
they were. What it cannot predict (a long reverberation, a loudspeaker that distorts, a room that it does not know yet)
is compared with what is being played: sound that is no louder than the echo usually is, in all bands of the spectrum,
is the robot's own and fades away; when somebody else is heard in it, nothing fades.

The microphone's clock and the loudspeaker's are two, and nobody knows how long the way between them is: it is looked
for by correlation, followed sample by sample, and two clocks that drift apart are found out by what the filter learns.
While nothing sounds, sound passes as it is.
"""

from __future__ import annotations

from collections import deque
from typing import Final, NamedTuple, Protocol

import numpy as np

from engine.audio.echo_gate import Gate
from engine.audio.echo_path import BLOCK, PARTITIONS, EchoPath, Sound, Spectrum
from engine.audio.echo_search import Search, shift_between
from engine.audio.source import RATE, Samples

TAIL_S: Final = 0.4
"""How long after the last sound an echo of it may be heard, s, besides the delay of the devices."""
LOST_S: Final = 0.03
"""When sound comes so much earlier or later than it should, some was lost, s."""
STAMPS: Final = 64
"""Frames (2 s) of which the early ones say when sound comes: a busy machine is late with some, and never early."""

_TAPS: Final = 16  # of the interpolation between two samples
_PHASES: Final = 256  # moments between two samples that are told apart
_ALIGNED: Final = 256  # samples: how far into the filter the beginning of an echo is put…
_SOONEST, _LATEST = 16, round(0.6 * BLOCK * PARTITIONS)  # …unless it is between these
_STAYS: Final = 6  # samples: an echo that comes so much later than before has not moved
_LEARN_BLOCKS: Final = 32  # after which the drift is looked at
_KNOWS_DB: Final = 2.0  # what the filter takes away when what it has learnt means something
_MOST_DRIFT: Final = 300e-6


def _interpolation() -> Sound:
    """(_PHASES + 1, _TAPS): a windowed sinc for each moment between two samples."""
    away = np.arange(-_TAPS // 2 + 1, _TAPS // 2 + 1) - np.arange(_PHASES + 1)[:, None] / _PHASES
    shape = np.sinc(away) * (0.5 + 0.5 * np.cos(np.pi * np.clip(away / (_TAPS / 2), -1, 1)))
    return np.asarray(shape, np.float32)


_BETWEEN: Final = _interpolation()


class Cleaned(NamedTuple):
    """A frame without the robot's own voice."""

    left: Samples  # what is predicted is subtracted, and nothing else done
    others: Samples  # besides, faded where nobody else is heard


class Played(Protocol):
    """What a loudspeaker plays."""

    @property
    def last(self) -> float:
        """When the last sound ended, or will end, of the loop's clock, s."""
        ...

    def samples(self, first: int, count: int) -> Samples:
        """What sounds from that sample of the loop's clock on, at 16 kHz."""
        ...


class EchoCanceller:
    """Takes one source's frames in their order. Belongs to one thread."""

    def __init__(self, played: Played) -> None:
        self._played = played
        self._path = EchoPath()
        self._gate = Gate()
        self._search = Search()
        self.drift = 0.0
        """How much faster the loudspeaker's clock goes than the microphone's, of 1."""
        self.alone = False
        """A word that was heard just now was the robot's own: whoever listens for words hears an echo that is not quite
        gone. Any thread."""
        self._lag = 0.0  # s: how late sound comes, as far as the filter need not know
        self._stamps: deque[float] = deque(maxlen=STAMPS)  # when sound came, less how much there was
        self._heard = 0  # samples
        self._at: float | None = None  # the sample of the loop's clock that is played to the next one that is heard
        self._active = False
        self._late: int | None = None  # samples: where in the filter the echo begins
        self._snapshot: Spectrum | None = None  # of the path, half a second ago
        self._blocks = 0  # since then

    @property
    def knows(self) -> bool:
        """It has heard the loudspeaker long enough to tell its echo from everybody else. Any thread."""
        return self._gate.learnt

    @property
    def sounds(self) -> bool:
        """What is heard now has something of the robot's own in it, or had just now. Any thread."""
        return self._active

    def reset(self) -> None:
        """Another source begins, with another clock and perhaps elsewhere."""
        self._path, self._gate, self._search = EchoPath(), Gate(), Search()
        self._lag = self.drift = 0.0
        self._stamps.clear()
        self._heard, self._at, self._active, self._late = 0, None, False, None
        self.alone = False

    def clean(self, frame: Samples, at: float) -> Cleaned | None:
        """The frame, shape (512,), without what is the robot's own; None: there is nothing of it in there. ``at``: when
        it came, of the loop's clock, s."""
        self._heard += len(frame)
        self._stamps.append(at - self._heard / RATE)
        now = sorted(self._stamps)[len(self._stamps) // 5] + self._heard / RATE
        wanted = (now - self._lag) * RATE - len(frame)
        if self._at is None or abs(self._at - wanted) > LOST_S * RATE:
            self._at = wanted
            self._path.begin()
        position, self._at = self._at, self._at + len(frame) * (1 + self.drift)
        self.alone = False
        if position / RATE > self._played.last + TAIL_S:
            if self._active:
                self._active = False
                self._path.begin()
            return None
        if not self._active:
            self._active = True
            self._path.begin()
            self._search.begin()
            self._snapshot, self._blocks = None, 0
        return self._cancel(frame, position)

    def _cancel(self, frame: Samples, position: float) -> Cleaned:
        heard = frame * np.float32(1 / 32768)
        played = self._read(position, len(frame))
        cleaned = np.empty((2, len(frame)), np.float32)
        for start in range(0, len(frame), BLOCK):
            block = slice(start, start + BLOCK)
            own = self._path.predict(played[block])
            left = heard[block] - own
            self._path.learn(left)
            cleaned[0, block] = left
            cleaned[1, block] = self._gate.pass_on(heard[block], left, self._path.power)
        self._follow(heard, played)
        self.alone = self._gate.alone
        left, others = np.clip(np.rint(cleaned * 32768), -32768, 32767).astype(np.int16)
        return Cleaned(left, others)

    def _read(self, position: float, count: int) -> Sound:
        """What is played from a moment between two samples on, the drift made good."""
        first = int(np.floor(position)) - _TAPS // 2 + 1
        whole = self._played.samples(first, count + _TAPS + 1) * np.float32(1 / 32768)
        where = (position - first) + np.arange(count) * (1 + self.drift)
        nearest = where.astype(np.int64)
        phases = np.rint((where - nearest) * _PHASES).astype(np.int64)
        windows = np.lib.stride_tricks.sliding_window_view(whole, _TAPS)[nearest - _TAPS // 2 + 1]
        return np.asarray(np.einsum("ij,ij->i", windows, _BETWEEN[phases]))

    def _follow(self, heard: Sound, played: Sound) -> None:
        """Look where the echo is, and how the clocks drift."""
        delay = self._search.push(heard, played)
        self._gate.echoes = self._search.evident
        if delay is not None and self._move(delay):
            self._search.begin()
            self._snapshot, self._blocks = None, 0
            return
        self._blocks += len(heard) // BLOCK
        if self._blocks >= _LEARN_BLOCKS:
            path, self._blocks = self._path.path.copy(), 0
            knows = self._gate.removed_db > _KNOWS_DB
            if self._snapshot is not None and knows:
                moved = shift_between(self._snapshot, path) / (_LEARN_BLOCKS * BLOCK)
                if abs(moved) < _MOST_DRIFT:
                    self.drift = float(np.clip(self.drift - 0.7 * moved, -_MOST_DRIFT, _MOST_DRIFT))
            self._snapshot = path if knows else None

    def _move(self, delay: int) -> bool:
        """The echo is so many samples late now: put it where the filter knows it, or can learn it; whether that was to
        be done."""
        if self._late is None and _SOONEST <= delay <= _LATEST:
            self._late = delay
        known = _ALIGNED if self._late is None else self._late
        if abs(delay - known) <= _STAYS:
            return False
        assert self._at is not None
        self._at -= delay - known
        self._lag += (delay - known) / RATE
        if self._late is None:
            self._path.shift(delay - known)
            self._path.doubt()
            self._late = known
        self._path.begin()
        return True
