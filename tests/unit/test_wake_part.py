"""The wake module as a part of the engine: a fault in its reader does not end it, and one that stays is told once."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from config.schema import SerialWake
from engine.bus import Bus
from engine.clock import SystemClock
from engine.commands import Wake
from engine.events import ErrorRaised, Event
from engine.handle import PartStatus
from engine.parts import wake as module
from engine.parts.part import Part
from engine.parts.wake import PAUSES_S, WakePart
from tests.wake_module import AI_VOICE_WAKE, WakeModule

LIMIT_S = 20
FRESH_STARTS = len(PAUSES_S)


@pytest.mark.parametrize("faults", [1, FRESH_STARTS, FRESH_STARTS + 1])
def test_after_a_fault_listening_begins_anew_but_not_for_ever(
    faults: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PAUSES_S", (0.0,) * FRESH_STARTS)
    published: list[Event] = []
    bus = Bus(SystemClock())
    bus.subscribe(published.append)
    called: list[Wake] = []

    async def scenario(plugged: WakeModule) -> None:
        loop = asyncio.get_running_loop()
        told: asyncio.Queue[PartStatus | Wake] = asyncio.Queue()

        def wake(wake: Wake) -> None:
            called.append(wake)
            if len(called) <= faults:
                raise ZeroDivisionError
            loop.call_soon_threadsafe(told.put_nowait, wake)

        part: Part[str] = Part("wake", told.put_nowait)
        settings = SerialWake(port=str(plugged.path), protocol="auto", phrase=None)
        keeping = asyncio.create_task(
            WakePart(part, settings, wake, bus.bound(turn=None, epoch=0), prompt=False).keep()
        )
        async with asyncio.timeout(LIMIT_S):
            for start in range(min(faults, FRESH_STARTS) + 1):
                if start:
                    await expect(told, "failed", "ZeroDivisionError")
                await expect(told, "ready", str(plugged.path))
                plugged.say(AI_VOICE_WAKE)
            if faults <= FRESH_STARTS:
                assert isinstance(await told.get(), Wake)
                keeping.cancel()
            else:
                await expect(told, "failed", "ZeroDivisionError")
            await asyncio.gather(keeping, return_exceptions=True)

    with WakeModule(tmp_path) as plugged:
        asyncio.run(scenario(plugged))
    errors = [event.body for event in published if isinstance(event.body, ErrorRaised)]
    assert len(errors) == (faults > FRESH_STARTS)


async def expect(told: asyncio.Queue[PartStatus | Wake], state: str, detail: str) -> None:
    """The next that is told is a status of this kind."""
    status = await told.get()
    assert isinstance(status, PartStatus)
    assert status.state == state
    assert detail in status.detail
