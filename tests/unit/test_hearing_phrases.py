"""What is said right behind a phrase that woke, and whether that was said."""

from __future__ import annotations

import asyncio
import threading

import numpy as np
import pytest

from engine.asr.whisper import WhisperRecogniser
from engine.audio.endpoint import Utterance
from engine.audio.pipe import PushSource
from engine.audio.source import FRAME_SAMPLES, RATE
from engine.audio.wav import read_wav
from engine.errors import ModelError
from engine.hearing.transcriber import LESS_FITS, LIKELY_SAID, SAID, ends_with
from tests.bench.speech import mixed as in_noise
from tests.bench.speech import speech_bounds
from tests.unit.hears import COMMAND, SPEECH, Scripted, all_read, an_utterance, ears, quiet
from tests.unit.test_whisper import SETTINGS, model_folder

# What was said right before a request

BEFORE = np.arange(RATE, dtype=np.int16)


@pytest.mark.parametrize("cut_s", [0.0, 0.2])
def test_the_recogniser_is_told_of_a_phrase_that_a_request_follows_without_a_pause(cut_s: float) -> None:
    async def scenario() -> None:
        source, cut = PushSource(), round(cut_s * RATE)
        async with ears(lambda: source) as it:
            source.push(np.concatenate((quiet(1), BEFORE, COMMAND[:cut])).tobytes())
            await all_read()
            it.hearing.mark(0.0, "hey jarvis")
            source.push(np.concatenate((COMMAND[cut:], quiet(1))).tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            await it.hearing.transcribe(heard, it.emit)
        everything = np.concatenate((quiet(1), BEFORE, COMMAND, quiet(1)))
        marked = (2 * RATE + cut) // FRAME_SAMPLES * FRAME_SAMPLES  # what was heard then, in whole frames
        assert it.recogniser.passes
        for given in it.recogniser.passes:
            assert given.lead is not None
            assert given.lead.text == "hey jarvis"
            whole = np.concatenate((given.lead.samples, (given.samples * 32768).astype(np.int16)))
            start = marked - len(given.lead.samples)
            assert len(given.lead.samples) == 32 * FRAME_SAMPLES, "about a second"
            assert np.array_equal(whole, everything[start : start + len(whole)]), "without a gap"

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("ago_s", "phrase", "pause_s"),
    [(0.0, "hey jarvis", 0.5), (None, "hey jarvis", 0.0), (0.0, "", 0.0), (0.0, "hey " * 99, 0.0)],
)
def test_what_came_before_a_pause_or_is_not_known_is_not_told(ago_s: float | None, phrase: str, pause_s: float) -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            source.push(np.concatenate((quiet(1), BEFORE)).tobytes())
            await all_read()
            it.hearing.mark(ago_s, phrase)
            source.push(np.concatenate((quiet(pause_s), COMMAND, quiet(1))).tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            await it.hearing.transcribe(heard, it.emit)
        assert it.recogniser.passes
        assert [given.lead for given in it.recogniser.passes] == [None] * len(it.recogniser.passes)

    asyncio.run(scenario())


def test_a_request_that_follows_a_phrase_in_noise_without_a_pause_is_heard_from_its_beginning() -> None:
    words = read_wav(SPEECH / "raise_your_arm.wav")
    begin, end = (round(at * RATE) for at in speech_bounds(words))
    words = words[begin:end]
    half = round(0.6 * len(words)) // FRAME_SAMPLES * FRAME_SAMPLES  # the phrase ends in the midst of a word
    voice = np.concatenate((quiet(0.96), words, quiet(1)))
    sound = in_noise(voice, np.random.default_rng(1).normal(0, 1000, len(voice)).astype(np.int16), 5.0)
    marked = round(0.96 * RATE) + half

    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            source.push(sound[:marked].tobytes())
            await all_read()
            it.hearing.mark(0.0, "hey jarvis")
            source.push(sound[marked:].tobytes())
            heard = await it.hearing.listen(it.emit)
            assert isinstance(heard, Utterance)
            assert heard.lead is not None
            assert heard.start == pytest.approx(marked / RATE)

    asyncio.run(scenario())


def test_a_phrase_counts_for_the_listening_that_it_woke_and_for_no_other() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source) as it:
            for phrase in ("hey jarvis", None):
                source.push(np.concatenate((quiet(1), BEFORE)).tobytes())
                await all_read()
                if phrase is not None:
                    it.hearing.mark(0.0, phrase)
                source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
                heard = await it.hearing.listen(it.emit)
                assert isinstance(heard, Utterance)
                assert (heard.lead is not None) == (phrase is not None)

    asyncio.run(scenario())


# Whether a phrase was said


@pytest.mark.parametrize(
    ("likelihood", "likely", "said"),
    [
        (SAID + 0.1, False, True),
        (SAID - 0.1, False, False),
        (LIKELY_SAID + 0.1, True, True),
        (LIKELY_SAID - 0.1, True, False),
        (None, True, None),
    ],
)
def test_a_phrase_was_said_where_the_recogniser_finds_it_likely(
    likelihood: float | None, likely: bool, said: bool | None
) -> None:
    async def scenario() -> None:
        answers: list[tuple[bool | None, bool]] = []

        def answer(said: bool | None) -> None:
            answers.append((said, threading.current_thread().name.startswith("recogniser")))

        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = likelihood
            it.hearing.ask("hey jarvis", COMMAND, answer, likely=likely)
            await it.recogniser_is_idle()
        assert answers == [(said, True)]
        assert {"hey jarvis", "Hey Jarvis"} <= set(it.recogniser.weighed[0])
        it.hearing.ask("hey jarvis", COMMAND, answer, likely=likely)  # after the end, and nothing comes of it
        assert len(answers) == 1

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("phrase", "instead", "less", "said"),
    [
        ("hey jarvis", "Jarvis", LESS_FITS + 0.1, False),
        ("hey jarvis", "Jarvis", LESS_FITS - 0.1, True),
        ("okay computer please", "Computer, Please", LESS_FITS + 0.1, False),
        ("okay computer please", "please", LESS_FITS + 0.1, False),
        ("alexa", "Alexa", LESS_FITS + 0.1, True),
    ],
)
@pytest.mark.parametrize("likely", [True, False])
def test_a_phrase_was_not_said_where_its_last_words_alone_are_much_likelier(
    phrase: str, instead: str, less: float, said: bool, likely: bool
) -> None:
    made = Scripted()
    made.likely = SAID + 1
    made.likelier[instead] = SAID + 1 + less
    assert ends_with(made, phrase, COMMAND, likely=likely) is said


@pytest.mark.model
@pytest.mark.parametrize("likely", [True, False])
def test_who_says_the_last_words_of_a_phrase_alone_has_not_said_the_phrase(likely: bool) -> None:
    whisper, stop = WhisperRecogniser(model_folder(), SETTINGS), read_wav(SPEECH / "stop.wav")
    for sound, phrase in ((COMMAND, "hey go to the kitchen"), (COMMAND, "okay hey kitchen"), (stop, "hey stop")):
        assert not ends_with(whisper, phrase, sound, likely=likely), phrase
    for sound, phrase in ((COMMAND, "go to the kitchen"), (stop, "stop")):
        assert ends_with(whisper, phrase, sound, likely=likely), phrase


def test_nobody_is_asked_about_a_phrase_before_the_recogniser_is_there_nor_while_somebody_is_listened_to() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            it.recogniser.likely = 0.0
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=False)
            assert answers == [None]
            await it.hearing.load()
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await all_read()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=False)
            assert answers == [None, None]
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
            await it.recogniser_is_idle()
            assert it.recogniser.weighed == []

    asyncio.run(scenario())


def test_what_nobody_needs_to_know_any_more_is_not_looked_at() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = 0.0
            held = threading.Event()
            it.hearing._transcriber.thread.submit(held.wait)
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await all_read()
            held.set()
            await it.recogniser_is_idle()
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
        assert answers == [None]
        assert it.recogniser.weighed == []

    asyncio.run(scenario())


def test_while_somebody_waits_to_be_understood_nobody_is_asked_about_a_phrase() -> None:
    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource) as it:
            await it.hearing.load()
            it.recogniser.likely = 0.0
            it.recogniser.may_answer.clear()
            understanding = asyncio.create_task(it.hearing.transcribe(an_utterance(), it.emit))
            await all_read()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            assert answers == [None]
            it.recogniser.may_answer.set()
            await understanding

    asyncio.run(scenario())


def test_a_recogniser_that_fails_cannot_tell() -> None:
    class Failing(Scripted):
        def likelihood(self, *given: object) -> float:
            raise ModelError("The recogniser has died.")

    async def scenario() -> None:
        answers: list[bool | None] = []
        async with ears(PushSource, Failing()) as it:
            await it.hearing.load()
            it.hearing.ask("hey jarvis", COMMAND, answers.append, likely=True)
            await it.recogniser_is_idle()
        assert answers == [None]

    asyncio.run(scenario())
