"""Chinese wake words and stops: characters become the right sounds, who tries has not trained, and what stops is
listened for where Chinese is spoken.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import config
from engine.errors import ModelError, UsageError
from engine.parts.loading import model_store
from engine.parts.words import stops_of
from engine.planner.phrases.stopping import is_stop
from engine.wake.choice import MODEL, make_spotters, stop_words
from engine.wake.embedding import RATE
from engine.wake.training import chinese
from engine.wake.training.casting import roles, takes
from engine.wake.training.mandarin import VOICE, signs
from engine.wake.training.texts import near, talk, ways_to_say
from engine.wake.training.voices import Espeak, Kokoro, KokoroVoice, Language, find_voices, trimmed
from tui import cli
from tui.commands.wake import train

NEEDS_ESPEAK = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="espeak-ng is not installed")


def spoken(text: str) -> str:
    command = ["espeak-ng", "-q", "-x", "-v", VOICE, "--", text]
    return signs(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


@NEEDS_ESPEAK
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("停", "tʰi↗ŋ"),
        ("别动", "pje↗ tʊ↘ŋ"),
        ("听", "tʰi→ŋ"),
        ("挺", "tʰi↓ŋ"),
        ("小叽", "ɕjau↓ ʨi→"),
        ("知识", "ꭧɨ→ ʂɨ"),
        ("圆圈", "ɥɛ↗n ʨʰɥɛ→n"),
        ("ting2 zhuang4", "tʰi↗ŋ ꭧwa↘ŋ"),
    ],
)
def test_characters_and_pinyin_become_syllables_with_tones(text: str, said: str) -> None:
    assert spoken(text).replace(" ", "").startswith(said.replace(" ", ""))


def test_what_is_no_syllable_is_left_out() -> None:
    assert signs("th'i35N_| l'i35N_:_| t'A21_|") == "tʰi↗ŋ ta↓"
    assert signs("") == ""


@NEEDS_ESPEAK
def test_every_character_that_is_said_in_training_has_a_sound() -> None:
    characters = sorted(
        {sign for text in (*talk("zh"), *chinese.WORDS, *near("停", 200)) for sign in text} - set("，、。？！")
    )
    assert len(spoken("。".join(characters)).split()) == len(characters) > 300


def test_what_stands_for_a_stop_stops_and_nothing_else_that_is_said_does() -> None:
    assert all(is_stop(way) for way in ways_to_say("停"))
    others = (*talk("zh"), *chinese.WORDS, *near("停", 200))
    assert [text for text in others if is_stop(text)] == []


@pytest.mark.parametrize("phrase", ["停", "小叽小叽", "你好小智"])
def test_what_is_like_a_chinese_phrase_is_never_the_phrase(phrase: str) -> None:
    texts = near(phrase, 200)
    assert len(texts) == len(set(texts)) > 10
    assert not {phrase, *(way[:-1] for way in ways_to_say(phrase))} & set(texts)


def test_who_speaks_another_language_only_talks() -> None:
    amounts = {"phrases": 5, "near": 4, "others": 3, "rambling": 2, "slips": 2}
    own, others = takes("停", Espeak(VOICE, "m1", 50), **amounts)
    assert [take.text for take in own if take.phrase] == list(ways_to_say("停"))
    assert (len(own), len(others)) == (9, 7)
    own, others = takes("停", Espeak("en-us", "m1", 50), **amounts)
    assert (own, len(others)) == ([], 5)
    assert all(take.text.isascii() for take in others)


def kokoro(language: Language, *speakers: str) -> list[KokoroVoice]:
    style = np.zeros((1, 256), np.float32)
    return [KokoroVoice(Kokoro(None), speaker, style, language) for speaker in speakers]  # type: ignore[arg-type]


def test_the_voices_of_one_language_do_not_change_the_roles_of_another() -> None:
    english = [Espeak("en-us", f"m{number}", 50) for number in range(1, 9)]
    chinese_too = [*english, *kokoro("zh", "za", "zb", "zc")]
    assert {**roles(english), **roles(chinese_too)} == roles(chinese_too)


@NEEDS_ESPEAK
def test_espeak_speaks_both_languages_and_says_different_things_in_them() -> None:
    assert {voice.language for voice in find_voices(None, (), ())} == {"en"}
    assert {voice.language for voice in find_voices(None, (), (), "zh")} == {"zh"}


@pytest.mark.parametrize(
    ("language", "stops"), [("en", ["stop"]), ("zh", ["stop", "停"]), ("auto", ["stop", "停"]), ("fr", ["stop"])]
)
def test_stops_are_listened_for_in_the_languages_that_are_spoken(language: str, stops: Sequence[str]) -> None:
    settings = config.load(overrides=[f"asr.language={language}"])
    assert stops_of(settings, ()) == stops
    assert stops_of(settings, ["stop"]) == [stop for stop in stops if stop != "stop"], "what wakes stops nothing"


@NEEDS_ESPEAK
@pytest.mark.model
@pytest.mark.parametrize("text", ["停下！", "停下来！", "停止！", "别动！"])
def test_a_chinese_stop_is_spotted_beside_the_english_one_and_by_the_same_embedding(text: str, tmp_path: Path) -> None:
    try:
        folder = model_store(config.load()).find(MODEL)
    except ModelError as error:
        pytest.skip(str(error))
    (spotter,) = make_spotters([], tmp_path, folder, stops=stop_words(["zh"]))
    assert list(spotter.phrases) == ["stop", "停"]
    quiet = np.random.default_rng(0).normal(0, 3, 2 * RATE)
    said = trimmed(Espeak(VOICE, "m1", 50).say(text, 1.0)) * 16000
    found = spotter.push(np.concatenate((quiet, said, quiet)).astype(np.int16))
    assert [spotted.phrase for spotted in found if spotted.sure] == ["停"]
    assert 0 <= found[-1].at - len(quiet) <= len(said) + 0.3 * RATE


def test_what_is_in_neither_writing_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for phrase in ("привет робот", "hey 小叽", "小叽2"):
        assert cli.main(["wake", "train", phrase]) == 2
        assert "neither in English letters nor in Chinese characters" in capsys.readouterr().err


def test_without_chinese_voices_a_chinese_phrase_is_not_trained() -> None:
    voices = [Espeak("en-us", f"m{number}", 50) for number in range(30)]
    with pytest.raises(UsageError, match="There are 0 synthetic voices"):
        train("小叽小叽", voices, None, None)  # type: ignore[arg-type]
