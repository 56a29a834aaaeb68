"""A Wyoming satellite as a microphone, over real sockets on loopback: what it hears is heard here until it goes."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
from wyoming.audio import AudioChunk
from wyoming.error import Error
from wyoming.event import Event, Eventable
from wyoming.ping import Ping, Pong
from wyoming.pipeline import PipelineStage, RunPipeline
from wyoming.satellite import RunSatellite

from engine import wyoming
from engine.audio.feed import Door
from engine.audio.pipe import GuestSource
from engine.audio.satellite import hear
from engine.audio.source import RATE
from engine.errors import DeviceError, ExitCode
from tests.e2e.sayso import command, environment, sayso

LIMIT_S = 30.0
TONE = np.asarray(9000 * np.sin(np.arange(3 * RATE) / 10), np.int16)
BEGINS = RunPipeline(start_stage=PipelineStage.ASR, end_stage=PipelineStage.ASR)


class Satellite:
    """One that streams as soon as a server lets it, and then does what a test says."""

    def __init__(self, then: Callable[[Satellite], Awaitable[None]]) -> None:
        self._then = then
        self.left = asyncio.Event()
        self.address = ""

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer
        event = await wyoming.read(reader)
        assert event is not None
        assert RunSatellite.is_type(event.type), "nothing is sent before it may"
        event = await wyoming.read(reader)
        assert event is not None
        assert Ping.is_type(event.type), "whoever has another server would not answer"
        await self.say(Pong())
        try:
            await self._then(self)
        except OSError:
            pass  # whoever heard it has gone
        finally:
            self.left.set()
            writer.close()

    async def say(self, *events: Eventable) -> None:
        await wyoming.write(self._writer, *events)

    async def hear(self) -> Event | None:
        return await wyoming.read(self._reader)


@asynccontextmanager
async def satellite(then: Callable[[Satellite], Awaitable[None]]) -> AsyncIterator[Satellite]:
    made = Satellite(then)
    async with asyncio.timeout(LIMIT_S), await asyncio.start_server(made.serve, "127.0.0.1", 0) as server:
        made.address = f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        yield made


def chunks(samples: np.ndarray[tuple[int], np.dtype[np.int16]]) -> list[Eventable]:
    pieces = (samples[at : at + 1024].tobytes() for at in range(0, len(samples), 1024))
    return [AudioChunk(RATE, 2, 1, piece) for piece in pieces]


def wire(event: Eventable) -> bytes:
    told = event.event()
    head = {"type": told.type, "data": told.data, "payload_length": len(told.payload or b"")}
    return json.dumps(head).encode() + b"\n" + (told.payload or b"")


def test_what_it_hears_is_handed_over_whole_and_a_ping_is_answered() -> None:
    pongs: list[str | None] = []

    async def stream(one: Satellite) -> None:
        await one.say(BEGINS, *chunks(TONE[:RATE]), Ping("are you there?"))
        answer = await one.hear()
        assert answer is not None
        pongs.append(Pong.from_event(answer).text)
        await one.say(*chunks(TONE[RATE:]))

    async def scenario() -> None:
        heard, begun = bytearray(), asyncio.Event()
        async with satellite(stream) as one:
            with pytest.raises(DeviceError, match="closed the connection"):
                await hear(one.address, heard.extend, begun=begun.set)
        assert begun.is_set()
        assert bytes(heard) == TONE.astype("<i2").tobytes()
        assert pongs == ["are you there?"]

    asyncio.run(scenario())


def test_one_that_waits_for_a_voice_is_asked_whether_it_is_still_there() -> None:
    asked: list[str] = []

    async def wait(one: Satellite) -> None:
        for _ in range(2):
            event = await one.hear()
            assert event is not None
            asked.append(event.type)
            await one.say(Pong())
        assert await one.hear() is not None  # which is not answered
        assert await one.hear() is None

    async def scenario() -> None:
        async with satellite(wait) as one:
            with pytest.raises(DeviceError, match="does not answer any more"):
                await hear(one.address, lambda pcm: None, silence_s=0.2)

    asyncio.run(scenario())
    assert asked == ["ping", "ping"]


@pytest.mark.parametrize(
    ("chunk", "message"),
    [
        (AudioChunk(RATE, 3, 1, b"abc"), r"this kind of sound \(16000 Hz, 3 bytes, 1 channels\) is not understood"),
        (AudioChunk(RATE, "\x1b[2J\n", 1, b"abc"), r"\(16000 Hz, \[2J bytes, 1 channels\) is not"),  # type: ignore[arg-type]
        (AudioChunk(RATE, 2, 1, b"abc"), "does not speak Wyoming"),
    ],
)
def test_one_that_sends_no_sound_is_an_error(chunk: AudioChunk, message: str) -> None:
    async def babble(one: Satellite) -> None:
        await one.say(chunk)
        await one.hear()

    async def scenario() -> None:
        async with satellite(babble) as one:
            with pytest.raises(DeviceError, match=message):
                await hear(one.address, lambda pcm: None)

    asyncio.run(scenario())


def test_one_whose_sound_stalls_in_the_midst_of_an_event_is_heard_when_it_comes() -> None:
    async def stall(one: Satellite) -> None:
        before, after = chunks(TONE[:1024]), chunks(TONE[1024:3072])
        whole = wire(after[0])
        begun = whole.index(b"\n") + 100  # the header, and some of the sound
        await one.say(*before)
        one._writer.write(whole[:begun])
        event = await one.hear()
        assert event is not None
        assert Ping.is_type(event.type), "it was silent for as long as it may be"
        one._writer.write(whole[begun:])
        await one.say(Pong(), *after[1:])

    async def scenario() -> None:
        heard = bytearray()
        async with satellite(stall) as one:
            with pytest.raises(DeviceError, match="closed the connection"):
                await hear(one.address, heard.extend, silence_s=0.3)
        assert bytes(heard) == TONE[:3072].astype("<i2").tobytes()

    asyncio.run(scenario())


def test_what_one_says_is_told_in_one_line_that_can_be_printed() -> None:
    async def babble(one: Satellite) -> None:
        await one.say(Error("no\x1b]0;title\x07 such\r\nthing \x9b31m" + "!" * 300))
        await one.hear()

    async def scenario() -> None:
        async with satellite(babble) as one:
            with pytest.raises(DeviceError, match="reports an error: no") as caught:
                await hear(one.address, lambda pcm: None)
        assert caught.value.message.isprintable()
        assert "no ]0;title such thing 31m!" in caught.value.message
        assert len(caught.value.message) < 300

    asyncio.run(scenario())


# The command


def test_the_sayso_that_runs_here_hears_it_until_it_goes(tmp_path: Path) -> None:
    guests: asyncio.Queue[GuestSource] = asyncio.Queue()

    async def stream(one: Satellite) -> None:
        await one.say(BEGINS, *chunks(TONE))

    async def scenario() -> None:
        async with satellite(stream) as one, Door(tmp_path / "mic.sock", guests.put_nowait):
            process = await asyncio.create_subprocess_exec(
                *command("mic", "--wyoming", one.address),
                env=environment(tmp_path),
                stdin=asyncio.subprocess.DEVNULL,
                stderr=asyncio.subprocess.PIPE,
            )
            guest = await guests.get()
            assert guest.name == f"satellite at {one.address.removeprefix('tcp://')}"
            heard = [frame.samples async for frame in guest]
            assert np.array_equal(np.concatenate(heard)[: len(TONE)], TONE)
            _, told = await process.communicate()
            assert process.returncode == ExitCode.MISSING
            assert "hears this now" in told.decode()
            assert "closed the connection" in told.decode()
            assert "Traceback" not in told.decode()

    asyncio.run(scenario())


def test_one_that_is_not_there_is_said_before_anybody_listens(tmp_path: Path) -> None:
    done = sayso("mic", "--wyoming", "tcp://127.0.0.1:9", state=tmp_path)
    assert done.returncode == ExitCode.MISSING
    assert "satellite at 127.0.0.1:9 cannot be used" in done.stderr.decode()
    assert "hears this now" not in done.stderr.decode()
    done = sayso("mic", "--wyoming", "robot", state=tmp_path)
    assert done.returncode == ExitCode.USAGE


def test_without_a_sayso_to_hear_it_the_satellite_is_let_go(tmp_path: Path) -> None:
    async def stream(one: Satellite) -> None:
        while True:
            await one.say(*chunks(TONE[:RATE]))

    async def scenario() -> None:
        async with satellite(stream) as one:
            process = await asyncio.create_subprocess_exec(
                *command("mic", "--wyoming", one.address), env=environment(tmp_path), stderr=asyncio.subprocess.PIPE
            )
            _, told = await process.communicate()
            assert process.returncode == ExitCode.MISSING
            assert "No sayso that hears runs" in told.decode()
            await one.left.wait()

    asyncio.run(scenario())
