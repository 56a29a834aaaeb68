"""What a microphone hears in a room where a loudspeaker plays and somebody speaks.

An echo is what was played through a small loudspeaker (no bass, a little distortion), a direct path and reflections
that die away, later by the latencies of two devices whose clocks drift apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import soxr
from numpy.typing import NDArray

from engine.audio.echo import EchoCanceller
from engine.audio.source import FRAME_SAMPLES, RATE, Samples

Sound = NDArray[np.float64]
"""±1, 16 kHz."""

VOICE = 10 ** (-26 / 20)
"""How loud a person is in the microphone, root of the mean square of ±1."""
NOISE = 10 ** (-62 / 20)
BEGUN = 1000.0
"""When it all begins, of the clock, s."""


@dataclass(frozen=True, slots=True)
class Room:
    """A room, two devices, and how loud the loudspeaker is."""

    delay_s: float = 0.06
    dies_s: float = 0.3  # until a sound is 60 dB quieter
    echo_db: float = 0.0  # the echo by a person's voice
    drift_ppm: float = 50.0
    seed: int = 3

    def echo(self, played: Sound) -> Sound:
        """What the microphone hears of it."""
        if not played.any():
            return np.zeros(len(played))
        heard = convolved(_drifted(_through_loudspeaker(played), self.drift_ppm), self._impulse())
        return np.asarray(heard * (VOICE * 10 ** (self.echo_db / 20) / loudness(heard)))

    def _impulse(self) -> Sound:
        random = np.random.default_rng(self.seed)
        count = round(self.dies_s * RATE)
        early, tail = np.zeros(count), random.normal(0, 1, count) * 10 ** (-3 * np.arange(count) / count)
        for at in random.integers(16, 800, 8):
            early[at] += random.uniform(-0.5, 0.5)
        early[0] = 1.0
        tail[: RATE // 250] = 0
        whole = early + tail * (0.6 / np.sqrt(np.sum(tail**2)))
        return np.concatenate((np.zeros(round(self.delay_s * RATE)), whole))


class Speaker:
    """A loudspeaker's reference as a player keeps it, in which everything is known from the beginning."""

    def __init__(self, played: Samples) -> None:
        loud = np.flatnonzero(played)
        self.last = BEGUN + (float(loud[-1]) + 1) / RATE if len(loud) else -np.inf
        self._played = played

    def samples(self, first: int, count: int) -> Samples:
        index = np.arange(count) + first - round(BEGUN * RATE)
        inside = (index >= 0) & (index < len(self._played))
        return np.where(inside, self._played[np.clip(index, 0, len(self._played) - 1)], 0).astype(np.int16)


def clean(
    canceller: EchoCanceller,
    heard: Samples,
    *,
    latency_s: float = 0.0,
    jitter_s: float = 0.002,
    alone: list[bool] | None = None,
) -> tuple[Samples, Samples]:
    """What a canceller makes of a recording that began when the speaker did, in whole frames: (left, others).
    ``latency_s``: from the sound to its frame, ``jitter_s`` how much later yet, on average. ``alone`` gets, for each
    frame, whether a word in it would be the robot's own."""
    random = np.random.default_rng(1)
    left, others = [], []
    for at in range(0, len(heard) // FRAME_SAMPLES * FRAME_SAMPLES, FRAME_SAMPLES):
        frame = heard[at : at + FRAME_SAMPLES]
        came = BEGUN + (at + FRAME_SAMPLES) / RATE + latency_s + random.exponential(jitter_s)
        found = canceller.clean(frame, came)
        if alone is not None:
            alone.append(canceller.alone)
        left.append(frame if found is None else found.left)
        others.append(frame if found is None else found.others)
    return np.concatenate(left), np.concatenate(others)


def said_in_turn(sounds: Sequence[Sound], *, pause_s: float, lead_s: float = 0.5) -> Sound:
    """One after the other, each at half of full scale."""
    parts = [np.zeros(round(lead_s * RATE))]
    for sound in sounds:
        parts += [sound * (0.5 / np.abs(sound).max()), np.zeros(round(pause_s * RATE))]
    return np.concatenate(parts)


def mixed(*sounds: Sound) -> Samples:
    """What a microphone makes of them, and of its own noise."""
    whole = np.random.default_rng(2).normal(0, NOISE, len(sounds[0])) + sum(sounds)
    return samples(whole)


def samples(sound: Sound) -> Samples:
    """16 bits."""
    return np.clip(np.rint(sound * 32768), -32768, 32767).astype(np.int16)


def loudness(sound: Sound) -> float:
    """Root of the mean square of its loud parts."""
    power = np.mean(sound[: len(sound) // 320 * 320].reshape(-1, 320) ** 2, axis=1)
    return float(np.sqrt(np.mean(power[power > power.max() * 1e-3])))


def decibels(before: NDArray[np.integer], after: NDArray[np.integer]) -> float:
    """How much quieter the second is, dB."""
    powers = [float(np.mean(sound.astype(np.float64) ** 2)) + 1e-3 for sound in (before, after)]
    return 10 * float(np.log10(powers[0] / powers[1]))


def convolved(sound: Sound, impulse: Sound) -> Sound:
    """A sound through a linear system, as long as it was."""
    size = 1 << (len(sound) + len(impulse)).bit_length()
    return np.fft.irfft(np.fft.rfft(sound, size) * np.fft.rfft(impulse, size), size)[: len(sound)]


def _through_loudspeaker(sound: Sound) -> Sound:
    """Nothing below 200 Hz, little above 7 kHz, and a few per cent of distortion at its loudest."""
    peak = float(np.abs(sound).max())
    bent = peak * (np.tanh(0.9 * sound / peak) / 0.9 + 0.03 * (sound / peak) ** 2)
    spectrum, frequencies = np.fft.rfft(bent), np.fft.rfftfreq(len(bent), 1 / RATE)
    high, low = 1 / np.sqrt(1 + (200 / np.maximum(frequencies, 1)) ** 4), 1 / np.sqrt(1 + (frequencies / 7000) ** 8)
    return np.fft.irfft(spectrum * high * low, len(bent))


def _drifted(sound: Sound, ppm: float) -> Sound:
    """The same by a clock that is so much slower."""
    if not ppm:
        return sound
    fine = soxr.resample(sound, RATE, 8 * RATE)
    return np.interp(np.arange(len(sound)) * (8 * (1 + ppm * 1e-6)), np.arange(len(fine)), fine)
