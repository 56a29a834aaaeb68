"""Noise that sounds steadily, and what is left of it."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from config.schema import Suppression
from engine.audio.denoise import LATE, NoiseSuppressor, usable
from engine.audio.level import loudness
from engine.audio.source import FRAME_SAMPLES, RATE, Frame, Samples
from tests.bench.speech import clips, frames, hum

LIBRARY_LATE = 96
"""Samples by which the library itself is later (6 ms)."""


def suppressed(level: Suppression, sound: Samples) -> Samples:
    suppressor = NoiseSuppressor(level)
    return np.concatenate([suppressor.apply(frame).samples for frame in frames(sound)])


def test_off_leaves_every_frame_alone() -> None:
    frame = Frame(np.arange(FRAME_SAMPLES, dtype=np.int16), 1.5, 0.2)
    assert NoiseSuppressor("off").apply(frame) is frame


def test_a_frame_stays_a_frame_of_its_moment() -> None:
    suppressor = NoiseSuppressor("low")
    for number in range(12):
        frame = Frame(np.full(FRAME_SAMPLES, 100, np.int16), number * 0.032, number * 0.032)
        less = suppressor.apply(frame)
        assert (less.end, less.at, less.samples.shape, less.samples.dtype) == (
            frame.end, frame.at, (FRAME_SAMPLES,), np.dtype(np.int16),
        )  # fmt: skip


@pytest.mark.parametrize(("level", "at_least_db"), [("low", 4), ("moderate", 8), ("high", 12)])
def test_a_steady_noise_becomes_quieter_by_so_much(level: Suppression, at_least_db: float) -> None:
    noise = hum(4, 0)
    last = slice(-RATE, None)
    before, after = (loudness(list(frames(sound[last]))).rms_db for sound in (noise, suppressed(level, noise)))
    assert before - after > at_least_db


def test_speech_is_left_and_nothing_is_cut_between_the_blocks() -> None:
    """The library fills up what is no whole block with silence: a frame is none."""
    speech = next(clip.samples for clip in clips() if clip.snr_db is None)
    speech = speech[: len(speech) // FRAME_SAMPLES * FRAME_SAMPLES]
    late = LATE + LIBRARY_LATE
    before, after = speech[:-late].astype(float), suppressed("low", speech)[late:].astype(float)
    assert np.corrcoef(before, after)[0, 1] > 0.98
    assert after.std() > 0.7 * before.std()


def test_another_source_begins_anew() -> None:
    noise, suppressor = hum(1, 0), NoiseSuppressor("moderate")
    first = [suppressor.apply(frame).samples for frame in frames(noise)]
    suppressor.reset()
    assert np.array_equal(first, [suppressor.apply(frame).samples for frame in frames(noise)])


def test_without_the_library_it_is_off_and_that_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    assert usable("low", told.append) == "low"
    monkeypatch.setitem(sys.modules, "pywebrtc_audio", None)
    assert usable("off", told.append) == "off"
    assert not told
    assert usable("high", told.append) == "off"
    (words,) = told
    assert "pip install 'sayso[denoise]'" in words
