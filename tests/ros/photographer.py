"""Takes the pictures of :mod:`tests.ros.robot`, in the Python that has the simulation: ``python -m
tests.ros.photographer [SCENE [WITNESS]]``, in JSON lines. It has a model of the scene for itself, so that the
simulation never waits for pixels.

It is told ``{"qpos": state of the world, "packed": whether a JPEG is wanted}``, and tells the picture of that: ``rgb``,
the ``depth`` of each pixel in mm (16 bits, little endian, 0 where there is none), and ``jpeg``.
"""

from __future__ import annotations

import sys

import cv2
import numpy as np

from engine.robot.camera import Lens
from engine.robot.sim.dimensions import CAMERA_VIEW
from engine.robot.sim.imaging import Studio
from engine.robot.sim.scene_file import load_scene, scene_path
from tests.ros.lines import read, write

WIDTH, HEIGHT = 240, 180
"""Pixels; not what the engine asks for, as with most cameras."""


def main(scene: str = "flat", witness: str = "") -> None:
    del witness
    studio = Studio(load_scene(scene_path(scene)), "rays", WIDTH, HEIGHT)
    write({"width": WIDTH, "height": HEIGHT, "focal": Lens.of_view(WIDTH, HEIGHT, CAMERA_VIEW).fx})
    for line in read():
        exposure = studio.take({"qpos": np.array(line["qpos"])}, labels=False)
        depth = np.where(np.isfinite(exposure.depth), np.round(1000 * exposure.depth), 0).astype("<u2")
        told = {"rgb": exposure.rgb.tobytes(), "depth": depth.tobytes()}
        if line["packed"]:
            told["jpeg"] = cv2.imencode(".jpg", exposure.rgb[:, :, ::-1])[1].tobytes()
        write(told)


if __name__ == "__main__":
    main(*sys.argv[1:])
