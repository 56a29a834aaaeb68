"""What is heard, before anybody listens: one source at a time, and all that happens to its frames.

A live source is read all the time, in a task, so that the moment before the wake is not lost and the level meter lives;
other sources are read only while somebody listens, and go on where they stopped. Every frame passes once: the robot's
own voice is taken out of it, then noise, then the gain is applied.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import Literal

from config.schema import Suppression
from engine.audio.denoise import NoiseSuppressor
from engine.audio.echo import EchoCanceller
from engine.audio.gain import Gain
from engine.audio.level import SILENT, loudness
from engine.audio.ring import Ring
from engine.audio.source import FRAME_S, Frame, Source
from engine.errors import DeviceError, SaysoError

WARN_S = 5.0
"""How often what a live source tolerates is told while nobody listens, at most, s."""


class HearingFault(SaysoError):
    """A fault of ours while a live source was read; opened again, it may be heard again."""

    code = "internal"


class Intake:
    """Has a source, and reads it. Belongs to the loop's thread, but for :attr:`level` and what ``ring`` and ``echo``
    allow.

    ``pre_roll_s``: how much of a live source is kept for who listens later, s. ``on_frame`` is handed every frame of
    one twice: less the robot's own voice as far as that can be subtracted, for whoever knows what to listen for; and
    with what is left of it faded out, for whoever takes all that sounds like speech for somebody's. ``on_end`` is
    called when a live source has ended or is lost, and ``warn`` of what it tolerates while nobody listens. For
    ``suppression``, ``gain_db`` and ``echo`` see ``Hearing``.
    """

    def __init__(
        self,
        pre_roll_s: float,
        on_frame: Callable[[Frame, Frame], None],
        *,
        suppression: Suppression,
        gain_db: float | Literal["auto"],
        echo: EchoCanceller | None,
        on_end: Callable[[SaysoError | None], None],
        warn: Callable[[str], None],
    ) -> None:
        self.level = SILENT
        """Newest loudness; a frozen value that is replaced, so any thread may read it."""
        self.ring = Ring(math.ceil(pre_roll_s / FRAME_S))
        """Frames of a live source on their way to a listener."""
        self.echo = echo
        """What takes the robot's own voice out, where that may be heard."""
        self.gain = self._usual_gain = Gain(gain_db)
        """That of the present source."""
        self._of_others, self._of_all = NoiseSuppressor(suppression), NoiseSuppressor(suppression)
        self._on_frame = on_frame
        self._on_end = on_end
        self._warn = warn
        self._open = AsyncExitStack()
        self._source: Source | None = None
        self._missing: SaysoError | None = None  # why there is no source
        self._told: set[str] = set()
        self._pump: asyncio.Task[None] | None = None

    @property
    def source(self) -> Source:
        """The source that can be listened to. Raises why there is none."""
        error = self._missing or self.ring.error
        if self._source is None or error is not None:
            raise error or DeviceError("There is no source of sound.")
        return self._source

    @property
    def source_name(self) -> str:
        """The source, for people."""
        return self._source.name if self._source is not None else "no sound source"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the source tolerated so far."""
        return self._source.warnings if self._source is not None else ()

    def untold(self) -> list[str]:
        """What the source tolerated and nobody has been told yet: its counters grow, but nothing is repeated."""
        untold = [warning for warning in self.warnings if warning not in self._told]
        self._told.update(untold)
        return untold

    async def replace(self, source: Source, gain: Gain | None = None) -> None:
        """Open ``source`` and read it in the place of the one before, which is closed. No frame of it is handed out
        before whoever waits for this has gone on. ``gain``: that of this source; else it is the usual one, as it was
        left. Raises what opening it raises; then all stays as it was."""
        if self._pump is not None and self._pump.done():
            await self._close_source()  # what has ended may have the device to itself that is to be opened
        opened = AsyncExitStack()
        await opened.enter_async_context(source)
        try:
            await self._close_source()
        except BaseException:
            await opened.aclose()
            raise
        self._open, self._source, self._missing = opened, source, None
        self.gain = gain or self._usual_gain
        self._told.clear()
        self._of_others.reset()
        self._of_all.reset()
        if source.live:
            self.ring.restart()
            if self.echo is not None:
                self.echo.reset()
            self._pump = asyncio.create_task(self._keep_reading(source), name="hearing")

    def lose(self, error: SaysoError) -> None:
        """There is no source any more: that is what whoever wants one is told."""
        self._missing = error

    async def next_frame(self, source: Source, enough: Callable[[], bool], patience_s: float) -> Frame | None:
        """The next frame for who listens, or None at the end: of the source, or, with a live one, when there is
        ``enough``, or when none comes for ``patience_s``. Raises what the source raises."""
        if source.live:
            try:
                async with asyncio.timeout(patience_s):
                    return await self.ring.get(enough)
            except TimeoutError:
                return None
        frame = await anext(source, None)
        return self._taken(frame) if frame is not None else None

    async def close(self) -> None:
        """Close the source; who listens is told that it has ended."""
        await self._close_source()
        self.ring.end(None)

    async def _close_source(self) -> None:
        pump, self._pump, self._source = self._pump, None, None
        outcome: object = None
        if pump is not None:
            pump.cancel()
            (outcome,) = await asyncio.gather(pump, return_exceptions=True)
        await self._open.aclose()
        if isinstance(outcome, Exception):  # a fault of ours, not of the device: those went to the listener
            raise outcome

    async def _keep_reading(self, source: Source) -> None:
        """The task that reads a live source until it ends, is lost, or another one takes its place."""
        error: SaysoError | None = None
        warned = 0.0  # stream time, s
        try:
            async for frame in source:
                left, others = self._without_echo(frame)
                taken = self._taken(others)
                quieter = self._of_all.apply(left)
                plain = taken if quieter is others else self.gain.apply(quieter)
                self.ring.put(taken)
                self._on_frame(plain, taken)
                if frame.end - warned >= WARN_S and not self.ring.is_listened_to:
                    warned = frame.end
                    for warning in self.untold():
                        self._warn(warning)
                await asyncio.sleep(0)  # much may have come at once, and the robot waits for its heartbeat
        except SaysoError as lost:
            error = lost
        except Exception as fault:  # noqa: BLE001 - nobody waits for this task: whoever opens sources is told
            error = HearingFault(f"Hearing failed: {fault!r}.", hint="Please report it.")
        except asyncio.CancelledError:  # whoever listens goes on with the next source
            self.level = SILENT
            raise
        except BaseException:
            self.ring.end(None)
            raise
        self.level = SILENT
        self.ring.end(error)
        self._on_end(error)

    def _taken(self, frame: Frame) -> Frame:
        frame = self.gain.apply(self._of_others.apply(frame))
        self.level = loudness([frame])
        return frame

    def _without_echo(self, frame: Frame) -> tuple[Frame, Frame]:
        """The frame less what the robot itself says, and the same with what is left of that faded out."""
        if self.echo is None or frame.at is None:
            return frame, frame
        cleaned = self.echo.clean(frame.samples, frame.at)
        if cleaned is None:
            return frame, frame
        return replace(frame, samples=cleaned.left), replace(frame, samples=cleaned.others)
