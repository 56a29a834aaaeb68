"""What the doctor says about a microphone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.schema import Vad
from engine.audio.calibration import Calibration, calibrate
from engine.audio.gain import TARGET_DB
from engine.audio.source import RATE, Framer, Samples
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from tui.commands.level_plot import BOTTOM_DB, ROWS, level_plot

COMMAND = read_wav(Path(__file__).parents[2] / "assets" / "speech" / "go_to_the_kitchen.wav")


def recording(speech_db: float | None, noise_db: float = -75.0) -> Samples:
    """Three seconds of a room in which somebody speaks, louder by so much than the recording is; None: nobody does."""
    sound = np.random.default_rng(0).normal(0, 32768 * 10 ** (noise_db / 20), 3 * RATE)
    if speech_db is not None:
        sound[RATE // 2 : RATE // 2 + len(COMMAND)] += COMMAND * 10 ** (speech_db / 20)
    return np.clip(sound, -32768, 32767).astype(np.int16)


def judged(sound: Samples) -> Calibration:
    return calibrate(Framer().push(sound), make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)))


@pytest.mark.parametrize(
    ("sound", "verdict", "advice"),
    [
        (recording(0), "good", "Nothing needs"),
        (recording(-20), "too quiet", "Set audio.gain_db to"),
        (recording(-34, -90), "too quiet", "raise the input level"),
        (recording(25), "too loud", "mixer"),
        (recording(-20, -40), "noisy", "closer"),
        (recording(None), "nobody spoke", "say something"),
        (np.zeros(3 * RATE, np.int16), "silent", "audio.device"),
    ],
)
def test_the_verdict_says_what_to_do(sound: Samples, verdict: str, advice: str) -> None:
    found = judged(sound)
    assert found.verdict == verdict
    assert advice in found.advice
    assert (found.gain_db is not None) == (verdict in ("good", "too quiet"))


def test_the_gain_that_is_named_makes_it_good() -> None:
    faint = judged(recording(-20))
    assert faint.gain_db is not None
    louder = recording(-20).astype(np.float64) * 10 ** (faint.gain_db / 20)
    mended = judged(np.clip(louder, -32768, 32767).astype(np.int16))
    assert mended.verdict == "good"
    assert mended.speech_db == pytest.approx(TARGET_DB, abs=2)


def test_levels_and_speech_are_where_they_were() -> None:
    found = judged(recording(0))
    assert found.noise_db == pytest.approx(-75, abs=1)
    assert found.speech_s == pytest.approx(len(COMMAND) / RATE, abs=0.5)
    assert found.clipped == 0
    assert not any(found.voiced[:10])
    assert sum(found.voiced[14:50]) > 20
    json.dumps(found.levels)


def test_the_plot_is_as_wide_as_the_terminal_and_as_high_as_the_sound_is_loud() -> None:
    levels = [BOTTOM_DB] * 30 + [-1.0] * 30 + [-41.0] * 30
    lines = level_plot(levels, [False] * 30 + [True] * 60, -60.0, 60).plain.splitlines()
    assert len(lines) == ROWS + 1
    assert all(len(line) <= 60 for line in lines)
    bars = [line[7:] for line in lines[:-1]]
    heights = [sum(row[column] in "▁▂▃▄▅▆▇█" for row in bars) for column in (5, len(bars[0]) // 2, len(bars[0]) - 5)]
    assert heights == [0, ROWS, ROWS // 2]
    assert bars[ROWS - 1 - 2].startswith("┄┄")


def test_a_narrow_terminal_still_gets_a_plot() -> None:
    assert level_plot([-20.0] * 94, [True] * 94, -70.0, 5).plain.count("\n") == ROWS
