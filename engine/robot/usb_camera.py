"""A camera on USB: colours, and no depth. It comes and goes without anybody else noticing more than that.

A thread reads it, for a driver may block for seconds. What is not measured is assumed: every pixel shows the floor
(:func:`engine.robot.camera.floor_depth`), which is right for lines and tags on the floor and for nothing that stands.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from config.schema import Camera as CameraSettings
from engine.errors import CameraError
from engine.robot.camera import Lens, Picture, floor_depth, floor_error
from engine.robot.camera_news import Lost, Opened, Opening, TellOfCamera
from engine.robot.description import Description
from engine.robot.host.memory import Memory, believed

AGAIN_S: Final = 1.0
"""Between two tries to open a camera that is not there."""
LATE_S: Final = 3.0
"""In which a picture must come."""
NAMES: Final = Path("/sys/class/video4linux")


def cameras() -> dict[str, str]:
    """What the system calls its cameras, by path: ``/dev/video0``."""
    found = {}
    with contextlib.suppress(OSError):
        for folder in sorted(NAMES.iterdir()):
            with contextlib.suppress(OSError):
                found[f"/dev/{folder.name}"] = (folder / "name").read_text().strip()
    return found


def path_of(device: str) -> str:
    """The path that a setting means: a number, a path, or a part of a name. Raises :class:`CameraError`."""
    if device.isdecimal():
        return f"/dev/video{device}"
    if os.sep in device:
        return str(Path(device).expanduser())
    there = cameras()
    found = next((path for path, name in there.items() if device.casefold() in name.casefold()), None)
    if found is None:
        known = ", ".join(there.values()) or "none at all"
        raise CameraError(f"There is no camera called {device!r}.", hint=f"There are: {known}.")
    return found


class Capture:
    """OpenCV's hold on a camera, or on a film that stands for one. Whoever makes it closes it."""

    def __init__(self, device: str) -> None:
        """Raises :class:`CameraError`, as all of this does."""
        import cv2

        self.path = path_of(device)
        with self._faults_told():
            self._capture: Any = cv2.VideoCapture(self.path)
            if not self._capture.isOpened():
                hint = "Is it plugged in, and used by nobody?"
                raise CameraError(f"The camera {self.path} cannot be opened.", hint=hint)
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, 640)
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, 480)
            film = Path(self.path).is_file()
            self.pace = 1 / (self._capture.get(cv2.CAP_PROP_FPS) or 30) if film else 0.0
            """s from one picture to the next in a film, which can be read faster; 0: a camera has its own pace."""

    def read(self) -> NDArray[np.uint8]:
        """The next picture, BGR. Waits for it."""
        with self._faults_told():
            good, bgr = self._capture.read()
        if not good:
            raise CameraError(f"The camera {self.path} delivers no more pictures.", hint="It is opened again.")
        picture: NDArray[np.uint8] = bgr
        return picture

    def close(self) -> None:
        """Let go of it."""
        self._capture.release()

    @contextlib.contextmanager
    def _faults_told(self) -> Iterator[None]:
        import cv2

        try:
            yield
        except cv2.error as error:
            raise CameraError(f"The camera {self.path} has a fault: {str(error).splitlines()[0]}.") from error


def how_good(height: float) -> str:
    """What distances are worth by a camera ``height`` m above the floor that measures none, for people."""
    errors = (f"{100 * floor_error(height, away):.0f} cm at {away:g} m" for away in (0.5, 1.0, 2.0))
    return f"on the floor it is right to about {', '.join(errors)}"


class UsbCamera:
    """One camera, in one asyncio loop, in which ``tell`` is called too."""

    pid: int | None = None
    """It has no process of its own."""

    def __init__(self, settings: CameraSettings, description: Description, memory: Memory, tell: TellOfCamera) -> None:
        """Open it in the background; ``memory`` is what the host fills."""
        assert settings.device is not None, "whoever makes one knows which"
        assert description.camera is not None, "the same"
        self._device = settings.device
        self._size = settings.width, settings.height
        self._description = description
        self._view = np.radians(description.camera.view)
        self._memory = memory
        self._tell = tell
        self._loop = asyncio.get_running_loop()
        self._newest: tuple[float, NDArray[np.uint8]] | None = None  # when it came, and BGR
        self._came = asyncio.Event()
        self._lost: CameraError | None = None
        self._closing = threading.Event()
        self._reader = threading.Thread(target=self._read, name="camera", daemon=True)
        self._reader.start()

    async def look(self, *, labels: bool = False) -> Picture:
        """A picture that is taken from now on. Raises ``CameraError``."""
        del labels
        asked = time.monotonic()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LATE_S):
                while self._newest is None or self._newest[0] < asked:
                    if self._lost is not None:
                        raise self._lost
                    self._came.clear()
                    await self._came.wait()
        if self._newest is None or self._newest[0] < asked:
            raise CameraError(f"The camera has delivered no picture for {LATE_S:g} s.")
        return self._picture(self._newest[1])

    async def close(self) -> None:
        """Let go of it."""
        self._closing.set()
        await asyncio.to_thread(self._reader.join, LATE_S)  # a driver that blocks keeps its thread

    def _picture(self, bgr: NDArray[np.uint8]) -> Picture:
        import cv2

        width, height = self._size
        rgb = cv2.cvtColor(cv2.resize(bgr, (width, height), interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2RGB)
        record = self._memory.state.get()
        lens = Lens.of_view(width, height, self._view)
        mount = self._description.eye(record["joints"].tolist())
        pose = believed(record, self._memory.correction.scratch)
        pixels: NDArray[np.uint8] = np.asarray(rgb, dtype=np.uint8)
        return Picture(float(record["t"]), pixels, floor_depth(lens, mount), lens, mount, pose, guessed=True)

    # In the thread that reads

    def _read(self) -> None:
        while not self._closing.is_set():
            self._in_loop(lambda: self._tell(Opening()))
            try:
                self._read_on()
            except CameraError as error:
                self._in_loop(partial(self._lose, error))
            self._closing.wait(AGAIN_S)

    def _read_on(self) -> None:
        """Read until it is closed. Raises ``CameraError`` when it is lost, or cannot be opened."""
        first = True
        with contextlib.closing(Capture(self._device)) as capture:
            while not self._closing.is_set():
                bgr = capture.read()
                self._in_loop(partial(self._take, time.monotonic(), bgr, capture.path, first))
                first = False
                self._closing.wait(capture.pace)

    def _in_loop(self, call: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody wants to know
            self._loop.call_soon_threadsafe(call)

    # In the loop

    def _take(self, at: float, bgr: NDArray[np.uint8], path: str, first: bool) -> None:
        self._newest, self._lost = (at, bgr), None
        if first:
            height, width = bgr.shape[:2]
            mount = self._description.eye(self._memory.state.get()["joints"].tolist())
            self._tell(Opened(f"{path} {width}×{height}, no depth: {how_good(float(mount.position[2]))}"))
        self._came.set()

    def _lose(self, error: CameraError) -> None:
        self._lost = error
        self._tell(Lost(error))
        self._came.set()
