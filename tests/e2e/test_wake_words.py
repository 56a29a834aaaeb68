"""A wake word and a request in one breath: the robot wakes, and understands what came after the word."""

from __future__ import annotations

import base64
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import config
from engine.audio.wav import read_wav
from engine.errors import SaysoError
from engine.parts.loading import model_store
from engine.wake.choice import MODEL
from engine.wake.embedding import RATE
from engine.wake.micro import is_installed
from engine.wake.training.voices import Espeak, trimmed
from tests.e2e.engine import Engine, engine

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
PIECE = RATE // 10


def has_embedding() -> bool:
    try:
        return bool(model_store(config.load()).find(MODEL))
    except SaysoError:
        return False


def say(running: Engine, sound: np.ndarray) -> None:
    """At a microphone: no faster than one can speak."""
    began = time.monotonic()
    for at in range(0, len(sound), PIECE):
        running.send(do="audio", pcm=base64.b64encode(sound[at : at + PIECE].astype("<i2").tobytes()).decode())
        time.sleep(max(0.0, began + (at + PIECE) / RATE - time.monotonic()))


WORDS: dict[str, tuple[Callable[[], bool], Espeak]] = {
    "hey jarvis": (is_installed, Espeak("en-gb-scotland", "f2", 40)),
    "hey sayso": (has_embedding, Espeak("en-us", "m3", 50)),
}


@pytest.mark.model
@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="espeak-ng is not installed")
@pytest.mark.parametrize("phrase", WORDS)
def test_what_is_said_in_one_breath_with_the_wake_word_is_understood(phrase: str, tmp_path: Path) -> None:
    installed, voice = WORDS[phrase]
    if not installed():
        pytest.skip(f"what hears “{phrase}” is not installed")
    word = (trimmed(voice.say(phrase, 1.0)) * 16000).astype(np.int16)
    room = np.random.default_rng(0).normal(0, 5, 2 * RATE).astype(np.int16)
    request = trimmed(read_wav(SPEECH / "go_to_the_kitchen.wav") / np.float32(32768))
    options = ("--set", f"wake.words=[{phrase}]")
    with engine(tmp_path, "", *options) as running:
        waited = {"robot", "recogniser", "wake words"}
        while waited:
            waited.discard(running.until("log")["source"])
        breath = room[: RATE // 10]
        say(running, np.concatenate((room, word, breath, (request * 16000).astype(np.int16), room)))
        woken = running.until("wake.heard")
        assert (woken["source"], woken["phrase"]) == ("word", phrase)
        text = running.until("transcript.final")["text"].casefold()
        assert "go to the kitchen" in text
        assert not set(phrase.split()) & set(text.replace(",", "").split()), "the word itself is no part of the request"
        assert [action["name"] for action in running.until("plan.made")["actions"]] == ["navigation"]
        assert [event["kind"] for event in running.seen].count("wake.heard") == 1
