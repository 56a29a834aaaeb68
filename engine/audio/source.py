"""Where sound comes from, as a stream of equal frames.

Every source, be it a microphone, a file, a pipe or a demo, yields the same :class:`Frame`: 32 ms of 16 kHz mono,
which is exactly what the voice activity detectors take. A source is opened by ``async with`` and read by ``async
for``; iteration ends when the sound ends, and raises ``DeviceError`` when a device goes away.

A *live* source goes on whether or not anybody reads, so that it must be read all the time; the others wait for their
reader.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from collections.abc import AsyncIterator
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.errors import SaysoError

RATE = 16_000
"""Samples per second of everything after a source."""

FRAME_SAMPLES = 512
"""Samples per frame: Silero's chunk."""

FRAME_S = FRAME_SAMPLES / RATE
"""Length of a frame, s."""

Samples = NDArray[np.int16]
"""16 kHz mono sound, shape (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """32 ms of sound."""

    samples: Samples  # shape (512,)
    end: float  # s of sound since the stream began, at the frame's end
    at: float | None = None  # s, of the loop's clock: when it came; None where this machine's loudspeaker is not heard


class Source(Protocol):
    """A stream of frames, for one reader. Closing it ends a read that is under way."""

    @property
    def name(self) -> str:
        """For people: ``microphone (USB PnP Audio)``."""
        ...

    @property
    def live(self) -> bool:
        """Sound passes whether or not somebody reads."""
        ...

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with the sound and was tolerated: a truncated file, lost sound."""
        ...

    async def __aenter__(self) -> Source:
        """Open. Raises ``DeviceError`` or ``AudioFormatError``."""
        ...

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close; a read that is under way ends."""
        ...

    def __aiter__(self) -> AsyncIterator[Frame]: ...

    async def __anext__(self) -> Frame: ...


class Framer:
    """Cuts a stream of samples of any lengths into frames, losing and reordering nothing."""

    def __init__(self) -> None:
        self._rest = np.empty(0, np.int16)
        self._frames = 0

    def push(self, samples: Samples) -> list[Frame]:
        """The frames that ``samples`` completes."""
        sound = np.concatenate((self._rest, samples))
        whole = len(sound) // FRAME_SAMPLES * FRAME_SAMPLES
        self._rest = sound[whole:]
        return [self._frame(chunk) for chunk in sound[:whole].reshape(-1, FRAME_SAMPLES)]

    def flush(self) -> list[Frame]:
        """What is left as a last frame, filled up with silence; empty when nothing is left."""
        if not len(self._rest):
            return []
        last = np.pad(self._rest, (0, FRAME_SAMPLES - len(self._rest)))
        self._rest = self._rest[:0]
        return [self._frame(last)]

    def _frame(self, samples: Samples) -> Frame:
        self._frames += 1
        return Frame(samples, self._frames * FRAME_S)


class FrameQueue:
    """Frames from any thread to one reader in an asyncio loop, in order.

    At most ``limit`` frames wait. Then :meth:`put` waits for the reader (``block``), or the oldest frame is dropped
    and counted in ``dropped``, because a live source must not fall behind.
    """

    def __init__(self, limit: int) -> None:
        self.dropped = 0
        self._limit = limit
        self._frames: deque[Frame] = deque()
        self._change = threading.Condition()
        self._ended = False
        self._error: SaysoError | None = None
        self._reader: tuple[asyncio.AbstractEventLoop, asyncio.Event] | None = None

    def put(self, frame: Frame, *, block: bool = False) -> bool:
        """Append a frame; False when the queue has ended and nobody will read it. Thread-safe."""
        with self._change:
            while block and len(self._frames) >= self._limit and not self._ended:
                self._change.wait()
            if self._ended:
                return False
            if len(self._frames) >= self._limit:
                self._frames.popleft()
                self.dropped += 1
            self._frames.append(frame)
            self._wake()
            return True

    def end(self, error: SaysoError | None = None) -> None:
        """No more frames follow; the reader gets those that wait, then ``error`` if any. Thread-safe."""
        with self._change:
            if not self._ended:
                self._ended, self._error = True, error
                self._change.notify_all()
                self._wake()

    def close(self) -> None:
        """End the queue and throw away what waits. Thread-safe."""
        with self._change:
            self._frames.clear()
        self.end()

    async def get(self) -> Frame:
        """The next frame. Raises ``StopAsyncIteration`` after the last, or the error that ended the stream."""
        while True:
            with self._change:
                if self._frames:
                    frame = self._frames.popleft()
                    self._change.notify_all()
                    return frame
                if self._ended:
                    if self._error is not None:
                        raise self._error
                    raise StopAsyncIteration
                arrived = asyncio.Event()
                self._reader = (asyncio.get_running_loop(), arrived)
            await arrived.wait()

    def _wake(self) -> None:
        if self._reader is not None:
            loop, arrived = self._reader
            self._reader = None
            with contextlib.suppress(RuntimeError):  # the loop is closed: there is no reader left to wake
                loop.call_soon_threadsafe(arrived.set)


class Pacer:
    """Lets frames pass no faster than they would sound, by the clock of the running loop."""

    def __init__(self) -> None:
        self._due: float | None = None

    async def wait(self) -> None:
        """Return when the next frame is due.

        After a short stall frames follow each other at once until the lost time is made up; a longer one (the reader
        was away) starts the pace anew.
        """
        now = asyncio.get_running_loop().time()
        due = now if self._due is None or now - self._due > 0.5 else self._due
        self._due = due + FRAME_S
        await asyncio.sleep(max(0.0, self._due - now))


def to_int16(sound: NDArray[np.float32]) -> Samples:
    """Samples of ±1 as 16-bit integers; louder ones are clipped, NaN becomes silence."""
    bounded = np.clip(np.nan_to_num(sound, posinf=1.0, neginf=-1.0), -1.0, 1.0)
    integers: Samples = np.clip(np.rint(bounded * 32768.0), -32768, 32767).astype(np.int16)
    return integers
