"""The door by rosbridge: JSON over a WebSocket, which robots of any age have (protocol: ROSBRIDGE_PROTOCOL.md of
RobotWebTools/rosbridge_suite).

A thread of its own keeps the connection. A connection that is lost is made again, and everything that was advertised
and subscribed with it.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any, Final

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from engine.ros.door import Message, Take

AGAIN_S: Final = 0.5
"""Between two tries to connect."""
OPEN_S: Final = 3.0
"""In which a bridge must have answered."""
PING_S: Final = 1.0
"""Between two pings; one that is not answered for as long is the end of the connection."""
MAX_BYTES: Final = 16 * 1024 * 1024
"""Longest message that is read: a large picture, in base64."""
LEAVE_S: Final = 0.3
"""In which what was published last goes out before the door is shut."""


@dataclass(frozen=True, slots=True)
class _Subscription:
    type: str
    take: Take
    every_s: float


class Rosbridge:
    """A :class:`engine.ros.door.Door` by a bridge at ``ws://…``."""

    def __init__(self, url: str) -> None:
        """Connect in the background."""
        self._url = url
        self.trouble = f"the bridge at {url} has not been reached yet"
        self._lock = threading.Lock()
        self._subscribed: dict[str, _Subscription] = {}
        self._advertised: dict[str, str] = {}
        self._orders: list[dict[str, Any]] = []  # to advertise or subscribe, in this connection
        self._newest: dict[str, Message] = {}  # to publish, by topic
        self._loop = asyncio.new_event_loop()
        self._work = asyncio.Event()  # something waits to go out
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="rosbridge", daemon=True)
        self._thread.start()

    # From any thread

    def publish(self, topic: str, type: str, message: Message) -> None:
        with self._lock:
            if topic not in self._advertised:
                self._advertised[topic] = type
                self._orders.append({"op": "advertise", "topic": topic, "type": type})
            self._newest[topic] = message
        self._wake()

    def subscribe(self, topic: str, type: str, take: Take, *, every_s: float = 0.0) -> None:
        with self._lock:
            self._subscribed[topic] = found = _Subscription(type, take, every_s)
            self._orders.append(_subscribe(topic, found))
        self._wake()

    def close(self) -> None:
        self._closing = True
        self._wake()
        self._thread.join(LEAVE_S + OPEN_S)

    def _wake(self) -> None:
        with contextlib.suppress(RuntimeError):  # it has been closed
            self._loop.call_soon_threadsafe(self._work.set)

    # In the thread of the door

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._keep())
        finally:
            self._loop.close()

    async def _keep(self) -> None:
        while not self._closing:
            try:
                async with self._connected() as bridge:
                    self.trouble = ""
                    await self._talk(bridge)
            except (OSError, TimeoutError, WebSocketException) as error:
                self.trouble = f"the bridge at {self._url} is gone ({_why(error)})"
            if not self._closing:
                await asyncio.sleep(AGAIN_S)
        self.trouble = "it has been closed"

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[ClientConnection]:
        async with connect(
            self._url,
            open_timeout=OPEN_S,
            close_timeout=LEAVE_S,
            ping_interval=PING_S,
            ping_timeout=PING_S,
            max_size=MAX_BYTES,
            compression=None,
            proxy=None,
        ) as bridge:
            with self._lock:
                self._newest.clear()  # what was to be published then is over
                self._orders = [
                    *({"op": "advertise", "topic": topic, "type": type} for topic, type in self._advertised.items()),
                    *(_subscribe(topic, found) for topic, found in self._subscribed.items()),
                ]
            self._work.set()
            yield bridge

    async def _talk(self, bridge: ClientConnection) -> None:
        """Send and receive until the connection or the door is closed."""
        hearing = asyncio.create_task(self._hear(bridge))
        try:
            while True:
                work = asyncio.ensure_future(self._work.wait())
                await asyncio.wait((hearing, work), return_when=asyncio.FIRST_COMPLETED)
                work.cancel()
                if hearing.done():
                    hearing.result()
                    return
                self._work.clear()
                await self._send_all(bridge)
                if self._closing:
                    return
        finally:
            hearing.cancel()

    async def _send_all(self, bridge: ClientConnection) -> None:
        with self._lock:
            orders, self._orders = self._orders, []
            newest, self._newest = self._newest, {}
        for order in orders:
            await bridge.send(msgspec.json.encode(order).decode())
        for topic, message in newest.items():
            await bridge.send(msgspec.json.encode({"op": "publish", "topic": topic, "msg": message}).decode())

    async def _hear(self, bridge: ClientConnection) -> None:
        async for text in bridge:
            try:
                order = msgspec.json.decode(text)
            except (msgspec.DecodeError, UnicodeDecodeError):
                continue  # a bridge that says what nobody can read has said nothing
            if not isinstance(order, dict) or order.get("op") != "publish":
                continue
            message, found = order.get("msg"), self._subscribed.get(str(order.get("topic")))
            if found is not None and isinstance(message, dict):
                found.take(message)


def _subscribe(topic: str, found: _Subscription) -> dict[str, Any]:
    order: dict[str, Any] = {"op": "subscribe", "topic": topic, "type": found.type, "queue_length": 1}
    return {**order, "throttle_rate": round(1000 * found.every_s)} if found.every_s else order


def _why(error: Exception) -> str:
    return str(error).splitlines()[0][:120] if str(error) else type(error).__name__
