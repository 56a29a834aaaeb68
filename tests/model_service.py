"""A large-model service on loopback that speaks chat completions over a real socket, and behaves as a test says."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import SecretStr

from config.schema import Platform

SECRET = "sk-nobody-may-read-this"
DEADLINE_S = 10.0
"""After this, something that a test waits for will never happen."""


@dataclass(frozen=True, slots=True)
class Request:
    """What somebody asked."""

    line: str
    headers: dict[str, str]
    body: Any


def answer(text: Any) -> bytes:
    """A chat completion."""
    message = {"role": "assistant", "content": text}
    return reply(200, {"id": "1", "object": "chat.completion", "choices": [{"index": 0, "message": message}]})


def reply(status: int, body: Any, **headers: str) -> bytes:
    """Any HTTP response; a body that is not bytes is sent as JSON."""
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    lines = [f"HTTP/1.1 {status} Because", f"Content-Length: {len(data)}", "Connection: close"]
    lines += [f"{name}: {value}" for name, value in headers.items()]
    return "\r\n".join([*lines, "", ""]).encode() + data


def streamed(*pieces: Any, end: str | None = "stop", usage: dict[str, Any] | None = None) -> bytes:
    """A chat completion in pieces; without ``end`` it breaks off."""
    chunks = [chunk({"content": piece}) for piece in pieces]
    if end is not None:
        chunks.append(chunk({}, end))
    if usage is not None:
        chunks.append(event({"object": "chat.completion.chunk", "choices": [], "usage": usage}))
    if end is not None:
        chunks.append(event("[DONE]"))
    return STREAM + b"".join(chunks)


def chunk(delta: Any, end: str | None = None) -> bytes:
    """One piece of a completion."""
    return event({"object": "chat.completion.chunk", "choices": [{"index": 0, "delta": delta, "finish_reason": end}]})


def event(data: Any) -> bytes:
    """One server-sent event."""
    return f"data: {data if isinstance(data, str) else json.dumps(data, ensure_ascii=False)}\n\n".encode()


STREAM = b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n\r\n"
"""How a stream of events begins."""


@dataclass(frozen=True, slots=True)
class Unfinished:
    """In place of an answer: these bytes, then nothing, or ``drip`` again and again, while the other side waits."""

    data: bytes
    drip: bytes = b""

    async def last(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Go on like that until the other side hangs up. Raises ``ConnectionError`` when it does so rudely."""
        writer.write(self.data)
        gone = asyncio.create_task(reader.read())
        while not (await asyncio.wait([gone], timeout=0.01 if self.drip else None))[0]:
            writer.write(self.drip)
        assert await gone == b""


Answer = bytes | Unfinished
SILENCE = Unfinished(b"")
"""In place of an answer: nothing, for as long as the other side waits."""
HANGS_UP = b""
"""In place of an answer: the connection is closed."""


@dataclass
class Service:
    """What was asked, and what will be answered: one answer after the other, the last one again and again."""

    answers: list[Answer]
    asked: list[Request] = field(default_factory=list)
    on_request: Callable[[], None] = lambda: None
    left: asyncio.Event = field(default_factory=asyncio.Event)  # somebody hung up instead of waiting for an answer
    port: int = 0

    def platform(self, **changes: Any) -> Platform:
        """How to reach it."""
        url = f"http://127.0.0.1:{self.port}/v1"
        facts = {"kind": "openai", "base_url": url, "model": "one-that-sees", "api_key": SecretStr(SECRET)}
        return Platform(**{**facts, **changes})

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await self._serve(reader, writer)
        except ConnectionError:
            self.left.set()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")
        headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in head[1:] if line)}
        body = json.loads(await reader.readexactly(int(headers["content-length"])))
        self.asked.append(Request(head[0], headers, body))
        told = self.answers[min(len(self.asked), len(self.answers)) - 1]
        self.on_request()
        if isinstance(told, Unfinished):
            await told.last(reader, writer)
            self.left.set()
        else:
            writer.write(told)
        writer.close()


@asynccontextmanager
async def serving(*answers: Answer, uds: Path | None = None) -> AsyncIterator[Service]:
    """A service that gives these answers, for as long as this is entered; at a UNIX socket with ``uds``."""
    service = Service(list(answers))
    if uds is not None:
        server = await asyncio.start_unix_server(service.serve, uds)
    else:
        server = await asyncio.start_server(service.serve, "127.0.0.1", 0)
        service.port = server.sockets[0].getsockname()[1]
    async with server:
        async with asyncio.timeout(DEADLINE_S):
            yield service
