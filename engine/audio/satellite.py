"""A Wyoming satellite: a microphone in another room, and the loudspeaker next to it.

(https://github.com/rhasspy/wyoming-satellite) A satellite waits for a server to connect and to say that it may stream;
it has one server at a time, so that all who use it here share a connection. It is made for the first of them, and ends
with the last. What a satellite does with wake words of its own is its own affair: once it streams, all it sends is
heard, and those of sayso are listened for in it.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, Protocol

from engine import wyoming
from engine.errors import DeviceError
from engine.wyoming import Intake, Talk, Trouble, talking

if TYPE_CHECKING:
    from wyoming.event import Event, Eventable

SILENCE_S: Final = 10.0
"""After so long without a word it is asked whether it is still there, and given up after as long again, s."""
AGAIN_S: Final = 2.0
"""Pause before somebody who is patient looks for it again, s."""


class End(Protocol):
    """Who uses a satellite. Both are called in the loop's thread, and must not hold it up."""

    def take(self, event: Event) -> None:
        """It has said something. Raises ``Trouble``, or ``ValueError`` where that made no sense: it is lost then."""
        ...

    def lose(self, error: DeviceError) -> None:
        """It is lost, and whoever wants it back joins again."""
        ...


class Satellite:
    """One satellite. Belongs to a loop's thread."""

    def __init__(self, address: str, *, silence_s: float = SILENCE_S) -> None:
        """``address``: tcp://HOST:PORT or unix:///PATH."""
        self._at = address.partition("://")[2]
        self.name = f"satellite at {self._at}"
        self.mute = False
        """It has said that it has no loudspeaker."""
        self._address = address
        self._silence_s = silence_s
        self._ends: list[End] = []
        self._talk: Talk | None = None
        self._working: asyncio.Task[None] | None = None
        self._joining = asyncio.Lock()

    async def join(self, end: End, *, patient: bool = False) -> None:
        """From now on ``end`` is told what it says. ``patient``: wait until it is there. Raises ``DeviceError``."""
        while True:
            try:
                async with self._joining:
                    await self._connect(end)
                return
            except DeviceError:
                if not patient:
                    raise
            await asyncio.sleep(AGAIN_S)

    async def leave(self, end: End) -> None:
        """``end`` is told no more; after the last one the satellite is let go."""
        if end in self._ends:
            self._ends.remove(end)
            async with self._joining:
                if not self._ends:
                    await self._hang_up()

    async def say(self, *events: Eventable, within_s: float | None = None) -> None:
        """Tell it something, which it has to take ``within_s`` at the latest, or else as soon as anybody has to; one
        that is lost is told nothing, and its ends know."""
        if (talk := self._talk) is not None:
            try:
                async with asyncio.timeout(within_s):
                    await talk.say(*events)
            except (OSError, TimeoutError):  # it has gone, or takes nothing any more
                talk.abort()

    async def _connect(self, end: End) -> None:
        if self._talk is None:
            if not wyoming.is_installed():
                hint = f"Install it: {wyoming.INSTALL}."
                raise self.fault("cannot be used: the package wyoming is not installed", hint)
            await self._hang_up()
            up = asyncio.get_running_loop().create_future()
            self._ends.append(end)  # from the first word on
            self._working = asyncio.create_task(self._work(up), name=self.name)
            try:
                await up
            except BaseException:
                self._ends.clear()  # whoever joins next waits for us
                await self._hang_up()
                raise
        else:
            self._ends.append(end)

    async def _hang_up(self) -> None:
        working, self._working, self._talk = self._working, None, None
        if working is not None:
            working.cancel()
            await asyncio.gather(working, return_exceptions=True)

    async def _work(self, up: asyncio.Future[None]) -> None:
        """Talk with it until one of us ends. ``up`` is told once it is there: one that has a server already takes a
        connection, and ends it at the first word."""
        from wyoming.ping import Ping
        from wyoming.satellite import RunSatellite

        try:
            async with talking(self._address, self.fault, self._silence_s) as talk:
                await talk.say(RunSatellite(), Ping("sayso"))
                event = await talk.hear()
                self._talk, self.mute = talk, False
                if not up.done():
                    up.set_result(None)
                while True:
                    await self._take(talk, event)
                    event = await _next(talk)
        except DeviceError as error:
            self._talk = None
            if not up.done():
                up.set_exception(error)
                return
            ends, self._ends = self._ends, []
            for end in ends:
                end.lose(error)

    async def _take(self, talk: Talk, event: Event) -> None:
        from wyoming.ping import Ping, Pong
        from wyoming.pipeline import PipelineStage, RunPipeline

        if Ping.is_type(event.type):
            await talk.say(Pong(Ping.from_event(event).text))
            return
        if RunPipeline.is_type(event.type):
            self.mute = RunPipeline.from_event(event).end_stage is not PipelineStage.TTS
        for end in tuple(self._ends):
            end.take(event)

    def fault(self, what: str, hint: str = "") -> DeviceError:
        """An error of the end of a sentence about it."""
        return DeviceError(f"The satellite at {self._at} {what}.", hint=hint or "Check its address, and that it runs.")


class _Listener:
    """One who only listens."""

    def __init__(self, take: Callable[[bytes], None]) -> None:
        self.lost: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._hand_over = take
        self._intake = Intake()

    def take(self, event: Event) -> None:
        from wyoming.audio import AudioChunk

        if AudioChunk.is_type(event.type) and len(samples := self._intake.taken(AudioChunk.from_event(event))):
            self._hand_over(samples.astype("<i2").tobytes())

    def lose(self, error: DeviceError) -> None:
        self.lost.set_exception(error)


async def hear(
    address: str,
    take: Callable[[bytes], None],
    *,
    begun: Callable[[], None] = lambda: None,
    silence_s: float = SILENCE_S,
) -> None:
    """Connect, and hand all sound over to ``take``: 16 kHz mono signed 16-bit little-endian. ``begun`` is called when
    it may stream. Ends by being cancelled, or raises the ``DeviceError`` by which it ended."""
    satellite, listener = Satellite(address, silence_s=silence_s), _Listener(take)
    await satellite.join(listener)
    try:
        begun()
        await listener.lost
    finally:
        await satellite.leave(listener)


async def _next(talk: Talk) -> Event:
    """What it says next. One that waits for a voice may say nothing for long, but answers."""
    from wyoming.ping import Ping

    with contextlib.suppress(TimeoutError):
        return await talk.hear()
    await talk.say(Ping("sayso"))
    try:
        return await talk.hear()
    except TimeoutError as error:
        raise Trouble("does not answer any more") from error
