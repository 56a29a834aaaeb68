"""Which Whisper a name stands for, and where it is."""

from __future__ import annotations

from pathlib import Path

import huggingface_hub.constants
import pytest

from config import load
from engine.asr.sizes import in_hub, is_size, listed
from engine.errors import ModelError
from engine.parts.loading import make_recogniser
from tests.unit.test_whisper import model_folder

OURS = {"whisper-base", "whisper-tiny.en"}


@pytest.mark.parametrize(
    ("name", "ours"),
    [("base", "whisper-base"), ("whisper-base", "whisper-base"), ("tiny.en", "whisper-tiny.en"), ("small", None)],
)
def test_a_model_of_ours_may_be_called_by_its_size(name: str, ours: str | None) -> None:
    assert listed(name, OURS) == ours
    assert is_size(name)


def test_what_is_no_size_is_none() -> None:
    assert not is_size("gigantic")


@pytest.fixture
def hub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, laid out as the hub does it."""
    monkeypatch.setattr(huggingface_hub.constants, "HF_HUB_CACHE", str(tmp_path))
    return tmp_path


def test_a_size_that_nobody_has_fetched_says_how_to_fetch_it(hub: Path) -> None:
    with pytest.raises(ModelError, match="not on this machine") as told:
        in_hub("small")
    assert "hf download Systran/faster-whisper-small" in told.value.hint


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A current folder, and none of sayso's own models."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def error_of(model: str) -> ModelError:
    with pytest.raises(ModelError) as caught:
        make_recogniser(load(overrides=[f"asr.model={model}", "models.folder=none"])).load()
    return caught.value


@pytest.mark.parametrize("name", ["base", "whisper-base"])
def test_a_folder_that_is_called_like_a_model_of_ours_is_not_meant(name: str, here: Path) -> None:
    (here / name).mkdir()
    assert error_of(name).message.startswith("The model whisper-base is not downloaded")


def test_a_folder_that_is_called_like_a_size_is_not_meant(here: Path, hub: Path) -> None:
    (here / "small").mkdir()
    assert error_of("small").message == "Whisper small is not on this machine."


def test_a_folder_beside_us_is_meant_by_its_path_or_if_it_holds_a_model(here: Path) -> None:
    for name in ("base", "mine"):
        (here / name).mkdir()
    assert "There is no model 'mine'" in error_of("mine").message
    assert error_of("./base").message == "The speech model in base is incomplete: model.bin is missing."
    (here / "mine" / "model.bin").touch()
    found = error_of("mine")
    assert found.message == "The speech model in mine is incomplete: config.json is missing."
    assert "asr.model" in found.hint


@pytest.mark.parametrize("path", ["/nowhere/at/all", "not/here"])
def test_a_path_at_which_there_is_no_folder_is_said(path: str, here: Path) -> None:
    found = error_of(path)
    assert found.message == f"There is no folder {path}."
    assert "pull" not in found.hint


@pytest.mark.model
def test_a_size_that_another_program_has_fetched_is_used(hub: Path) -> None:
    folder = hub / "models--Systran--faster-whisper-small"
    (folder / "refs").mkdir(parents=True)
    (folder / "refs" / "main").write_text("c0ffee")
    (folder / "snapshots").mkdir()
    (folder / "snapshots" / "c0ffee").symlink_to(model_folder())  # what is in it does not matter here
    recogniser = make_recogniser(load(overrides=["asr.model=small"]))
    recogniser.load()
    assert recogniser.name.startswith("faster-whisper-small (int8")
