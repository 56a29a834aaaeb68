"""Server-sent events (https://html.spec.whatwg.org/multipage/server-sent-events.html): bytes in, the data of each
event out. Events without data, with which services keep a connection alive, are none."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator


async def events(chunks: AsyncIterator[bytes]) -> AsyncGenerator[str, None]:
    """The data of each event. Raises ``UnicodeDecodeError``."""
    data: list[bytes] = []
    async for line in _lines(chunks):
        if line.startswith(b"data:"):
            data.append(line[5:].removeprefix(b" "))
        elif not line and data:
            yield b"\n".join(data).decode()
            data.clear()
    if data:  # the last one may lack its empty line
        yield b"\n".join(data).decode()


async def _lines(chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """Lines end with CR, LF or both; what else Unicode takes for the end of a line may stand in one. The last one is
    dropped if it was cut off."""
    rest = bytearray()
    async for chunk in chunks:
        rest += chunk
        while (end := _end(rest)) is not None:
            line, after = end
            yield bytes(rest[:line])
            del rest[:after]


def _end(buffer: bytearray) -> tuple[int, int] | None:
    """Where the first line ends and where the next one begins; a CR at the very end may be half of a CR LF."""
    feed, carriage = buffer.find(b"\n"), buffer.find(b"\r", 0, len(buffer) - 1)
    if carriage >= 0 and (feed < 0 or carriage < feed):
        return carriage, carriage + (2 if buffer[carriage + 1] == 0x0A else 1)
    return (feed, feed + 1) if feed >= 0 else None
