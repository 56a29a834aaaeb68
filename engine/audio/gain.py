"""How much louder sound is made before anything else hears it.

A fixed gain is what the settings say. The automatic one learns from nothing but speech that was understood, and changes
between two utterances, so that it stands still while nobody speaks, never breathes within a sentence, and cannot lift a
noise until it passes for a voice.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from engine.audio.level import decibels
from engine.audio.source import FRAME_SAMPLES, Frame, Samples

TARGET_DB = -26.0
"""Where the loud parts of speech are brought to, dB relative to full scale: as loud as most recordings are."""

NOISE_DB = -50.0
"""What is heard between the words is not lifted above this, dB relative to full scale."""

HEADROOM_DB = 3.0
"""How far the loudest sample stays below full scale."""

HIGHEST_DB = 30.0
"""The automatic gain stays between 0 and this: sound that was too loud for the device is not mended by less of it."""

RISE_DB, FALL_DB = 3.0, 6.0
"""The largest steps up and down between two utterances."""

ENOUGH_DB = 3.0
"""A gain that is as near to the wanted one as this stays."""

_LOUD, _QUIET = 85, 10
"""Percentiles of an utterance's frames: its voice, and the noise before, after and between the words."""


class Gain:
    """The gain of one source. ``setting``: dB, or "auto". Belongs to one thread."""

    def __init__(self, setting: float | Literal["auto"]) -> None:
        self._automatic = setting == "auto"
        self.db = 0.0 if setting == "auto" else float(setting)

    def apply(self, frame: Frame) -> Frame:
        """The frame with the gain of now; what becomes too loud is clipped."""
        if self.db == 0.0:
            return frame
        louder = np.clip(frame.samples * 10 ** (self.db / 20), -32768, 32767).astype(np.int16)
        return Frame(louder, frame.end)

    def learn(self, understood: Samples) -> bool:
        """Take an utterance that was understood, with the gain of now in it, as the measure of the next; whether that
        changes the gain."""
        if not self._automatic:
            return False
        step = max(-FALL_DB, min(RISE_DB, wanted_gain(understood, self.db) - self.db))
        if abs(step) < ENOUGH_DB:
            return False
        self.db = round(self.db + step, 1)
        return True


def wanted_gain(speech: Samples, applied_db: float = 0.0) -> float:
    """The gain that suits a speaker who sounds like this, dB; ``applied_db`` is in ``speech`` already."""
    frames = speech[: len(speech) // FRAME_SAMPLES * FRAME_SAMPLES].reshape(-1, FRAME_SAMPLES)
    if not len(frames):
        return applied_db
    sound = frames.astype(np.float64) / 32768
    levels = np.sqrt(np.mean(sound**2, axis=1))
    voice, noise = (decibels(float(np.percentile(levels, share))) - applied_db for share in (_LOUD, _QUIET))
    peak = decibels(float(np.abs(sound).max())) - applied_db
    return suitable_gain(voice, noise, peak)


def suitable_gain(voice_db: float, noise_db: float, peak_db: float) -> float:
    """The gain for a voice, the noise around it and the loudest sample, all in dB relative to full scale."""
    return max(0.0, min(HIGHEST_DB, TARGET_DB - voice_db, NOISE_DB - noise_db, -HEADROOM_DB - peak_db))
