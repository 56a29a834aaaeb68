"""A large-model service on loopback that speaks chat completions over a real socket, and behaves as a test says."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
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


SILENCE = b"silence"
"""In place of an answer: nothing, for as long as the other side waits."""
HANGS_UP = b""
"""In place of an answer: the connection is closed."""


@dataclass
class Service:
    """What was asked, and what will be answered: one answer after the other, the last one again and again."""

    answers: list[bytes]
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
        head = (await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")
        headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in head[1:] if line)}
        body = json.loads(await reader.readexactly(int(headers["content-length"])))
        self.asked.append(Request(head[0], headers, body))
        told = self.answers[min(len(self.asked), len(self.answers)) - 1]
        self.on_request()
        if told == SILENCE:
            assert await reader.read() == b""
            self.left.set()
        else:
            writer.write(told)
        writer.close()


@asynccontextmanager
async def serving(*answers: bytes) -> AsyncIterator[Service]:
    """A service that gives these answers, for as long as this is entered."""
    service = Service(list(answers))
    server = await asyncio.start_server(service.serve, "127.0.0.1", 0)
    service.port = server.sockets[0].getsockname()[1]
    async with server:
        async with asyncio.timeout(DEADLINE_S):
            yield service
