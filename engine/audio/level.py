"""How loud it is: for the level meter, and for the events while listening."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine import events
from engine.audio.source import Frame
from engine.audio.vad import VadResult

LEVEL_FRAMES = 3
"""Frames per ``listen.level``: 10.4 a second."""

QUIETEST_DB = -96.0
"""The level of digital silence: what 16 bits can tell apart."""


@dataclass(frozen=True, slots=True)
class Level:
    """Loudness, dB relative to full scale."""

    rms_db: float
    peak_db: float


SILENT = Level(QUIETEST_DB, QUIETEST_DB)


class Meter:
    """Makes one ``listen.level`` of every few frames."""

    def __init__(self) -> None:
        self._frames: list[Frame] = []
        self._probability = 0.0

    def add(self, frame: Frame, vad: VadResult, *, in_speech: bool) -> events.ListenLevel | None:
        self._frames.append(frame)
        self._probability = max(self._probability, vad.probability)
        if len(self._frames) < LEVEL_FRAMES:
            return None
        level = loudness(self._frames)
        event = events.ListenLevel(level.rms_db, level.peak_db, round(self._probability, 3), in_speech)
        self._frames.clear()
        self._probability = 0.0
        return event


def loudness(frames: Sequence[Frame]) -> Level:
    sound = np.concatenate([frame.samples for frame in frames]).astype(np.float32) / 32768
    return Level(decibels(float(np.sqrt(np.mean(sound**2)))), decibels(float(np.max(np.abs(sound)))))


def decibels(amplitude: float) -> float:
    """An amplitude (1: full scale) in dB relative to full scale."""
    return round(max(QUIETEST_DB, 20 * math.log10(max(amplitude, 1e-9))), 1)
