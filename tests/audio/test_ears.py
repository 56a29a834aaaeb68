"""The ears of an engine at a real (virtual) microphone that comes and goes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import pytest

from config import load
from engine.handle import PartStatus
from engine.hearing.hearing import Hearing
from engine.parts.ears import Ears
from engine.parts.loading import Sound
from engine.parts.part import Part
from tests.audio.server import SoundServer
from tests.unit.hears import Scripted

LIMIT_S = 30
PCM = bytes(64)

pytestmark = pytest.mark.audio


@pytest.fixture(autouse=True)
def _here(server: SoundServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process uses the test's own sound server, and needs no recogniser."""
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("engine.parts.ears.make_isolated_recogniser", lambda settings: Scripted())


class Watched:
    """Ears, and what is said of their microphone."""

    def __init__(self, kind: str) -> None:
        self.lines: list[PartStatus] = []
        self._changed = asyncio.Event()
        self.hearing: Part[Hearing] = Part("recogniser", lambda status: None)
        self.ears = Ears(load(), Sound(kind), Part("microphone", self._note), self.hearing)  # type: ignore[arg-type]

    def _note(self, status: PartStatus) -> None:
        self.lines.append(status)
        self._changed.set()

    async def until(self, met: Callable[[PartStatus], bool]) -> None:
        """Wait until the newest line is like that."""
        while not self.lines or not met(self.lines[-1]):
            self._changed.clear()
            await self._changed.wait()

    @property
    def states(self) -> list[str]:
        return [line.state for line in self.lines]


@asynccontextmanager
async def watched(kind: str) -> AsyncIterator[Watched]:
    it = Watched(kind)
    async with asyncio.timeout(LIMIT_S):
        keeping = asyncio.create_task(it.ears.keep())
        await it.hearing.get()
        yield it
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)


def ready(status: PartStatus) -> bool:
    return status.state == "ready"


def missing(status: PartStatus) -> bool:
    return status.state == "missing"


@pytest.mark.parametrize("kind", ["mic", "auto"])
def test_every_loss_and_every_return_is_told_once(server: SoundServer, kind: str) -> None:
    async def scenario() -> None:
        async with watched(kind) as it:
            for _ in range(2):
                await asyncio.to_thread(server.kill)
                await it.until(missing)
                assert not it.ears.push(PCM)
                await asyncio.to_thread(server.start)
                await it.until(ready)
            assert it.states == ["ready", "missing", "ready", "missing", "ready"]
            assert it.lines[-1].detail == "microphone (default)"

    asyncio.run(scenario())


def test_a_microphone_that_comes_later_is_heard_in_place_of_commands(server: SoundServer) -> None:
    async def scenario() -> None:
        server.kill()
        async with watched("auto") as it:
            await asyncio.to_thread(server.start)
            await it.until(ready)
            assert it.states == ["missing", "ready"]
            assert not it.ears.push(PCM)

    asyncio.run(scenario())


def test_whoever_sends_sound_stays_heard_when_a_microphone_comes(server: SoundServer) -> None:
    async def scenario() -> None:
        server.kill()
        async with watched("auto") as it:
            assert it.ears.push(PCM)
            await asyncio.to_thread(server.start)
            hearing = await it.hearing.get()
            async with hearing_more(it):
                assert hearing.source_name == "audio commands"
            assert it.states == ["missing"]

    asyncio.run(scenario())


@asynccontextmanager
async def hearing_more(it: Watched) -> AsyncIterator[None]:
    """Another pair of ears finds the microphone, so that these would have found it as well."""
    async with watched("mic") as other:
        await other.until(ready)
        yield
        assert it.ears.push(PCM)
