"""The robot's own voice is taken out of what its microphone hears, and nobody else's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.audio.echo import EchoCanceller
from engine.audio.echo_path import BLOCK, EchoPath
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Samples
from engine.audio.wav import read_wav
from tests.room import BEGUN, VOICE, Room, Sound, Speaker, clean, decibels, loudness, mixed, said_in_turn, samples

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
WORDS = [read_wav(file) / 32768 for file in sorted(SPEECH.glob("*.wav"))]


def answer(seconds: float) -> Sound:
    """The robot speaks for so long."""
    whole = said_in_turn(WORDS[4:], pause_s=0.2)
    return np.resize(whole, round(seconds * RATE))


def canceller(played: Sound) -> EchoCanceller:
    return EchoCanceller(Speaker(samples(played)))


def at(seconds: float, sound: Sound, whole: float) -> Sound:
    """A sound as loud as a person, so late in a longer silence."""
    result = np.zeros(round(whole * RATE))
    first = round(seconds * RATE)
    result[first : first + len(sound)] = sound * (VOICE / loudness(sound))
    return result


def second(sound: Samples, begin: float, end: float) -> Samples:
    return sound[round(begin * RATE) : round(end * RATE)]


def test_while_nothing_is_played_sound_passes_as_it_is() -> None:
    heard = mixed(at(0.5, WORDS[0], 4))
    echoes = canceller(np.zeros(4 * RATE))
    for start in range(0, len(heard) // FRAME_SAMPLES * FRAME_SAMPLES, FRAME_SAMPLES):
        assert echoes.clean(heard[start : start + FRAME_SAMPLES], 1000 + start / RATE) is None


def test_before_the_first_sound_and_after_the_last_echo_of_it_sound_passes_as_it_is() -> None:
    played = np.concatenate((np.zeros(RATE), answer(2), np.zeros(2 * RATE)))
    heard = mixed(Room().echo(played))
    left, others = clean(canceller(played), heard)
    assert np.array_equal(second(left, 0, 0.9), second(heard, 0, 0.9))
    assert np.array_equal(second(others, 0, 0.9), second(heard, 0, 0.9))
    assert np.array_equal(second(others, 3.6, 4.9), second(heard, 3.6, 4.9))
    assert not np.array_equal(second(left, 2, 3), second(heard, 2, 3))


@pytest.mark.parametrize(
    "room",
    [
        Room(drift_ppm=0),
        Room(delay_s=0.02, drift_ppm=0, echo_db=-10),
        Room(delay_s=0.25),
        Room(drift_ppm=-50, echo_db=6, dies_s=0.5),
    ],
    ids=["a usual room", "near and quiet", "a late loudspeaker", "loud, in a hall"],
)
def test_the_echo_is_subtracted_once_the_room_is_known_and_then_faded(room: Room) -> None:
    played = answer(20)
    heard = mixed(room.echo(played))
    left, others = clean(canceller(played), heard)
    assert decibels(second(heard, 14, 20), second(left, 14, 20)) > 8
    assert decibels(second(heard, 14, 20), second(others, 14, 20)) > decibels(
        second(heard, 14, 20), second(left, 14, 20)
    )
    assert decibels(second(heard, 14, 20), second(others, 14, 20)) > 12


def test_clocks_that_drift_apart_are_found_out() -> None:
    for ppm in (-50.0, 50.0):
        played = answer(16)
        echoes = canceller(played)
        clean(echoes, mixed(Room(drift_ppm=ppm).echo(played)))
        assert echoes.drift * 1e6 == pytest.approx(ppm, abs=15)


@pytest.mark.parametrize("latency_s", [-0.03, 0.1, 0.35])
def test_the_echo_is_found_however_late_the_devices_are(latency_s: float) -> None:
    """What a device says of its own latency may be wrong in either direction."""
    played = answer(12)
    heard = mixed(Room(drift_ppm=0, delay_s=0.02).echo(played))
    left, _ = clean(canceller(played), heard, latency_s=latency_s)
    assert decibels(second(heard, 8, 12), second(left, 8, 12)) > 10


def test_somebody_who_talks_over_the_robot_is_left_as_they_are() -> None:
    played = answer(16)
    room = Room(drift_ppm=0, echo_db=5)
    voice = at(11, WORDS[1], 16)
    left, others = clean(canceller(played), mixed(room.echo(played), voice))
    alone, end = samples(voice), 11 + len(WORDS[1]) / RATE
    whole = len(left)
    heard_alone = second(alone[:whole], 11, end).astype(float)
    for sound, alike in ((left, 0.95), (others, 0.85)):
        assert np.corrcoef(second(sound, 11, end).astype(float), heard_alone)[0, 1] > alike


def test_somebody_who_talks_does_not_spoil_what_was_learnt() -> None:
    played = answer(18)
    room = Room(drift_ppm=0)
    voice = sum(at(second, WORDS[index], 18) for index, second in enumerate((8.0, 10.5, 13.0)))
    quiet = mixed(room.echo(played))
    left, _ = clean(canceller(played), quiet)
    talked, _ = clean(canceller(played), mixed(room.echo(played), np.asarray(voice)))
    assert (
        decibels(second(quiet, 16, 18), second(talked, 16, 18))
        > decibels(second(quiet, 16, 18), second(left, 16, 18)) - 6
    )


def test_a_person_is_heard_whole_where_no_echo_comes() -> None:
    """With headphones, for example."""
    played = answer(10)
    heard = mixed(at(3.5, WORDS[0], 10) + at(6.5, WORDS[1], 10))
    left, others = clean(canceller(played), heard)
    assert decibels(heard, left) == pytest.approx(0, abs=0.5)
    assert decibels(heard, others) == pytest.approx(0, abs=0.5)


def test_who_sounds_like_the_robot_for_a_moment_is_no_echo_and_heard_whole_from_there_on() -> None:
    played = answer(12)
    alike = played[5 * RATE : round(5.5 * RATE)]
    heard = mixed(at(5.1, alike, 12) + at(8.0, WORDS[0], 12))
    _, others = clean(canceller(played), heard)
    assert decibels(second(heard, 7.9, 11), second(others, 7.9, 11)) == pytest.approx(0, abs=0.5)


def test_a_room_that_changes_is_learnt_anew() -> None:
    played = answer(24)
    before, after = (mixed(Room(drift_ppm=0, seed=seed).echo(played)) for seed in (3, 4))
    half = 12 * RATE
    heard = np.concatenate((before[:half], after[half:]))
    left, _ = clean(canceller(played), heard)
    assert decibels(second(heard, 20, 24), second(left, 20, 24)) > 10


def test_sound_that_was_lost_on_the_way_is_noticed() -> None:
    played = answer(20)
    heard = mixed(Room(drift_ppm=0).echo(played))
    echoes = canceller(played)
    first, _ = clean(echoes, heard[: 8 * RATE])
    lost = heard[9 * RATE :]  # and all stamps say so
    cleaned = []
    for start in range(0, len(lost) // FRAME_SAMPLES * FRAME_SAMPLES, FRAME_SAMPLES):
        frame = lost[start : start + FRAME_SAMPLES]
        found = echoes.clean(frame, 1009 + (start + FRAME_SAMPLES) / RATE)
        cleaned.append(frame if found is None else found.left)
    left = np.concatenate(cleaned)
    assert decibels(heard[6 * RATE : 8 * RATE], first[6 * RATE : 8 * RATE]) > 10
    assert decibels(second(lost, 7, 10), second(left, 7, 10)) > 10


def test_a_word_is_the_robots_own_unless_somebody_else_says_it() -> None:
    played = answer(20)
    echoes = canceller(played)
    alone: list[bool] = []
    end = 14 + len(WORDS[1]) / RATE
    heard = mixed(Room(drift_ppm=0).echo(played), at(14, WORDS[1], 20))
    for start in range(0, len(heard) // FRAME_SAMPLES * FRAME_SAMPLES, FRAME_SAMPLES):
        echoes.clean(heard[start : start + FRAME_SAMPLES], BEGUN + (start + FRAME_SAMPLES) / RATE)
        alone.append(echoes.alone)
    assert not alone[round(end / FRAME_S)]
    own = alone[round(10 / FRAME_S) : round(14 / FRAME_S)]
    assert sum(own) > 0.3 * len(own)


@pytest.mark.parametrize("gap_s", [0.023, -0.017])
def test_a_gap_in_what_is_played_does_not_cost_what_was_learnt(gap_s: float) -> None:
    """A busy machine is late with a block, or a device skips one."""
    played = answer(20)
    echo = Room(drift_ppm=0).echo(played)
    cut = 12 * RATE
    late = np.concatenate(
        (echo[:cut], np.zeros(max(0, round(gap_s * RATE))), echo[cut + max(0, round(-gap_s * RATE)) :])
    )
    heard = mixed(late[: 19 * RATE])
    left, _ = clean(canceller(played), heard)
    before = decibels(second(heard, 9, 12), second(left, 9, 12))
    assert before > 10
    assert decibels(second(heard, 15, 19), second(left, 15, 19)) > before - 5


def test_another_source_is_another_room() -> None:
    played = answer(8)
    echoes = canceller(played)
    clean(echoes, mixed(Room(drift_ppm=80, delay_s=0.3).echo(played)))
    echoes.reset()
    heard = mixed(at(1, WORDS[0], 3))
    left, _ = clean(echoes, heard)
    assert decibels(heard, left) == pytest.approx(0, abs=0.5)


def test_what_another_source_hears_is_not_the_robots_own() -> None:
    played = answer(20)
    echoes = canceller(played)
    heard = Room(drift_ppm=0).echo(played)
    for start in range(8 * RATE, 20 * RATE, FRAME_SAMPLES):
        echoes.clean(samples(heard[start : start + FRAME_SAMPLES]), BEGUN + (start + FRAME_SAMPLES) / RATE)
        if echoes.alone:
            break
    assert echoes.alone
    echoes.reset()
    assert not echoes.alone


def test_what_was_learnt_can_be_shifted() -> None:
    random = np.random.default_rng(0)
    sound = random.normal(0, 0.1, 400 * BLOCK).astype(np.float32)
    path, echo = EchoPath(), np.roll(sound, 500) * np.float32(0.5)

    def left(late: int, begin: int, end: int) -> float:
        rest = 0.0
        for start in range(begin, end, BLOCK):
            heard = echo[start : start + BLOCK]
            error = heard - path.predict(sound[start - late : start - late + BLOCK])
            path.learn(error)
            rest = float(np.mean(error**2) / np.mean(heard**2))
        return rest

    assert left(0, BLOCK * 4, 200 * BLOCK) < 0.01
    path.shift(300)
    assert left(300, 200 * BLOCK, 220 * BLOCK) < 0.01
