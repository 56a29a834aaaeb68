"""A sound card for what no real one can be made to do: what of sounddevice's interface the sounder uses.

Where a file ``sounddevice.py`` that imports it is first on the path, a real sounder plays on it.
"""

from __future__ import annotations

import threading
import time
import types
from collections.abc import Callable
from typing import Any, Final

import numpy as np

HANGS_AT_START: Final = "hangs at the start"
HANGS_AT_REST: Final = "hangs at rest"


class PortAudioError(Exception):
    """As sounddevice's own."""


def query_devices(device: str | int | None = None, kind: str | None = None) -> dict[str, Any]:
    del device, kind
    return {"name": "Test card", "default_samplerate": 16_000.0, "max_output_channels": 1}


class OutputStream:
    """Sounds a block after the other, as time goes; the devices with these two names never return."""

    latency = 0.02

    def __init__(self, *, device: str | None, samplerate: int, blocksize: int, callback: Any, **others: Any) -> None:
        del others
        self._device = device
        self._period = blocksize / samplerate
        self._callback: Callable[..., None] = callback
        self._block = np.zeros((blocksize, 1), np.int16)
        self._over = threading.Event()

    def start(self) -> None:
        if self._device == HANGS_AT_START:
            threading.Event().wait()
        self._over = threading.Event()
        threading.Thread(target=self._sound, args=(self._over,), daemon=True).start()

    def stop(self) -> None:
        if self._device == HANGS_AT_REST:
            threading.Event().wait()
        self._over.set()

    def _sound(self, over: threading.Event) -> None:
        while not over.wait(self._period):
            now = time.monotonic()
            when = types.SimpleNamespace(currentTime=now, outputBufferDacTime=now + self.latency)
            self._callback(self._block, len(self._block), when, None)
