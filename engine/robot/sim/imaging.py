"""The camera process: ``python -m engine.robot.sim.imaging``, started by :class:`engine.robot.sim.camera.SimCamera`.

It builds the same scene as the robot process, and takes each picture from a copy of the newest state in the memory
that the robot process shares, so that neither the physics nor the engine's interpreter ever waits for pixels. One
process tries one backend: what it fails at, or dies of, the next one can be spared.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any, Protocol

import mujoco

from engine.errors import ExitCode, SaysoError
from engine.robot.camera import Lens
from engine.robot.host.memory import Memory, Record
from engine.robot.sim.build import build
from engine.robot.sim.dimensions import CAMERA_VIEW
from engine.robot.sim.film import Film
from engine.robot.sim.rays import Exposure, RayCamera
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene

PULSE_S = 0.05
"""Between two signs of life, s."""


class Backend(Protocol):
    """One way to take a picture of a model."""

    def take(self, data: Any, *, labels: bool) -> Exposure:
        """A picture of ``data``, whose positions must be up to date (``mj_kinematics``, ``mj_camlight``)."""
        ...


class Studio:
    """A model of its own, posed like the robot's world and photographed."""

    def __init__(self, scene: Scene, backend: str, width: int, height: int) -> None:
        """``backend`` is rays, egl or osmesa. Raises whatever a graphics library may raise."""
        self._model: Any = build(scene)
        self._model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)  # what sleeps would not be posed
        self._data: Any = mujoco.MjData(self._model)
        lens = Lens.of_view(width, height, CAMERA_VIEW)
        self._backend: Backend
        if backend == "rays":
            self._backend = RayCamera(self._model, lens)
        else:
            from engine.robot.sim.render import GlCamera

            self._backend = GlCamera(self._model, lens)
        self._pose(self._data.qpos)
        self._backend.take(self._data, labels=False)  # the first one is slow: shaders are compiled, memory is fetched

    def take(self, state: Record, *, labels: bool) -> Exposure:
        """A picture of the world in ``state``, a record of ``memory.STATE``."""
        self._pose(state["qpos"][: self._model.nq])
        return self._backend.take(self._data, labels=labels)

    def _pose(self, qpos: Any) -> None:
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)


def serve(link: socket.socket, studio: Studio, memory: Memory, film: Film) -> None:
    """Take a picture for every request until the engine closes the link."""
    with link.makefile("rb") as requests:
        for line in requests:
            request = json.loads(line)
            state = memory.state.get()
            exposure = studio.take(state, labels=request["labels"])
            for name in ("t", "pose", "correction", "joints"):
                film.taken[name] = state[name]
            film.rgb[:], film.depth[:] = exposure.rgb, exposure.depth
            if exposure.labels is not None:
                film.labels[:] = exposure.labels
            link.sendall(json.dumps({"taken": request["take"]}).encode() + b"\n")


def show_life(film: Film) -> None:
    """Stamp the film for ever, also while the backend is busy, so that a slow picture is not taken for a lost one."""
    while True:
        film.taken["alive"] = time.monotonic()
        time.sleep(PULSE_S)


def main(argv: list[str]) -> int:
    """Set up the camera, say so, and take pictures."""
    parser = argparse.ArgumentParser(prog="python -m engine.robot.sim.imaging", description="Internal to sayso.")
    for name in ("link", "memory", "film"):
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    for name in ("width", "height"):
        parser.add_argument(f"--{name}", type=int, required=True, help="pixels")
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--backend", choices=("rays", "egl", "osmesa"), required=True)
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    try:
        studio = Studio(load_scene(args.scene), args.backend, args.width, args.height)
    except Exception as error:  # noqa: BLE001 - graphics libraries raise whatever they like
        told = error if isinstance(error, SaysoError) else f"{type(error).__name__}: {error}"
        print(told, file=sys.stderr)  # noqa: T201 - CameraProcess puts our stderr into its own error
        return int(ExitCode.MISSING)
    with socket.socket(fileno=args.link) as link:
        link.sendall(b'{"taken": 0}\n')  # ready
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # an engine killed between asking and hearing
            film = Film(args.film, args.width, args.height)
            threading.Thread(target=show_life, args=(film,), name="pulse", daemon=True).start()
            serve(link, studio, Memory(args.memory), film)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
