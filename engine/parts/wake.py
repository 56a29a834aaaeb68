"""The wake module as a part of the engine: what its reader tells becomes the part's status and lines of the log.

Only news go through the engine's loop. A wake does not: it acts in the thread of the reader.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

from config.schema import SerialWake
from engine.bus import Emit
from engine.commands import Wake
from engine.events import Log
from engine.parts.part import Part
from engine.wake.reader import Listening, Lost, News, Remark, WakeReader


class WakePart:
    """Listens to the module and follows how it is doing; the part's value says which one it is and where."""

    def __init__(
        self, part: Part[str], settings: SerialWake, wake: Callable[[Wake], None], emit: Emit, *, prompt: bool
    ) -> None:
        """``wake`` is called in the reader's thread, which ``prompt`` lets go before others."""
        self._part = part
        self._emit = emit
        self._reader = WakeReader(settings, wake, self._soon, prompt=prompt)

    async def keep(self) -> None:
        """Listen until this is cancelled."""
        self._loop = asyncio.get_running_loop()
        self._reader.start()
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.to_thread(self._reader.close)

    def _soon(self, news: News) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody is interested any more
            self._loop.call_soon_threadsafe(self._follow, news)

    def _follow(self, news: News) -> None:
        match news:
            case Listening(detail):
                self._part.succeed(detail, detail)
            case Lost(error):
                self._part.fail(error)
            case Remark(text, odd):
                self._emit(Log("warning" if odd else "info", "wake", text))
