"""``sayso wake``: what people are told of a wake word, and when it is kept."""

from __future__ import annotations

import io
import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

import config
from config.schema import Settings
from engine.errors import ExitCode, ModelError, UsageError
from engine.parts.loading import model_store
from engine.wake.choice import MODEL, known_words
from engine.wake.embedding import RATE
from engine.wake.head import Head, Trial
from engine.wake.training.trainer import Trained, train
from engine.wake.training.trial import Point, doubts
from engine.wake.training.voices import Espeak, Remembered, trimmed
from engine.wake.words import Spotted
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


def test_false_alarms_are_told_as_they_were_counted() -> None:
    assert alarms(POOR) == "9 false alarms in 18 min of other talk"
    assert alarms(GOOD) == "no false alarms in 18 min of other talk"
    assert figures(GOOD).startswith(
        "heard 97% clean, 95% 10 dB, 80% 5 dB of 70; 5% of what is like it; no false alarms"
    )


def test_a_damaged_head_does_not_hide_the_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = tmp_path / "config" / "wake"
    tiny("hey rosie").save(own / "hey_rosie.npz")
    (own / "broken.npz").write_bytes(b"RIFF")
    spoilt = bytearray((own / "hey_rosie.npz").read_bytes())
    spoilt[300:340] = bytes(40)  # within what zlib packed
    (own / "spoilt.npz").write_bytes(spoilt)
    assert cli.main(["wake", "list", "--json"]) == ExitCode.DONE
    told = capsys.readouterr()
    lines = {line["phrase"]: line for line in map(json.loads, told.out.splitlines())}
    assert lines["hey rosie"]["trial"]["alarms"] == 2
    assert "hey sayso" in lines
    assert "broken.npz is no head" in told.err
    assert "spoilt.npz is no head" in told.err


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


class Listening:
    """Hears a phrase wherever it is loud, and remembers what it was given."""

    def __init__(self, phrase: str) -> None:
        self.phrase = phrase
        self.given = np.zeros(0, np.int16)

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        self.given = samples
        return [Spotted(self.phrase, at, at) for at in np.flatnonzero(samples > 20_000)[:1]]


@pytest.fixture
def loadable(monkeypatch: pytest.MonkeyPatch) -> dict[str, Listening]:
    """Phrases that can be listened for; all others cannot."""
    phrases: dict[str, Listening] = {}

    def load(settings: Settings, wanted: Sequence[str]) -> list[Listening]:
        del settings
        if wanted[0] not in phrases:
            raise ModelError(f"“{wanted[0]}” cannot be listened for.", hint="pip install it")
        return [phrases[wanted[0]]]

    monkeypatch.setattr(wake, "load_spotters", load)
    return phrases


def test_only_what_was_listened_for_is_named_and_what_could_not_be_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], loadable: dict[str, Listening]
) -> None:
    file = tmp_path / "quiet.wav"
    soundfile.write(file, np.zeros(RATE), RATE)
    assert cli.main(["wake", "test", str(file)]) == ExitCode.MISSING
    assert "none of" not in capsys.readouterr().err, "nothing was listened for"
    loadable["hey sayso"] = Listening("hey sayso")
    assert cli.main(["wake", "test", str(file)]) == ExitCode.MISSING
    told = capsys.readouterr().err
    assert "“hey jarvis” cannot be listened for." in told
    assert f"sayso: none of hey sayso in {file}." in told
    loadable |= {word.phrase: Listening(word.phrase) for word in known_words(tmp_path)}
    assert cli.main(["wake", "test", str(file)]) == ExitCode.FAILED
    soundfile.write(file, np.ones(RATE), RATE)
    del loadable["hey jarvis"]
    assert cli.main(["wake", "test", str(file)]) == ExitCode.DONE


def test_what_is_louder_than_full_scale_is_clipped_as_a_microphone_does(
    tmp_path: Path, loadable: dict[str, Listening]
) -> None:
    spotter = loadable["hey sayso"] = Listening("hey sayso")
    file, rate = tmp_path / "clipped.wav", 44_100
    wave = np.sign(np.sin(np.arange(rate) * (2 * np.pi * 200 / rate)))  # to resample it makes it louder still
    soundfile.write(file, wave, rate)
    cli.main(["wake", "test", str(file)])
    heard = spotter.given[round(wake.BEFORE_S * RATE) :][:RATE].astype(np.int32)
    assert np.abs(heard).max() >= 32767
    assert np.abs(np.diff(heard)).max() < 60_000, "what wraps around jumps from one end to the other"


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

    monkeypatch.setattr(wake, "check", lambda *arguments: None)
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


@pytest.mark.model
@pytest.mark.parametrize(
    ("arguments", "why", "code"),
    [
        (["--to", "."], "is no file", ExitCode.USAGE),
        (["--to", "/dev/full"], "is no file", ExitCode.USAGE),
        (["--to", "/proc/hey_rosie.npz"], "cannot be written", ExitCode.MISSING),
        (["--to", "quiet.wav/hey_rosie.npz"], "cannot be written", ExitCode.MISSING),
        (["--to", f"{'long' * 99}.npz"], "cannot be written", ExitCode.MISSING),
        (["--others", "none.wav"], "There is no file none.wav", ExitCode.USAGE),
        (["--others", "words.wav"], "words.wav cannot be read", ExitCode.USAGE),
        (["--mine", "nowhere"], "There are no WAV files in nowhere", ExitCode.USAGE),
        (["--mine", "."], "Nobody is heard to speak in quiet.wav. Record it again", ExitCode.USAGE),
    ],
)
def test_what_cannot_be_used_is_refused_before_anything_is_trained(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    why: str,
    code: ExitCode,
) -> None:
    monkeypatch.setattr(wake, "check", lambda *arguments: None)
    monkeypatch.setattr(wake, "train", lambda *arguments, **more: pytest.fail("it was trained"))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    soundfile.write("quiet.wav", np.random.default_rng(0).normal(0, 0.002, 3 * RATE), RATE)
    if "words.wav" in arguments:
        Path("words.wav").write_text("not a sound")
    before = sorted(tmp_path.rglob("*"))
    assert cli.main(["wake", "train", "hey rosie", *arguments]) == code
    assert why in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


@NEEDS_ESPEAK
@pytest.mark.model
def test_who_cannot_train_a_phrase_is_not_asked_to_say_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wake, "make_microphone", lambda settings: pytest.fail("it was recorded"))
    phrase = "hello my dear old robot friend in the kitchen"
    assert cli.main(["wake", "train", phrase, "--mine", "record"]) == ExitCode.USAGE
    assert "too long to say" in capsys.readouterr().err
    assert cli.main(["wake", "train", "hey rosie", "--mine", "record", "--to", str(tmp_path)]) == ExitCode.USAGE
    monkeypatch.setenv("PATH", str(tmp_path))  # there is no espeak-ng in it
    assert cli.main(["wake", "train", "hey rosie", "--mine", "record"]) == ExitCode.USAGE
    assert "apt install espeak-ng" in capsys.readouterr().err


@pytest.mark.model
@pytest.mark.parametrize("cache", ["writable", "full"])
def test_a_head_that_cannot_be_saved_after_all_is_kept_and_how_to_move_it_is_said(
    trained: list[Trial],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    cache: str,
) -> None:
    training = wake.train
    spare = tmp_path / "cache" / "wake" / "hey_rosie.npz"
    if cache == "full":
        (tmp_path / "cache").write_text("in the way")
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
        spare = tmp_path / f"sayso-{os.getpid()}" / "hey_rosie.npz"

    def meanwhile(*arguments: Any, **more: Any) -> Trained:
        (tmp_path / "my heads").write_text("in the way")
        return training(*arguments, **more)

    monkeypatch.setattr(wake, "train", meanwhile)
    target = tmp_path / "my heads" / "rosie.npz"
    assert cli.main(["wake", "train", "hey rosie", "--yes", "--to", str(target)]) == ExitCode.MISSING
    told = capsys.readouterr().err
    assert Head.load(spare).phrase == "hey rosie"
    assert f"It is kept in {spare}." in told
    assert f"mv {spare} '{target}'" in told


@pytest.mark.model
def test_how_to_listen_for_it_is_said_where_it_will_be_found_and_else_where_to_copy_it(
    trained: list[Trial], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    usual, other = tmp_path / "config" / "wake" / "hey_rosie.npz", tmp_path / "hey_rosie.npz"
    for target, way in ((usual, "Listen for it: --set"), (other, f"Copy it to {usual} to listen for it: --set")):
        assert cli.main(["wake", "train", "hey rosie", "--yes", "--to", str(target)]) == ExitCode.DONE
        assert f"sayso: {target}. {way} 'wake.words=[hey rosie]'" in capsys.readouterr().err


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
