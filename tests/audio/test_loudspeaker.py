"""The loudspeaker for real: PortAudio plays into a sound server, and what came out of it is recorded."""

from __future__ import annotations

import asyncio
import os
import subprocess
import threading
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager

import numpy as np
import pytest

from engine.audio.loudspeaker import Loudspeaker
from engine.audio.player import Playback, Player
from engine.audio.source import RATE, Samples
from engine.errors import DeviceError
from tests.audio.server import SoundServer
from tests.children import children

pytestmark = pytest.mark.audio

LIMIT_S = 30.0
PROCESS = "engine.audio.sounder"


@pytest.fixture(autouse=True)
def _at_the_server(server: SoundServer, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """This process and its children use the test's sound server; no child of it is left."""
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    yield
    assert children(PROCESS) == []


class Microphone:
    """What comes out of the loudspeaker."""

    def __init__(self, server: SoundServer) -> None:
        argv = ["parecord", "--raw", "--device=loudspeaker.monitor", "--format=s16le", f"--rate={RATE}", "--channels=1"]
        environment = os.environ | server.environment
        self._process = subprocess.Popen([*argv, "--latency-msec=20"], stdout=subprocess.PIPE, env=environment)
        self._heard = bytearray()
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        while data := os.read(self._process.stdout.fileno(), 4096):
            with self._change:
                self._heard += data
                self._change.notify_all()

    def hear(self, seconds: float) -> Samples:
        """The next so many seconds, and all that was before."""
        with self._change:
            enough = len(self._heard) + round(seconds * RATE) * 2
            assert self._change.wait_for(lambda: len(self._heard) >= enough, LIMIT_S), "nothing to be heard"
            return np.frombuffer(bytes(self._heard[: len(self._heard) // 2 * 2]), np.int16)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._thread.join(LIMIT_S)
        assert self._process.stdout is not None
        self._process.stdout.close()


@pytest.fixture
def microphone(server: SoundServer) -> Iterator[Microphone]:
    made = Microphone(server)
    made.hear(0.1)
    yield made
    made.close()


@asynccontextmanager
async def playing() -> AsyncIterator[Player]:
    player = Player(Loudspeaker())
    await player.open()
    try:
        async with asyncio.timeout(LIMIT_S):
            yield player
    finally:
        await player.close()


def chirp(seconds: float) -> Samples:
    time = np.arange(round(seconds * RATE)) / RATE
    return np.asarray(0.5 * 32767 * np.sin(2 * np.pi * (200 + 300 * time) * time), np.int16)


async def fed(player: Player, samples: Samples) -> Playback:
    playback = player.begin()
    await playback.feed(samples, RATE)
    playback.finish()
    return playback


def loud_s(sound: Samples) -> float:
    """How much of it is loud, s: a busy machine has gaps in what it plays, and is no less loud in all."""
    windows = np.abs(sound[: len(sound) // 80 * 80].astype(int)).reshape(-1, 80).max(axis=1)  # 5 ms
    return float(np.count_nonzero(windows > 500)) * 80 / RATE


def test_what_is_played_comes_out_of_it_whole_and_once(microphone: Microphone) -> None:
    async def scenario() -> Samples:
        async with playing() as player:
            playback = await fed(player, chirp(1.0))
            await playback.until_ended()
            assert playback.complete
            return await asyncio.to_thread(microphone.hear, 0.5)

    heard = asyncio.run(scenario())
    assert loud_s(heard) == pytest.approx(1.0, abs=0.06)
    part = chirp(1.0)[: RATE // 10].astype(float)  # its beginning: nowhere else is it so low
    start = int(np.argmax(np.correlate(heard.astype(float), part, "valid")))
    assert np.corrcoef(heard[start : start + len(part)], part)[0, 1] > 0.8


def test_a_stop_silences_the_device_in_the_midst_of_a_sound(microphone: Microphone) -> None:
    async def scenario() -> tuple[Samples, float]:
        async with playing() as player:
            playback = await fed(player, chirp(10.0))
            while playback.position < 0.5:
                await playback.news()
            player.stop(2)
            await playback.until_ended()
            assert not playback.complete
            return await asyncio.to_thread(microphone.hear, 1.0), playback.position

    heard, position = asyncio.run(scenario())
    assert 0.4 < loud_s(heard) < position + 0.5  # of sound, not of a clock; a busy machine is late with both


def test_what_is_played_after_a_stop_is_heard(microphone: Microphone) -> None:
    async def scenario() -> Samples:
        async with playing() as player:
            first = await fed(player, chirp(10.0))
            await first.news()
            player.stop(2)
            await first.until_ended()
            await asyncio.to_thread(microphone.hear, 0.5)
            before = len(await asyncio.to_thread(microphone.hear, 0.1))
            await (await fed(player, chirp(0.7))).until_ended()
            return (await asyncio.to_thread(microphone.hear, 0.5))[before:]

    assert loud_s(asyncio.run(scenario())) == pytest.approx(0.7, abs=0.06)


def test_a_sound_server_that_dies_is_one_error_and_one_that_comes_back_is_found(server: SoundServer) -> None:
    async def scenario() -> None:
        async with playing() as player:
            told: list[object] = []
            player.tell = told.append
            playback = await fed(player, chirp(20.0))
            await playback.news()
            await asyncio.to_thread(server.kill)
            with pytest.raises(DeviceError, match=r"^The loudspeaker \(default\) is gone\.") as gone:
                await playback.until_ended()
            assert "pcm" not in str(gone.value), "what drivers write is nothing for people"
            assert not player.usable
            with pytest.raises(DeviceError):
                await player.open()
            await asyncio.to_thread(server.start)
            await player.open()
            again = await fed(player, chirp(0.2))
            await again.until_ended()
            assert again.complete
            assert [type(each) for each in told] == [DeviceError, type(None)]

    asyncio.run(scenario())


def test_a_sound_server_that_hangs_is_one_error_and_one_that_goes_on_is_found(server: SoundServer) -> None:
    async def scenario() -> None:
        async with playing() as player:
            playback = await fed(player, chirp(20.0))
            await playback.news()
            server.freeze()
            with pytest.raises(DeviceError, match=r"^The loudspeaker \(default\) takes no sound\."):
                await playback.until_ended()
            assert not player.usable
            server.go_on()
            await player.open(patient=True)
            again = await fed(player, chirp(0.2))
            await again.until_ended()
            assert again.complete

    asyncio.run(scenario())


def test_a_loudspeaker_that_is_waited_for_is_there_as_soon_as_the_sound_server_is(server: SoundServer) -> None:
    async def scenario() -> None:
        await asyncio.to_thread(server.kill)
        player = Player(Loudspeaker())
        with pytest.raises(DeviceError):
            await player.open()
        waiting = asyncio.create_task(player.open(patient=True))
        await asyncio.to_thread(server.start)
        async with asyncio.timeout(LIMIT_S):
            await waiting
        await (await fed(player, chirp(0.2))).until_ended()
        await player.close()

    asyncio.run(scenario())


def test_waiting_for_a_loudspeaker_can_be_given_up(server: SoundServer) -> None:
    async def scenario() -> None:
        await asyncio.to_thread(server.kill)
        speaker = Loudspeaker()
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(1.5):
                await Player(speaker).open(patient=True)
        assert speaker.pid is None

    asyncio.run(scenario())


def test_a_sounder_that_is_killed_is_one_error_and_can_be_started_anew() -> None:
    async def scenario() -> None:
        speaker = Loudspeaker()
        player = Player(speaker)
        await player.open()
        playback = await fed(player, chirp(20.0))
        await playback.news()
        (sounder,) = children(PROCESS)
        assert sounder.pid == speaker.pid
        sounder.kill()
        with pytest.raises(DeviceError, match="SIGKILL"):
            async with asyncio.timeout(LIMIT_S):
                await playback.until_ended()
        await player.open()
        await (await fed(player, chirp(0.2))).until_ended()
        await player.close()

    asyncio.run(scenario())


def test_a_loudspeaker_that_there_is_not_is_an_error_that_names_those_that_there_are() -> None:
    async def scenario() -> DeviceError:
        with pytest.raises(DeviceError) as error:
            await Player(Loudspeaker("no such thing")).open()
        return error.value

    error = asyncio.run(scenario())
    assert "'no such thing'" in error.message
    assert "voice.device" in error.hint
