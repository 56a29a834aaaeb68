"""The end that feeds the sounder process, without a sound system."""

from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.audio import loudspeaker
from engine.audio.loudspeaker import STALLED_S, Loudspeaker
from engine.audio.player import Playback, Player
from engine.audio.source import RATE
from engine.errors import DeviceError, SaysoError
from tests.children import children
from tests.open_files import open_files
from tests.unit import sound_card, sounder_that_goes
from tests.unit.sounder_that_goes import GONE
from tests.unit.test_child import no_more_files_than
from tests.virtual_time import VirtualTimeLoop, run

LIMIT_S = 30.0
SOON_S = 0.3
"""A loudspeaker of which it is known that it hangs may be given up after so long, s."""


@pytest.fixture
def card(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Sounders play on a sound card of the tests."""
    (tmp_path / "sounddevice.py").write_text(f"from {sound_card.__name__} import *")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))


async def fed(player: Player, seconds: float) -> Playback:
    playback = player.begin()
    await playback.feed(np.ones(round(seconds * RATE), np.int16), RATE)
    playback.finish()
    return playback


def test_the_last_thing_that_a_sounder_says_is_told_also_where_it_ends_before_it_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(loudspeaker, "_SOUNDER", sounder_that_goes.__name__)
    speaker = Loudspeaker()

    def once_it_has_ended(count: int, at: float) -> NDArray[np.int16]:
        assert speaker.pid is not None
        os.waitid(os.P_PID, speaker.pid, os.WEXITED | os.WNOWAIT)
        return np.zeros(count, np.int16)

    async def scenario() -> str:
        loop, lost = asyncio.get_running_loop(), asyncio.Queue[SaysoError]()

        def told(error: SaysoError) -> None:
            loop.call_soon_threadsafe(lost.put_nowait, error)

        await speaker.open(once_it_has_ended, told)
        async with asyncio.timeout(LIMIT_S):
            error = await lost.get()
        await speaker.close()
        return error.message

    assert asyncio.run(scenario()) == GONE


@pytest.mark.parametrize("more", [0, 2, 4])
def test_a_sounder_for_which_there_are_too_few_descriptors_is_an_error_and_leaves_none_behind(more: int) -> None:
    async def scenario() -> None:
        speaker, before = Loudspeaker(), open_files()
        with no_more_files_than(more), pytest.raises(DeviceError, match="loudspeaker process cannot be started"):
            await speaker.open(lambda count, at: np.zeros(count, np.int16), lambda error: None)
        assert open_files() == before
        assert speaker.pid is None

    asyncio.run(scenario())


# One that hangs


@pytest.mark.usefixtures("card")
def test_a_sounder_that_is_frozen_is_one_error_and_the_next_one_takes_its_place() -> None:
    async def scenario() -> None:
        speaker = Loudspeaker(stalled_s=1.0)  # a busy machine is late
        player = Player(speaker)
        told: list[SaysoError | None] = []
        player.tell = told.append
        await player.open()
        playback = await fed(player, 20.0)
        await playback.news()
        frozen = speaker.pid
        assert frozen is not None
        os.kill(frozen, signal.SIGSTOP)
        async with asyncio.timeout(LIMIT_S):
            with pytest.raises(DeviceError, match=r"^The loudspeaker \(Test card\) takes no sound\.") as stalled:
                await playback.until_ended()
            assert "it is looked for" in stalled.value.hint
            assert not player.usable
            await player.open(patient=True)
            assert [sounder.pid for sounder in children("engine.audio.sounder")] == [speaker.pid]
            assert speaker.pid != frozen
            await (await fed(player, 0.2)).until_ended()
        assert told == [stalled.value, None]
        await player.close()

    asyncio.run(scenario())


@pytest.mark.usefixtures("card")
@pytest.mark.parametrize("device", [sound_card.HANGS_AT_START, sound_card.HANGS_AT_REST])
def test_a_driver_that_never_returns_is_an_error_when_there_is_something_to_play(device: str) -> None:
    async def scenario() -> None:
        speaker, lost = Loudspeaker(device, stalled_s=SOON_S), asyncio.Queue[SaysoError]()
        await speaker.open(lambda count, at: np.zeros(count, np.int16), lost.put_nowait)
        await speaker.start()
        await speaker.stop()
        assert lost.empty(), "one that rests takes no sound"
        await speaker.start()
        async with asyncio.timeout(LIMIT_S):
            assert "takes no sound" in (await lost.get()).message
        await speaker.close()
        assert children("engine.audio.sounder") == []

    asyncio.run(scenario())


def test_a_loudspeaker_may_rest_for_long_and_take_its_time_when_it_starts() -> None:
    async def scenario() -> None:
        speaker, lost = Loudspeaker(), list[SaysoError]()
        speaker._lost = lost.append
        await speaker.start()
        await speaker.stop()
        await asyncio.sleep(60)
        await speaker.start()
        await asyncio.sleep(2 * STALLED_S - 0.1)
        assert not lost
        speaker._taken += 1
        await asyncio.sleep(STALLED_S)
        assert not lost
        await asyncio.sleep(STALLED_S)
        assert [error.message for error in lost] == ["The loudspeaker takes no sound."]
        await speaker.close()

    run(scenario())


def test_an_engine_that_was_away_itself_does_not_take_its_loudspeaker_for_lost() -> None:
    async def scenario() -> None:
        speaker, lost = Loudspeaker(), list[SaysoError]()
        speaker._lost = lost.append
        await speaker.start()
        for _ in range(10):
            cast(VirtualTimeLoop, asyncio.get_running_loop())._jump(60)  # it stands still meanwhile
            await asyncio.sleep(STALLED_S / 2)
            assert not lost
            speaker._taken += 1
        await speaker.close()

    run(scenario())
