"""Training a head: who says what, who tries it, where its threshold is, and that it can be broken off."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from engine.errors import UsageError
from engine.wake.head import Head
from engine.wake.training.casting import known_speakers, roles, takes
from engine.wake.training.fit import fit
from engine.wake.training.mandarin import VOICE
from engine.wake.training.texts import near
from engine.wake.training.trainer import Effort, train
from engine.wake.training.trial import Point, chosen
from engine.wake.training.voices import Espeak, Kokoro, KokoroVoice, Language, Remembered, find_voices
from tests.unit.test_wake_words import NEEDS_ESPEAK, embedding


def test_what_is_like_a_phrase_is_never_the_phrase() -> None:
    for phrase in ("hey sayso", "stop", "hey rosie", "computer"):
        texts = near(phrase, 100)
        assert len(texts) == len(set(texts)) > 10
        assert phrase not in {" ".join(text.casefold().split()) for text in texts}


@pytest.mark.parametrize("phrase", ["psst", "hmm", "brr", "a", "走", "好"])
def test_there_is_always_something_to_tell_a_phrase_from(phrase: str) -> None:
    texts = near(phrase, 200)
    assert len(texts) == len(set(texts)) > 14
    assert not any(text == phrase for text in texts)
    voice = Espeak("en-us" if phrase.isascii() else VOICE, "m1", 50)
    own, _ = takes(phrase, voice, phrases=1, near=14, others=1, rambling=1, slips=8)
    assert len(own) == 15


def test_who_tries_a_head_has_not_trained_it() -> None:
    voices = [Espeak("en-us", f"m{number}", 50) for number in range(1, 9)]
    parts = roles(voices)
    assert {parts[voice.name] for voice in voices} == {"train", "tune", "test"}
    assert parts == roles(voices[::-1]), "whatever the order in which they are found"
    train, tried = ([v for v in voices if parts[v.name] in several] for several in (("train", "tune"), ("test",)))
    assert set(known_speakers(voices)) == {speaker for voice in train for speaker in voice.speakers}
    assert not set(known_speakers(voices)) & {speaker for voice in tried for speaker in voice.speakers}


def test_a_voice_that_is_mixed_of_a_trainer_and_a_trier_says_nothing() -> None:
    style, model = np.zeros((1, 256), np.float32), Kokoro(Path("nowhere"))
    alone = [KokoroVoice(model, name, style) for name in "abcdefgh"]
    mixed = [KokoroVoice(model, f"{a}+{b}", style) for a, b in itertools.combinations("abcdefgh", 2)]
    parts = roles([*alone, *mixed])
    assert {parts[voice.name] for voice in alone} == {"train", "tune", "test"}
    for voice in mixed:
        theirs = {parts[speaker] for speaker in voice.speakers}
        assert {parts.get(voice.name)} == (theirs if len(theirs) == 1 else {None})


def test_who_speaks_with_another_accent_or_in_another_language_does_the_same() -> None:
    accents, names = ("en-us", "en-gb-scotland", VOICE), [f"m{number}" for number in range(1, 9)]
    alone = [roles([Espeak(accent, name, 50) for name in names]) for accent in accents]
    together = roles([Espeak(accent, name, 50) for name in names for accent in accents])
    for name in names:
        assert len({together[f"espeak:{accent}+{name}"] for accent in accents}) == 1
        assert len({parts[f"espeak:{accent}+{name}"] for accent, parts in zip(accents, alone, strict=True)}) == 1


def test_a_voice_says_the_phrase_and_what_is_like_it() -> None:
    own, others = takes("hey rosie", Espeak("en-us", "m1", 50), phrases=3, near=5, others=2, rambling=4, slips=6)
    assert [take.phrase for take in own] == [True] * 3 + [False] * 5
    assert len({(take.text, take.pace) for take in (*own, *others)}) == 20
    assert [any(text in take.text for text in near("hey rosie", 200)) for take in others][:6] == [True] * 6


def test_nobody_says_the_phrase_by_chance() -> None:
    voices = [Espeak("en-us", f"m{number}", 50) for number in range(1, 30)]
    talk = [
        take.text
        for voice in voices
        for take in takes("the", voice, phrases=1, near=1, others=20, rambling=20, slips=0)[1]
    ]
    assert len(talk) > 300, "most sentences do without so common a word"
    assert not any("the" in text.casefold() for text in talk)


def test_each_voice_talks_in_words_of_its_own() -> None:
    said = [
        {take.text for take in takes("hey rosie", Espeak("en-us", name, 50), **amounts)[1]}
        for name in ("m1", "m2", "f3")
        for amounts in [{"phrases": 1, "near": 1, "others": 0, "rambling": 30, "slips": 0}]
    ]
    assert [len(one) for one in said] == [30, 30, 30]
    assert not said[0] & said[1]
    assert not said[1] & said[2]


def point(threshold: float, clean: float, noisy: float, alarms: int, like: float = 0.05) -> Point:
    return Point(threshold, {"clean": clean, "10 dB": noisy, "5 dB": noisy / 2}, like, alarms)


@pytest.mark.parametrize(
    ("points", "threshold"),
    [
        ([point(0.5, 1.0, 1.0, 3), point(0.7, 0.98, 0.95, 0), point(0.9, 0.95, 0.9, 0)], 0.7),
        ([point(0.5, 1.0, 1.0, 3), point(0.7, 0.98, 0.95, 0), point(0.9, 0.98, 0.95, 0)], 0.9),
        ([point(0.5, 1.0, 1.0, 0, like=0.4), point(0.7, 0.98, 0.95, 0), point(0.9, 0.9, 0.8, 0)], 0.7),
        ([point(0.5, 1.0, 1.0, 9), point(0.7, 0.98, 0.9, 4), point(0.9, 0.8, 0.5, 0)], 0.7),
        ([point(0.5, 0.4, 0.3, 9), point(0.7, 0.3, 0.2, 4), point(0.9, 0.2, 0.1, 1)], 0.9),
    ],
    ids=["the lowest without alarms", "higher where it costs nothing", "likeness", "not deaf", "hopeless"],
)
def test_a_threshold_is_as_low_as_false_alarms_allow_and_as_high_as_costs_nothing(
    points: list[Point], threshold: float
) -> None:
    assert chosen(points, 0.4, alarms_an_hour=0.5).threshold == threshold


def test_a_network_learns_what_can_be_learnt() -> None:
    chance = np.random.default_rng(0)
    rows = chance.normal(3, 2, (1000, 6)).astype(np.float32)
    wanted = ((rows[:, 0] > 3) ^ (rows[:, 1] > 3)).astype(np.float32)
    losses: list[float] = []
    layers = fit(
        rows,
        wanted,
        np.ones(2000, np.float32),
        epochs=80,
        seed=0,
        dropout=0.0,
        on_epoch=lambda epoch, loss: losses.append(loss),
    )
    found = Head("xor", 0.5, [layers]).probabilities(rows) > 0.5
    assert np.mean(found == wanted) > 0.93
    assert losses[-1] < 0.5 * losses[0]


@NEEDS_ESPEAK
def test_words_are_said_once_and_kept(tmp_path: Path) -> None:
    voice, remembered = Espeak("en-us", "m1", 50), Remembered(tmp_path)
    first = remembered.say(voice, "hey rosie", 1.0)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    np.savez(tmp_path / "several.npz", a=first)
    np.save(tmp_path / "other.npy", np.zeros((2, 2)))
    unfinished = b"\x93NUMPY\x01\x00\x10\x00{'descr': '<i2',"
    others = [(tmp_path / name).read_bytes() for name in ("several.npz", "other.npy")]
    for damaged in (b"", whole[:50], whole[:-7], unfinished, whole[:128], *others):  # as by a crash, or a full disk
        file.write_bytes(damaged)
        np.testing.assert_array_equal(remembered.say(voice, "hey rosie", 1.0), first)
        assert file.read_bytes() == whole


def test_without_voices_it_says_what_to_install(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="apt install espeak-ng"):
        train("hey rosie", [], None, tmp_path)  # type: ignore[arg-type]


@NEEDS_ESPEAK
@pytest.mark.model
@pytest.mark.parametrize(("phrase", "language"), [("hmm", "en"), ("走", "zh")])
def test_a_phrase_of_which_nothing_like_it_is_known_can_be_trained(
    tmp_path: Path, phrase: str, language: Language
) -> None:
    effort = Effort(phrases=4, rounds=1, epochs=1, networks=1, silences=1, said=0.05)
    trained = train(phrase, find_voices(None, (), (), language)[:16], embedding(), tmp_path, effort=effort)
    assert trained.head.phrase == phrase


@NEEDS_ESPEAK
@pytest.mark.model
def test_training_gives_a_head_that_was_tried_and_can_be_broken_off(tmp_path: Path) -> None:
    voices = find_voices(None, (), ())[:12]
    stages: list[str] = []

    def step(stage: str, done: int, total: int) -> None:
        stages.append(stage)
        assert 0 < done <= total

    effort = Effort(phrases=40, rounds=1, epochs=3, networks=1, silences=5, said=0.2)
    trained = train("hey rosie", voices, embedding(), tmp_path, effort=effort, on_step=step)
    assert list(dict.fromkeys(stages)) == ["speaking", "embedding", "learning", "trying"]
    assert trained.head.trial is not None
    assert trained.head.trial.said > 0
    assert trained.head.trained_by == known_speakers(voices)
    assert trained.points[0].recall["clean"] > 0.5, "even so little training is better than chance"

    def interrupt(stage: str, done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train("hey rosie", voices, embedding(), tmp_path, effort=effort, on_step=interrupt)
    assert not list(tmp_path.glob("*.partial"))
