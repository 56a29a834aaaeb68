"""Fetching a model in the background, for a part of the engine that wants it: nobody has to wait for a download."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from engine.models import ModelStore, Progress

NEWS_S: Final = 0.5
"""Between two pieces of news, s."""
_LEAVE_S: Final = 1.0  # for a download to end when it is told to


@dataclass(frozen=True, slots=True)
class Fetching:
    """Where a missing model comes from."""

    store: ModelStore
    name: str


class _GivenUp(Exception):
    """Nobody needs the download any more."""


class Pull:
    """One download, in a thread that nobody has to wait for: a network may not let go of it."""

    def __init__(self, store: ModelStore, name: str, tell: Callable[[str], None]) -> None:
        self._store = store
        self._name = name
        self._tell = tell
        self._total = store.manifest[name].size
        self._parts: dict[str, int] = {}  # bytes of what came now
        self._before = 0  # bytes that were there
        self._said = 0.0
        self._given_up = threading.Event()
        self._loop = asyncio.get_running_loop()
        self._ended: asyncio.Future[Path] = self._loop.create_future()

    async def done(self) -> Path:
        """The model's folder. Cancelling ends the download at its next sign of life."""
        threading.Thread(target=self._pull, name="fetch", daemon=True).start()
        try:
            return await asyncio.shield(self._ended)
        except asyncio.CancelledError:
            self._given_up.set()
            self._ended.add_done_callback(lambda ended: ended.cancelled() or ended.exception())
            await asyncio.wait([self._ended], timeout=_LEAVE_S)
            raise

    # In its thread

    def _pull(self) -> None:
        try:
            self._before = self._store.fetched(self._name)
            folder = self._store.pull(self._name, self._hear)
        except Exception as error:  # noqa: BLE001 - raised again by whoever waits
            self._soon(functools.partial(self._ended.set_exception, error))
        else:
            self._soon(functools.partial(self._ended.set_result, folder))

    def _hear(self, progress: Progress) -> None:
        if self._given_up.is_set():
            raise _GivenUp
        if progress.stage == "download":
            self._parts[progress.part] = progress.done_bytes
        now = time.monotonic()
        if now - self._said >= NEWS_S:
            self._said = now
            self._soon(functools.partial(self._tell, self._words(progress)))

    def _words(self, progress: Progress) -> str:
        if progress.stage == "wait":
            return "another sayso is fetching it"
        if progress.stage == "download":
            done = min(self._total, self._before + sum(self._parts.values()))
            return f"fetching {done / self._total:.0%}, {done / 1e6:.0f} of {self._total / 1e6:.0f} MB"
        verb = "checking" if progress.stage == "verify" else "unpacking"
        return f"{verb} {progress.done_bytes / max(1, progress.total_bytes):.0%}"

    def _soon(self, act: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody is interested any more
            self._loop.call_soon_threadsafe(act)
