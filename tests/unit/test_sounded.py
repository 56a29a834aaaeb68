"""What has sounded is one sound, however its blocks were stamped and whatever the device's rate is."""

from __future__ import annotations

import numpy as np
import pytest

from engine.audio.sounded import KEPT_S, Sounded
from engine.audio.source import RATE, Samples

BLOCK_S = 0.02
AT = 1000.0


def chirp(seconds: float, rate: int) -> Samples:
    time = np.arange(round(seconds * rate)) / rate
    return np.asarray(10000 * np.sin(2 * np.pi * (200 + 150 * time) * time), np.int16)


def add(sounded: Sounded, sound: Samples, rate: int, at: float, jitter_s: float = 0.0) -> None:
    random, size = np.random.default_rng(0), round(BLOCK_S * rate)
    for start in range(0, len(sound), size):
        sounded.add(sound[start : start + size], rate, at + start / rate + random.uniform(-jitter_s, jitter_s))


@pytest.mark.parametrize("rate", [16_000, 44_100, 48_000])
def test_blocks_that_follow_each_other_have_no_seams(rate: int) -> None:
    sounded = Sounded()
    add(sounded, chirp(2.0, rate), rate, AT, jitter_s=0.004)
    found = sounded.between(AT - 0.05, AT + 1.9).astype(float)
    wanted = chirp(2.0, RATE).astype(float)
    late = int(np.argmax(np.correlate(found[: RATE // 2], wanted[: RATE // 4], "valid")))
    assert late / RATE == pytest.approx(0.05, abs=0.005)  # the first stamp is not better
    part = slice(RATE // 10, round(1.7 * RATE))
    assert np.abs(found[late:][part] - wanted[part]).max() < 200


def test_what_is_read_in_pieces_is_what_is_read_at_once() -> None:
    sounded = Sounded()
    add(sounded, chirp(1.0, 44_100), 44_100, AT)
    first = round(AT * RATE)
    pieces = [sounded.samples(first + start, 512) for start in range(0, 8192, 512)]
    assert np.array_equal(np.concatenate(pieces), sounded.samples(first, 8192))


def test_a_sound_after_a_rest_begins_where_its_stamp_says() -> None:
    sounded = Sounded()
    add(sounded, chirp(0.2, RATE), RATE, AT)
    add(sounded, chirp(0.2, RATE), RATE, AT + 3.0)
    assert not sounded.between(AT + 0.3, AT + 2.9).any()
    assert np.array_equal(sounded.between(AT + 3.0, AT + 3.1), chirp(0.2, RATE)[: RATE // 10])
    assert sounded.last == pytest.approx(AT + 3.2)


def test_a_clock_that_drifts_is_set_right_in_silence_and_not_in_the_midst_of_a_sound() -> None:
    sounded = Sounded()
    sounded.add(chirp(0.02, RATE), RATE, AT)
    sounded.add(chirp(0.02, RATE), RATE, AT + 0.04)  # 20 ms late
    assert sounded.between(AT + 0.02, AT + 0.04).any()
    sounded.add(np.zeros(RATE // 50, np.int16), RATE, AT + 0.06)
    sounded.add(chirp(0.02, RATE), RATE, AT + 0.08)
    assert not sounded.between(AT + 0.061, AT + 0.079).any()
    assert np.array_equal(sounded.between(AT + 0.08, AT + 0.1), chirp(0.02, RATE))


def test_what_is_stamped_earlier_than_the_last_replaces_it() -> None:
    sounded = Sounded()
    add(sounded, chirp(1.0, RATE), RATE, AT)
    sounded.add(np.full(320, 7, np.int16), RATE, AT + 0.5)
    assert np.array_equal(sounded.between(AT + 0.5, AT + 0.52), np.full(320, 7))
    assert not sounded.between(AT + 0.52, AT + 1.0).any()
    assert sounded.between(AT + 0.4, AT + 0.5).any()


def test_what_is_long_past_is_silence() -> None:
    sounded = Sounded()
    sounded.add(chirp(0.02, RATE), RATE, AT)
    add(sounded, np.zeros(round((KEPT_S + 1) * RATE), np.int16), RATE, AT + 0.02)
    assert not sounded.between(AT, AT + 0.02).any()
    assert sounded.last == pytest.approx(AT + 0.02)
