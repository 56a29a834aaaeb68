"""The robot's voice at a satellite, over a real socket under virtual time: it is played there, stops there, and what
counts as heard has sounded there."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest

from config import load
from engine.audio import satellite as satellite_module
from engine.audio.player import BLOCK_S, Player
from engine.audio.satellite import Satellite
from engine.audio.satellite_loudspeaker import GOODBYE_S, LEAD_S, SatelliteLoudspeaker
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.source import FRAME_SAMPLES
from engine.audio.source import RATE as HEARD_RATE
from engine.errors import DeviceError, SaysoError
from engine.handle import PartStatus
from engine.hearing.hearing import Hearing
from engine.parts import ears as ears_module
from engine.parts.loading import Sound, make_satellite
from engine.parts.part import Part
from engine.speaking import SpokenVoice
from tests import satellite as peer
from tests.unit.hears import Scripted
from tests.unit.test_speaking import WORD_S, Tones
from tests.virtual_time import run

ANSWER = "I am in the kitchen now, and I see two red boxes here."


def now() -> float:
    return asyncio.get_running_loop().time()


@asynccontextmanager
async def playing_at(address: str) -> AsyncIterator[tuple[Player, Satellite]]:
    satellite = Satellite(address)
    output = SatelliteLoudspeaker(satellite)
    player = Player(output)
    output.busy = lambda: player.busy
    await player.open()
    try:
        yield player, satellite
    finally:
        await player.close()


@pytest.fixture
def address(tmp_path: Path) -> str:
    return f"unix://{tmp_path}/satellite"


def with_satellite(
    address: str, test: Callable[[peer.Satellite, Player, Satellite], Awaitable[None]], *, buffer_s: float = 0.2
) -> None:
    async def scenario() -> None:
        there = peer.Satellite(address, buffer_s=buffer_s)
        async with peer.there(there), playing_at(address) as (player, satellite):
            await test(there, player, satellite)

    run(scenario())


def tone(player: Player, seconds: float) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    return np.asarray(0.5 * np.sin(np.arange(round(seconds * player.rate)) / 10), np.float32)


def test_a_sound_is_played_there_whole_between_a_start_and_a_stop(address: str) -> None:
    async def test(there: peer.Satellite, player: Player, satellite: Satellite) -> None:
        made = tone(player, 0.5)
        playback = player.play(made)
        await playback.until_ended()
        assert playback.complete
        assert there.heard_by(now()) >= playback.position - BLOCK_S
        kinds = [kind for _, kind in there.events]
        assert kinds == ["audio-start", *["audio-chunk"] * 25, "audio-stop"]
        sounded = np.concatenate([sound for _, sound in there.sounded])
        assert np.abs(sounded[: len(made)] - made * 32768).max() <= 1
        assert not sounded[len(made) :].any()

    with_satellite(address, test)


def test_a_chime_is_not_held_back_until_a_buffer_is_full(address: str) -> None:
    async def test(there: peer.Satellite, player: Player, satellite: Satellite) -> None:
        began = now()
        await player.play(tone(player, 0.06)).until_ended()
        assert there.sounded[0][0] - began < 0.06 + 2 * BLOCK_S

    with_satellite(address, test, buffer_s=0.5)


def test_whoever_interrupts_hears_no_more_than_what_was_on_its_way(address: str) -> None:
    async def test(there: peer.Satellite, player: Player, satellite: Satellite) -> None:
        playback = player.play(tone(player, 10.0))
        await asyncio.sleep(2.0)
        player.stop(2)
        stopped = now()
        await playback.until_ended()
        assert not playback.complete
        await asyncio.sleep(5.0)
        assert there.events[-1][1] == "audio-stop"
        assert there.events[-1][0] <= stopped + 2 * BLOCK_S
        assert there.heard_by(now()) <= 2.0 + LEAD_S + 3 * BLOCK_S
        again = player.play(tone(player, 0.2))
        await again.until_ended()
        assert again.complete

    with_satellite(address, test)


def test_one_that_takes_nothing_any_more_holds_up_nobody_who_stops_and_is_lost(address: str) -> None:
    async def scenario() -> None:
        lost: asyncio.Queue[SaysoError] = asyncio.Queue()
        async with peer.there(peer.Satellite(address)) as there:
            output = SatelliteLoudspeaker(Satellite(address))
            output.busy = lambda: True
            await output.open(lambda count, at: np.ones(count, np.int16), lost.put_nowait)
            await output.start()
            await asyncio.sleep(1.0)
            there.stall()
            await asyncio.sleep(8.0)  # longer than what fits on the way
            stopped = now()
            await output.stop()
            assert now() - stopped < 2 * GOODBYE_S
            assert "closed the connection" in str(await lost.get())
            assert now() - stopped < 2 * GOODBYE_S
            await output.close()

    run(scenario())


@pytest.mark.parametrize("buffer_s", [0.0, 0.2, 0.5, 0.9])
def test_what_is_remembered_of_an_interrupted_answer_has_sounded_there(address: str, buffer_s: float) -> None:
    """Once the satellite has told of a sound that it has played; before that it may be a word or two."""

    async def test(there: peer.Satellite, player: Player, satellite: Satellite) -> None:
        voice = SpokenVoice(player)
        voice.settle(Tones())
        await voice.say(ANSWER, lambda words: None)
        await asyncio.sleep(2.0)
        for cut_s in (0.7, 1.5, 2.6):
            heard: list[str] = []
            before, began = len(there.sounded), now()
            speaking = asyncio.create_task(voice.say(ANSWER, heard.append))
            await asyncio.sleep(cut_s)
            speaking.cancel()
            await asyncio.gather(speaking, return_exceptions=True)
            cut = now()
            await asyncio.sleep(3.0)
            sounded = [(begins, sound) for begins, sound in there.sounded[before:] if begins < cut]
            truth = sum(min(len(sound) / there.rate, cut - begins) for begins, sound in sounded)
            words = len(heard[-1].split()) if heard else 0
            assert words * WORD_S <= truth + BLOCK_S
            assert words >= (cut - began - buffer_s) / WORD_S - 3, "nor is it much less than that"

    with_satellite(address, test, buffer_s=buffer_s)


def test_one_without_a_loudspeaker_says_so_and_is_heard_all_the_same(address: str) -> None:
    async def scenario() -> None:
        async with peer.there(peer.Satellite(address, mute=True)) as there:
            satellite = Satellite(address)
            async with SatelliteMicrophone(satellite) as microphone:
                await there.streams.wait()
                player = Player(SatelliteLoudspeaker(satellite))
                await there.speak(np.ones(FRAME_SAMPLES, np.int16))
                assert (await anext(microphone)).samples.all()
                with pytest.raises(DeviceError, match="has no loudspeaker"):
                    await player.open()
                await there.speak(np.ones(FRAME_SAMPLES, np.int16))
                assert (await anext(microphone)).samples.all()
                await player.close()

    run(scenario())


def test_microphone_and_loudspeaker_share_one_connection_and_either_may_leave_first(address: str) -> None:
    async def scenario() -> None:
        async with peer.there(peer.Satellite(address)) as there, playing_at(address) as (player, satellite):
            async with SatelliteMicrophone(satellite) as microphone:
                await there.speak(np.ones(HEARD_RATE, np.int16))
                assert (await anext(microphone)).samples.all()
                with pytest.raises(DeviceError, match="closed the connection"):
                    await SatelliteMicrophone(Satellite(address)).__aenter__()  # another sayso
            await player.play(tone(player, 0.2)).until_ended()
            assert there.sounded

    run(scenario())


def test_one_that_goes_ends_what_plays_and_is_found_again_when_it_comes_back(address: str) -> None:
    async def scenario() -> None:
        told: list[SaysoError | None] = []
        async with playing_twice(address, told) as player:
            async with peer.there(peer.Satellite(address)):
                await player.open(patient=True)
                lost = player.play(tone(player, 5.0))
                await asyncio.sleep(1.0)
            with pytest.raises(SaysoError, match=r"closed the connection\. Answers are shown until it is back"):
                await lost.until_ended()
            assert not player.usable
            back = asyncio.create_task(player.open(patient=True))
            await asyncio.sleep(10 * satellite_module.AGAIN_S)
            assert not back.done()
            async with peer.there(peer.Satellite(address)) as there:
                await back
                await player.play(tone(player, 0.3)).until_ended()
                assert there.sounded
                assert [error is None for error in told] == [False, True]

    run(scenario())


@asynccontextmanager
async def playing_twice(address: str, told: list[SaysoError | None]) -> AsyncIterator[Player]:
    output = SatelliteLoudspeaker(Satellite(address))
    player = Player(output)
    output.busy = lambda: player.busy
    player.tell = told.append
    try:
        yield player
    finally:
        await player.close()


def test_ears_at_a_satellite_say_once_when_it_goes_and_once_when_it_is_back(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ears_module, "make_isolated_recogniser", lambda settings: Scripted())
    settings = load(overrides=[f"audio.device={address}"], environ={})
    satellite = make_satellite(settings, Sound("mic"))
    told: asyncio.Queue[PartStatus] = asyncio.Queue()
    part: Part[Hearing] = Part("recogniser", lambda status: None)
    ears = ears_module.Ears(settings, Sound("mic"), Part("microphone", told.put_nowait), part, satellite=satellite)

    async def scenario() -> None:
        keeping = asyncio.create_task(ears.keep())
        try:
            async with peer.there(peer.Satellite(address)):
                assert (await told.get()).state == "ready"
            gone = await told.get()
            assert gone.state == "missing"
            assert gone.detail.endswith("closed the connection. sayso keeps looking for it.")
            await asyncio.sleep(10 * satellite_module.AGAIN_S)
            assert told.empty()
            async with peer.there(peer.Satellite(address)) as there:
                back = await told.get()
                assert back.state == "ready"
                assert back.detail.startswith("satellite at ")
                hearing = await part.get()
                await there.speak(np.full(HEARD_RATE, 3000, np.int16))
                async with asyncio.timeout(10):
                    while hearing.level.rms_db < -30:  # noqa: ASYNC110 - a value, and virtual time
                        await asyncio.sleep(0.03)
                assert told.empty()
        finally:
            keeping.cancel()
            await asyncio.gather(keeping, return_exceptions=True)

    run(scenario())
