"""The simulated camera, as the engine holds it: it has a process that takes pictures, and replaces one that is lost.

Pictures are asked for over a link and come through shared memory (:class:`engine.robot.sim.film.Film`), one at a time
and in the order of asking. A process that ends or stays silent is lost: whoever waits for a picture, or asks for one
before anybody has been told, gets a :class:`engine.errors.CameraError`, and who asks next the first picture of its
replacement. So whoever drives by pictures learns of it, also if it happens between two of them. A camera that is lost
too often is given up. Graphics libraries are tried first where the settings allow it, each in a process of its own, so
that one which crashes takes nothing with it; rays can always be cast.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
from pathlib import Path

from config.schema import Camera as CameraSettings
from engine.errors import CameraError
from engine.robot.camera import Lens, Picture
from engine.robot.camera_news import GivenUp, Lost, Opened, Opening, TellOfCamera
from engine.robot.host.memory import Memory, believed
from engine.robot.sim.camera_process import Backend, CameraProcess
from engine.robot.sim.dimensions import ARM, CAMERA_VIEW
from engine.robot.sim.film import Film

PAUSES_S = (0.0, 1.0, 2.0)
"""Before the first, second and third time that a lost process is replaced, s."""
WINDOW_S = 60.0
"""A camera that is lost more often than there are pauses within so many seconds is given up."""
_BACKENDS: dict[str, tuple[Backend, ...]] = {
    "auto": ("egl", "osmesa", "rays"),
    "opengl": ("egl", "osmesa"),
    "rays": ("rays",),
}
_NAMES: dict[Backend, str] = {"egl": "opengl (egl)", "osmesa": "opengl (osmesa)", "rays": "rays"}


class SimCamera:
    """The camera of one simulated robot, in one asyncio loop, in which ``tell`` is called too."""

    def __init__(self, scene: Path, settings: CameraSettings, memory: Memory, tell: TellOfCamera) -> None:
        """Start in the background; ``memory`` is what the robot process fills."""
        self._scene = scene
        self._memory = memory
        self._tell = tell
        self._backends = list(_BACKENDS[settings.backend])  # those that may still work, the best first
        self._film = Film.create(settings.width, settings.height)
        self._lens = Lens.of_view(settings.width, settings.height, CAMERA_VIEW)
        self._shutter = asyncio.Lock()  # fair: first come, first served
        self._replaced: list[float] = []  # when lost processes were, loop time
        self._process: CameraProcess | None = None
        self._lost: CameraError | None = None  # why the last process takes no pictures, until there is another one
        self._told: CameraError | None = None  # the newest loss of which somebody who wanted a picture was told
        self._failure: CameraError | None = None
        self._opened = asyncio.Event()  # there is a process, or will never be one again
        self._keeping = asyncio.create_task(self._keep())

    @property
    def pid(self) -> int | None:
        """Of the camera process, once it takes pictures."""
        return self._process.pid if self._process is not None else None

    async def look(self, *, labels: bool = False) -> Picture:
        """A picture of now, as soon as it is this caller's turn. Raises :class:`CameraError`."""
        asked = self._process if self._process is not None and self._process.lost is None else None
        async with self._shutter:
            if asked is not None and asked.lost is not None:
                self._told = asked.lost
                raise asked.lost  # while this one was waiting
            lost = self._lost if self._process is None else self._process.lost
            if lost is not None and lost is not self._told:
                self._told = lost
                raise lost  # when nobody was
            process = await self._ready()
            try:
                await process.take(labels=labels)
            except CameraError:
                self._told = process.lost
                raise
            return self._developed(labels=labels)

    async def close(self) -> None:
        """End the process and release everything."""
        self._give_up(CameraError("The camera has been closed."))
        self._keeping.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._keeping
        os.close(self._film.fd)

    async def _ready(self) -> CameraProcess:
        while True:
            await self._opened.wait()
            if self._failure is not None:
                raise self._failure
            if self._process is not None and self._process.lost is None:
                return self._process
            await asyncio.sleep(0)  # its keeper has not heard of the loss yet

    def _developed(self, *, labels: bool) -> Picture:
        film, taken = self._film, self._film.taken
        yaw, shoulder, elbow, wrist, roll = taken["joints"].tolist()
        return Picture(
            float(taken["t"]),
            film.rgb.copy(),
            film.depth.copy(),
            self._lens,
            ARM.camera((yaw, shoulder, elbow, wrist, roll)),
            believed(taken, self._memory.correction.scratch),
            film.labels.copy() if labels else None,
        )

    # The life of its processes

    async def _keep(self) -> None:
        """Start a process, and another one whenever it is lost, until that has become hopeless."""
        while True:
            self._tell(Opening())
            try:
                if self._lost is not None:
                    await asyncio.sleep(self._pause(self._lost))
                self._process, note = await self._start()
            except CameraError as error:
                self._give_up(error)
                self._tell(GivenUp(error))
                return
            self._lost = None
            self._opened.set()
            self._tell(Opened(f"{_NAMES[self._process.backend]} {self._lens.width}×{self._lens.height}", note))
            try:
                self._lost = await self._process.loss()
            finally:
                self._opened.clear()
                process, self._process = self._process, None
                await process.bury()
            self._tell(Lost(self._lost))

    async def _start(self) -> tuple[CameraProcess, str]:
        """A process that takes pictures, with the best backend that works, and a note when that is not the best."""
        note = ""
        while True:
            process = CameraProcess(self._scene, self._backends[0], self._memory, self._film)
            try:
                await process.ready()
                return process, note if process.backend == "rays" else ""
            except CameraError as error:
                await process.bury()
                if len(self._backends) == 1:
                    raise CameraError(error.message, hint="`sayso doctor` says what works here.") from error
                del self._backends[0]
                note = f"Pictures are cast by rays; OpenGL cannot be used: {error.message}"
            except BaseException:
                await process.bury()
                raise

    def _pause(self, lost: CameraError) -> float:
        """How long to wait before the next process. Raises :class:`CameraError` when there have been too many."""
        now = asyncio.get_running_loop().time()
        self._replaced = [then for then in self._replaced if now - then < WINDOW_S]
        if len(self._replaced) == len(PAUSES_S):
            message = f"The camera was lost too often within {WINDOW_S:g} s, the last time so: {lost.message}"
            raise CameraError(message, hint="Start sayso again.")
        pause = PAUSES_S[len(self._replaced)]
        self._replaced.append(now)
        return pause

    def _give_up(self, error: CameraError) -> None:
        self._failure = error
        self._opened.set()
