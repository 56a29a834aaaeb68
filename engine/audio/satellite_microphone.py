"""The microphone of a Wyoming satellite, as the ears' own. One that is lost stays lost: whoever wants it back opens
another one, which can wait for it."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING, Final

from engine.audio.satellite import Satellite
from engine.audio.source import FRAME_S, Frame, FrameQueue, Framer
from engine.errors import DeviceError
from engine.wyoming import Intake

if TYPE_CHECKING:
    from wyoming.event import Event

WAITING_S: Final = 10.0
"""How much sound may wait for its reader, s."""


class SatelliteMicrophone:
    """See ``Source``. ``patient``: opening waits until the satellite is there. Opening and reading raise
    ``DeviceError``. Its frames carry the time at which they came: the loudspeaker is in the same room."""

    live = True

    def __init__(self, satellite: Satellite, *, patient: bool = False) -> None:
        self.name = satellite.name
        self.overruns = 0
        """A satellite does not tell."""
        self._satellite = satellite
        self._patient = patient
        self._intake = Intake()
        self._framer = Framer()
        self._queue = FrameQueue(round(WAITING_S / FRAME_S))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sound that was lost here."""
        lost = self._queue.dropped * FRAME_S
        return (f"{self.name}: {lost:.1f} s of sound were not read in time.",) if lost else ()

    async def __aenter__(self) -> SatelliteMicrophone:
        await self._satellite.join(self, patient=self._patient)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.close()
        await self._satellite.leave(self)

    def __aiter__(self) -> SatelliteMicrophone:
        return self

    async def __anext__(self) -> Frame:
        return await self._queue.get()

    # What the satellite does with it

    def take(self, event: Event) -> None:
        from wyoming.audio import AudioChunk

        if AudioChunk.is_type(event.type):
            now = asyncio.get_running_loop().time()
            for frame in self._framer.push(self._intake.taken(AudioChunk.from_event(event))):
                self._queue.put(replace(frame, at=now))

    def lose(self, error: DeviceError) -> None:
        self._queue.end(DeviceError(error.message, hint="sayso keeps looking for it."))
