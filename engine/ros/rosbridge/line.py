"""One connection to a rosbridge: JSON over a WebSocket (source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite).

A bridge does what comes over one connection one after the other, and by default a call or a goal is not done before it
has ended: whatever comes behind it waits, a zero velocity, too. So whoever uses a bridge needs several.
"""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final

import msgspec
import numpy as np
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

OPEN_S: Final = 3.0
"""In which a bridge must have answered."""
PING_S: Final = 1.0
"""Between two pings; one that is not answered for as long is the end of the connection."""
LEAVE_S: Final = 0.3
"""In which what was sent last goes out before a connection is closed."""
MAX_BYTES: Final = 16 * 1024 * 1024
"""Longest message that is read: a large picture, in base64."""

GONE = (OSError, TimeoutError, WebSocketException)
"""What a connection raises once it is gone."""


class Line:
    """An open connection."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket

    async def send(self, order: Mapping[str, Any]) -> None:
        """Raises ``GONE``."""
        await self._socket.send(msgspec.json.encode(order, enc_hook=_plain).decode())

    async def heard(self) -> AsyncIterator[dict[str, Any]]:
        """What the bridge sends, until the connection ends. Raises ``GONE`` unless it was closed in order."""
        async for text in self._socket:
            try:
                order = _read(text)
            except (ValueError, RecursionError):
                continue  # a bridge that says what nobody can read has said nothing
            if isinstance(order, dict):
                yield order

    async def close(self) -> None:
        await self._socket.close()


async def opened(url: str) -> Line:
    """A connection to the bridge at ``ws://…``. Raises ``GONE``."""
    socket = await connect(
        url,
        open_timeout=OPEN_S,
        close_timeout=LEAVE_S,
        ping_interval=PING_S,
        ping_timeout=PING_S,
        max_size=MAX_BYTES,
        compression=None,
        proxy=None,
    )
    return Line(socket)


class Lines:
    """Connections for calls and goals: one that is not used any more serves the next."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._idle: list[Line] = []

    @asynccontextmanager
    async def one(self) -> AsyncIterator[Line]:
        """A connection that nobody else uses; it is closed where whoever had it was cut off. Raises ``GONE``."""
        line = self._idle.pop() if self._idle else await opened(self._url)
        try:
            yield line
        except BaseException:
            await line.close()
            raise
        self._idle.append(line)

    async def close(self) -> None:
        idle, self._idle = self._idle, []
        for line in idle:
            await line.close()


def why(error: Exception) -> str:
    """What went wrong with a connection, for people."""
    return str(error).splitlines()[0][:120] if str(error) else type(error).__name__


def _read(text: str | bytes) -> object:
    """JSON, and what a bridge makes of numbers that are none: NaN and Infinity, which Python's own reader knows."""
    try:
        return msgspec.json.decode(text)
    except msgspec.DecodeError:
        return json.loads(text)


def _plain(value: object) -> object:
    """What JSON has no word for."""
    if isinstance(value, np.ndarray):
        return value.tobytes() if value.dtype == np.uint8 else value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is nothing that a message holds")
