"""How sound gets from a mouth to a microphone: other bodies, rooms, distances and noises, all made up and seeded.

Everything works on mono sound at 16 kHz in ±1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import soxr

from engine.wake.embedding import RATE, SPAN, STEP
from engine.wake.training.voices import Sound

TAIL: Final = round(0.28 * RATE)
"""How long after its end a phrase is still to be heard, samples: a microphone delivers late."""

USUAL_DB: Final = (5.0, 15.0)
"""How much louder than the noise somebody is who talks to a machine in a room where others live…"""
ANY_DB: Final = (-1.0, 30.0)
"""…and how much at all."""

Chance = np.random.Generator


def resampled(sound: Sound, chance: Chance) -> Sound:
    """A smaller or larger body that speaks faster or slower."""
    return np.asarray(soxr.resample(sound, RATE, RATE / chance.uniform(0.82, 1.22), quality="LQ"), np.float32)


def coloured(sound: Sound, chance: Chance) -> Sound:
    """Another microphone: a random curve over the octaves, and an end to the high ones now and then."""
    size = _smooth(len(sound))
    spectrum = np.fft.rfft(sound, size)
    octaves = np.linspace(0, 1, 7)
    gains = np.cumsum(chance.normal(0, 2.5, 7))
    curve = np.interp(np.linspace(0, 1, len(spectrum)) ** 0.4, octaves, gains - gains.mean())
    if chance.random() < 0.25:
        curve[round(len(spectrum) * chance.uniform(0.42, 0.8)) :] -= 25
    return np.fft.irfft(spectrum * 10 ** (curve / 20), size)[: len(sound)].astype(np.float32)


def in_a_room(sound: Sound, chance: Chance) -> Sound:
    """Direct sound, and an echo that dies away; as long as before."""
    length = round(RATE * chance.uniform(0.1, 0.5))
    decay = np.exp(-np.arange(length) * (6.9 / length))
    response = (chance.normal(0, 1, length) * decay).astype(np.float32)
    response *= chance.uniform(0.1, 0.6) / np.linalg.norm(response)
    response[0] = 1
    size = _smooth(len(sound) + length)
    return np.fft.irfft(np.fft.rfft(sound, size) * np.fft.rfft(response, size), size)[: len(sound)].astype(np.float32)


def noise(length: int, chance: Chance, babble: Sequence[Sound]) -> Sound:
    """Hiss, rumble, hum, a fan, people who talk, or two of these; of loudness 1."""
    kinds = [_hiss, _hum] if not babble else [_hiss, _hum, _hiss, lambda n, c: _talk(n, c, babble)]
    made = np.zeros(length, np.float32)
    for kind in chance.choice(len(kinds), chance.integers(1, 3)):
        part = kinds[kind](length, chance)
        made += part * np.float32(chance.uniform(0.3, 1) / max(loudness(part), 1e-9))
    return np.asarray(made / max(loudness(made), 1e-9), np.float32)


def with_noise(sound: Sound, snr_db: float, speech: float, made: Sound) -> Sound:
    """The sound, in which speech is ``speech`` loud, and noise so much quieter."""
    return np.asarray(sound + made * np.float32(speech * 10 ** (-snr_db / 20)), np.float32)


def loudness(sound: Sound) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(sound, dtype=np.float64)))) if len(sound) else 0.0


def spoilt(sound: Sound, chance: Chance, babble: Sequence[Sound], speech: float) -> Sound:
    """What a microphone makes of it: colour, room, noise, gain."""
    sound = coloured(sound, chance)
    if chance.random() < 0.6:
        sound = in_a_room(sound, chance)
    if chance.random() < 0.85:
        snr_db = chance.uniform(*(USUAL_DB if chance.random() < 0.5 else ANY_DB))
        sound = with_noise(sound, snr_db, speech, noise(len(sound), chance, babble))
    peak = float(np.abs(sound).max(initial=1e-6))
    return np.asarray(sound * np.float32(10 ** chance.uniform(-2.2, -0.05) / peak), np.float32)


def with_phrase(
    phrase: Sound, chance: Chance, before: Sequence[Sound], after: Sequence[Sound], babble: Sequence[Sound]
) -> Sound:
    """Somebody says it: after a silence or other words, and goes on talking or does not. Every window that ends in it
    ends within ``TAIL`` after it."""
    word = resampled(phrase, chance)
    rest = max(0, SPAN - len(word))
    lead = _quiet(rest, chance)
    if chance.random() < 0.3 and before:
        _lay(lead, before[int(chance.integers(len(before)))], end=rest - round(RATE * chance.uniform(0.05, 0.6)))
    tail = _quiet(TAIL + round(chance.uniform(0, 1) * STEP), chance)
    if chance.random() < 0.5 and after:
        start = round(RATE * chance.uniform(0, 0.3))
        going_on = after[int(chance.integers(len(after)))][: max(0, len(tail) - start)]
        tail[start : start + len(going_on)] += going_on
    word = word[-SPAN:]
    joined = np.concatenate((lead, word, tail))[round(chance.uniform(0, 1) * STEP * 0.5) :]
    return spoilt(joined, chance, babble, loudness(word))


def talk(sounds: Sequence[Sound], chance: Chance, babble: Sequence[Sound]) -> Sound:
    """Several of them, one after another with pauses, from silence to silence."""
    parts = [_quiet(round(SPAN * 0.6), chance)]
    for sound in sounds:
        parts += [resampled(sound, chance), _quiet(round(RATE * chance.uniform(0.05, 0.9)), chance)]
    parts.append(_quiet(round(SPAN * 0.7), chance))
    joined = np.concatenate(parts)
    speech = loudness(np.concatenate(list(sounds))) if sounds else 0.05
    return spoilt(joined, chance, babble, speech)


def silence(length: int, chance: Chance) -> Sound:
    """A quiet room, near to nothing at all."""
    if chance.random() < 0.15:
        return np.zeros(length, np.float32)
    made = noise(length, chance, ())
    return np.asarray(made * np.float32(10 ** chance.uniform(-5, -1.5)), np.float32)


def _smooth(length: int) -> int:
    """A length that a Fourier transform is quick with: a power of two, or three quarters of one."""
    size = 1 << (length - 1).bit_length()
    return size * 3 // 4 if size * 3 // 4 >= length else size


def _quiet(length: int, chance: Chance) -> Sound:
    return chance.standard_normal(length, np.float32) * np.float32(10 ** chance.uniform(-5, -3))


def _lay(on: Sound, sound: Sound, end: int) -> None:
    """Add a sound so that it ends there, as far as there is room."""
    if end > 0:
        part = sound[-end:]
        on[end - len(part) : end] += part


def _hiss(length: int, chance: Chance) -> Sound:
    """White to brown, and louder and quieter."""
    size = _smooth(length)
    spectrum = np.fft.rfft(chance.standard_normal(size, np.float32))
    tilt = np.maximum(np.arange(len(spectrum)), 1.0) ** -chance.uniform(0, 1.1)
    made = np.fft.irfft(spectrum * tilt, size)[:length]
    swell = 1 + chance.uniform(0, 0.7) * np.sin(np.arange(length) * (2 * np.pi * chance.uniform(0.2, 5) / RATE))
    return np.asarray(made * swell, np.float32)


def _hum(length: int, chance: Chance) -> Sound:
    """Mains, motors, and tones as of music."""
    base = float(chance.choice([50, 60, 100, chance.uniform(80, 500)]))
    turn = np.arange(length, dtype=np.float32) * np.float32(2 * np.pi * base / RATE)
    made = np.zeros(length, np.float32)
    for overtone in range(1, int(chance.integers(3, 9))):
        made += np.sin(turn * np.float32(overtone) + np.float32(chance.uniform(0, 6))) / np.float32(overtone)
    return made


def _talk(length: int, chance: Chance, babble: Sequence[Sound]) -> Sound:
    """Two to six people at once."""
    made = np.zeros(length, np.float32)
    for _ in range(chance.integers(2, 7)):
        at = -round(chance.uniform(0, 1) * RATE)
        while at < length:
            sound = babble[int(chance.integers(len(babble)))]
            start, end = max(at, 0), min(at + len(sound), length)
            if end > start:
                made[start:end] += sound[start - at : end - at]
            at += len(sound) + round(chance.uniform(0, 0.5) * RATE)
    return made
