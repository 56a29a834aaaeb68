"""The wake words as a part of the engine: a fault in a spotter does not end them, and one that stays is told once."""

from __future__ import annotations

import asyncio
import threading

import numpy as np
import pytest
from numpy.typing import NDArray

from config import load
from engine.bus import Bus
from engine.clock import SystemClock
from engine.commands import Wake
from engine.errors import ModelError
from engine.events import ErrorRaised, Event, Log
from engine.handle import PartStatus
from engine.parts import words as module
from engine.parts.part import Part
from engine.parts.words import FRESH_STARTS, WordsPart
from engine.wake.words import BEHIND_S, RATE, Spotted

LIMIT_S = 20
CLAP = np.full(512, 9000, np.int16)


class Failing:
    """A spotter that hears every piece of sound, if it is not broken."""

    phrases = ("clap",)

    def __init__(self, *, broken: bool) -> None:
        self._broken = broken

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        if self._broken:
            raise ZeroDivisionError
        return [Spotted("clap", len(samples), len(samples))]

    def reset(self) -> None: ...


class Slow(Failing):
    """A spotter that hears nothing before the test lets it."""

    def __init__(self) -> None:
        super().__init__(broken=False)
        self.began, self.may_hear = threading.Event(), threading.Event()
        self.heard = 0

    def push(self, samples: NDArray[np.int16]) -> list[Spotted]:
        self.heard += 1
        self.began.set()
        assert self.may_hear.wait(LIMIT_S)
        return []


def test_who_cannot_keep_up_with_the_sound_is_told_of_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    slow = Slow()
    monkeypatch.setattr(module, "load_spotters", lambda *_, **__: [slow])
    told: list[str] = []
    bus = Bus(SystemClock())
    bus.subscribe(lambda event: told.append(event.body.message) if isinstance(event.body, Log) else None)

    async def scenario() -> None:
        ready = asyncio.Event()
        words = WordsPart(
            load(overrides=("wake.words=[clap]",), environ={}),
            lambda wake: None,
            lambda spotted: None,
            lambda phrase, sound, said: None,
            bus.bound(turn=None, epoch=0),
        )
        keeping = asyncio.create_task(words.keep(lambda: Part("wake words", lambda status: ready.set())))
        async with asyncio.timeout(LIMIT_S):
            await ready.wait()
            words.push(CLAP)
            await asyncio.to_thread(slow.began.wait, LIMIT_S)
            slow.began.clear()
            for _ in range(round(2 * BEHIND_S * RATE / len(CLAP))):
                words.push(CLAP)
            assert told == []
            slow.may_hear.set()
            await asyncio.to_thread(slow.began.wait, LIMIT_S)
            for _ in range(3):
                words.push(CLAP)
        assert len(told) == 1
        assert "too slow" in told[0]
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    asyncio.run(scenario())


@pytest.mark.parametrize("faults", [1, FRESH_STARTS, FRESH_STARTS + 1])
def test_after_a_fault_listening_begins_anew_but_not_for_ever(faults: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Failing] = []

    def make(*_: object, **__: object) -> list[Failing]:
        made.append(Failing(broken=len(made) < faults))
        return made[-1:]

    monkeypatch.setattr(module, "load_spotters", make)
    published: list[Event] = []
    bus = Bus(SystemClock())
    bus.subscribe(published.append)

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        told: asyncio.Queue[PartStatus | Wake] = asyncio.Queue()

        def wake(wake: Wake) -> None:
            loop.call_soon_threadsafe(told.put_nowait, wake)

        words = WordsPart(
            load(overrides=("wake.words=[clap]",), environ={}),
            wake,
            lambda spotted: None,
            lambda phrase, sound, said: None,
            bus.bound(turn=None, epoch=0),
        )
        keeping = asyncio.create_task(words.keep(lambda: Part("wake words", told.put_nowait)))
        async with asyncio.timeout(LIMIT_S):
            for _ in range(min(faults, FRESH_STARTS) + 1):
                status = await told.get()
                assert isinstance(status, PartStatus)
                assert (status.state, status.detail) == ("ready", "“clap”")
                words.push(CLAP)
            last = await told.get()
        if faults <= FRESH_STARTS:
            assert isinstance(last, Wake)
            keeping.cancel()
        else:
            assert isinstance(last, PartStatus)
            assert last.state == "failed"
        await asyncio.gather(keeping, return_exceptions=True)
        words.push(CLAP)  # to nobody

    asyncio.run(scenario())
    errors = [event.body for event in published if isinstance(event.body, ErrorRaised)]
    assert len(errors) == (faults > FRESH_STARTS)
    assert len(made) == min(faults, FRESH_STARTS) + 1


@pytest.mark.parametrize("others", [["clap"], []])
def test_a_phrase_that_nobody_knows_takes_neither_the_others_nor_the_stops_with_it(
    others: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def make(_: object, phrases: list[str], **more: object) -> list[Failing]:
        if "hey rosi" in phrases:
            raise ModelError("Nobody knows how “hey rosi” sounds.", hint="Train it.")
        return [Failing(broken=False)] if phrases or more.get("stops") else []

    monkeypatch.setattr(module, "load_spotters", make)
    told: list[str] = []
    bus = Bus(SystemClock())
    bus.subscribe(lambda event: told.append(event.body.message) if isinstance(event.body, Log) else None)

    async def scenario() -> None:
        loop, heard = asyncio.get_running_loop(), asyncio.Event()
        statuses: asyncio.Queue[PartStatus] = asyncio.Queue()

        def wake(wake: Wake) -> None:
            loop.call_soon_threadsafe(heard.set)

        words = WordsPart(
            load(overrides=(f"wake.words=[{', '.join(['hey rosi', *others])}]",), environ={}),
            wake,
            lambda spotted: None,
            lambda phrase, sound, said: None,
            bus.bound(turn=None, epoch=0),
        )
        keeping = asyncio.create_task(words.keep(lambda: Part("wake words", statuses.put_nowait)))
        async with asyncio.timeout(LIMIT_S):
            status = await statuses.get()
            words.push(CLAP)
            await heard.wait()
        assert status.state == ("ready" if others else "missing")
        assert "hey rosi" in status.detail
        assert told == ["Nobody knows how “hey rosi” sounds. Train it."]
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    asyncio.run(scenario())
