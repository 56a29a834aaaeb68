"""When an utterance starts and ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema import Endpoint
from engine.audio.endpoint import RESUME_FRAMES, Ended, Endpointer, Started
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame
from engine.audio.vad import VadResult
from engine.lead import Lead

SETTINGS = Endpoint(
    pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=3, no_speech_s=2
)
START, SILENCE, LONGEST, NO_SPEECH, PRE_ROLL = 4, 19, 93, 63, 10  # the settings, in frames of 32 ms


LEAD = Lead("hey jarvis", np.zeros(RATE, np.int16))


def hear(
    pattern: Sequence[bool], settings: Endpoint = SETTINGS, lead: Lead | None = None
) -> tuple[Started | None, Ended | None, int]:
    """Push one frame per entry (is it speech?); frame ``i`` holds the number ``i``. Until the end, or all of them."""
    machine = Endpointer(settings, lead)
    started = None
    for index, speech in enumerate(pattern):
        frame = Frame(np.full(FRAME_SAMPLES, index, np.int16), (index + 1) * FRAME_S)
        found = machine.push(frame, VadResult(float(speech), speech))
        if isinstance(found, Started):
            assert started is None, "an utterance starts once"
            started = found
        elif found is not None:
            return started, found, index + 1
    return started, None, len(pattern)


def numbers(ended: Ended) -> list[int]:
    """Which frames the utterance holds."""
    assert ended.utterance is not None
    return [int(n) for n in ended.utterance.samples[::FRAME_SAMPLES]]


def test_an_utterance_has_a_pre_roll_and_a_short_tail() -> None:
    started, ended, count = hear([False] * 30 + [True] * 20 + [False] * 40)
    assert started is not None
    assert started.at == pytest.approx(30 * FRAME_S)
    assert ended is not None
    assert ended.reason == "silence"
    assert count == 30 + 20 + SILENCE
    assert numbers(ended) == list(range(20, 50 + 7)), "10 frames of pre-roll, the speech, 0.2 s of silence"
    assert ended.utterance is not None
    assert ended.utterance.start == pytest.approx(20 * FRAME_S)
    assert ended.utterance.end == pytest.approx(57 * FRAME_S)
    assert ended.utterance.speech_s == pytest.approx(20 * FRAME_S)


@pytest.mark.parametrize(("silence", "follows"), [(0, True), (PRE_ROLL, True), (PRE_ROLL + 1, False), (50, False)])
def test_what_was_said_before_belongs_to_an_utterance_that_begins_at_once(silence: int, follows: bool) -> None:
    _, ended, _ = hear([False] * silence + [True] * 20 + [False] * 40, lead=LEAD)
    assert ended is not None
    assert ended.utterance is not None
    assert ended.utterance.lead is (LEAD if follows else None)
    assert (numbers(ended)[0] == 0) == follows, "without a gap"


def test_after_what_was_no_utterance_one_is_waited_for_with_the_newest_sound_before_it() -> None:
    machine = Endpointer(SETTINGS, LEAD)
    pattern = [True] * 8 + [False] * 12 + [True] * 30 + [False] * 40
    found = []
    for index, speech in enumerate(pattern):
        if index == 21:  # the first frame of a word has just been heard
            assert machine.lead is LEAD
            machine.forget()
            assert not machine.in_speech
        frame = Frame(np.full(FRAME_SAMPLES, index, np.int16), (index + 1) * FRAME_S)
        found.append(machine.push(frame, VadResult(float(speech), speech)))
        if isinstance(found[-1], Ended):
            break
    (ended,) = [item for item in found if isinstance(item, Ended)]
    assert ended.utterance is not None
    assert ended.utterance.lead is None
    assert numbers(ended)[0] == 20 - PRE_ROLL
    assert ended.utterance.speech_s == pytest.approx(30 * FRAME_S)


def test_what_was_no_utterance_does_not_prolong_the_wait_for_one() -> None:
    machine = Endpointer(SETTINGS)
    for index in range(NO_SPEECH):
        if index == 30:
            machine.forget()
        speech = index < 20
        found = machine.push(Frame(np.zeros(FRAME_SAMPLES, np.int16), (index + 1) * FRAME_S), VadResult(1.0, speech))
    assert found == Ended("no_speech", None)


def test_a_blip_shorter_than_the_start_never_starts() -> None:
    started, ended, count = hear(([True] * (START - 1) + [False]) * 30)
    assert started is None
    assert ended == Ended("no_speech", None)
    assert count == NO_SPEECH + 1, "the wait is over at the first frame without speech"


def test_nobody_speaking_ends_exactly_at_the_limit() -> None:
    assert hear([False] * 500)[1:] == (Ended("no_speech", None), NO_SPEECH)


def test_a_word_that_begins_as_the_wait_runs_out_is_heard() -> None:
    started, ended, _ = hear([False] * (NO_SPEECH - 1) + [True] * 10 + [False] * 40)
    assert started is not None
    assert ended is not None
    assert ended.reason == "silence"


def test_a_pause_shorter_than_the_silence_does_not_end() -> None:
    _, ended, _ = hear([True] * 10 + [False] * (SILENCE - 3) + [True] * 10 + [False] * 40)
    assert ended is not None
    assert ended.utterance is not None
    assert ended.utterance.speech_s == pytest.approx(20 * FRAME_S)


def test_a_word_that_begins_as_the_silence_runs_out_is_heard() -> None:
    _, ended, _ = hear([True] * 10 + [False] * (SILENCE - 1) + [True] * 10 + [False] * 40)
    assert ended is not None
    assert ended.utterance is not None
    assert ended.utterance.speech_s == pytest.approx(20 * FRAME_S)


def test_a_click_in_the_silence_does_not_put_off_the_end() -> None:
    _, ended, count = hear([True] * 10 + [False] * 10 + [True, True] + [False] * 60)
    assert ended is not None
    assert count == 10 + SILENCE


def test_what_is_known_to_be_all_ends_in_the_middle_of_noise() -> None:
    machine = Endpointer(SETTINGS)
    for index in range(20):
        frame = Frame(np.full(FRAME_SAMPLES, index, np.int16), (index + 1) * FRAME_S)
        assert not isinstance(machine.push(frame, VadResult(1.0, True)), Ended)
    machine.conclude()
    ended = machine.push(Frame(np.full(FRAME_SAMPLES, 20, np.int16), 21 * FRAME_S), VadResult(1.0, True))
    assert isinstance(ended, Ended)
    assert ended.reason == "silence"
    assert numbers(ended) == list(range(21)), "nothing of it is taken for silence"


def test_who_knows_that_no_more_silence_is_needed_waits_for_no_frame() -> None:
    machine = Endpointer(SETTINGS)
    heard = [True] * 10 + [False] * 8
    for index, speech in enumerate(heard):
        machine.push(Frame(np.zeros(FRAME_SAMPLES, np.int16), (index + 1) * FRAME_S), VadResult(float(speech), speech))
    assert not machine.is_over
    machine.wait(8 * FRAME_S)
    assert machine.is_over
    machine.push(Frame(np.zeros(FRAME_SAMPLES, np.int16), (len(heard) + 1) * FRAME_S), VadResult(1.0, True))
    assert not machine.is_over, "a word may just have begun"
    machine.conclude()
    assert machine.is_over
    assert machine.finish().reason == "silence"
    assert not machine.is_over


def test_a_voice_fades_before_the_pause_and_not_in_it() -> None:
    machine = Endpointer(SETTINGS)
    fading = []
    for index, probability in enumerate([1.0] * 10 + [0.7, 0.9, 0.7, 0.5, 0.2, 0.1]):
        frame = Frame(np.zeros(FRAME_SAMPLES, np.int16), (index + 1) * FRAME_S)
        machine.push(frame, VadResult(probability, probability >= 0.35))
        fading.append(machine.fading)
    assert fading == [False] * 10 + [True, False, True, True, False, False]


@pytest.mark.parametrize(("fade", "counted"), [(0, 0), (2, 2), (4, 4), (12, 4)])
def test_the_fade_of_a_voice_is_silence_to_who_says_so(fade: int, counted: int) -> None:
    def silence_that_ends(*heard: float, with_fade: bool) -> int:
        machine = Endpointer(SETTINGS)
        for index, probability in enumerate([*heard, *[0.0] * 20]):
            machine.wait(8 * FRAME_S, with_fade=with_fade)
            frame = Frame(np.zeros(FRAME_SAMPLES, np.int16), (index + 1) * FRAME_S)
            if machine.push(frame, VadResult(probability, probability >= 0.35)) and machine.in_speech is False:
                return index + 1 - len(heard)
        raise AssertionError("it never ends")

    voice, fading, short = [1.0] * 10, [0.6] * fade, [0.0] * 3
    assert silence_that_ends(*voice, *fading, with_fade=True) == 8 - counted
    assert silence_that_ends(*voice, *fading, with_fade=False) == 8
    assert silence_that_ends(*voice, *fading, *short, *voice, with_fade=True) == 8, "each pause has its own"
    assert silence_that_ends(*voice, *fading, *short, *[0.6] * RESUME_FRAMES, with_fade=True) == 7, "also after another"


def test_noise_that_sounds_like_speech_ends_at_the_greatest_length() -> None:
    _, ended, count = hear([True] * 1000)
    assert ended is not None
    assert ended.reason == "max_length"
    assert count == LONGEST


def test_the_end_of_the_source_ends_the_utterance() -> None:
    machine = Endpointer(SETTINGS)
    for index in range(8):
        machine.push(Frame(np.zeros(FRAME_SAMPLES, np.int16), (index + 1) * FRAME_S), VadResult(1.0, True))
    ended = machine.finish()
    assert ended.reason == "source_ended"
    assert ended.utterance is not None
    assert Endpointer(SETTINGS).finish() == Ended("source_ended", None)


def test_an_ended_machine_takes_no_more_frames() -> None:
    machine = Endpointer(SETTINGS)
    machine.finish()
    with pytest.raises(RuntimeError, match="has ended"):
        machine.push(Frame(np.zeros(FRAME_SAMPLES, np.int16), FRAME_S), VadResult(0.0, False))


runs = st.lists(st.tuples(st.booleans(), st.integers(1, 60)), min_size=1, max_size=30)


@given(runs)
def test_an_utterance_is_a_gapless_stretch_of_bounded_length(pattern: list[tuple[bool, int]]) -> None:
    frames = [speech for speech, count in pattern for _ in range(count)]
    started, ended, count = hear(frames)
    if ended is None:
        assert count < NO_SPEECH + LONGEST + START, "it always ends"
        return
    if ended.utterance is None:
        assert started is None
        assert NO_SPEECH <= count < NO_SPEECH + START
        return
    held = numbers(ended)
    assert held == list(range(held[0], held[0] + len(held))), "no frame is lost, doubled or moved"
    assert len(held) <= LONGEST + PRE_ROLL
    assert started is not None
    first_speech = round(started.at / FRAME_S)
    assert held[0] == max(0, first_speech - PRE_ROLL)
    assert all(frames[first_speech : first_speech + START])
    for index in range(first_speech + 2, count):
        if all(frames[index - 2 : index + 1]):
            assert index <= held[-1], "speech is never trimmed"


@given(runs, st.floats(0.033, 2), st.floats(0.033, 1), st.floats(0, 2))
def test_any_settings_end_every_utterance(
    pattern: list[tuple[bool, int]], silence_s: float, start_s: float, pre_roll_s: float
) -> None:
    settings = Endpoint(
        pre_roll_s=pre_roll_s,
        start_s=start_s,
        silence_s=silence_s,
        complete_s=0.35,
        incomplete_s=1.2,
        max_length_s=1.5,
        no_speech_s=0.5,
    )
    frames = [speech for speech, count in pattern for _ in range(count)] + [False] * 80
    _, ended, _ = hear(frames, settings)
    assert ended is not None
    if ended.utterance is not None:
        assert ended.utterance.duration <= 1.5 + pre_roll_s + FRAME_S
