"""A satellite as wyoming-satellite 1.4 is one (always streaming), without a sound card: it speaks the real protocol
over a real socket, and plays as aplay does.

It has one server at a time, and closes every other connection at the first word. What it is to play waits until there
is a buffer of it, or its end; ``played`` is told when a sound has ended, and the next one begins only then.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import numpy as np
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.event import Event, Eventable
from wyoming.ping import Ping, Pong
from wyoming.pipeline import PipelineStage, RunPipeline
from wyoming.satellite import RunSatellite
from wyoming.snd import Played

from engine import wyoming
from engine.audio.source import Samples


class Satellite:
    """``buffer_s`` is aplay's; ``mute``: it has no loudspeaker."""

    def __init__(self, address: str, *, buffer_s: float = 0.5, mute: bool = False) -> None:
        self.address = address
        self.events: list[tuple[float, str]] = []
        """What it was told to play, and when: starts and stops, each chunk too."""
        self.sounded: list[tuple[float, Samples]] = []
        """What its loudspeaker has begun to play when, or will."""
        self.rate = 22_050
        self.streams = asyncio.Event()
        self._buffer_s = buffer_s
        self._mute = mute
        self._writer: asyncio.StreamWriter | None = None
        self._to_play: asyncio.Queue[Event] = asyncio.Queue()

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._writer is not None:
            await wyoming.read(reader)
            writer.close()
            return
        self._writer = writer
        playing = asyncio.create_task(self._play())
        try:
            while (event := await wyoming.read(reader)) is not None:
                await self._obey(event)
        except (OSError, EOFError):
            pass
        finally:
            playing.cancel()
            self._writer = None
            self.streams.clear()
            writer.close()

    async def _obey(self, event: Event) -> None:
        if Ping.is_type(event.type):
            await self.say(Pong(Ping.from_event(event).text))
        elif RunSatellite.is_type(event.type):
            end = PipelineStage.HANDLE if self._mute else PipelineStage.TTS
            await self.say(RunPipeline(PipelineStage.WAKE, end))
            self.streams.set()
        elif AudioStart.is_type(event.type) or AudioChunk.is_type(event.type) or AudioStop.is_type(event.type):
            self.events.append((asyncio.get_running_loop().time(), event.type))
            if not self._mute:
                self._to_play.put_nowait(event)

    async def say(self, *events: Eventable) -> None:
        assert self._writer is not None
        await wyoming.write(self._writer, *events)

    async def speak(self, samples: Samples) -> None:
        """Its microphone hears this (16 kHz), in no time."""
        for at in range(0, len(samples), 1024):
            await self.say(AudioChunk(16_000, 2, 1, samples[at : at + 1024].tobytes()))

    def drop(self) -> None:
        """It goes, without a word."""
        assert self._writer is not None
        self._writer.transport.abort()

    def stall(self) -> None:
        """It stays, and takes nothing any more."""
        assert self._writer is not None
        self._writer.transport.pause_reading()  # type: ignore[attr-defined]

    def heard_by(self, time: float) -> float:
        """How much has sounded by then, s."""
        lengths = ((begins, len(sound) / self.rate) for begins, sound in self.sounded)
        return sum(min(max(0.0, time - begins), length) for begins, length in lengths)

    async def _play(self) -> None:
        loop = asyncio.get_running_loop()
        waiting: list[Samples] = []
        until: float | None = None  # all that was begun will have sounded
        while True:
            event = await self._to_play.get()
            if AudioChunk.is_type(event.type):
                chunk = AudioChunk.from_event(event)
                assert (chunk.rate, chunk.width, chunk.channels) == (self.rate, 2, 1)
                waiting.append(np.frombuffer(chunk.audio, "<i2"))
            ends = AudioStop.is_type(event.type)
            if waiting and (until is not None or ends or sum(map(len, waiting)) >= self._buffer_s * self.rate):
                sound, waiting = np.concatenate(waiting), []
                begins = max(until or 0.0, loop.time())
                self.sounded.append((begins, sound))
                until = begins + len(sound) / self.rate
            if ends:
                await asyncio.sleep(max(0.0, (until or 0.0) - loop.time()))
                until = None
                with suppress(OSError):
                    await self.say(Played())


@asynccontextmanager
async def there(satellite: Satellite) -> AsyncIterator[Satellite]:
    """It is there as long as this is entered, at its unix:// address."""
    path = satellite.address.removeprefix("unix://")
    with suppress(FileNotFoundError):
        os.unlink(path)  # noqa: PTH108 - of a last time
    server = await asyncio.start_unix_server(satellite.serve, path)
    try:
        yield satellite
    finally:
        server.close()
        if satellite._writer is not None:
            satellite.drop()
