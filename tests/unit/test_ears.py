"""The ears of an engine, where something of them is missing."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import numpy as np
import pytest

from config import load
from engine.asr.recogniser import RecogniserLost
from engine.audio.feed import Door
from engine.audio.source import FRAME_SAMPLES, Frame
from engine.audio.wav import read_wav
from engine.errors import DeviceError, SaysoError
from engine.handle import PartStatus
from engine.hearing.hearing import Hearing
from engine.hearing.intake import HearingFault, Intake
from engine.parts import ears as module
from engine.parts.ears import FRESH_STARTS, Ears
from engine.parts.loading import Sound
from engine.parts.part import Part
from tests.recogniser import Scripted
from tests.unit.hears import SPEECH, all_read

LIMIT_S = 20
FRAME = np.full(FRAME_SAMPLES, 3000, np.int16).tobytes()


def test_without_a_recogniser_the_microphone_does_not_seem_to_be_opened_for_ever(tmp_path: Path) -> None:
    told: asyncio.Queue[PartStatus] = asyncio.Queue()

    async def scenario() -> None:
        settings = load(environ={"SAYSO_ASR__MODEL": str(tmp_path / "nothing")})
        recogniser: Part[Hearing] = Part("recogniser", told.put_nowait)
        ears = Ears(settings, Sound("mic"), Part("microphone", told.put_nowait), recogniser)
        keeping = asyncio.create_task(ears.keep())
        async with asyncio.timeout(60):
            states = [(status.name, status.state) for status in (await told.get(), await told.get())]
        assert states == [("recogniser", "missing"), ("microphone", "missing")]
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    asyncio.run(scenario())


class LostAtFirst(Scripted):
    """A recogniser whose process does not survive the first loadings."""

    def __init__(self, losses: int) -> None:
        super().__init__("Go to the kitchen.")
        self.losses = losses

    def load(self) -> None:
        if self.losses:
            self.losses -= 1
            raise RecogniserLost("The recogniser process was killed by SIGKILL.", hint="Say it again.")


@pytest.mark.parametrize(("losses", "state"), [(FRESH_STARTS, "ready"), (FRESH_STARTS + 1, "missing")])
def test_a_recogniser_that_is_lost_while_it_loads_is_started_again(
    losses: int, state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "make_isolated_recogniser", lambda settings: LostAtFirst(losses))
    monkeypatch.setattr(module, "AGAIN_S", 0.01)
    warned: list[str] = []

    async def scenario() -> None:
        told: asyncio.Queue[PartStatus] = asyncio.Queue()
        recogniser: Part[Hearing] = Part("recogniser", told.put_nowait)
        ears = Ears(
            load(environ={}), Sound("none"), Part("microphone", lambda news: None), recogniser, warn=warned.append
        )
        keeping = asyncio.create_task(ears.keep())
        async with asyncio.timeout(LIMIT_S):
            status = await told.get()
        assert status.state == state
        assert "Say it again" not in status.detail, "nobody would hear it"
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    asyncio.run(scenario())
    assert warned == ["The recogniser process was killed by SIGKILL. It is started again."] * FRESH_STARTS


class Kept:
    """Ears with a recogniser of ours that hear what is pushed, and what they told."""

    def __init__(self, door: Path | None = None) -> None:
        self.told: asyncio.Queue[PartStatus] = asyncio.Queue()
        self.faults: list[SaysoError] = []
        self.hearing: Part[Hearing] = Part("recogniser", self.told.put_nowait)
        microphone: Part[str] = Part("microphone", self.told.put_nowait)
        self.ears = Ears(
            load(environ={}), Sound("none"), microphone, self.hearing, door=door, on_fault=self.faults.append
        )

    async def until(self, *wanted: tuple[str, str]) -> None:
        """Wait for parts to be in these states, one after the other."""
        for name, state in wanted:
            async with asyncio.timeout(LIMIT_S):
                while ((status := await self.told.get()).name, status.state) != (name, state):
                    pass


@asynccontextmanager
async def kept(monkeypatch: pytest.MonkeyPatch, door: Path | None = None) -> AsyncIterator[Kept]:
    monkeypatch.setattr(module, "make_isolated_recogniser", lambda settings: Scripted("Go to the kitchen."))
    monkeypatch.setattr(module, "AGAIN_S", 0.01)
    it = Kept(door)
    keeping = asyncio.create_task(it.ears.keep())
    try:
        await it.until(("recogniser", "ready"))
        yield it
    finally:
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)


@pytest.mark.parametrize(("backend", "asked"), [("openai", False), ("whisper", True)])
def test_a_service_is_sent_nothing_of_what_is_said_while_the_robot_moves_but_a_stop_that_is_suspected(
    backend: str, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted = Scripted("Stop!")
    monkeypatch.setattr(module, "make_isolated_recogniser", lambda settings: scripted)
    told: list[str] = []
    settled = asyncio.Event()
    settings = load(overrides=(f"asr.backend={backend}", "asr.platform=openai"), environ={"OPENAI_API_KEY": "none"})
    stop = read_wav(SPEECH / "stop.wav")

    async def scenario() -> None:
        hearing: Part[Hearing] = Part("recogniser", lambda news: None)
        ears = Ears(settings, Sound("none"), Part("microphone", lambda news: None), hearing, on_words=told.append)
        keeping = asyncio.create_task(ears.keep())
        async with asyncio.timeout(LIMIT_S):
            listening = await hearing.get()
            listening.overhear(True)
            assert listening.overhears
            ears.push(np.concatenate((np.zeros(16_000, np.int16), stop, np.zeros(16_000, np.int16))).tobytes())
            await all_read()
            await listening.load()  # queues up behind what is being recognised
            assert bool(scripted.passes) == asked
            if not asked:
                listening.suspect("stop", settled.set, lambda: None, sure=True)
                await settled.wait()
        assert told == ["Stop!"]
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    asyncio.run(scenario())


def test_a_door_that_another_engine_has_is_ours_when_that_one_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        refused, ours = asyncio.Event(), asyncio.Event()

        class Tried(Door):
            async def __aenter__(self) -> Door:
                try:
                    opened = await super().__aenter__()
                except DeviceError:
                    refused.set()
                    raise
                ours.set()
                return opened

        monkeypatch.setattr(module, "Door", Tried)
        async with asyncio.timeout(LIMIT_S), AsyncExitStack() as closing:
            other = AsyncExitStack()
            await other.enter_async_context(Door(tmp_path / "door", lambda guest: None))
            await closing.enter_async_context(kept(monkeypatch, tmp_path / "door"))
            await refused.wait()
            assert not ours.is_set()
            await other.aclose()
            await ours.wait()

    asyncio.run(scenario())


def test_a_fault_while_sound_is_read_is_told_and_the_source_is_opened_again(monkeypatch: pytest.MonkeyPatch) -> None:
    faults, heard = [FloatingPointError("once")], asyncio.Event()
    plain = Intake._without_echo

    def at_first_broken(self: Intake, frame: Frame) -> tuple[Frame, Frame]:
        if faults:
            raise faults.pop()
        heard.set()
        return plain(self, frame)

    monkeypatch.setattr(Intake, "_without_echo", at_first_broken)

    async def scenario() -> None:
        async with kept(monkeypatch) as it:
            assert it.ears.push(FRAME)
            await it.until(("microphone", "failed"), ("microphone", "ready"))
            assert [type(fault) for fault in it.faults] == [HearingFault]
            assert it.ears.push(FRAME)
            async with asyncio.timeout(LIMIT_S):
                await heard.wait()

    asyncio.run(scenario())
