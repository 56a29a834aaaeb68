"""A local model as a part of the engine: fetched if it is missing, loaded, told its instructions, then ready.

Nobody waits for a gigabyte: plain commands need no model, so the engine is usable from the first moment and the part's
status tells how far it is. Whoever asks the model while it is being fetched gets an error that says so at once; whoever
asks while it loads waits, for that takes seconds. Nothing that goes wrong here harms anybody else.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Sequence

from engine.errors import SaysoError
from engine.llm.chat import Message
from engine.llm.llama import NotRunning
from engine.llm.local import LocalChat
from engine.parts.fetching import NEWS_S, Fetching, Pull
from engine.parts.part import Part

Instructions = Callable[[], Awaitable[Sequence[Sequence[Message]]]]
"""What questions will begin with, once that is known: one beginning for each layer that asks this model."""


class ModelPart:
    """Keeps one local model; the part's value is the model's name."""

    def __init__(
        self, part: Part[str], chat: LocalChat, instructions: Instructions, fetching: Fetching | None = None
    ) -> None:
        """Without ``fetching`` a missing model stays missing, and the status says which command fetches it."""
        self._part = part
        self._chat = chat
        self._instructions = instructions
        self._fetching = fetching
        self._told = 0.0  # when the status changed, monotonic

    async def keep(self) -> None:
        """Get the model ready, follow how it is doing, and end its process when this is cancelled."""
        try:
            await self._part.load(self._up, str)
            self._chat.tell = self._follow
            await asyncio.Event().wait()
        finally:
            await self._chat.close()

    async def _up(self) -> str:
        if self._fetching is not None:
            await self._fetch(self._fetching)
        self._part.progress("loading")
        await self._chat.load()
        for beginning in await self._instructions():
            await self._chat.prepare(beginning, lambda done: self._say(f"reading its instructions {done:.0%}"))
        return self._chat.model

    async def _fetch(self, fetching: Fetching) -> None:
        """Pull the model unless it is here. Raises ``ModelError`` or ``StorageError``."""
        with contextlib.suppress(SaysoError):
            await asyncio.to_thread(fetching.store.find, fetching.name)
            return
        self._chat.on_the_way = "it is being fetched"
        try:
            await Pull(fetching.store, fetching.name, self._say).done()
        finally:
            self._chat.on_the_way = ""

    def _say(self, detail: str) -> None:
        """How far it is, now and then."""
        now = time.monotonic()
        if now - self._told >= NEWS_S:
            self._told = now
            self._part.progress(detail)
            if self._chat.on_the_way:
                self._chat.on_the_way = detail

    def _follow(self, trouble: NotRunning | None) -> None:
        """It was lost, or somebody fetched it by hand, or the next question has brought it back."""
        if trouble is None:
            self._part.succeed(self._chat.model, self._chat.model)
        else:
            self._part.fail(trouble)
