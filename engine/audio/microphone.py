"""The live microphone. A process of its own records it (``engine.audio.recorder``); this is the end where one listens.

No device is touched, and sounddevice is not imported, in this process. Every failure becomes a ``DeviceError`` that
says what to do. A microphone that is lost stays lost: whoever wants it back opens another one, which can wait for it.
"""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import replace
from types import TracebackType

import msgspec
import numpy as np

from engine.audio.recorder import MESSAGES, Failed, Looking, Message, Opened, Sound
from engine.audio.source import Frame, Framer
from engine.child import Child
from engine.errors import DeviceError, ProcessError
from engine.messages import LENGTH_BYTES

ANSWER_S = 10.0
"""A recorder that says nothing for this long hangs: it looks every second, and reports silence after three."""

_EPITAPH_S = 1.0  # from the end of the link to the end of the process
_RECORDER = "engine.audio.recorder"


class Microphone:
    """A microphone by (part of) its name or by index; None is the system's default.

    ``patient``: opening waits until it is there, however long that takes. Opening and reading raise ``DeviceError``.
    """

    live = True

    def __init__(self, device: str | int | None = None, *, patient: bool = False) -> None:
        self.name = "microphone"
        self.overruns = 0
        """How often the device has lost sound."""
        self._arguments = (f"--device={msgspec.json.encode(device).decode()}", *(("--patient",) if patient else ()))
        self._unread = 0
        self._framer = Framer()
        self._ready: deque[Frame] = deque()
        self._child: Child | None = None
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sound lost by the device or by us."""
        found = []
        if self.overruns:
            found.append(f"{self.name}: the device lost sound {_times(self.overruns)}.")
        if self._unread:
            found.append(f"{self.name}: sound was not read in time {_times(self._unread)}.")
        return tuple(found)

    async def __aenter__(self) -> Microphone:
        try:
            await self._start()
            await self._until_open()
        except BaseException:
            await self._end()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ready.clear()
        await self._end()

    def __aiter__(self) -> Microphone:
        return self

    async def __anext__(self) -> Frame:
        while not self._ready:
            if self._child is None:
                raise StopAsyncIteration
            match await self._message():
                case Sound(pcm, overruns, unread):
                    self.overruns, self._unread = overruns, unread
                    now = asyncio.get_running_loop().time()
                    self._ready.extend(
                        replace(frame, at=now) for frame in self._framer.push(np.frombuffer(pcm, np.int16))
                    )
                case None:  # closed meanwhile
                    raise StopAsyncIteration
                case answer:
                    raise _nonsense(answer)
        return self._ready.popleft()

    async def _start(self) -> None:
        starting = asyncio.ensure_future(asyncio.to_thread(Child, "microphone", _RECORDER, self._arguments))
        try:
            self._child = await asyncio.shield(starting)
        except asyncio.CancelledError:
            self._child = await starting  # or nobody would end it
            raise
        except ProcessError as error:
            raise DeviceError(error.message) from error
        self._child.link.setblocking(False)
        self._reader, self._writer = await asyncio.open_connection(sock=self._child.link)

    async def _until_open(self) -> None:
        while True:
            match await self._message():
                case Opened(name):
                    self.name = name
                    return
                case Looking():
                    continue
                case answer:
                    raise _nonsense(answer)

    async def _message(self) -> Message | None:
        """What the recorder says next; None once the microphone is closed. Raises ``DeviceError``, also the one that
        the recorder tells of."""
        reader, child = self._reader, self._child
        assert reader is not None
        assert child is not None
        try:
            async with asyncio.timeout(ANSWER_S):
                length = int.from_bytes(await reader.readexactly(LENGTH_BYTES), "little")
                message = MESSAGES.decode(await reader.readexactly(length))
        except TimeoutError as error:
            raise DeviceError(f"The {self.name} hangs.", hint="sayso tries again.") from error
        except (asyncio.IncompleteReadError, OSError) as error:
            if self._child is None:
                return None
            why = await asyncio.to_thread(child.epitaph, wait=_EPITAPH_S)
            raise DeviceError(why or "The microphone process closed its connection.") from error
        if isinstance(message, Failed):
            raise Lost(message.message, hint=message.hint, for_good=message.for_good)
        return message

    async def _end(self) -> None:
        child, self._child = self._child, None
        if self._writer is not None:
            self._writer.close()
        if child is not None:
            await asyncio.to_thread(child.discard)


class Lost(DeviceError):
    """The microphone is not there (any more). ``for_good``: looking for it is in vain."""

    def __init__(self, message: str, *, hint: str, for_good: bool) -> None:
        super().__init__(message, hint=hint)
        self.for_good = for_good


def _nonsense(answer: object) -> DeviceError:
    return DeviceError(f"The microphone process sent something unreadable: {type(answer).__name__}.")


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
