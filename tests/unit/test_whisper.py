"""What Whisper makes of speech, of silence, and of a broken model."""

from __future__ import annotations

import functools
import math
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from config.folders import paths
from config.schema import Asr
from engine.asr.recogniser import Decoding, Rejected, RejectReason, Transcript
from engine.asr.whisper import FILES, NEARLY, UNCLEAR_LOGPROB, WhisperRecogniser, after, judge
from engine.audio.source import RATE
from engine.audio.wav import read_wav
from engine.errors import ExitCode, ModelError
from engine.lead import Lead
from engine.models import ModelStore
from tests.bench.speech import hum, mixed
from tests.bench.wer import errors, normalised

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
NOUNS = ("kitchen", "living room", "bedroom", "study", "hall", "charging dock")
SETTINGS = Asr(
    backend="whisper", model="whisper-base", platform=None, server=None, language="en", languages=("en", "zh"),
    threads=2, window_s=10, min_logprob=-1.1, max_no_speech=0.5,
)  # fmt: skip


@functools.cache
def model_folder() -> Path:
    """Where whisper-base is; skips the test when it is not on this machine."""
    try:
        return ModelStore(paths().models).find("whisper-base")
    except ModelError as error:
        pytest.skip(f"whisper-base is needed: {error}")


@functools.cache
def recogniser() -> WhisperRecogniser:
    loaded = WhisperRecogniser(model_folder(), SETTINGS)
    loaded.load()
    return loaded


def spoken(*names: str) -> NDArray[np.float32]:
    return np.concatenate([read_wav(SPEECH / name) for name in names]).astype(np.float32) / np.float32(32768)


# Speech


@pytest.mark.model
def test_the_demo_commands_are_understood() -> None:
    index = yaml.safe_load((SPEECH / "index.yaml").read_text(encoding="utf-8"))
    wrong = words = 0
    for row in index:
        heard = recogniser().transcribe(spoken(row["file"]), NOUNS)
        assert isinstance(heard, Transcript), (row["text"], heard)
        assert heard.decoding.language == "en"
        assert 0 < heard.confidence <= 1
        wrong += errors(normalised(row["text"]), normalised(heard.text))
        words += len(normalised(row["text"]))
    assert wrong / words <= 0.1


@pytest.mark.model
@pytest.mark.parametrize("name", ["go_to_the_kitchen.wav", "raise_your_arm.wav", "end_the_current_task.wav"])
def test_what_noise_makes_unclear_is_looked_at_in_the_full_window_but_not_by_a_quick_look(name: str) -> None:
    words = read_wav(SPEECH / name)
    sound = mixed(words, np.resize(hum(len(words) / RATE, 1), len(words)), 5.0) * np.float32(1 / 32768)
    quick, found = (recogniser().transcribe(sound, NOUNS, quick=quick) for quick in (True, False))
    assert isinstance(quick, Transcript)
    assert isinstance(found, Transcript)
    assert quick.decoding.avg_logprob < UNCLEAR_LOGPROB
    assert (quick.decoding.window_s, found.decoding.window_s) == (10.0, 30.0)
    assert found.confidence >= quick.confidence
    if quick.confidence > found.confidence * math.exp(-NEARLY / 2):
        assert quick.text in (found.text, *found.others), "what was nearly as likely is not forgotten"


@pytest.mark.model
def test_a_short_command_takes_the_short_window_and_says_the_same_as_with_the_long_one() -> None:
    full = WhisperRecogniser(model_folder(), SETTINGS.model_copy(update={"window_s": 30.0}))
    sound = spoken("go_to_the_kitchen.wav")
    short, long = recogniser().transcribe(sound), full.transcribe(sound)
    assert short.decoding is not None
    assert long.decoding is not None
    assert (short.decoding.window_s, long.decoding.window_s) == (10.0, 30.0)
    assert normalised(short.text) == normalised(long.text)


@pytest.mark.model
def test_speech_longer_than_the_window_is_heard_to_its_end() -> None:
    names = ("go_to_the_bedroom_then_turn_around", "move_forward_one_metre", "turn_left_ninety_degrees") * 2
    heard = recogniser().transcribe(spoken(*(f"{name}.wav" for name in names)), NOUNS)
    assert isinstance(heard, Transcript)
    assert heard.decoding.audio_s > 11
    assert heard.decoding.window_s > heard.decoding.audio_s
    assert "degrees" in " ".join(normalised(heard.text)[-3:])


@pytest.mark.model
def test_the_language_is_found_among_those_that_are_spoken_here() -> None:
    automatic = SETTINGS.model_copy(update={"language": "auto"})
    chinese = WhisperRecogniser(model_folder(), automatic.model_copy(update={"languages": ("zh",)}))
    either = WhisperRecogniser(model_folder(), automatic)
    sound = spoken("go_to_the_kitchen.wav")
    for made, language in ((chinese, "zh"), (either, "en")):
        found = made.transcribe(sound, (*NOUNS, "厨房"))
        assert found.decoding is not None
        assert found.decoding.language == language
    assert ", auto, " in either.name


# What was said right before it

KITCHEN, TURN = "go_to_the_kitchen.wav", "turn_left_ninety_degrees.wav"


def behind(first: str, request: NDArray[np.float32], cut_s: float, text: str = "go to the kitchen") -> Lead:
    """A lead that ends so far in the request, which loses that."""
    whole = np.concatenate((spoken(first), request[: round(cut_s * RATE)]))
    return Lead(text, (whole * 32768).astype(np.int16))


@pytest.mark.model
@pytest.mark.parametrize("cut_s", [0.0, 0.2])
@pytest.mark.parametrize("quick", [False, True])
def test_a_request_is_understood_behind_what_is_known_wherever_it_is_cut(cut_s: float, quick: bool) -> None:
    request = spoken(TURN)
    rest = request[round(cut_s * RATE) :]
    found = recogniser().transcribe(rest, NOUNS, quick=quick, lead=behind(KITCHEN, request, cut_s))
    assert isinstance(found, Transcript)
    assert normalised(found.text) == normalised("turn left 90 degrees")
    assert found.text[0].isupper(), "a sentence of its own"
    assert found.decoding.audio_s == len(rest) / RATE
    alone = recogniser().transcribe(request, NOUNS, quick=quick)
    assert alone.decoding is not None
    assert found.decoding.avg_logprob == pytest.approx(alone.decoding.avg_logprob, abs=0.15), "of the request alone"
    assert not any("kitchen" in other.lower() for other in found.others)


@pytest.mark.model
def test_a_look_without_a_lead_is_another_one_than_with_it() -> None:
    sound = spoken(TURN)
    made = recogniser()
    for lead in (None, behind(KITCHEN, sound, 0.0), None):
        found = made.transcribe(sound, NOUNS, quick=True, lead=lead)
        assert normalised(found.text) == normalised("turn left 90 degrees")


@pytest.mark.model
def test_nothing_but_what_is_known_is_no_speech() -> None:
    rest = np.random.default_rng(0).normal(0, 0.0005, RATE).astype(np.float32)
    found = recogniser().transcribe(rest, NOUNS, lead=behind(KITCHEN, rest, 0.0))
    assert isinstance(found, Rejected)
    assert (found.reason, found.text) == ("no_speech", "")
    assert "go to the kitchen" in found.detail


@pytest.mark.parametrize(
    ("written", "left"),
    [
        (" Hey Jarvis, go to the kitchen.", "Go to the kitchen."),
        (" Hey Jarvis, Stop!", "Stop!"),
        (" Hey Jarvis, go to the kitchen,", "Go to the kitchen"),
        (" Hey Jarvis, Hey, Jarvis. Hey jarvis turn left.", "Turn left."),
        (" Hey Jarvis, Hey Jarvis.", ""),
        (" Hey Jarvis, Hey", ""),
        (" Hey Jarvis,", ""),
        (" Hey Jarvis, Hey Jarvisson is here.", "Hey Jarvisson is here."),
        (" Hey Jarvis, 去厨房", "去厨房"),
    ],
)
def test_what_had_to_come_first_is_no_part_of_a_text(written: str, left: str) -> None:
    assert after("Hey Jarvis,", written) == left


def test_a_text_that_had_to_begin_with_nothing_is_left_as_it_is() -> None:
    assert after("", " go, go. ") == "go, go."


def test_a_text_does_not_end_in_a_comma() -> None:
    assert after("", " Go to the kitchen, ") == "Go to the kitchen"


@pytest.mark.model
def test_the_language_is_that_of_the_request_and_a_chinese_lead_invites_nobody_to_write_chinese() -> None:
    either = WhisperRecogniser(model_folder(), SETTINGS.model_copy(update={"language": "auto"}))
    sound = spoken(TURN)
    found = either.transcribe(sound, NOUNS, lead=behind(KITCHEN, sound, 0.0, "你好小智"))
    assert isinstance(found, Transcript)
    assert found.decoding.language == "en"
    assert normalised(found.text) == normalised("turn left 90 degrees")


# How likely a text is

STOPS = ("Stop", "stop")


@pytest.mark.model
def test_what_was_said_is_likelier_than_what_was_not() -> None:
    stop, kitchen = spoken("stop.wav"), spoken("go_to_the_kitchen.wav")
    made = recogniser()
    said = made.likelihood(stop, STOPS)
    assert said is not None
    assert -1.5 < said <= 0
    for sound, texts in ((kitchen, STOPS), (stop, ("Go to the kitchen",)), (stop, ("Stop the train",))):
        other = made.likelihood(sound, texts)
        assert other is not None
        assert other < said - 4
    assert made.likelihood(stop, ("Kitchen", "stop", "Stop")) == pytest.approx(said, abs=1e-3), "however many are asked"
    assert made.likelihood(stop, ("Stop", "Stop the train", "Stop", "stop")) == pytest.approx(said, abs=1e-3)
    both = made.likelihood(kitchen, ("Go to", "Go to the kitchen"))
    assert both == pytest.approx(made.likelihood(kitchen, ("Go to the kitchen",)), abs=1e-3)


@pytest.mark.model
def test_the_beginning_of_a_sentence_was_not_said_alone() -> None:
    start, whole = spoken("go_to_the_kitchen.wav"), ("Go", "Go to the")
    likelihood = recogniser().likelihood(start, whole)
    assert likelihood is not None
    assert likelihood < -4


@pytest.mark.model
def test_asking_for_a_likelihood_changes_nothing_of_what_is_recognised_next() -> None:
    sound, made = spoken("go_to_the_kitchen.wav"), recogniser()
    before = made.transcribe(sound, NOUNS)
    made.likelihood(sound, STOPS)
    after = made.transcribe(sound, NOUNS)
    assert isinstance(before, Transcript)
    assert isinstance(after, Transcript)
    assert after.text == before.text


@pytest.mark.model
def test_of_what_it_cannot_hear_it_says_nothing() -> None:
    sound = spoken("stop.wav")
    assert recogniser().likelihood(sound[:100], STOPS) is None
    assert recogniser().likelihood(sound, STOPS, lambda: True) is None


# What is no speech


@pytest.mark.model
@pytest.mark.parametrize("vocabulary", [(), NOUNS])
def test_silence_and_noise_become_no_command(vocabulary: tuple[str, ...]) -> None:
    random = np.random.default_rng(5)
    time = np.arange(2 * RATE) / RATE
    sounds: list[NDArray[np.float32]] = [np.zeros(round(seconds * RATE), np.float32) for seconds in (0.5, 2, 5)]
    sounds += [random.normal(0, level, 2 * RATE).astype(np.float32) for level in (0.0005, 0.01, 0.1)]
    sounds.append((0.1 * np.sin(2 * np.pi * 50 * time)).astype(np.float32))
    for sound in sounds:
        assert isinstance(recogniser().transcribe(sound, vocabulary), Rejected)


@pytest.mark.model
def test_sound_too_short_for_a_word_is_not_even_decoded() -> None:
    answer = recogniser().transcribe(np.zeros(RATE // 10, np.float32))
    assert isinstance(answer, Rejected)
    assert answer.reason == "too_short"
    assert answer.decoding is None


def decoding(logprob: float = -0.2, no_speech: float = 0.02) -> Decoding:
    return Decoding("en", logprob, no_speech, audio_s=2.0, decode_s=0.2, window_s=10.0)


@pytest.mark.parametrize(
    ("text", "logprob", "no_speech", "reason"),
    [
        ("", -0.2, 0.02, "empty"),
        (" ... ", -0.2, 0.02, "empty"),
        ("[Music]", -0.2, 0.02, "empty"),
        ("♪ la la la ♪", -0.2, 0.02, "empty"),
        ("Go to the kitchen.", -1.2, 0.02, "low_confidence"),
        ("Go to the kitchen.", -0.2, 0.7, "no_speech"),
        ("Thanks for watching!", -0.2, 0.02, "artefact"),
        ("You", -0.2, 0.02, "artefact"),
        ("The kitchen, living room, bedroom.", -0.2, 0.02, "artefact"),
        ("kitchen, living room, bedroom, study, hall", -0.2, 0.02, "artefact"),
    ],
)
def test_a_text_that_is_no_command_is_turned_down_with_the_reason(
    text: str, logprob: float, no_speech: float, reason: RejectReason
) -> None:
    answer = judge(text, decoding(logprob, no_speech), SETTINGS, NOUNS)
    assert isinstance(answer, Rejected)
    assert answer.reason == reason
    assert answer.text == text
    assert answer.detail


@pytest.mark.parametrize(
    "text", ["Stop.", "The kitchen.", "The bedroom, then the hall.", "Thank you, now stop.", "Turn left 90°.", "停下"]
)
def test_a_command_passes_however_short(text: str) -> None:
    answer = judge(text, decoding(-1.0, 0.3), SETTINGS, NOUNS)
    assert isinstance(answer, Transcript)
    assert answer.text == text


@pytest.mark.model
def test_a_cancelled_recogniser_does_not_try_the_long_window() -> None:
    noise = np.random.default_rng(0).normal(0, 0.05, 3 * RATE).astype(np.float32)
    strict = WhisperRecogniser(model_folder(), SETTINGS.model_copy(update={"max_no_speech": 1.0}))
    assert (kept := strict.transcribe(noise).decoding) is not None
    assert (cancelled := strict.transcribe(noise, cancelled=lambda: True).decoding) is not None
    assert (kept.window_s, cancelled.window_s) == (30.0, 10.0)


@pytest.mark.model
def test_who_is_not_needed_any_more_writes_nothing_and_knows_it_the_next_time(monkeypatch: pytest.MonkeyPatch) -> None:
    made = recogniser()
    sound, asked = spoken("go_to_the_kitchen.wav"), []
    encode = made._model.encode
    monkeypatch.setattr(made._model, "encode", lambda features: asked.append(1) or encode(features))
    assert isinstance(made.transcribe(sound, cancelled=lambda: bool(asked), quick=True), Rejected)
    assert made.transcribe(sound, quick=True).text == "Go to the kitchen."


@pytest.mark.model
def test_a_thorough_look_at_what_a_quick_one_has_seen_only_looks_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(0).normal(0, 0.05, 3 * RATE).astype(np.float32)
    strict = WhisperRecogniser(model_folder(), SETTINGS.model_copy(update={"max_no_speech": 1.0}))
    quick = strict.transcribe(noise, quick=True)
    assert quick.decoding is not None
    assert quick.decoding.doubtful
    looked: list[float] = []
    decode = strict._decode

    def watched(samples: NDArray[np.float32], vocabulary: Sequence[str], window_s: float, cancelled: Any) -> Any:
        looked.append(window_s)
        return decode(samples, vocabulary, window_s, cancelled)

    monkeypatch.setattr(strict, "_decode", watched)
    strict.transcribe(noise.copy())
    strict.transcribe(noise[RATE:], quick=True)
    assert looked == [30.0, 10.0]


# Broken models


def test_an_incomplete_model_says_which_file_is_missing(tmp_path: Path) -> None:
    (tmp_path / "model.bin").write_bytes(b"")
    with pytest.raises(ModelError, match=r"config\.json is missing") as caught:
        WhisperRecogniser(tmp_path, SETTINGS).load()
    assert caught.value.exit_code is ExitCode.MISSING
    assert "asr.model" in caught.value.hint, "a folder of the user's own is fetched by nobody"


@pytest.mark.model
@pytest.mark.parametrize("damaged", FILES)
def test_a_damaged_model_is_an_error_with_a_way_out(tmp_path: Path, damaged: str) -> None:
    for path in model_folder().iterdir():
        if path.name != damaged:
            (tmp_path / path.name).symlink_to(path)
    shutil.copyfile(model_folder() / damaged, tmp_path / damaged)
    with (tmp_path / damaged).open("r+b") as file:
        file.truncate(1000)
    with pytest.raises(ModelError, match="cannot be loaded") as caught:
        WhisperRecogniser(tmp_path, SETTINGS).load()
    assert str(tmp_path) in caught.value.message
    assert "sayso models verify" in caught.value.hint


@pytest.mark.model
def test_a_language_that_the_model_does_not_know_is_an_error() -> None:
    with pytest.raises(ModelError, match="does not know the language 'tlh'"):
        WhisperRecogniser(model_folder(), SETTINGS.model_copy(update={"language": "tlh"})).load()
