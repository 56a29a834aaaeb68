"""Recordings for the benchmarks of hearing, and ways to spoil them.

The recordings are those of ``../shared/data`` where they lie beside the checkout, else the demo speech.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from engine.audio.source import FRAME_SAMPLES, RATE, Frame, Framer, Samples
from engine.audio.wav import read_wav

CHECKOUT = Path(__file__).resolve().parents[2]
SHARED = CHECKOUT.parent / "shared" / "data"
DEMO = CHECKOUT / "assets" / "speech"


@dataclass(frozen=True, slots=True)
class Clip:
    """A recording, what it says, and who says it (with how much noise)."""

    samples: Samples
    text: str
    voice: str
    snr_db: float | None


def clips() -> list[Clip]:
    """All recordings that there are."""
    if (SHARED / "speech.json").exists():
        index = json.loads((SHARED / "speech.json").read_text(encoding="utf-8"))
        return [Clip(read_wav(SHARED / row["file"]), row["text"], row["voice"], row["snr_db"]) for row in index]
    index = yaml.safe_load((DEMO / "index.yaml").read_text(encoding="utf-8"))
    return [Clip(read_wav(DEMO / row["file"]), row["text"], "demo", None) for row in index]


def noise(seconds: float, seed: int) -> Samples:
    """A stretch of kitchen noise from a random place, or white noise where that recording is absent."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    path = SHARED / "noise" / "kitchen_25s.wav"
    if not path.exists():
        return random.normal(0, 1000, count).astype(np.int16)
    sound = np.roll(read_wav(path), -int(random.integers(25 * RATE)))
    return np.resize(sound, count)


def hum(seconds: float, seed: int) -> Samples:
    """A fan beside the microphone: noise, the more the deeper, and the tones of its motor."""
    count = round(seconds * RATE)
    white = np.fft.rfft(np.random.default_rng(seed).normal(size=count))
    sound = np.fft.irfft(white / np.sqrt(np.maximum(np.fft.rfftfreq(count, 1 / RATE), 60)), count)
    sound /= sound.std()
    time = np.arange(count) / RATE
    for hertz, level in ((100, 0.4), (200, 0.3), (1200, 0.2)):
        sound += level * np.sin(2 * np.pi * hertz * time)
    steady: Samples = (3000 * sound / sound.std()).astype(np.int16)
    return steady


def mixed(speech: Samples, background: Samples, snr_db: float) -> Samples:
    """``speech`` in ``background`` of the same length; the ratio counts the speech's loud parts only."""
    voice, rest = speech.astype(np.float64), background.astype(np.float64)
    loud = voice[np.abs(voice) > 0.05 * np.abs(voice).max()]
    gain = np.sqrt(np.mean(loud**2) / max(1.0, np.mean(rest**2))) * 10 ** (-snr_db / 20)
    result: Samples = np.clip(voice + gain * rest, -32768, 32767).astype(np.int16)
    return result


def speech_bounds(samples: Samples) -> tuple[float, float]:
    """Where the voice of a clean recording begins and ends, s: no more than 35 dB below its loudest 20 ms."""
    window = RATE // 50
    whole = samples[: len(samples) // window * window].astype(np.float64).reshape(-1, window)
    power = np.mean(whole**2, axis=1)
    loud = np.flatnonzero(power > power.max() * 10**-3.5)
    return float(loud[0] * window / RATE), float((loud[-1] + 1) * window / RATE)


def frames(samples: Samples) -> list[Frame]:
    """The recording as a source would deliver it."""
    framer = Framer()
    return [*framer.push(samples), *framer.flush()]


def silence(seconds: float) -> Samples:
    """Silence with the faintest noise, as every real recording has; whole frames."""
    count = round(seconds * RATE / FRAME_SAMPLES) * FRAME_SAMPLES
    return np.random.default_rng(0).normal(0, 3, count).astype(np.int16)
