"""An output without a device: sound is pulled as the loop's clock goes, and nobody hears it.

For tests under virtual time, and for engines whose sound comes from elsewhere: speaking takes as long as it would, and
whoever is interrupted has said as much.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from engine.audio.player import BLOCK_S, Pull
from engine.audio.source import RATE, Samples
from engine.errors import SaysoError


class ClockedOutput:
    """Pulls 20 ms every 20 ms; ``hear`` is given every block."""

    name = "no loudspeaker"

    def __init__(self, rate: int = RATE, hear: Callable[[Samples], None] = lambda block: None) -> None:
        self.rate = rate
        self._hear = hear
        self._pull: Pull | None = None
        self._running: asyncio.Task[None] | None = None

    async def open(self, pull: Pull, lost: Callable[[SaysoError], None], *, patient: bool = False) -> None:
        del lost, patient  # a clock is there, and stays
        self._pull = pull

    async def start(self) -> None:
        if self._running is None:
            self._running = asyncio.get_running_loop().create_task(self._run(), name="clocked output")

    async def stop(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    def hush(self) -> None:
        """It pulls nothing before it sounds."""

    async def close(self) -> None:
        await self.stop()
        self._pull = None

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        begun, blocks = loop.time(), 0
        while self._pull is not None:
            at = begun + blocks * BLOCK_S
            await asyncio.sleep(max(0.0, at - loop.time()))
            if loop.time() - at > 0.5:  # a long stall (a paused process): go on from here
                begun, blocks, at = loop.time(), 0, loop.time()
            self._hear(self._pull(round(BLOCK_S * self.rate), at))
            blocks += 1
