"""Wake words: what is heard of them does not depend on how sound arrives, and what is said after them is not lost."""

from __future__ import annotations

import asyncio
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import config
from engine.audio.ring import Ring
from engine.audio.source import FRAME_S, Frame
from engine.audio.wav import read_wav
from engine.commands import Wake
from engine.errors import ModelError
from engine.parts.loading import model_store
from engine.wake.choice import DOUBTED, MODEL, SHIPPED, make_spotters
from engine.wake.embedding import RATE, SPAN, STEP, Embedding, Stream
from engine.wake.head import Head
from engine.wake.micro import CUTOFF, DELAY, SOONER, MicroSpotter, is_installed
from engine.wake.trained import TrainedSpotter
from engine.wake.training.voices import Espeak, Sound, trimmed
from engine.wake.words import ASKED_S, Answer, Detections, Doubts, Spotted, Spotter, WordListener

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
LIMIT_S = 20
NEEDS_ESPEAK = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="espeak-ng is not installed")
PIECES = st.lists(st.integers(1, 9000), min_size=1, max_size=12)


def model() -> Path:
    try:
        return model_store(config.load()).find(MODEL)
    except ModelError as error:
        pytest.skip(str(error))


@cache
def embedding() -> Embedding:
    return Embedding(model())


def pcm(sound: Sound) -> NDArray[np.int16]:
    return (sound * 32767).astype(np.int16)


def said(voice: Espeak, text: str) -> NDArray[np.int16]:
    """Somebody says something in a quiet room."""
    room = np.random.default_rng(0).normal(0, 3e-4, 2 * RATE).astype(np.float32)
    word = trimmed(voice.say(text, 1.0))
    return pcm(np.concatenate((room, word + 0 * word, room)))


def cut(sound: NDArray[np.int16], sizes: Sequence[int]) -> Iterator[NDArray[np.int16]]:
    """The sound in pieces of these sizes, over and over."""
    at = 0
    while at < len(sound):
        for size in sizes:
            yield sound[at : at + size]
            at += size


# The embedding


@pytest.mark.model
@settings(max_examples=8)
@given(PIECES)
def test_the_stream_gives_the_rows_of_the_whole_however_sound_is_cut(sizes: list[int]) -> None:
    sound = read_wav(SPEECH / "go_to_the_bedroom_then_turn_around.wav")[: 2 * RATE]
    whole = embedding().stacks(sound / np.float32(32768))
    stream = Stream(embedding())
    rows = [row for piece in cut(sound, sizes) for row in stream.push(piece)]
    assert len(rows) == len(whole) == (len(sound) - SPAN) // STEP + 1
    np.testing.assert_array_equal(np.concatenate(rows), whole)


@pytest.mark.model
def test_a_stream_forgets_what_came_before_a_reset() -> None:
    sound = read_wav(SPEECH / "go_to_the_bedroom_then_turn_around.wav")[: 2 * RATE]
    fresh, used = Stream(embedding()), Stream(embedding())
    list(used.push(sound[::-1].copy()))
    used.reset()
    np.testing.assert_array_equal(list(used.push(sound)), list(fresh.push(sound)))


# Stops


@pytest.mark.model
def test_a_stop_is_spotted_beside_the_words_that_wake_and_by_the_same_embedding() -> None:
    spotters = make_spotters(["hey sayso"], Path("nowhere"), model(), stops=["stop"])
    (spotter,) = spotters
    assert list(spotter.phrases) == ["hey sayso", "stop"]
    sound = read_wav(SPEECH / "stop.wav")
    found = [
        spotted
        for piece in cut(np.concatenate((np.zeros(2 * RATE, np.int16), sound, np.zeros(RATE, np.int16))), [512])
        for spotted in spotter.push(piece)
    ]
    assert [(spotted.phrase, spotted.sure) for spotted in found if spotted.sure] == [("stop", True)]


@pytest.mark.model
def test_a_stop_that_wakes_is_none_that_is_suspected(tmp_path: Path) -> None:
    (spotter,) = make_spotters(["stop"], tmp_path, model(), stops=["stop"])
    assert list(spotter.phrases) == ["stop"]


@pytest.mark.model
def test_where_chinese_is_spoken_a_stop_has_to_be_surer_before_anything_pauses(tmp_path: Path) -> None:
    (english,) = make_spotters([], tmp_path, model(), stops=["stop"])
    (among,) = make_spotters([], tmp_path, model(), stops=["stop", "停"])
    assert isinstance(english, TrainedSpotter)
    assert isinstance(among, TrainedSpotter)
    assert english._doubts["stop"].below == 0.0
    assert among._doubts["stop"].below > Head.load(SHIPPED / "stop.npz").threshold
    assert among._doubts["停"].below == 0.0


def test_without_the_model_nothing_is_listened_for(tmp_path: Path) -> None:
    assert make_spotters([], tmp_path, None, stops=["stop"]) == []


def test_a_threshold_for_wake_words_is_none_for_stops(tmp_path: Path) -> None:
    (spotter,) = make_spotters(["hey sayso"], tmp_path, model(), 0.123, stops=["stop"])
    assert isinstance(spotter, TrainedSpotter)
    assert spotter._thresholds == [0.123, Head.load(SHIPPED / "stop.npz").threshold]


class Certainty:
    """A head that is as sure as the test says, from step to step."""

    phrase, threshold, delay_s, steps = "stop", 0.9, 0.0, 1

    def __init__(self, *probabilities: float) -> None:
        self._probabilities = list(probabilities)

    def probabilities(self, stacks: NDArray[np.float32]) -> NDArray[np.float32]:
        del stacks
        return np.array([self._probabilities.pop(0) if self._probabilities else 0.0], np.float32)


@pytest.mark.model
@pytest.mark.parametrize(
    ("probabilities", "found"),
    [
        ((0.4, 0.6, 0.7), [False]),
        ((0.6, 0.95, 0.99), [False, True]),
        ((0.95, 0.6), [True, False]),
        ((0.4, 0.3), []),
    ],
    ids=["doubtful once", "doubtful, then sure", "sure, then doubtful", "neither"],
)
def test_a_phrase_is_told_as_doubtful_and_as_sure_once_each(
    probabilities: tuple[float, ...], found: list[bool]
) -> None:
    assert [spotted.sure for spotted in told(probabilities, Doubts(above=0.5))] == found


def told(probabilities: tuple[float, ...], doubts: Doubts) -> Sequence[Spotted]:
    head: Any = Certainty(*probabilities)
    spotter = TrainedSpotter(embedding(), [head], doubts={"stop": doubts})
    return spotter.push(np.zeros(SPAN + 8 * STEP, np.int16))


def test_what_is_likely_need_not_be_sure() -> None:
    found = told((0.4, 0.6, 0.91, 0.93, 0.99), Doubts(0.5, 0.98))
    assert [(spotted.likely, spotted.sure) for spotted in found] == [(False, False), (True, False), (True, True)]


@pytest.mark.skipif(not is_installed(), reason="pymicro-wakeword is not installed")
def test_what_its_makers_would_not_take_for_hey_jarvis_is_not_sure() -> None:
    import pymicro_wakeword as library

    makers = library.MicroWakeWord.from_builtin(library.Model.HEY_JARVIS).probability_cutoff
    for probability, sure in ((CUTOFF["hey jarvis"], False), (makers - 0.01, False), (makers + 0.01, True)):
        told = Detections("hey jarvis", CUTOFF["hey jarvis"], DELAY, DOUBTED["hey jarvis"]).take(RATE, probability)
        assert told is not None
        assert (told.likely, told.sure) == (True, sure), probability


# Listening


class Clapping:
    """A spotter that hears every sample above a limit; a phrase ends 100 ms before it is known."""

    phrases = ("clap",)

    def __init__(self) -> None:
        self.resets = 0
        self._heard = 0

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        claps = np.flatnonzero(samples > 1000)
        found = [Spotted("clap", self._heard + int(at), self._heard + int(at) - RATE // 10) for at in claps]
        self._heard += len(samples)
        return found

    def reset(self) -> None:
        self.resets += 1
        self._heard = 0


def silence(seconds: float) -> NDArray[np.int16]:
    return np.zeros(round(seconds * RATE), np.int16)


def clap() -> NDArray[np.int16]:
    sound = silence(0.032)
    sound[-1] = 9000
    return sound


class Woken:
    """Who is woken, and in which thread."""

    def __init__(self, spotter: Spotter, wakes: int = 1) -> None:
        self.wakes: list[Wake] = []
        self.threads: set[str] = set()
        self.faults: list[Exception] = []
        self.enough = threading.Semaphore(0)
        self._expected = wakes
        self.listener = WordListener([spotter], self._wake, self._fail, prompt=False)
        self.listener.start()

    def _wake(self, wake: Wake) -> None:
        self.wakes.append(wake)
        self.threads.add(threading.current_thread().name)
        self.enough.release()

    def _fail(self, error: Exception) -> None:
        self.faults.append(error)
        self.enough.release()

    def wait(self) -> None:
        assert self.enough.acquire(timeout=LIMIT_S), "nothing was heard"


def test_a_wake_acts_in_the_thread_that_listens_and_says_how_long_ago_the_phrase_ended() -> None:
    woken = Woken(Clapping())
    try:
        woken.listener.push(silence(1))
        woken.listener.push(clap())
        woken.wait()
    finally:
        woken.listener.close()
    (wake,) = woken.wakes
    assert (wake.source, wake.phrase) == ("word", "clap")
    assert wake.ago_s == pytest.approx(0.1, abs=0.001)
    assert woken.threads == {"wake-words"}


def test_what_is_heard_twice_within_a_second_wakes_once() -> None:
    woken = Woken(Clapping())
    try:
        for sound in (clap(), silence(0.5), clap(), silence(0.6), clap()):
            woken.listener.push(sound)
        woken.wait()
        woken.wait()
    finally:
        woken.listener.close()
    assert len(woken.wakes) == 2


def test_another_source_begins_anew() -> None:
    spotter = Clapping()
    woken = Woken(spotter)
    try:
        woken.listener.push(clap())
        woken.wait()
        woken.listener.reset()
        woken.listener.push(clap())  # at once, but it is not the same sound any more
        woken.wait()
    finally:
        woken.listener.close()
    assert len(woken.wakes) == 2
    assert spotter.resets >= 1


def test_a_stop_is_suspected_in_the_thread_that_listens_and_wakes_nobody() -> None:
    heard: SimpleQueue[tuple[Spotted, str]] = SimpleQueue()
    wakes: list[Wake] = []
    listener = WordListener(
        [Clapping()],
        wakes.append,
        lambda error: None,
        prompt=False,
        suspect=lambda spotted: heard.put((spotted, threading.current_thread().name)),
        stops=["clap"],
    )
    listener.start()
    try:
        assert listener.phrases == ()
        listener.push(clap())
        spotted, thread = heard.get(timeout=LIMIT_S)
    finally:
        listener.close()
    assert spotted.phrase == "clap"
    assert thread == "wake-words"
    assert wakes == []


class Doubting(Clapping):
    """A spotter that is sure of what is loud, and finds likely what is not soft."""

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        claps = super().push(samples)
        begun = self._heard - len(samples)
        levels = [samples[found.at - begun] for found in claps]
        return [
            replace(found, likely=level > 3000, sure=level > 5000) for found, level in zip(claps, levels, strict=True)
        ]


def softer_clap() -> NDArray[np.int16]:
    return (clap() // 2).astype(np.int16)


def soft_clap() -> NDArray[np.int16]:
    return (clap() // 4).astype(np.int16)


class Asked:
    """A listener, and somebody who is asked whether a clap was one."""

    def __init__(self) -> None:
        self.wakes: SimpleQueue[Wake] = SimpleQueue()
        self.asked: SimpleQueue[tuple[Spotted, NDArray[np.int16], Answer]] = SimpleQueue()
        self.listener = WordListener(
            [Doubting()],
            self.wakes.put,
            lambda error: None,
            prompt=False,
            ask=lambda spotted, sound, answer: self.asked.put((spotted, sound, answer)),
        )

    def __enter__(self) -> Asked:
        self.listener.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.listener.close()

    def hear(self, *sounds: NDArray[np.int16]) -> Answer:
        """Push sounds, the last of which somebody is asked about."""
        self.listener.push(np.concatenate(sounds))
        return self.asked.get(timeout=LIMIT_S)[2]


def test_of_a_doubtful_word_somebody_is_asked_and_it_wakes_once_that_is_known() -> None:
    with Asked() as it:
        before = np.arange(2 * RATE, dtype=np.int16) % 900
        heard = np.concatenate((before, soft_clap(), silence(0.1)))
        it.listener.push(heard[:RATE])
        it.listener.push(heard[RATE:])
        spotted, sound, answer = it.asked.get(timeout=LIMIT_S)
        assert spotted.phrase == "clap"
        assert it.wakes.empty()
        known = int(np.flatnonzero(heard > 1000)[0])
        assert np.array_equal(sound, heard[known - round(ASKED_S * RATE) : known]), "to where it was known, no farther"
        answer(True)
        wake = it.wakes.get(timeout=LIMIT_S)
        assert (wake.source, wake.phrase) == ("word", "clap")
        assert wake.ago_s is not None
        assert 0.2 - 0.001 <= wake.ago_s <= 1.0
        answer(True)
        assert it.wakes.empty(), "once"


@pytest.mark.parametrize(
    ("of", "said", "wakes"),
    [
        (softer_clap, True, True),
        (softer_clap, False, False),
        (softer_clap, None, True),
        (soft_clap, True, True),
        (soft_clap, False, False),
        (soft_clap, None, False),
    ],
)
def test_what_is_likely_counts_where_nobody_can_tell(
    of: Callable[[], NDArray[np.int16]], said: bool | None, wakes: bool
) -> None:
    with Asked() as it:
        it.hear(silence(1), of())(said)
        assert it.wakes.qsize() == wakes


def test_whoever_was_asked_wakes_nobody_if_somebody_was_sure_meanwhile() -> None:
    with Asked() as it:
        answer = it.hear(silence(1), soft_clap())
        it.listener.push(clap())
        assert it.wakes.get(timeout=LIMIT_S).phrase == "clap"
        answer(True)
        assert it.wakes.empty()


def test_whoever_is_sure_a_little_later_does_not_wake_again() -> None:
    with Asked() as it:
        it.hear(silence(1), soft_clap())(True)
        it.wakes.get(timeout=LIMIT_S)
        it.hear(silence(0.3), clap(), silence(1.2), soft_clap())  # asked about the last: the clap before has been heard
        assert it.wakes.empty()
        it.listener.push(clap())
        assert it.wakes.get(timeout=LIMIT_S).phrase == "clap"


def test_two_answers_about_the_same_wake_once() -> None:
    with Asked() as it:
        doubtful = it.hear(silence(1), soft_clap())
        likely = it.hear(silence(0.1), softer_clap())
        doubtful(True)
        likely(True)
        assert it.wakes.qsize() == 1


def test_nobody_is_asked_about_what_has_just_woken() -> None:
    with Asked() as it:
        it.listener.push(np.concatenate((silence(1), clap(), silence(0.5), soft_clap())))  # the echo of a clap
        it.listener.push(np.concatenate((silence(1), soft_clap(), silence(1), clap())))
        it.wakes.get(timeout=LIMIT_S)
        it.wakes.get(timeout=LIMIT_S)
        assert it.asked.qsize() == 1


def test_a_fault_is_told() -> None:
    class Broken(Clapping):
        def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
            raise ZeroDivisionError

    woken = Woken(Broken())
    woken.listener.push(clap())
    woken.wait()
    woken.listener.close()
    assert isinstance(woken.faults[0], ZeroDivisionError)


def test_after_a_fault_no_sound_is_kept_for_nobody() -> None:
    class Broken(Clapping):
        def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
            raise ZeroDivisionError

    woken = Woken(Broken())
    woken.listener.push(clap())
    woken.wait()
    for _ in range(100):
        woken.listener.push(clap())
    assert woken.listener._sound.qsize() == 0
    woken.listener.close()


# What was said since the phrase


def numbered(first: int, count: int) -> list[Frame]:
    return [Frame(silence(FRAME_S), (number + 1) * FRAME_S) for number in range(first, first + count)]


async def given_to_a_listener(ring: Ring, count: int) -> list[int]:
    ring.listen()
    try:
        return [round((await ring.get()).end / FRAME_S) - 1 for _ in range(count)]  # type: ignore[union-attr]
    finally:
        ring.release()


@pytest.mark.parametrize("ago", [0, 3, 10, 25])
def test_a_request_begins_where_the_mark_says(ago: int) -> None:
    async def scenario() -> list[int]:
        ring = Ring(10)
        for frame in numbered(0, 40):
            ring.put(frame)
        ring.mark(ago)
        for frame in numbered(40, 5):
            ring.put(frame)
        return await given_to_a_listener(ring, 5 + ago)

    assert asyncio.run(scenario()) == list(range(40 - ago, 45))


def test_what_one_listener_was_given_since_the_phrase_is_given_to_the_next_one_again() -> None:
    async def scenario() -> list[int]:
        ring = Ring(10)
        for frame in numbered(0, 20):
            ring.put(frame)
        await given_to_a_listener(ring, 10)  # the pre-roll: 10…19
        ring.mark(4)
        ring.put(*numbered(20, 1))
        return await given_to_a_listener(ring, 5)

    assert asyncio.run(scenario()) == [16, 17, 18, 19, 20]


def test_an_ordinary_wake_begins_with_the_pre_roll() -> None:
    async def scenario() -> list[int]:
        ring = Ring(10)
        for frame in numbered(0, 40):
            ring.put(frame)
        ring.mark()
        return await given_to_a_listener(ring, 10)

    assert asyncio.run(scenario()) == list(range(30, 40))


# Real words


@NEEDS_ESPEAK
@pytest.mark.model
@settings(max_examples=4)
@given(PIECES)
def test_hey_sayso_is_heard_once_and_soon_however_sound_is_cut(sizes: list[int]) -> None:
    sound = said(Espeak("en-us", "m3", 50), "hey sayso")
    spotter = TrainedSpotter(embedding(), [Head.load(SHIPPED / "hey_sayso.npz")])
    (spotted,) = [found for piece in cut(sound, sizes) for found in spotter.push(piece)]
    assert abs(spotted.at - (len(sound) - 2 * RATE)) < 0.5 * RATE


@pytest.mark.model
def test_nothing_else_is_taken_for_hey_sayso() -> None:
    spotter = TrainedSpotter(embedding(), [Head.load(SHIPPED / "hey_sayso.npz")])
    for file in sorted(SPEECH.glob("*.wav")):
        assert not spotter.push(read_wav(file)), file


@NEEDS_ESPEAK
@pytest.mark.skipif(not is_installed(), reason="pymicro-wakeword is not installed")
def test_hey_jarvis_is_heard_the_same_however_sound_is_cut() -> None:
    sound = said(Espeak("en-gb-scotland", "f2", 40), "Hey Jarvis")
    spotter = MicroSpotter("hey jarvis")
    found = []
    for sizes in ([len(sound)], [512], [1, 7000, 160]):
        found.append([spotted for piece in cut(sound, sizes) for spotted in spotter.push(piece)])
        spotter.reset()
    assert len(found[0]) == 1
    assert found[0] == found[1] == found[2]


@NEEDS_ESPEAK
@pytest.mark.skipif(not is_installed(), reason="pymicro-wakeword is not installed")
def test_hey_jarvis_is_known_sooner_than_its_makers_chose_and_ends_where_it_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sound = said(Espeak("en-gb-scotland", "f2", 40), "Hey Jarvis")
    (soon,) = MicroSpotter("hey jarvis").push(sound)
    monkeypatch.delitem(SOONER, "hey jarvis")
    (late,) = MicroSpotter("hey jarvis").push(sound)
    assert late.at - soon.at > 0.02 * RATE
    assert abs(late.ended - soon.ended) < 0.05 * RATE


@NEEDS_ESPEAK
@pytest.mark.skipif(not is_installed(), reason="pymicro-wakeword is not installed")
def test_a_hey_jarvis_that_may_be_one_is_told_only_where_doubts_are_wanted() -> None:
    sound = said(Espeak("en-gb-scotland", "f2", 40), "Hey Jarvis")
    assert MicroSpotter("hey jarvis", 1.0).push(sound) == []
    (doubtful,) = MicroSpotter("hey jarvis", 1.0, Doubts(above=0.1)).push(sound)
    assert not doubtful.sure
    (sure,) = [found for found in MicroSpotter("hey jarvis", doubts=Doubts(above=0.1)).push(sound) if found.sure]
    assert sure.at >= doubtful.at
    (chosen,) = make_spotters(["hey jarvis"], SHIPPED, None)
    assert all(found.sure for found in chosen.push(sound))


@pytest.mark.skipif(not is_installed(), reason="pymicro-wakeword is not installed")
def test_another_version_of_the_library_is_one_that_cannot_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    import pymicro_wakeword

    def refusing(self: object, *, model: str) -> None:
        raise AssertionError(model)

    monkeypatch.setattr(pymicro_wakeword.MicroWakeWord, "__init__", refusing)
    monkeypatch.delattr(pymicro_wakeword.MicroWakeWord, "__del__")
    with pytest.raises(ModelError, match="“hey jarvis” cannot be listened for") as caught:
        MicroSpotter("hey jarvis")
    assert "pip install" in str(caught.value)
