"""Wyoming, the protocol in which voice programs talk to each other (https://github.com/OHF-Voice/wyoming): the wire.

An event is a line of JSON, then as much more JSON and as many bytes of payload as that line says. What is in the events
is known by the package ``wyoming``, which is imported when it is needed. Reading is ours: the package believes whatever
length the other side claims, and here nobody gets more of this machine's memory than :data:`PAYLOAD_BYTES`.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import numpy as np
import soxr
from numpy.typing import NDArray

from engine.errors import ModelError, SaysoError, one_line
from engine.strict_json import read_json

if TYPE_CHECKING:
    from wyoming.audio import AudioChunk
    from wyoming.event import Event, Eventable

INSTALL: Final = "pip install 'sayso[wyoming]'"
LINE_BYTES: Final = 1 << 16
"""Longest first line of an event."""
DATA_BYTES: Final = 1 << 20
"""Most further JSON: what a server can do is told in some tens of kilobytes."""
PAYLOAD_BYTES: Final = 1 << 22
"""Longest payload: two minutes of sound at 16 kHz, while the usual chunk lasts a tenth of a second."""
RATE: Final = 16_000
"""Hz, of the sound that is understood here."""
CONNECT_S: Final = 5.0
"""Longest wait for a connection, s."""


class NotWyoming(ValueError):
    """What came is no event, or a longer one than anybody needs."""


def is_installed() -> bool:
    return find_spec("wyoming") is not None


def require() -> None:
    """Raises ``ModelError`` where the package is missing."""
    if not is_installed():
        raise ModelError("The package wyoming is not installed.", hint=f"Install it: {INSTALL}.")


async def read(reader: asyncio.StreamReader) -> Event | None:
    """The next event; None at the end. ``reader`` has a limit of ``LINE_BYTES``.

    Raises :class:`NotWyoming`, ``EOFError`` where it ends in the midst of an event, and ``OSError``.
    """
    from wyoming.event import Event

    try:
        line = await reader.readline()
    except ValueError as error:
        raise NotWyoming("its first line is too long") from error
    if not line:
        return None
    if not line.endswith(b"\n"):
        raise EOFError("it ended in the midst of an event")
    told = _decoded(line)
    kind, data = told.get("type"), told.get("data") or {}
    if not isinstance(kind, str) or not isinstance(data, dict):
        raise NotWyoming("it is no event")
    if more := await reader.readexactly(_length(told, "data_length", DATA_BYTES)):
        data = data | _decoded(more)
    payload = await reader.readexactly(_length(told, "payload_length", PAYLOAD_BYTES))
    return Event(kind, data, payload or None)


async def write(writer: asyncio.StreamWriter, *events: Eventable) -> None:
    """Raises ``OSError`` when the other side has gone."""
    from wyoming.event import async_write_event

    for event in events:
        await async_write_event(event.event(), writer)


class Intake:
    """Sound as others send it, while it comes: of any usual kind, and 16 kHz, mono from here on."""

    def __init__(self) -> None:
        self._resampler: Any = None
        self._rate = RATE

    def taken(self, chunk: AudioChunk) -> NDArray[np.int16]:
        """The samples that are complete by now. Raises :class:`UnknownKind`, and ``ValueError`` for half a sample."""
        width, channels, rate = chunk.width, chunk.channels, chunk.rate
        if width not in (2, 4) or not 1 <= channels <= 8 or not 8000 <= rate <= 192_000:
            kind = one_line(f"{rate} Hz, {width} bytes, {channels} channels", 80)
            raise UnknownKind(f"this kind of sound ({kind}) is not understood")
        samples = np.frombuffer(chunk.audio, f"<i{width}").reshape(-1, channels)
        mono = (samples.mean(axis=1) / (1 << 8 * (width - 2))).astype(np.int16)
        before = self.rest() if rate != self._rate else mono[:0]
        if rate != self._rate:
            self._rate = rate
            self._resampler = None if rate == RATE else soxr.ResampleStream(rate, RATE, 1, dtype="int16")
        now = mono if self._resampler is None else self._resampler.resample_chunk(mono)
        return np.concatenate((before, now)) if len(before) else np.asarray(now, np.int16)

    def rest(self) -> NDArray[np.int16]:
        """What is left in here; that was all."""
        resampler, self._resampler, self._rate = self._resampler, None, RATE
        nothing = np.zeros(0, np.int16)
        return nothing if resampler is None else np.asarray(resampler.resample_chunk(nothing, last=True), np.int16)


class UnknownKind(ValueError):
    """Sound of a kind that nobody sends; the end of a sentence about it."""


class Talk:
    """A connection to a Wyoming server."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, limit_s: float) -> None:
        self._reader = reader
        self._writer = writer
        self._limit_s = limit_s
        self._reading: asyncio.Task[Event | None] | None = None  # an event that has not come as a whole yet

    async def say(self, *events: Eventable) -> None:
        async with asyncio.timeout(self._limit_s):
            await write(self._writer, *events)

    def abort(self) -> None:
        """End the connection at once; whoever hears is told that it is closed."""
        self._writer.transport.abort()

    async def end(self) -> None:
        """End the connection, and whatever was still being read: all that was to come has come, and one that hangs must
        not hold us up."""
        self.abort()
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.gather(self._reading, return_exceptions=True)

    async def hear(self) -> Event:
        """What the server says next; an error of it is raised as :class:`Trouble`. After a ``TimeoutError`` whoever
        asks again gets the event whose beginning may have come."""
        from wyoming.error import Error

        event = await self._read()
        if event is None:
            raise Trouble("closed the connection")
        if Error.is_type(event.type):
            raise Trouble(f"reports an error: {one_line(str(event.data.get('text', '')))}".rstrip(".: "))
        return event

    async def _read(self) -> Event | None:
        """The next event. A read that was given up in the midst of it would leave the rest to be taken for a line."""
        if self._reading is None:
            self._reading = asyncio.create_task(read(self._reader))
        if not (await asyncio.wait([self._reading], timeout=self._limit_s))[0]:
            raise TimeoutError
        reading, self._reading = self._reading, None
        return reading.result()


class Trouble(Exception):
    """What is wrong with a server, as the end of a sentence about it."""


Fault = Callable[[str], SaysoError]
"""Makes an error of the end of a sentence about whoever was talked to."""


def server_fault(server: str, setting: str) -> Fault:
    """A ``ModelError`` about the server that ``setting`` names."""

    def fault(what: str) -> SaysoError:
        return ModelError(f"The Wyoming server at {server} {what}.", hint=f"Check {setting}, and that it runs.")

    return fault


@asynccontextmanager
async def talking(server: str, fault: Fault, limit_s: float) -> AsyncIterator[Talk]:
    """A connection to ``server`` (tcp://HOST:PORT or unix:///PATH). Whatever goes wrong, and silence for ``limit_s``,
    is raised as a ``fault``."""
    try:
        talk = Talk(*await _connected(server, min(CONNECT_S, limit_s)), limit_s)
        try:
            yield talk
        finally:
            await talk.end()
    except TimeoutError:
        raise fault(f"has not answered for {limit_s:g} s") from None
    except Trouble as trouble:
        raise fault(str(trouble)) from trouble
    except (ConnectionResetError, BrokenPipeError) as error:
        raise fault("closed the connection") from error
    except UnknownKind as kind:
        raise fault(f"cannot be used: {kind}") from kind
    except (OSError, EOFError) as error:  # IncompleteReadError is an EOFError
        raise fault(f"cannot be used: {_why(error)}") from error
    except SaysoError:
        raise
    except Exception as error:  # whatever its events bring about, also in the package that reads them
        raise fault("does not speak Wyoming") from error


async def _connected(server: str, limit_s: float) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    try:
        async with asyncio.timeout(limit_s):
            return await _connection(server)
    except TimeoutError:
        raise Trouble(f"cannot be reached within {limit_s:g} s") from None


async def _connection(server: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    address = urlsplit(server)
    if address.scheme == "unix":
        return await asyncio.open_unix_connection(address.path, limit=LINE_BYTES)
    return await asyncio.open_connection(address.hostname, address.port, limit=LINE_BYTES)


def _why(error: OSError | EOFError) -> str:
    """asyncio has words of its own for what the system says, with the address in them once more."""
    if isinstance(error, OSError) and (error.errno or 0) > 0:  # names that nobody knows have codes below 0
        return os.strerror(error.errno or 0)
    return str(error).rstrip(".") or type(error).__name__


def _decoded(data: bytes) -> dict[str, Any]:
    try:
        told = read_json(data)
    except ValueError as error:
        raise NotWyoming("it is no JSON") from error
    if not isinstance(told, dict):
        raise NotWyoming("it is no event")
    return told


def _length(told: dict[str, Any], name: str, most: int) -> int:
    length = told.get(name) or 0
    if not isinstance(length, int) or not 0 <= length <= most:
        raise NotWyoming(f"its {name} is {length!r}"[:80])
    return length
