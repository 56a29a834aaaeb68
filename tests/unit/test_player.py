"""What is played sounds in time, stops at once, and is known afterwards."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema import Endpoint, Vad
from engine.audio.clocked import ClockedOutput
from engine.audio.endpoint import Ended, Endpointer, Started
from engine.audio.loudspeaker import Loudspeaker
from engine.audio.player import BLOCK_S, FADE_S, REST_S, Playback, Player
from engine.audio.sounds import NOTES, sound
from engine.audio.source import RATE, Framer, Samples
from engine.audio.vad import make_vad
from engine.audio.wav import read_wav
from engine.epoch import Epoch
from engine.errors import DeviceError
from tests.bench.speech import DEMO, silence, speech_bounds
from tests.virtual_time import run

BLOCK = round(BLOCK_S * RATE)


class Room:
    """What one hears of a player without a loudspeaker: every block, one after the other."""

    def __init__(self) -> None:
        self.blocks: list[Samples] = []
        self.on_block: Callable[[int], None] = lambda count: None

    def hear(self, block: Samples) -> None:
        self.blocks.append(block)
        self.on_block(len(self.blocks))

    @property
    def sound(self) -> Samples:
        return np.concatenate(self.blocks) if self.blocks else np.zeros(0, np.int16)


@asynccontextmanager
async def playing(rate: int = RATE, volume: float = 1.0) -> AsyncIterator[tuple[Player, Room]]:
    room = Room()
    player = Player(ClockedOutput(rate, room.hear), volume=volume)
    await player.open()
    try:
        yield player, room
    finally:
        await player.close()


def tone(seconds: float, rate: int = RATE, loudness: float = 0.5) -> Samples:
    time = np.arange(round(seconds * rate)) / rate
    return np.asarray(loudness * 32767 * np.sin(2 * np.pi * 440 * time), np.int16)


def chirp(seconds: float, rate: int = RATE) -> Samples:
    """Unlike itself at any other moment."""
    time = np.arange(round(seconds * rate)) / rate
    return np.asarray(0.5 * 32767 * np.sin(2 * np.pi * (200 + 800 * time) * time), np.int16)


async def fed(player: Player, *sounds: Samples, rate: int = RATE) -> Playback:
    playback = player.begin()
    for samples in sounds:
        await playback.feed(samples, rate)
    playback.finish()
    return playback


def loudness(samples: Samples) -> float:
    return float(np.abs(samples.astype(np.float64)).max(initial=0.0))


# Playing


def test_what_is_fed_sounds_once_and_whole() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            playback = await fed(player, tone(0.5), tone(0.25))
            await playback.until_ended()
            assert playback.complete
            assert playback.position == pytest.approx(0.75)
            heard = room.sound
            assert np.abs(heard[: round(0.75 * RATE)] - np.concatenate((tone(0.5), tone(0.25)))).max() <= 1

    run(scenario())


def test_sounds_of_several_rates_follow_each_other_whole() -> None:
    async def scenario() -> None:
        async with playing(48_000) as (player, room):
            playback = player.begin()
            for rate in (22_050, 48_000, 16_000, 22_050):
                await playback.feed(tone(0.2, rate), rate)
            playback.finish()
            await playback.until_ended()
            assert playback.position == pytest.approx(0.8, abs=0.002)
            loud = np.abs(room.sound[: round(0.8 * 48_000)].astype(int)).reshape(-1, 480).max(axis=1)
            assert loud.min() > 10_000, "every hundredth of a second"

    run(scenario())


@given(st.lists(st.integers(0, 3000), max_size=12), st.sampled_from([RATE, 22_050, 48_000]))
def test_the_pieces_that_sound_comes_in_make_no_difference(lengths: list[int], rate: int) -> None:
    whole = tone(sum(lengths) / rate + 0.001, rate)
    cuts = np.cumsum([0, *lengths, len(whole)])

    async def heard(*pieces: Samples) -> Samples:
        async with playing() as (player, room):
            playback = await fed(player, *pieces, rate=rate)
            await playback.until_ended()
            return np.trim_zeros(room.sound)

    at_once = run(heard(whole))
    in_pieces = run(heard(*(whole[a:b] for a, b in pairwise(cuts))))
    length = min(len(at_once), len(in_pieces))
    assert abs(len(at_once) - len(in_pieces)) <= 2
    assert np.abs(at_once[:length].astype(int) - in_pieces[:length]).max(initial=0) <= 2


def test_a_playback_knows_how_far_it_has_sounded_not_how_far_it_was_fed() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            began = asyncio.get_running_loop().time()
            playback = await fed(player, tone(2.0))
            positions = []
            while not playback.ended:
                await playback.news()
                positions.append((asyncio.get_running_loop().time() - began, playback.position))
            assert len(positions) == 100
            assert all(at - BLOCK_S <= position <= at + 1e-6 for at, position in positions)

    run(scenario())


def test_sound_that_comes_late_goes_on_where_it_was() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            playback = player.begin()
            await playback.feed(tone(0.1), RATE)
            await asyncio.sleep(1.0)
            assert playback.position == pytest.approx(0.1)
            assert not playback.ended
            await playback.feed(tone(0.1), RATE)
            playback.finish()
            await playback.until_ended()
            assert playback.position == pytest.approx(0.2)
            assert loudness(room.sound[round(0.15 * RATE) : round(0.9 * RATE)]) == 0

    run(scenario())


def test_two_that_play_sound_together_and_too_much_of_it_is_clipped_not_wrapped() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            first, second = await fed(player, tone(0.2, loudness=0.9)), await fed(player, tone(0.2, loudness=0.9))
            await first.until_ended()
            await second.until_ended()
            both = room.sound[: round(0.2 * RATE)].astype(int)
            alone = tone(0.2, loudness=0.9).astype(int)
            assert np.all(both * alone >= 0)
            assert both.max() == 32767

    run(scenario())


def test_the_volume_is_that_of_the_settings() -> None:
    async def scenario() -> None:
        async with playing(volume=0.25) as (player, room):
            await (await fed(player, tone(0.2))).until_ended()
            assert loudness(room.sound) == pytest.approx(0.25 * loudness(tone(0.2)), rel=0.01)

    run(scenario())


def test_the_output_rests_when_nothing_has_sounded_for_a_while_and_wakes_for_the_next_sound() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            await (await fed(player, tone(0.1))).until_ended()
            await asyncio.sleep(REST_S + 2)
            blocks = len(room.blocks)
            await asyncio.sleep(60)
            assert len(room.blocks) == blocks
            playback = await fed(player, tone(0.1))
            await playback.until_ended()
            assert playback.complete

    run(scenario())


# Stopping


@given(st.integers(0, 2 * BLOCK), st.integers(1, 40))
def test_a_stop_silences_within_a_block_wherever_it_comes(offset: int, blocks: int) -> None:
    async def scenario() -> None:
        async with playing() as (player, room):

            def stop(count: int) -> None:
                if count == blocks:
                    player.stop(2)

            room.on_block = stop
            playback = await fed(player, np.concatenate((np.zeros(offset, np.int16), tone(2.0))))
            await playback.until_ended()
            assert not playback.complete
            assert playback.position == pytest.approx(blocks * BLOCK_S)
            await asyncio.sleep(0.2)
            after = room.sound[blocks * BLOCK :]
            assert loudness(after[round(FADE_S * RATE) :]) == 0
            assert loudness(np.diff(room.sound.astype(int)).astype(np.int16)) < 4500  # no click: it fades

    run(scenario())


def test_a_stop_from_another_thread_does_not_wait_for_the_loop() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            playback = await fed(player, tone(5.0))
            await asyncio.sleep(0.5)
            stopping = threading.Thread(target=player.stop, args=(7,))
            stopping.start()
            stopping.join(10)  # the loop does not turn meanwhile
            assert not stopping.is_alive()
            heard = len(room.sound)
            assert playback.silenced
            await playback.until_ended()
            assert loudness(room.sound[heard + round(FADE_S * RATE) :]) == 0

    run(scenario())


def test_what_is_begun_after_a_stop_sounds_and_what_was_begun_before_it_stays_silent_however_late_it_is_fed() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            early = player.begin()
            epoch = player.epoch
            player.stop(3)
            await early.feed(tone(0.5), RATE)
            late = player.begin(epoch)  # as somebody who had been asked before the stop
            await late.feed(tone(0.5), RATE)
            await asyncio.sleep(0.6)
            assert loudness(room.sound) == 0
            assert early.ended
            assert late.ended
            answer = await fed(player, tone(0.2))
            await answer.until_ended()
            assert answer.complete

    run(scenario())


def test_telling_an_old_epoch_again_silences_nothing() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            player.stop(4)
            playback = await fed(player, tone(0.3))
            player.stop(4)
            player.stop(2)
            await playback.until_ended()
            assert playback.complete

    run(scenario())


def test_the_first_epoch_told_again_silences_nothing_and_the_second_does() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            epoch = Epoch(player.stop)
            playback = await fed(player, tone(0.3))
            epoch.tell_again()  # a robot has got ready meanwhile
            await playback.until_ended()
            assert playback.complete
            playback = await fed(player, tone(0.3))
            epoch.advance()
            await playback.until_ended()
            assert not playback.complete

    run(scenario())


def test_one_playback_can_be_stopped_alone() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            one, other = await fed(player, tone(1.0)), await fed(player, tone(1.0))
            one.stop()
            await one.until_ended()
            assert not one.complete
            await other.until_ended()
            assert other.complete

    run(scenario())


def test_closing_ends_whatever_plays() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            playback = await fed(player, tone(5.0))
            await asyncio.sleep(0.1)
        assert playback.ended
        assert not playback.complete
        assert player.begin().ended

    run(scenario())


# Ducking


def test_speech_ducks_while_somebody_is_listened_to_without_a_click_and_sounds_do_not() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            playback = await fed(player, tone(1.0))
            await asyncio.sleep(0.3)
            player.duck(True)
            await asyncio.sleep(0.3)
            player.duck(False)
            await playback.until_ended()
            heard = room.sound
            loud, quiet, again = heard[: RATE // 5], heard[round(0.4 * RATE) : RATE // 2], heard[round(0.8 * RATE) :]
            assert loudness(quiet) == pytest.approx(loudness(loud) * 10 ** (-12 / 20), rel=0.05)
            assert loudness(again) == pytest.approx(loudness(loud), rel=0.02)
            assert loudness(np.diff(heard.astype(int)).astype(np.int16)) < 3500

            player.duck(True)
            blocks = len(room.blocks)
            chime = player.play(sound("wake", RATE))
            await chime.until_ended()
            assert loudness(np.concatenate(room.blocks[blocks:])) == pytest.approx(
                32767 * float(np.abs(sound("wake", RATE)).max()), rel=0.02
            )

    run(scenario())


def test_another_volume_counts_at_once_without_a_click_and_the_reference_has_it() -> None:
    async def scenario() -> None:
        async with playing() as (player, room):
            playback = await fed(player, tone(1.0))
            await asyncio.sleep(0.3)
            player.set_volume(0.25)
            await playback.until_ended()
            heard = room.sound
            loud, quiet = heard[: RATE // 5], heard[round(0.5 * RATE) : round(0.7 * RATE)]
            assert loudness(quiet) == pytest.approx(loudness(loud) / 4, rel=0.05)
            assert loudness(np.diff(heard.astype(int)).astype(np.int16)) < 3500

    run(scenario())


# The reference


@pytest.mark.parametrize("rate", [RATE, 48_000])
def test_the_reference_is_what_sounded_when_it_sounded(rate: int) -> None:
    async def scenario() -> None:
        async with playing(rate) as (player, _):
            loop = asyncio.get_running_loop()
            await asyncio.sleep(1.0)
            begun = loop.time()
            await (await fed(player, chirp(0.5, rate), rate=rate)).until_ended()
            await asyncio.sleep(0.5)
            reference = player.sounded.between(begun - 0.25, loop.time())
            assert len(reference) == pytest.approx((loop.time() - begun + 0.25) * RATE, abs=2)
            before, during = reference[: round(0.24 * RATE)], reference[round(0.27 * RATE) : round(0.7 * RATE)]
            assert loudness(before) < 50
            assert loudness(during) == pytest.approx(loudness(chirp(0.5)), rel=0.05)
            assert loudness(reference[round(0.8 * RATE) :]) < 50
            expected = chirp(0.5)
            lag = np.argmax(np.correlate(reference.astype(float), expected[: RATE // 10].astype(float), "valid"))
            assert lag / RATE == pytest.approx(0.25, abs=0.003)

    run(scenario())


def test_the_reference_forgets_what_is_long_past() -> None:
    async def scenario() -> None:
        async with playing() as (player, _):
            loop = asyncio.get_running_loop()
            begun = loop.time()
            await (await fed(player, tone(12.0))).until_ended()
            assert loudness(player.sounded.between(begun, begun + 1)) == 0
            assert loudness(player.sounded.between(begun + 5, begun + 6)) > 0

    run(scenario())


# The robot's own sounds


@pytest.mark.parametrize("name", NOTES)
@pytest.mark.parametrize("rate", [RATE, 44_100, 48_000])
def test_the_sounds_are_short_soft_and_begin_and_end_in_silence(name: str, rate: int) -> None:
    made = sound(name, rate)  # type: ignore[arg-type]
    assert len(made) / rate < 0.5
    assert 0.02 < np.abs(made).max() < 0.25
    assert abs(made[0]) < 1e-3
    assert abs(made[-1]) < 1e-3
    assert np.abs(np.diff(made)).max() < 0.08


def test_the_answer_to_a_wake_is_no_speech_and_what_is_said_over_it_is_heard_whole() -> None:
    """The microphone hears the robot's sounds as loud as they are played, which no real one does."""
    vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
    settings = Endpoint(
        pre_roll_s=0.3, start_s=0.1, silence_s=0.6, complete_s=0.35, incomplete_s=1.2, max_length_s=15, no_speech_s=2
    )
    chimes = np.concatenate((sound("wake", RATE), sound("listen", RATE)))

    def listened(speech: Samples, at: float) -> tuple[float | None, Ended | None]:
        room = np.concatenate((silence(at), speech, silence(2.5))).astype(np.int32)
        room[round(0.1 * RATE) :][: len(chimes)] += np.asarray(chimes * 32767, np.int32)
        vad.reset()
        endpointer, started = Endpointer(settings), None
        framer = Framer()
        for frame in framer.push(np.clip(room, -32768, 32767).astype(np.int16)):
            found = endpointer.push(frame, vad.process(frame))
            if isinstance(found, Started):
                started = found.at
            elif isinstance(found, Ended):
                return started, found
        return started, None

    started, ended = listened(np.zeros(0, np.int16), 0.0)
    assert started is None
    assert ended is not None
    assert ended.utterance is None
    command = read_wav(DEMO / "go_to_the_kitchen.wav")
    begins, _ = speech_bounds(command)
    for at in (0.1, 0.3, 1.0):  # over the sounds, at their end, after them
        started, ended = listened(command, at)
        assert started is not None
        assert ended is not None
        assert ended.reason == "silence"
        assert ended.utterance is not None
        assert ended.utterance.start <= at + begins


# Loudspeakers


def test_neither_a_player_nor_a_loudspeaker_touches_a_device_or_its_library_before_it_is_opened() -> None:
    code = (
        "import sys; from engine.audio.loudspeaker import Loudspeaker; from engine.audio.player import Player; "
        "Player(Loudspeaker()); assert 'sounddevice' not in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_without_portaudio_there_is_one_error_that_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "sounddevice.py").write_text("raise OSError('PortAudio library not found')")  # as the real one does
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    async def scenario() -> None:
        player = Player(Loudspeaker())
        for _ in range(2):
            with pytest.raises(DeviceError) as error:
                await player.open()
            assert not player.usable
            assert "PortAudio library is missing" in error.value.message
            assert "libportaudio2" in error.value.hint
            assert "Answers are shown" in error.value.hint

    asyncio.run(scenario())


def test_a_loudspeaker_that_is_lost_ends_what_plays_with_an_error_and_can_be_opened_again() -> None:
    class Card(ClockedOutput):
        """An output that can be unplugged."""

        def pull_the_plug(self) -> None:
            threading.Thread(target=self.lost, args=(DeviceError("The loudspeaker is gone."),)).start()

        async def open(self, pull, lost, *, patient=False) -> None:  # type: ignore[no-untyped-def]
            self.lost = lost
            await super().open(pull, lost)

    async def scenario() -> None:
        card = Card()
        player = Player(card)
        told: list[object] = []
        player.tell = told.append
        await player.open()
        playback = await fed(player, tone(60.0))
        await playback.news()
        card.pull_the_plug()
        with pytest.raises(DeviceError, match="gone"):
            async with asyncio.timeout(20):
                await playback.until_ended()
        assert not player.usable
        assert player.begin().ended
        await player.open()
        await (await fed(player, tone(0.1))).until_ended()
        assert [type(each) for each in told] == [DeviceError, type(None)]
        await player.close()

    asyncio.run(scenario())
