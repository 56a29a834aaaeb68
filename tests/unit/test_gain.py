"""Making sound louder, without making a noise pass for a voice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.audio.gain import HIGHEST_DB, NOISE_DB, TARGET_DB, Gain, wanted_gain
from engine.audio.level import loudness
from engine.audio.source import FRAME_SAMPLES, RATE, Frame, Samples
from engine.audio.wav import read_wav

COMMAND = read_wav(Path(__file__).parents[2] / "assets" / "speech" / "go_to_the_kitchen.wav")


def scaled(decibels: float, noise_db: float = -90.0) -> Samples:
    """The command, louder by so much, with silence around it, in a steady noise."""
    random = np.random.default_rng(0)
    speech = np.pad(COMMAND * 10 ** (decibels / 20), RATE // 3)
    noise = random.normal(0, 32768 * 10 ** (noise_db / 20), len(speech))
    return np.clip(speech + noise, -32768, 32767).astype(np.int16)


def steady(amplitude: int) -> Frame:
    return Frame(np.full(FRAME_SAMPLES, amplitude, np.int16), 0.0)


def test_a_fixed_gain_makes_louder_clips_and_learns_nothing() -> None:
    gain = Gain(20)
    assert gain.apply(steady(100)).samples[0] == 1000
    assert gain.apply(steady(-30000)).samples[0] == -32768
    assert not gain.learn(scaled(-40))
    assert gain.db == 20


def test_the_automatic_gain_brings_faint_speech_to_the_usual_level_in_small_steps() -> None:
    gain, steps = Gain("auto"), []
    while gain.learn(scaled(-22 + gain.db)):
        steps.append(gain.db)
    assert steps == pytest.approx([3.0 * n for n in range(1, len(steps) + 1)])
    assert gain.db == pytest.approx(wanted_gain(scaled(-22)), abs=3)
    levels = [loudness([frame]).rms_db for frame in frames(scaled(-22 + gain.db))]
    assert TARGET_DB - 6 < np.percentile(levels, 85) < TARGET_DB + 3


def test_it_comes_down_again_for_somebody_louder() -> None:
    gain = Gain("auto")
    gain.db = 24.0
    while gain.learn(scaled(-10 + gain.db)):
        pass
    assert gain.db < 14


def test_a_noise_is_not_lifted_to_where_it_could_pass_for_speech() -> None:
    assert wanted_gain(scaled(-25, noise_db=-60)) == pytest.approx(NOISE_DB + 60, abs=1)
    assert wanted_gain(scaled(-25, noise_db=-45)) == 0.0


@given(st.binary(max_size=40_000), st.floats(0, HIGHEST_DB))
def test_whatever_is_learnt_the_gain_stays_within_its_limits(noise: bytes, before: float) -> None:
    gain = Gain("auto")
    gain.db = before
    for _ in range(3):
        gain.learn(np.frombuffer(noise[: len(noise) // 2 * 2], np.int16))
    assert 0 <= gain.db <= HIGHEST_DB


def frames(sound: Samples) -> list[Frame]:
    whole = sound[: len(sound) // FRAME_SAMPLES * FRAME_SAMPLES].reshape(-1, FRAME_SAMPLES)
    return [Frame(samples, 0.0) for samples in whole]
