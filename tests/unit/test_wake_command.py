"""``sayso wake``: what people are told of a wake word, and when it is kept."""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile

import config
from engine.errors import ExitCode, ModelError, UsageError
from engine.parts.loading import model_store
from engine.wake.choice import MODEL
from engine.wake.embedding import RATE
from engine.wake.head import Trial
from engine.wake.training.trainer import Trained, train
from engine.wake.training.trial import Point, doubts
from engine.wake.training.voices import Espeak, Remembered, trimmed
from tests.unit.test_heads import tiny
from tui import cli
from tui.commands import wake
from tui.commands.head_plot import alarms, described, figures, plot

NEEDS_ESPEAK = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="espeak-ng is not installed")
GOOD = Trial({"clean": 0.97, "10 dB": 0.95, "5 dB": 0.8}, 70, 0.05, 0, 0.3)
POOR = Trial({"clean": 0.7, "10 dB": 0.4, "5 dB": 0.2}, 70, 0.5, 9, 0.3)


@pytest.fixture(autouse=True)
def _folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of somebody who has nothing but the models."""
    models = model_store(config.load()).folder
    monkeypatch.setenv("SAYSO_MODELS__FOLDER", str(models))
    for name in ("CONFIG", "CACHE", "STATE"):
        monkeypatch.setenv(f"SAYSO_{name}_DIR", str(tmp_path / name.lower()))


def heads(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.rglob("*") if file.is_file() and file.parent.name == "wake")


# What is told


def test_a_good_head_is_not_doubted_and_a_poor_one_in_every_respect() -> None:
    assert doubts(GOOD) == []
    assert doubts(POOR) == [
        "It is heard only 70% of the time in a quiet room.",
        "It is heard only 40% of the time over noise (10 dB).",
        "It takes 50% of what is like the phrase for it.",
        "It would wake by itself about 30 times in an hour of talk.",
    ]


def test_false_alarms_are_told_by_the_hour_and_never_as_none_at_all() -> None:
    assert alarms(POOR) == "about 30 false alarms an hour (9 in 18 min of other sound)"
    assert alarms(GOOD) == "fewer than 10 false alarms an hour (none in 18 min of other sound)"
    assert figures(GOOD).startswith("heard 97% clean, 95% 10 dB, 80% 5 dB of 70; 5% of what is like it; fewer than")


def test_a_damaged_head_does_not_hide_the_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = tmp_path / "config" / "wake"
    tiny("hey rosie").save(own / "hey_rosie.npz")
    (own / "broken.npz").write_bytes(b"RIFF")
    assert cli.main(["wake", "list", "--json"]) == ExitCode.DONE
    told = capsys.readouterr()
    lines = {line["phrase"]: line for line in map(json.loads, told.out.splitlines())}
    assert lines["hey rosie"]["trial"]["alarms"] == 2
    assert "hey sayso" in lines
    assert "broken.npz is no head" in told.err


def test_the_plot_fits_into_80_columns() -> None:
    points = [Point(threshold, dict(GOOD.recall), 1.0, 999) for threshold in (0.3, 0.997)]
    head = replace(tiny(), threshold=0.997, trial=GOOD)
    shown = f"{plot(Trained(head, points, 0.3))}\n{described(head)}".splitlines()
    assert max(map(len, shown)) <= 80
    assert [line[0] for line in shown[1:3]] == [" ", "→"]


# A recording


@NEEDS_ESPEAK
@pytest.mark.model
def test_a_phrase_with_which_a_recording_begins_is_heard(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        model_store(config.load()).find(MODEL)
    except ModelError as error:
        pytest.skip(str(error))
    said = trimmed(Espeak("en-us", "f2", 50).say("hey sayso", 1.0))
    soundfile.write(tmp_path / "said.wav", said, RATE)
    assert cli.main(["wake", "test", str(tmp_path / "said.wav"), "--json"]) == ExitCode.DONE
    [found] = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert found["phrase"] == "hey sayso"
    assert 0 < found["ended_s"] <= found["at_s"]
    assert found["ended_s"] == pytest.approx(len(said) / RATE, abs=0.3)


def test_what_is_no_recording_is_said_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "words.wav").write_text("not a sound")
    for file, why in ((tmp_path / "none.wav", "There is no file"), (tmp_path / "words.wav", "cannot be read")):
        assert cli.main(["wake", "test", str(file)]) == ExitCode.USAGE
        told = capsys.readouterr().err
        assert why in told
        assert ".." not in told.replace(str(tmp_path), "")


# Training


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch) -> list[Trial]:
    """Training takes no time, and leads to the trial in here."""
    trials = [GOOD]

    def fake(phrase: str, voices: Sequence[Any], *arguments: Any, **more: Any) -> Trained:
        del voices, arguments, more
        [trial] = trials
        head = tiny(phrase)
        points = [Point(head.threshold, dict(trial.recall), trial.near, trial.alarms)]
        return Trained(type(head)(phrase, 0.5, head.networks, 0.05, trial, "nobody"), points, trial.hours)

    monkeypatch.setattr(wake, "train", fake)
    return trials


@pytest.mark.model
@pytest.mark.parametrize(
    ("trial", "arguments", "answer", "kept", "code"),
    [
        (GOOD, [], None, True, ExitCode.DONE),
        (POOR, [], None, False, ExitCode.FAILED),
        (POOR, ["--yes"], None, True, ExitCode.DONE),
        (POOR, ["--json"], "", False, ExitCode.FAILED),
        (GOOD, [], "\n", True, ExitCode.DONE),
        (GOOD, [], "n\n", False, ExitCode.DONE),
        (POOR, [], "\n", False, ExitCode.FAILED),
        (POOR, [], "y\n", True, ExitCode.DONE),
        (POOR, [], "", False, ExitCode.FAILED),
    ],
)
def test_what_is_not_good_enough_is_said_and_only_kept_by_whoever_wants_it(
    trained: list[Trial],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    trial: Trial,
    arguments: list[str],
    answer: str | None,
    kept: bool,
    code: ExitCode,
) -> None:
    trained[:] = [trial]
    monkeypatch.setattr("sys.stdin", io.StringIO("") if answer is None else Terminal(answer))
    assert cli.main(["wake", "train", "hey rosie", *arguments]) == code
    assert heads(tmp_path) == (["hey_rosie.npz"] if kept else [])
    told = capsys.readouterr()
    assert ("not good enough" in told.err) == (trial is POOR)
    assert ("Keep it as" in told.err) == (answer is not None and "--json" not in arguments)
    assert "Keep it" not in told.out, "stdout is data"
    assert "97%" in told.out or "0.97" in told.out or trial is POOR


@pytest.mark.model
@pytest.mark.parametrize(
    ("phrase", "short"), [("hi", True), ("stop it", True), ("hey rosie", False), ("computer", False)]
)
def test_who_chooses_a_short_phrase_is_told_before_it_is_trained(
    trained: list[Trial], capsys: pytest.CaptureFixture[str], phrase: str, short: bool
) -> None:
    assert cli.main(["wake", "train", phrase, "--yes", "--json"]) == ExitCode.DONE
    assert (f"“{phrase}” is short" in capsys.readouterr().err) == short


@NEEDS_ESPEAK
def test_a_phrase_that_takes_too_long_is_refused_before_everybody_says_it(tmp_path: Path) -> None:
    said: list[str] = []
    voices = [Espeak("en-us", f"m{number}", 50) for number in range(1, 9)] * 2
    phrase = "hello my dear old robot friend in the kitchen"
    with pytest.raises(UsageError, match=r"too long to say: \d\.\d s"):
        train(phrase, voices, None, tmp_path, on_step=lambda stage, done, total: said.append(stage))  # type: ignore[arg-type]
    assert said == []


@NEEDS_ESPEAK
def test_a_cache_that_cannot_be_written_only_makes_it_slower(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    sound = Remembered(tmp_path / "file").say(Espeak("en-us", "m1", 50), "hey rosie", 1.0)
    assert np.abs(sound).max() == pytest.approx(0.5)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
