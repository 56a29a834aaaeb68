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
