"""How long a picture takes, by backend and size: *bare* in one process, *process* as a skill gets it.

The bare figure poses the model and takes the picture (a warm one); the other asks the camera process for it and
copies it out of the shared memory, while the robot stands in the flat. OpenGL is left out where it does not work.
"""

from __future__ import annotations

import argparse
import asyncio
from time import perf_counter

import mujoco

from engine.errors import CameraError
from engine.robot.camera import Lens
from engine.robot.sim.dimensions import CAMERA_VIEW
from engine.robot.sim.rays import RayCamera
from tests.bench.report import Figure, figures, print_report, report
from tests.sim.eye import Eye
from tests.sim.rig import running

SIZES = ((160, 120), (320, 240), (640, 480))


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench camera", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--pictures", type=int, default=40, help="of each kind")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    for width, height in SIZES:
        size = f"{width}×{height}"
        found[f"rays, bare {size}"] = figures(_bare(width, height, args.pictures), "ms")
        for backend in ("rays", "opengl"):
            try:
                opening, taken = asyncio.run(_process(backend, width, height, args.pictures))
            except CameraError:
                continue
            found[f"{backend}, process {size}"] = figures(taken, "ms")
            found[f"{backend}, first {size}"] = figures([opening], "ms")
    print_report(report("camera", args.pictures, found), args.json)


def _bare(width: int, height: int, pictures: int) -> list[float]:
    eye = Eye("flat")
    eye.look()
    camera, taken = RayCamera(eye.model, Lens.of_view(width, height, CAMERA_VIEW)), []
    for _ in range(pictures):
        began = perf_counter()
        mujoco.mj_kinematics(eye.model, eye.data)
        mujoco.mj_camlight(eye.model, eye.data)
        camera.take(eye.data, labels=False)
        taken.append((perf_counter() - began) * 1e3)
    return taken


async def _process(backend: str, width: int, height: int, pictures: int) -> tuple[float, list[float]]:
    """ms from the first wish for a picture, with the start of the process in it, and of those after it."""
    taken = []
    async with running(camera={"backend": backend, "width": width, "height": height}) as robot:
        for _ in range(pictures + 1):
            began = perf_counter()
            await robot.look()
            taken.append((perf_counter() - began) * 1e3)
            await robot.tick()
    return taken[0], taken[1:]


if __name__ == "__main__":
    main()
