"""Who of a shape (``tests.shapes``) is alive, known from the kernel alone and not from the code under test."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

from tests import shapes

DEADLINE_S = 20.0
"""s for what takes milliseconds; a test that waits longer has failed."""


class RollCall:
    """The read end of the FIFO that every process of a shape holds."""

    def __init__(self, path: Path, reader: asyncio.StreamReader, keeping_open: int) -> None:
        self.path = path
        self._reader = reader
        self._keeping_open = keeping_open

    def command(self, shape: str) -> list[str]:
        """The program that takes this shape."""
        return [sys.executable, "-I", "-S", shapes.__file__, shape, str(self.path)]

    async def complete(self, shape: str) -> None:
        """Wait until every process of the shape is in place."""
        async with asyncio.timeout(DEADLINE_S):
            for _ in range(shapes.SHAPES[shape][1]):
                assert (await self._reader.readline()).strip(), "the shape fell apart before it was complete"
        self.stop_keeping_open()

    async def empty(self) -> None:
        """Wait until none of them is left."""
        async with asyncio.timeout(DEADLINE_S):
            while await self._reader.read(1 << 16):
                pass

    def members(self) -> list[int]:
        """Processes that hold the FIFO now."""
        found = []
        for folder in Path("/proc").glob("[0-9]*/fd"):
            with suppress(OSError):
                held = any(link.readlink() == self.path for link in folder.iterdir())
                if held and int(folder.parent.name) != os.getpid():
                    found.append(int(folder.parent.name))
        return found

    def stop_keeping_open(self) -> None:
        if self._keeping_open >= 0:
            os.close(self._keeping_open)
            self._keeping_open = -1


@asynccontextmanager
async def roll_call(path: Path) -> AsyncIterator[RollCall]:
    """A roll call at ``path``, which must not exist and stays; nobody else is left in the end, whatever was found."""
    os.mkfifo(path)
    reading = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    keeping_open = os.open(path, os.O_WRONLY)  # or the file would be at its end before the first one comes
    reader = asyncio.StreamReader()
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(reading, "rb", buffering=0)
    )
    roll = RollCall(path, reader, keeping_open)
    try:
        yield roll
    finally:
        roll.stop_keeping_open()
        for pid in roll.members():
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        transport.close()
