"""The camera process from outside: starting it, asking it for pictures, and noticing its end or its silence.

Requests are numbered, so that the answer to one that nobody waits for any more is not taken for that to the next.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from pathlib import Path
from typing import Literal

from engine.child import Child, end_for_good
from engine.errors import CameraError, ProcessError
from engine.robot.host.memory import Memory
from engine.robot.host.process import LEAN
from engine.robot.sim.film import Film

START_LIMIT_S = 60.0
"""s until a camera process must be ready."""
ANSWER_LIMIT_S = 10.0
"""s that a picture may take, however large it is."""
SILENCE_LIMIT_S = 0.8
"""s without a sign of life after which a camera process counts as lost, while somebody waits for a picture."""
_SLICE_S = 0.1  # of a wait: an engine that was paused itself does not take that for silence of the camera

Backend = Literal["egl", "osmesa", "rays"]


class CameraProcess(Child):
    """One running camera process, in one asyncio loop. Whoever makes it buries it."""

    def __init__(self, scene: Path, backend: Backend, memory: Memory, film: Film) -> None:
        """Start the process. Raises :class:`CameraError`."""
        self.backend = backend
        arguments = [f"--memory={memory.fd}", f"--film={film.fd}", f"--scene={scene}", f"--backend={backend}"]
        height, width = film.depth.shape
        arguments += [f"--width={width}", f"--height={height}"]
        library = "disable" if backend == "rays" else backend  # mujoco reads it when it is loaded
        try:
            super().__init__(
                "camera",
                "engine.robot.sim.imaging",
                arguments,
                shared=(memory.fd, film.fd),
                environment={"MUJOCO_GL": library, **LEAN},
            )
        except ProcessError as error:
            raise CameraError(error.message) from error
        self._film = film
        self._loop = asyncio.get_running_loop()
        self._lost: asyncio.Future[CameraError] = self._loop.create_future()
        self._read = b""
        self._number = 0  # of the last request
        self._answered = -1  # 0: it is ready
        self._answer = asyncio.Event()
        self.link.setblocking(False)
        self._loop.add_reader(self.link, self._on_link)

    async def ready(self) -> None:
        """Wait until it can take pictures. Raises :class:`CameraError`."""
        await self._reach(0, START_LIMIT_S)

    async def take(self, *, labels: bool) -> None:
        """Have a picture taken; it is on the film when this returns. Raises :class:`CameraError`."""
        self._number += 1
        with contextlib.suppress(OSError):  # full of requests that were not read, or closed: no answer will come
            self.link.send(json.dumps({"take": self._number, "labels": labels}).encode() + b"\n")
        await self._reach(self._number, ANSWER_LIMIT_S)

    @property
    def lost(self) -> CameraError | None:
        """Why it takes no pictures any more."""
        return self._lost.result() if self._lost.done() else None

    async def loss(self) -> CameraError:
        """Wait until it is lost."""
        return await asyncio.shield(self._lost)

    async def bury(self) -> None:
        """End the process and leave nothing of it."""
        self._loop.remove_reader(self.link)
        ending = asyncio.ensure_future(asyncio.to_thread(end_for_good, self._process))
        try:
            await asyncio.shield(ending)
        except asyncio.CancelledError:
            await ending  # a moment at most; nothing may be left running
            raise
        finally:
            self.release()

    async def _reach(self, number: int, limit: float) -> None:
        """Wait for the answer to this request; one that takes longer than ``limit`` s, or a process that shows no
        life once it is ready, is a loss."""
        life, silent = -1.0, 0.0
        for _ in range(round(limit / _SLICE_S)):
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_SLICE_S):
                    while self._answered < number and not self._lost.done():
                        self._answer.clear()
                        await self._answer.wait()
            if self._answered >= number:
                return
            if (error := self.lost) is not None:
                raise error
            before, life = life, float(self._film.taken["alive"])
            silent = silent + _SLICE_S if life == before and number > 0 else 0.0
            if silent > SILENCE_LIMIT_S - _SLICE_S:
                raise self._lose(f"The camera process has shown no life for {SILENCE_LIMIT_S:g} s.")
        raise self._lose(f"The camera process has not answered for {limit:g} s.")

    def _on_link(self) -> None:
        try:
            data = self.link.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._lose(self.epitaph(wait=0.5) or "The camera process closed its connection.")
            return
        *lines, self._read = (self._read + data).split(b"\n")
        for line in lines:
            self._answered = json.loads(line)["taken"]
        self._answer.set()

    def _lose(self, why: str) -> CameraError:
        """From now on it takes no pictures."""
        self._loop.remove_reader(self.link)
        error = CameraError(why, hint="It is being started again.")
        if not self._lost.done():
            self._lost.set_result(error)
        self._answer.set()
        return error
