"""Perception in a process of its own, for people who look on.

Understanding a picture is 30 ms of Python that takes the interpreter lock, and who looks on gets several pictures a
second: on a busy machine, whoever stops the robot meanwhile would wait for the lock. Here one waits for a link.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from typing import TYPE_CHECKING

from engine.child import Child
from engine.errors import CameraError, ProcessError
from engine.perception.sighting import Sight
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from engine.scheduling import workers

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from engine.perception.onlooker_worker import Found

ANSWER_LIMIT_S = 30.0
"""s for a process to start and understand a picture, on the busiest machine."""
_WORKER = "engine.perception.onlooker_worker"
_EPITAPH_S = 1.0  # from the end of the link to the end of the process
_AGAIN = "It is started again with the next picture."


class Onlooker:
    """Understands one picture after the other. Whoever makes it closes it. ``prompt``: see
    ``engine.scheduling.workers``. A process that is lost is replaced with the next picture."""

    def __init__(self, *, prompt: bool) -> None:
        self._thread = workers("onlooker", 1, prompt=prompt)
        self._changing = threading.Lock()  # guards the two below, of which close() in another thread makes use
        self._child: Child | None = None
        self._closed = False
        self._link: Connection | None = None
        self._house: FloorMap | None = None  # that the process knows

    @property
    def pid(self) -> int | None:
        """Of the process, if there is one. Any thread."""
        child = self._child
        return child.pid if child is not None else None

    def begin(self) -> None:
        """Start the process now if there is none, so that it is there when there is a picture."""
        if self._child is None:
            with contextlib.suppress(RuntimeError):  # closed
                self._thread.submit(self._begin)

    async def perceive(self, picture: Picture, house: FloorMap) -> Sight:
        """As :func:`engine.perception.perceive.perceive`. Raises ``CameraError``."""
        try:
            work = asyncio.get_running_loop().run_in_executor(self._thread, self._ask, picture, house)
        except RuntimeError:
            raise _closed() from None
        objects, tags = await work
        return Sight(picture, objects, tags)

    async def close(self) -> None:
        """End the process at once. Whoever waits for it gets a ``CameraError``."""
        with self._changing:
            self._closed = True
            if self._child is not None:
                self._child.kill()
        self._thread.submit(self._bury)
        await asyncio.to_thread(self._thread.shutdown)

    # In the thread

    def _begin(self) -> None:
        with contextlib.suppress(CameraError):  # whoever has a picture tries again, and is told
            self._ready()

    def _ready(self) -> Connection:
        if self._child is not None and self._child.epitaph() is not None:
            self._bury()  # nobody was waiting for it, so nothing is lost but time
        if self._link is None:
            with self._changing:
                if self._closed:
                    raise _closed()
                try:
                    self._child = Child("perception", _WORKER)
                except ProcessError as error:
                    raise CameraError(error.message, hint=_AGAIN) from error
            from multiprocessing.connection import Connection  # nobody needs it who does not look on

            self._link = Connection(self._child.link.detach())
        return self._link

    def _ask(self, picture: Picture, house: FloorMap) -> Found:
        link = self._ready()
        try:
            link.send((picture, None if house is self._house else house))
            self._house = house
            if not link.poll(ANSWER_LIMIT_S):
                raise CameraError(f"The perception process has not answered for {ANSWER_LIMIT_S:g} s.", hint=_AGAIN)
            found: Found = link.recv()
        except (EOFError, OSError) as error:
            assert self._child is not None, "only this thread takes it away"
            why = self._child.epitaph(wait=_EPITAPH_S) or "The perception process closed its connection."
            self._bury()
            raise _closed() if self._closed else CameraError(why, hint=_AGAIN) from error
        except BaseException:  # whatever it was: the next picture must not meet the answer to this one
            self._bury()
            raise
        return found

    def _bury(self) -> None:
        """Leave nothing of the process."""
        with self._changing:
            child, self._child = self._child, None
        link, self._link, self._house = self._link, None, None
        if child is not None:
            child.discard()
        if link is not None:
            link.close()


def _closed() -> CameraError:
    return CameraError("The engine has ended.")
