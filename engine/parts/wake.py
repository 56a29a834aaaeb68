"""The wake module as a part of the engine: what its reader tells becomes the part's status and lines of the log.

Only news go through the engine's loop. A wake does not: it acts in the thread of the reader.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import Final

from config.schema import SerialWake
from engine.bus import Emit
from engine.commands import Wake
from engine.errors import SaysoError
from engine.events import ErrorRaised, Log
from engine.parts.part import Part
from engine.wake.reader import Listening, Lost, News, Remark, WakeReader

PAUSES_S: Final = (0.0, 1.0, 5.0)
"""Before listening begins anew after a fault, the first time and each further one, s; then it is given up."""


class WakePart:
    """Listens to the module and follows how it is doing; the part's value says which one it is and where."""

    def __init__(
        self, part: Part[str], settings: SerialWake, wake: Callable[[Wake], None], emit: Emit, *, prompt: bool
    ) -> None:
        """``wake`` is called in the reader's thread, which ``prompt`` lets go before others."""
        self._part = part
        self._settings = settings
        self._wake = wake
        self._emit = emit
        self._prompt = prompt
        self._faults: asyncio.Queue[SaysoError] = asyncio.Queue()

    async def keep(self) -> None:
        """Listen until this is cancelled, or one fault has followed the other."""
        for pause in PAUSES_S:
            self._part.fail(await self._listen())
            await asyncio.sleep(pause)
        fault = await self._listen()
        self._part.fail(fault)
        self._emit(ErrorRaised("internal", fault.message, fault.hint))

    async def _listen(self) -> SaysoError:
        """Listen until this is cancelled, or to the fault that ends it."""
        self._loop = asyncio.get_running_loop()
        reader = WakeReader(self._settings, self._wake, self._soon, prompt=self._prompt)
        reader.start()
        try:
            return await self._faults.get()
        finally:
            await asyncio.to_thread(reader.close)

    def _soon(self, news: News) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody is interested any more
            self._loop.call_soon_threadsafe(self._follow, news)

    def _follow(self, news: News) -> None:
        match news:
            case Listening(detail):
                self._part.succeed(detail, detail)
            case Lost(fault, over=True):
                self._faults.put_nowait(fault)
            case Lost(error):
                self._part.fail(error)
            case Remark(text, odd):
                self._emit(Log("warning" if odd else "info", "wake", text))
