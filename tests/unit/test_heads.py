"""A head is whole or not there, holds nothing that is executed, and is as sure however sound is cut."""

from __future__ import annotations

import contextlib
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.audio.wav import read_wav
from engine.errors import ModelError, StorageError
from engine.wake.choice import SHIPPED, known_words, make_spotters
from engine.wake.embedding import RATE, SIZE, SPAN, STACK, STEP
from engine.wake.head import Head, Trial
from engine.wake.trained import TrainedSpotter
from tests.unit.test_wake_words import PIECES, SPEECH, cut, embedding


def tiny(phrase: str = "hey rosie", threshold: float = 0.5) -> Head:
    chance = np.random.default_rng(0)
    layers = [
        (chance.normal(0, 0.1, (STACK * SIZE, 4)).astype(np.float32), np.zeros(4, np.float32)),
        (chance.normal(0, 1, (4, 1)).astype(np.float32), np.zeros(1, np.float32)),
    ]
    return Head(phrase, threshold, [layers], 0.05, Trial({"clean": 1.0}, 3, 0.1, 2, 0.5), "three voices")


def test_a_head_is_read_as_it_was_written(tmp_path: Path) -> None:
    head = replace(tiny(), steps=3, trained_by=("espeak:m1", "kokoro:af_heart"))
    rows = np.random.default_rng(1).normal(0, 1, (5, STACK * SIZE)).astype(np.float32)
    head.save(tmp_path / "heads" / "hey_rosie.npz")
    read = Head.load(tmp_path / "heads" / "hey_rosie.npz")
    assert (read.phrase, read.threshold, read.delay_s, read.steps) == ("hey rosie", 0.5, 0.05, 3)
    assert (read.trial, read.trained_by) == (head.trial, head.trained_by)
    np.testing.assert_allclose(read.probabilities(rows), head.probabilities(rows), atol=0.01)


def test_a_head_goes_by_the_mean_of_its_newest_steps() -> None:
    rows = np.random.default_rng(1).normal(0, 1, (6, STACK * SIZE)).astype(np.float32)
    alone = tiny().probabilities(rows)
    votes = np.log(alone / (1 - alone))
    together = replace(tiny(), steps=3).probabilities(rows)
    means = [votes[max(0, index - 2) : index + 1].mean() for index in range(6)]
    np.testing.assert_allclose(np.log(together / (1 - together)), means, rtol=1e-3)
    np.testing.assert_array_equal(replace(tiny(), steps=9).probabilities(rows[:1]), alone[:1])


def test_a_head_of_an_older_version_goes_by_one_step_and_knows_nobody(tmp_path: Path) -> None:
    file = tmp_path / "hey_rosie.npz"
    replace(tiny(), steps=3, trained_by=("espeak:m1",)).save(file)
    with np.load(file) as arrays:
        older = dict(arrays)
    about = json.loads(str(older["about"]))
    del about["steps"], about["trained_by"]
    np.savez(file, **{**older, "about": np.array(json.dumps(about))})
    assert (Head.load(file).steps, Head.load(file).trained_by) == (1, ())


def test_every_head_that_ships_says_who_trained_it() -> None:
    for file in SHIPPED.glob("*.npz"):
        assert len(Head.load(file).trained_by) > 50, file


@pytest.mark.model
@settings(max_examples=4)
@given(PIECES)
def test_a_spotter_is_as_sure_as_its_head_is_of_the_whole_however_sound_is_cut(sizes: list[int]) -> None:
    sound = read_wav(SPEECH / "go_to_the_bedroom_then_turn_around.wav")[: 3 * RATE]
    head = replace(tiny(), steps=3)
    sure = head.probabilities(embedding().stacks(sound / np.float32(32768)))
    head = replace(head, threshold=float(np.median(sure)))
    spotter = TrainedSpotter(embedding(), [head])
    first = next(spotted for piece in cut(sound, sizes) for spotted in spotter.push(piece))
    assert first.at == SPAN + int(np.argmax(sure >= head.threshold)) * STEP


@pytest.mark.parametrize("spoil", [lambda data: data[:-200], lambda data: b"", lambda data: b"RIFF" + data])
def test_a_damaged_head_is_refused(tmp_path: Path, spoil: object) -> None:
    file = tmp_path / "hey_rosie.npz"
    tiny().save(file)
    file.write_bytes(spoil(file.read_bytes()))  # type: ignore[operator]
    with pytest.raises(ModelError, match=r"hey_rosie\.npz is no head"):
        Head.load(file)


@settings(max_examples=300)
@given(where=st.floats(0, 0.999), spoilt=st.binary(min_size=1, max_size=8))
def test_a_head_that_is_damaged_anywhere_is_refused_or_whole(
    tmp_path_factory: pytest.TempPathFactory, where: float, spoilt: bytes
) -> None:
    file = tmp_path_factory.mktemp("heads") / "hey_rosie.npz"
    tiny().save(file)
    whole = file.read_bytes()
    at = round(where * len(whole))
    file.write_bytes(whole[:at] + spoilt + whole[at + len(spoilt) :])
    with contextlib.suppress(ModelError):
        assert Head.load(file).phrase == "hey rosie"


def _stored(folder: Path, name: str, data: bytes) -> Path:
    """A file like a head, in which one array is made of these bytes."""
    file = folder / "odd.npz"
    tiny().save(file)
    with zipfile.ZipFile(file) as whole:
        parts = {part: whole.read(part) for part in whole.namelist()} | {name: data}
    with zipfile.ZipFile(file, "w") as odd:
        for part, content in parts.items():
            odd.writestr(part, content)
    return file


@pytest.mark.parametrize(
    "header",
    [b"", b"{'descr': '<f2', 'fortran_order': False, 'shape': (3,", b"(" * 90, b"{'descr': '<f2'\n", b"\xff" * 9],
)
def test_an_array_that_is_no_array_makes_it_no_head(tmp_path: Path, header: bytes) -> None:
    array = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
    with pytest.raises(ModelError, match=r"odd\.npz is no head"):
        Head.load(_stored(tmp_path, "w0_0.npy", array))


def test_a_head_of_another_shape_is_refused(tmp_path: Path) -> None:
    layers = [(np.ones((7, 1), np.float32), np.zeros(1, np.float32))]
    Head("hey rosie", 0.5, [layers]).save(tmp_path / "odd.npz")
    with pytest.raises(ModelError, match="does not fit"):
        Head.load(tmp_path / "odd.npz")


def test_a_head_holds_nothing_that_is_executed(tmp_path: Path) -> None:
    np.savez(tmp_path / "evil.npz", about=np.array([object()], dtype=object))
    with pytest.raises(ModelError, match="no head"):
        Head.load(tmp_path / "evil.npz")


def test_a_head_that_cannot_be_written_leaves_the_one_before(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StorageError):
        tiny().save(tmp_path / "file" / "hey_rosie.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_ones_own_heads_go_before_those_that_ship(tmp_path: Path) -> None:
    tiny("hey jarvis").save(tmp_path / "hey_jarvis.npz")
    (jarvis,) = [word for word in known_words(tmp_path) if word.phrase == "hey jarvis"]
    assert jarvis.by == "yours"


def test_a_phrase_that_nobody_trained_says_how_to_train_it(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="sayso wake train") as caught:
        make_spotters(["hey nobody"], tmp_path, None)
    assert "hey jarvis" in str(caught.value)
