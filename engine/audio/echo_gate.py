"""Which sound near a loudspeaker that speaks is somebody else's, and silence for the rest."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np

from engine.audio.echo_path import BLOCK, PARTITIONS, Sound


class Gate:
    """Fades what is the robot's own in what the filter has left.

    Somebody else is heard where, in enough bands of the spectrum, the filter took little away *and* what is left is not
    much less than the echo of what was played in the last quarter of a second can be (a long reverberation is nothing
    that the filter takes away). Until the filter has learnt enough, everything is taken for the robot's own; where no
    echo was found after some seconds, there is none.
    """

    EDGES: Final = np.unique(np.round(np.geomspace(4, 230, 25)).astype(int))
    """Bins of the bands: 125 Hz to 7.2 kHz."""
    CLOSED: Final = 10 ** (-50 / 20)
    HOLD: Final = 14
    """Blocks for which somebody who was heard counts as speaking on: 0.22 s, as long as a pause in a word."""
    OPEN: Final = 0.4
    """Share of the spectrum that must be somebody else's…"""
    SURE: Final = 2
    """…in so many blocks in a row: a single one may be a mistake."""
    LEFT: Final = 0.25
    """What is left of a band in which somebody else is heard, at least: -6 dB."""
    BELOW: Final = 0.15
    """How far below the usual echo that may be: -8 dB."""
    WORD: Final = 56
    """Blocks (0.9 s) in which a word is said, and…"""
    IN_A_WORD: Final = 0.25
    """…the share of them in which whoever says it is heard, in at least…"""
    OF_A_WORD: Final = 0.3
    """…this share of the spectrum."""
    LAST: Final = 120
    """Blocks of sound (2 s) within which an echo will be found, where there is one."""
    SOUNDS: Final = 1.0
    """Power of a band that sounds."""
    REMOVED_DB: Final = 9.0
    """When so much is taken away, the filter has learnt enough, but not…"""
    SETTLED: Final = 250
    """…within so many blocks of sound (4 s): it takes much away now and then before it does at all times."""

    def __init__(self) -> None:
        bands = len(self.EDGES) - 1
        self._decay = 0.75 ** np.arange(PARTITIONS, dtype=np.float32)[:, None]
        self._window = np.hanning(2 * BLOCK).astype(np.float32)
        self._before = np.zeros((2, BLOCK), np.float32)
        self._floor = np.full(bands, 1e-4)
        self._powers = np.zeros((2, bands))
        self._usual = np.zeros(bands)  # power of the echo by the power that was played
        self._removed = 0.0  # dB
        self._learnt = False
        self._sounding = 0  # blocks
        self._heard: deque[bool] = deque(maxlen=self.WORD)
        self.echoes = False
        """There surely is an echo."""
        self._lasts = 0  # blocks: for so long somebody else is heard without a gap
        self._open = 0
        self._gain = 1.0
        self.likely = 0.0
        """Newest share of the spectrum that is somebody else's."""

    @property
    def alone(self) -> bool:
        """A word that was heard just now was the robot's own."""
        return self._learnt and sum(self._heard) < self.IN_A_WORD * self.WORD

    @property
    def learnt(self) -> bool:
        """The filter has taken most of the echo away, once."""
        return self._learnt

    @property
    def removed_db(self) -> float:
        """How much quieter the filter makes what is heard, dB."""
        return self._removed

    def pass_on(self, heard: Sound, left: Sound, played: Sound) -> Sound:
        """One block: what was heard, what is left of it, and the power of what was played (PARTITIONS, BINS)."""
        both = np.stack((heard, left))
        spectra = np.abs(np.fft.rfft(np.concatenate((self._before, both), axis=1) * self._window, axis=1)) ** 2
        self._before = both
        self._powers = 0.5 * self._powers + 0.5 * np.add.reduceat(spectra, self.EDGES, axis=1)[:, :-1]
        whole, rest = self._powers
        own = np.add.reduceat(np.sum(self._decay * played, axis=0), self.EDGES)[:-1] + np.float32(1e-9)
        self._floor = np.minimum(np.maximum(self._floor, 1e-6) * 1.003, rest + 1e-7)
        audible = rest > 6 * self._floor
        other = (rest > self.LEFT * whole) & (rest > self.BELOW * self._usual * own) & audible
        self.likely = float(other.sum() / max(4, audible.sum()))
        self._learn(heard, left, own)
        self._lasts = self._lasts + 1 if self.likely > self.OPEN else 0
        self._open = self.HOLD if self._lasts >= self.SURE else max(0, self._open - 1)
        self._sounding += float(own.max()) > self.SOUNDS
        unknown = self.echoes or 0 < self._sounding < self.LAST
        own_only = not self._open if self._learnt else unknown
        self._heard.append(self.likely > self.OF_A_WORD)
        target = self.CLOSED if own_only else 1.0
        ramp = np.linspace(self._gain, target, BLOCK) if target != self._gain else target
        self._gain = target
        return np.asarray(left * ramp)

    def _learn(self, heard: Sound, left: Sound, own: Sound) -> None:
        """How much is taken away, and how loud the echo usually is; from bands in which nobody else is heard."""
        whole, rest = self._powers
        before, after = float(np.mean(heard**2)), float(np.mean(left**2))
        if before < 1e-7:
            return
        self._removed += 0.05 * (10 * np.log10(before / (after + 1e-12)) - self._removed)
        self._learnt |= self._removed > self.REMOVED_DB and self._sounding > self.SETTLED
        clear = (rest < self.LEFT * whole) & (own > 0.01 * own.max())
        self._usual = np.where(clear, self._usual + 0.1 * (whole / own - self._usual), self._usual)
