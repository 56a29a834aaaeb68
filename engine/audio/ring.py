"""The sound of a live source on its way to a listener who may not be there yet."""

from __future__ import annotations

import asyncio
import math
import threading
from collections import deque
from collections.abc import Callable

from engine.audio.source import FRAME_S, Frame
from engine.errors import SaysoError

LOOKBACK_S = 10.0
"""How much sound after a mark waits for the listener, s."""

PAST_S = 1.0
"""How long before its mark a request can have begun, s…"""
_PAST_FRAMES = math.ceil(PAST_S / FRAME_S)  # …and how much before that is kept

CATCH_UP_S = 0.003
"""Pause before each frame that has waited, s: the pre-roll is caught up within 0.04 s, ten seconds within two."""


class Ring:
    """Frames of a live source on their way to a listener.

    Without a listener only the newest frames are kept: the pre-roll, or all since the mark. A mark may lie in the past:
    what the last listener was given since then is given to the next one again. ``mark`` may be called from any thread,
    everything else from the loop's.
    """

    def __init__(self, pre_roll: int) -> None:
        self.error: SaysoError | None = None  # what the source ended with
        self._pre_roll = pre_roll
        self._marked_limit = pre_roll + math.ceil(LOOKBACK_S / FRAME_S)
        self._frames: deque[Frame] = deque()  # for a listener
        self._past: deque[Frame] = deque(maxlen=2 * _PAST_FRAMES)  # given to one, or too old for one
        self._again: Frame | None = None  # in the past, and the first one for the next listener
        self._lock = threading.Lock()
        self._marked = False
        self._listening = False
        self._ended = False
        self._arrived = asyncio.Event()

    @property
    def is_listened_to(self) -> bool:
        """There is a listener. Any thread."""
        return self._listening

    def restart(self) -> None:
        """Another source begins. What is left of the last one is for a listener; without one it is forgotten."""
        with self._lock:
            if not self._listening:
                self._frames.clear()
            self._past.clear()
            self._again = None
        self._ended, self.error = False, None

    def put(self, frame: Frame) -> None:
        with self._lock:
            self._frames.append(frame)
            if not self._listening:
                self._trim(self._marked_limit if self._marked else self._pre_roll)
        self._arrived.set()

    def mark(self, ago: int | None = None) -> None:
        """What comes from now on is for the next listener, and so are the frames of the pre-roll, or the last ``ago``
        ones."""
        with self._lock:
            self._marked, self._again = True, None
            if ago is None or ago <= len(self._frames):
                if not self._listening:
                    self._trim(self._pre_roll if ago is None else ago)
            elif self._past:
                self._again = self._past[max(0, len(self._past) + len(self._frames) - ago)]

    def end(self, error: SaysoError | None) -> None:
        self._ended, self.error = True, error
        self._arrived.set()

    def listen(self) -> tuple[Frame, ...]:
        """From now on frames belong to a listener: none is dropped. Returns those right before them, the last 1 s."""
        with self._lock:
            while self._again is not None and self._past:
                self._frames.appendleft(self._past.pop())
                if self._frames[0] is self._again:
                    break
            self._listening, self._marked, self._again = True, False, None
            return tuple(self._past)[-_PAST_FRAMES:]

    def release(self) -> None:
        with self._lock:
            self._listening = False

    def look_again(self) -> None:
        """Whoever waits may have ``enough`` by now."""
        self._arrived.set()

    async def get(self, enough: Callable[[], bool] = lambda: False) -> Frame | None:
        """The next frame; None after the last, and where none has come yet and there are ``enough``. Raises the error
        that ended the source.

        What has waited for the listener is not given all at once: judging it takes a millisecond a frame, and the
        robot process, which a wake has just told to stop, needs the processor more.
        """
        if len(self._frames) > 1:
            await asyncio.sleep(CATCH_UP_S)
        while True:
            with self._lock:
                if self._frames:
                    self._past.append(self._frames.popleft())
                    return self._past[-1]
            if self._ended:
                if self.error is not None:
                    raise self.error
                return None
            if enough():
                return None
            self._arrived.clear()
            await self._arrived.wait()

    def _trim(self, limit: int) -> None:
        while len(self._frames) > limit:
            self._past.append(self._frames.popleft())
