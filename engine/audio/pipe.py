"""Sound that another program hands over: raw PCM on a pipe such as stdin, or pushed in pieces by commands.

Both are 16 kHz mono signed 16-bit little-endian. Bytes arrive in pieces of any size; a sample that is split between
two pieces is put together again, and a single byte left at the end is dropped with a warning.
"""

from __future__ import annotations

import os
import selectors
import stat
import threading
import time
from types import TracebackType
from typing import BinaryIO

import numpy as np

from engine.audio.source import FRAME_S, Frame, FrameQueue, Framer
from engine.errors import DeviceError

READ_BYTES = 8192
WAITING_S = 130.0
"""How much sound may wait for its reader: more than the longest ``audio`` command holds (``commands.MAX_LINE``)."""


class _PcmSource:
    """What both sources share: bytes to frames, and the queue to the reader."""

    def __init__(self, name: str, *, live: bool) -> None:
        self.name = name
        self.live = live
        self._framer = Framer()
        self._queue = FrameQueue(round(WAITING_S / FRAME_S) if live else 64)
        self._odd = b""
        self._dropped_byte = False

    @property
    def warnings(self) -> tuple[str, ...]:
        """Lost frames and a half sample at the end, if any."""
        found = []
        if self._dropped_byte:
            found.append(f"{self.name}: the sound ended within a sample; the last byte was dropped.")
        if self._queue.dropped:
            found.append(f"{self.name}: {self._queue.dropped * FRAME_S:.1f} s of sound were not read in time.")
        return tuple(found)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.close()

    async def __anext__(self) -> Frame:
        return await self._queue.get()

    def _accept(self, data: bytes) -> bool:
        """Queue the frames that ``data`` completes; False when nobody reads them any more."""
        data = self._odd + data
        whole = len(data) // 2 * 2
        self._odd = data[whole:]
        frames = self._framer.push(np.frombuffer(data[:whole], dtype="<i2").astype(np.int16))
        return all(self._queue.put(frame, block=not self.live) for frame in frames)

    def _finish(self, error: DeviceError | None = None) -> None:
        self._dropped_byte = bool(self._odd)
        for frame in self._framer.flush():
            self._queue.put(frame, block=not self.live)
        self._queue.end(error)


class PcmSource(_PcmSource):
    """Raw PCM from a binary stream, normally ``sys.stdin.buffer``.

    ``live`` (a microphone at the other end of the pipe) reads all the time and drops the oldest sound when nobody
    listens; otherwise the writer waits for the reader. None: a regular file is not live, a pipe is.

    The file descriptor is read directly, by a daemon thread that also waits for ``close``: a thread inside a
    ``BufferedReader`` would hold its lock, and the interpreter aborts at exit over that. Bytes that were already
    buffered in ``stream`` are not seen.
    """

    def __init__(self, stream: BinaryIO, *, name: str = "stdin", live: bool | None = None) -> None:
        self._stream = stream
        self._fd = stream.fileno()
        if live is None:
            live = not stat.S_ISREG(os.fstat(self._fd).st_mode)
        super().__init__(name, live=live)
        self._stop_read, self._stop_write = -1, -1
        self._thread: threading.Thread | None = None

    async def __aenter__(self) -> PcmSource:
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._read, name="pcm-reader", daemon=True)
        self._thread.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.close()  # first: the thread may be waiting for room in the queue
        if self._thread is not None:
            os.close(self._stop_write)
            self._thread.join()  # returns at once: closing the pipe wakes its select
            os.close(self._stop_read)
            self._thread = None

    def __aiter__(self) -> PcmSource:
        return self

    def _read(self) -> None:
        try:
            while self._readable():
                data = os.read(self._fd, READ_BYTES)
                if not data:
                    break
                if not self._accept(data):
                    return
        except OSError as error:
            self._finish(DeviceError(f"Reading sound from {self.name} failed: {error.strerror}."))
        else:
            self._finish()

    def _readable(self) -> bool:
        """Wait for bytes; False when the source is being closed."""
        with selectors.SelectSelector() as selector:  # epoll refuses regular files
            selector.register(self._stop_read, selectors.EVENT_READ)
            selector.register(self._fd, selectors.EVENT_READ)
            return all(key.fd != self._stop_read for key, _ in selector.select())


class PushSource(_PcmSource):
    """Sound that is pushed from any thread, as if it came from a microphone."""

    def __init__(self, *, name: str = "audio commands") -> None:
        super().__init__(name, live=True)
        self._lock = threading.Lock()  # pieces of several senders must not mix within a frame

    async def __aenter__(self) -> PushSource:
        return self

    def __aiter__(self) -> PushSource:
        return self

    def push(self, pcm: bytes) -> None:
        """Append sound. Thread-safe, returns at once."""
        with self._lock:
            self._accept(pcm)

    def finish(self) -> None:
        """No more sound will come; the reader's iteration ends after what was pushed. Thread-safe."""
        with self._lock:
            self._finish()


class GuestSource(PushSource):
    """Sound that somebody outside hands over for a while."""

    def __init__(self, name: str) -> None:
        super().__init__(name=name)
        self._heard = time.monotonic()

    @property
    def idle_s(self) -> float:
        """For how long nothing has come, s."""
        return time.monotonic() - self._heard

    def push(self, pcm: bytes) -> None:
        """Append sound. Thread-safe, returns at once."""
        self._heard = time.monotonic()
        super().push(pcm)
