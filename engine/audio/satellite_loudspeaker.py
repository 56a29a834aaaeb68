"""The loudspeaker of a Wyoming satellite, as the player's output.

The protocol knows no way to take back what was sent, so that no more is sent than must be: block by block as it is to
sound, :data:`LEAD_S` ahead. Whoever interrupts ends the sound with the block that is pulled next; what the satellite
has in its buffers sounds to its end. How long a sound is on its way is what the satellite tells by ``played``, which
comes when a sound has ended there. What counts as heard is late by as much.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from engine.audio.player import BLOCK_S, Pull
from engine.audio.satellite import Satellite
from engine.audio.sounder import SHOWN, SOUGHT
from engine.errors import DeviceError, SaysoError

if TYPE_CHECKING:
    from wyoming.event import Event

RATE: Final = 22_050
"""Hz; that of satellites, unless somebody has changed it, and they convert what comes."""
LEAD_S: Final = 0.1
"""How far ahead of time blocks are sent, s: a network delivers in fits and starts."""
DELAY_S: Final = 0.4
"""From when a block is due until it sounds, s, as long as nobody knows better: aplay, which most satellites play with,
begins when it has half a second, and others at once."""
LONGEST_S: Final = 3.0
"""A satellite that says to be later than that means something else, s."""
GOODBYE_S: Final = 0.2
"""A satellite that does not take the end of a sound that is broken off within so long is lost, s: it has taken nothing
for seconds, and whoever breaks off is in a hurry."""
_STALL_S: Final = 0.5  # after a longer one (a paused process) it goes on from here


class SatelliteLoudspeaker:
    """See ``Output``. ``busy`` tells whether there is something to play."""

    def __init__(self, satellite: Satellite) -> None:
        self.name = satellite.name
        self.rate = RATE
        self.busy: Callable[[], bool] = lambda: False
        self._satellite = satellite
        self._delay = DELAY_S
        self._on_way: deque[tuple[float, float]] = deque(maxlen=8)  # sounds: due to end when, how long
        self._pull: Pull | None = None
        self._lost: Callable[[SaysoError], None] = lambda error: None
        self._sounding: asyncio.Task[None] | None = None

    async def open(self, pull: Pull, lost: Callable[[SaysoError], None], *, patient: bool = False) -> None:
        await self._satellite.join(self, patient=patient)
        if self._satellite.mute:
            await self._satellite.leave(self)
            raise self._no_loudspeaker()
        self._on_way.clear()
        self._pull, self._lost = pull, lost

    async def start(self) -> None:
        if self._sounding is None:
            self._sounding = asyncio.create_task(self._sound(), name="satellite's loudspeaker")

    async def stop(self) -> None:
        sounding, self._sounding = self._sounding, None
        if sounding is not None:
            sounding.cancel()
            await asyncio.gather(sounding, return_exceptions=True)

    def hush(self) -> None:
        """What was pulled is on its way, and cannot be called back."""

    async def close(self) -> None:
        await self.stop()
        await self._satellite.leave(self)
        self._pull = None

    # What the satellite does with it

    def take(self, event: Event) -> None:
        from wyoming.pipeline import RunPipeline
        from wyoming.snd import Played

        if Played.is_type(event.type) and self._on_way:
            self._learn(*self._on_way.popleft())
        elif RunPipeline.is_type(event.type) and self._satellite.mute:
            self._lost(self._no_loudspeaker())

    def lose(self, error: DeviceError) -> None:
        self._lost(DeviceError(error.message, hint=SOUGHT))

    def _learn(self, due: float, length: float) -> None:
        """A sound of that length, which was due to end then, has ended. One that is shorter than the satellite's buffer
        begins at its end, and only tells that longer ones are as late at least."""
        late = asyncio.get_running_loop().time() - due
        if 0 < late < LONGEST_S:
            self._delay = late if late < length / 2 else max(late, self._delay)

    async def _sound(self) -> None:
        """Pull block after block, and send what sounds."""
        from wyoming.audio import AudioChunk, AudioStart, AudioStop

        loop, count = asyncio.get_running_loop(), round(BLOCK_S * self.rate)
        begun, blocks, sounds = loop.time(), 0, False
        assert self._pull is not None
        try:
            while True:
                due = begun + blocks * BLOCK_S
                lead = min(LEAD_S, (due - begun) / 4) if sounds else 0.0  # what is said now may not be made further
                await asyncio.sleep(max(0.0, due - lead - loop.time()))
                if loop.time() - due > _STALL_S:
                    begun, blocks, due = loop.time(), 0, loop.time()
                block = self._pull(count, due + self._delay)
                blocks += 1
                if not sounds and block.any():
                    begun, blocks, sounds = due, 1, True
                    await self._satellite.say(AudioStart(self.rate, 2, 1))
                if sounds:
                    await self._satellite.say(AudioChunk(self.rate, 2, 1, block.astype("<i2").tobytes()))
                if sounds and not self.busy():
                    sounds = False
                    self._on_way.append((due + BLOCK_S, blocks * BLOCK_S))
                    await self._satellite.say(AudioStop())
        finally:
            if sounds:
                await self._satellite.say(AudioStop(), within_s=GOODBYE_S)

    def _no_loudspeaker(self) -> DeviceError:
        return self._satellite.fault("has no loudspeaker", hint=SHOWN)
