"""A camera in the hand of a test: pictures of a scene from any pose, without a process."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from engine.robot.arm import ARM_INITIAL, ARM_JOINTS, Joints
from engine.robot.camera import Lens, Picture
from engine.robot.geometry import Pose
from engine.robot.sim.body import BASE_JOINTS, initial_qpos
from engine.robot.sim.build import build
from engine.robot.sim.dimensions import ARM, CAMERA_VIEW
from engine.robot.sim.rays import RayCamera
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path


class Eye:
    """Looks at a scene (its name, or a scene that a test has made)."""

    def __init__(self, scene: str | Scene = "flat", *, width: int = 160, height: int = 120) -> None:
        self.scene = load_scene(scene_path(scene)) if isinstance(scene, str) else scene
        self.model: Any = build(self.scene)
        self.data: Any = mujoco.MjData(self.model)
        self._lens = Lens.of_view(width, height, CAMERA_VIEW)
        self._camera = RayCamera(self.model, self._lens)
        initial_qpos(self.model, self.data, self.scene.start.pose)

    def put(self, name: str, x: float, y: float, z: float, yaw: float = 0.0) -> None:
        """Put a loose object (the middle of its bottom) somewhere, map frame."""
        at = self.model.joint(name).qposadr[0]
        self.data.qpos[at : at + 7] = (x, y, z, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2))

    def where(self, name: str) -> tuple[float, float, float]:
        """Where a loose object is."""
        x, y, z = self.data.body(name).xpos.tolist()
        return x, y, z

    def settle(self, seconds: float = 0.5) -> None:
        """Let physics have its way."""
        for _ in range(round(seconds / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)

    def look(self, pose: Pose | None = None, joints: Joints = ARM_INITIAL, believed: Pose | None = None) -> Picture:
        """A picture from ``pose``; ``believed`` is where the robot thinks it is."""
        start = pose or self.scene.start.pose
        values: Mapping[str, float] = dict(
            zip((*BASE_JOINTS, *ARM_JOINTS), (start.x, start.y, start.yaw, *joints), strict=True)
        )
        for name, value in values.items():
            self.data.qpos[self.model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        taken = self._camera.take(self.data)
        return Picture(
            float(self.data.time),
            taken.rgb,
            taken.depth,
            self._lens,
            ARM.camera(joints),
            believed or start,
            taken.labels,
        )
