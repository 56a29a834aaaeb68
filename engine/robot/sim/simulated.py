"""The simulated body: the scene with the robot in it, its motors, servos and sensors, in MuJoCo.

It knows nothing of processes, clocks or shared memory; whoever tells it something has made sure of limits and obstacles
(``engine.robot.host.controller``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from config.schema import Robot as RobotSettings
from engine.errors import SceneError
from engine.robot.arm import ARM_JOINTS
from engine.robot.company import Company
from engine.robot.geometry import ZERO, Pose, Twist, wrap
from engine.robot.host.body import STEP_S
from engine.robot.host.controller import added_up
from engine.robot.host.memory import MAX_QPOS, Record
from engine.robot.sim.body import BASE_JOINTS, LIGHT_GEOM, initial_qpos
from engine.robot.sim.build import build
from engine.robot.sim.dimensions import FINGER_TRAVEL
from engine.robot.sim.lidar import Lidar
from engine.robot.sim.odometry import Odometry
from engine.robot.sim.people import People
from engine.robot.sim.scene import Scene


class SimulatedBody:
    """A :class:`engine.robot.host.body.Body` in a scene."""

    trouble = ""
    """Nothing goes wrong with it."""
    lag = 0.0
    guard_pid = 0

    def __init__(
        self, scene: Scene, settings: RobotSettings, last: Record | None = None, *, pictures: bool = True
    ) -> None:
        """``last`` is the state to go on from, in a robot that stands still; without one it begins at the start.
        ``pictures`` is for whoever takes pictures of it, see :func:`engine.robot.sim.build.build`."""
        self.model: Any = build(scene, pictures=pictures)
        if self.model.nq > MAX_QPOS:
            raise SceneError(
                f"Scene {scene.name} has {self.model.nq} coordinates; {MAX_QPOS} are the most.",
                hint="Leave out some loose objects.",
            )
        self.data: Any = mujoco.MjData(self.model)
        initial_qpos(self.model, self.data, scene.start.pose)
        if last is not None:
            self.data.time = last["t"]
            self.data.qpos[:] = last["qpos"][: self.model.nq]
        self._people = People(self.model, self.data, scene, again=last is not None) if scene.people else None
        mujoco.mj_forward(self.model, self.data)
        # Views of the simulation's own numbers: they are read and written in every step.
        self._base = _consecutive(self.data.qpos, [self.model.joint(name).qposadr[0] for name in BASE_JOINTS])
        self._base_speed = _consecutive(self.data.qvel, [self.model.joint(name).dofadr[0] for name in BASE_JOINTS])
        self._motors = _consecutive(self.data.ctrl, [self.model.actuator(name).id for name in BASE_JOINTS])
        self._positions = np.array([self.model.joint(name).qposadr[0] for name in ARM_JOINTS])
        self._fingers = np.array([self.model.joint(f"finger {side}").qposadr[0] for side in ("left", "right")])
        self._servos = np.array([self.model.actuator(name).id for name in ARM_JOINTS])
        self._gripper = self.model.actuator("gripper").id
        self._light = self.model.geom(LIGHT_GEOM).id
        self._odometry = Odometry(scene.start.pose, noise=settings.odometry_noise, seed=settings.seed)
        self._lidar = Lidar(self.model, self.data)
        self._told = ZERO
        if last is not None:
            self._odometry.resume(self.true_pose, added_up(last))

    @property
    def t(self) -> float:
        return float(self.data.time)

    @property
    def true_pose(self) -> Pose:
        """Where it stands, map frame."""
        x, y, yaw = self._base.tolist()
        return Pose(x, y, wrap(yaw))

    @property
    def twist(self) -> Twist:
        vx, vy, wz = self._base_speed.tolist()
        yaw = float(self._base[2])
        c, s = math.cos(yaw), math.sin(yaw)
        return Twist(c * vx + s * vy, c * vy - s * vx, wz)

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.data.qpos[self._positions].tolist())

    @property
    def opening(self) -> float:
        return max(0.0, min(1.0, float(self.data.qpos[self._fingers].mean()) / FINGER_TRAVEL))

    @property
    def company(self) -> Company | None:
        """The people around it, where there are any."""
        return self._people

    def step(self) -> None:
        self._push()
        if self._people is not None:
            self._people.step(STEP_S, self.true_pose)
        mujoco.mj_step(self.model, self.data)

    def drive(self, twist: Twist) -> None:
        self._told = twist
        self._push()

    def place_arm(self, joints: Sequence[float], opening: float) -> None:
        self.data.ctrl[self._servos] = joints
        self.data.ctrl[self._gripper] = opening * FINGER_TRAVEL

    def shine(self, rgb: tuple[int, int, int]) -> None:
        self.model.geom_rgba[self._light] = [*(v / 255 for v in rgb), 1.0] if any(rgb) else [0.95, 0.95, 0.93, 1]

    def beep(self, seconds: float) -> None:
        """It makes no sound."""

    def odometry(self) -> Pose:
        return self._odometry.update(self.true_pose)

    def put_at(self, pose: Pose) -> None:
        """Be somewhere else from now on, at rest, as if it had never been anywhere else."""
        self._odometry.resume(pose, pose)
        initial_qpos(self.model, self.data, pose)
        self.data.qvel[:] = 0
        mujoco.mj_forward(self.model, self.data)

    def scan(self) -> NDArray[np.float64]:
        return self._lidar.ranges(self.true_pose)

    def fill(self, record: Record) -> None:
        true = self.true_pose
        record["true_pose"] = (true.x, true.y, true.yaw)
        record["qpos"][: self.model.nq] = self.data.qpos

    def close(self) -> None:
        """Nothing is held."""

    def touching(self) -> tuple[str, ...]:
        """What the robot touches, by name (tests and evaluation)."""
        base = self.model.body("base").id
        found = set()
        for contact in self.data.contact:
            bodies = [int(self.model.geom_bodyid[geom]) for geom in contact.geom]
            roots = [int(self.model.body_rootid[body]) for body in bodies]
            if base in roots:
                found.add(self.model.body(bodies[1 - roots.index(base)]).name)
        return tuple(sorted(found))

    def _push(self) -> None:
        """Command the motors, which push along the map's axes, in the direction the base looks now."""
        if self._told.is_zero:
            self._motors[:] = 0.0
            return
        yaw = float(self._base[2])
        c, s = math.cos(yaw), math.sin(yaw)
        told = self._told
        self._motors[:] = (c * told.vx - s * told.vy, s * told.vx + c * told.vy, told.wz)


def _consecutive(values: NDArray[np.float64], at: Sequence[int]) -> NDArray[np.float64]:
    """A view of the values at these places, which follow one another."""
    first = int(at[0])
    assert [int(place) for place in at] == list(range(first, first + len(at))), "the base was added in one go"
    return values[first : first + len(at)]
