"""The end that feeds the sounder process, without a sound system."""

from __future__ import annotations

import asyncio
import os

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.audio import loudspeaker
from engine.audio.loudspeaker import Loudspeaker
from engine.errors import SaysoError
from tests.unit import sounder_that_goes
from tests.unit.sounder_that_goes import GONE


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
        async with asyncio.timeout(30):
            error = await lost.get()
        await speaker.close()
        return error.message

    assert asyncio.run(scenario()) == GONE
