"""A robot whose physics a test holds in its hand: the real world and the real camera, in the test's own process.

It speaks the protocol of a robot, so skills run on it as on any other; and a test may put things where it wants them,
also in the middle of a skill, and look up where they really are.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from config import load
from engine.perception.eyes import Eyes
from engine.perception.memory import WorldMemory
from engine.robot.arm import ARM_INITIAL, ArmModel
from engine.robot.camera import Lens, Picture
from engine.robot.company import Company
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import UNMOVED, Pose, Twist, compose, inverse
from engine.robot.host.memory import STATE
from engine.robot.lidar import LIDAR_ANGLES
from engine.robot.robot import Capability, Footprint, RobotState, Scan
from engine.robot.sim.dimensions import ARM, CAMERA_VIEW, FOOTPRINT
from engine.robot.sim.floor import floor_map
from engine.robot.sim.rays import RayCamera
from engine.robot.sim.scene import Scene
from engine.robot.sim.world import World
from engine.skills.context import SkillContext
from engine.skills.places import Places
from tests.sim.rig import TICK_STEPS, flat, settings

PLACES = load(environ={}).places
SQUEEZED_N = 0.2
"""What both fingers press with on what they hold; less is a touch, and either word for it is true."""


class HandRobot:
    """A :class:`engine.robot.robot.Robot` over a world in this process; a tick advances it by 20 ms."""

    def __init__(self, scene: Scene | None = None, **changes: Any) -> None:
        self.scene = scene or flat()
        self.world = World(self.scene, settings(**changes))
        self._map = floor_map(self.scene)
        self._lens = Lens.of_view(160, 120, CAMERA_VIEW)
        self._camera = RayCamera(self.world.model, self._lens)
        self._epoch = 1
        self.pictures = 0
        self.each_tick: Callable[[], None] = lambda: None

    name = "robot in hand"
    capabilities: frozenset[Capability] = frozenset({"base", "arm", "camera", "voice"})

    @property
    def footprint(self) -> Footprint:
        return FOOTPRINT

    @property
    def floor_map(self) -> FloorMap:
        return self._map

    @property
    def arm(self) -> ArmModel:
        return ARM

    @property
    def navigates(self) -> bool:
        return False

    @property
    def company(self) -> Company | None:
        return self.world.company

    def go(self, goal: Pose, epoch: int) -> int:
        raise AssertionError("it does not navigate")

    async def start(self) -> None: ...

    async def close(self) -> None: ...

    def stop(self, epoch: int) -> None:
        self._epoch = epoch
        self.world.stop()

    def press(self, pressed: bool) -> None:
        raise NotImplementedError("no skill presses the emergency stop")

    def limit_speed(self, share: float) -> None:
        raise NotImplementedError("no skill limits the speed")

    def pause(self, epoch: int) -> int:
        raise NotImplementedError("no skill pauses a robot")

    def resume(self, token: int) -> None:
        raise NotImplementedError("no skill pauses a robot")

    def heartbeat(self) -> None: ...

    def state(self) -> RobotState:
        record = np.zeros((), STATE)
        self.world.fill(record)
        return RobotState(
            t=float(record["t"]),
            epoch=self._epoch,
            pose=Pose(*record["pose"].tolist()),
            twist=Twist(*record["twist"].tolist()),
            command=Twist(*record["command"].tolist()),
            joints=tuple(record["joints"].tolist()),
            joint_targets=tuple(record["joint_targets"].tolist()),
            gripper=float(record["gripper"]),
            grip=float(record["grip"]),
            light=(0, 0, 0),
            blocked=self.world.blocked,
            halted=None,
        )

    def scan(self) -> Scan:
        return Scan(self.world.scan_time, LIDAR_ANGLES, self.world.ranges.copy())

    async def look(self) -> Picture:
        await asyncio.sleep(0)
        self.pictures += 1
        data = self.world.data
        mujoco.mj_kinematics(self.world.model, data)
        mujoco.mj_camlight(self.world.model, data)
        taken = self._camera.take(data)
        state = self.state()
        return Picture(state.t, taken.rgb, taken.depth, self._lens, ARM.camera(state.joints), state.pose, taken.labels)

    def relocate(self, believed: Pose, true: Pose) -> None:
        record = np.zeros((), STATE)
        self.world.fill(record)
        correction = Pose(*record["correction"].tolist())
        self.world.correct(compose(compose(true, inverse(believed)), correction))

    def drive(self, twist: Twist, epoch: int) -> None:
        if epoch == self._epoch:
            self.world.drive(twist)

    def move_arm(self, joints: Sequence[float], epoch: int, *, speed: float = 1.0) -> None:
        if epoch == self._epoch:
            self.world.move_arm(joints, speed)

    def set_gripper(self, opening: float, epoch: int) -> None:
        if epoch == self._epoch:
            self.world.grip(opening)

    def set_light(self, rgb: tuple[int, int, int], epoch: int) -> None: ...

    def beep(self, seconds: float, epoch: int) -> None: ...

    async def tick(self) -> RobotState:
        await asyncio.sleep(0)
        for _ in range(TICK_STEPS):
            self.world.step()
        self.each_tick()
        return self.state()

    # What only a test may do.

    def put(self, name: str, x: float, y: float, z: float, yaw: float = 0.0) -> None:
        """Put a loose object (the middle of its bottom) somewhere, at rest, map frame."""
        joint = self.world.model.joint(name)
        at, dof = joint.qposadr[0], joint.dofadr[0]
        self.world.data.qpos[at : at + 7] = (x, y, z, math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))
        self.world.data.qvel[dof : dof + 6] = 0
        mujoco.mj_forward(self.world.model, self.world.data)

    def where(self, name: str) -> tuple[float, float, float]:
        """Where the middle of a loose object's bottom is, map frame."""
        x, y, z = self.world.data.body(name).xpos.tolist()
        return x, y, z

    def stand_at(self, pose: Pose) -> None:
        """Stand there, and know it, with the arm folded and the gripper half open."""
        self.world.simulated.put_at(pose)
        self.world.correct(UNMOVED)
        self.world.arm.move(ARM_INITIAL, 2.0)
        self.world.arm.resume_grip(0.5)


def pressed_by(world: World, name: str) -> float:
    """With how many newtons both fingers press on a loose object."""
    force = dict.fromkeys(("left finger", "right finger"), 0.0)
    for index, contact in enumerate(world.data.contact):
        bodies = [world.model.body(int(world.model.geom_bodyid[geom])).name for geom in contact.geom]
        found = np.zeros(6)
        mujoco.mj_contactForce(world.model, world.data, index, found)
        for finger in force.keys() & set(bodies) if name in bodies else ():
            force[finger] += float(found[0])
    return min(force.values())


def context_of(robot: Any, memory: WorldMemory, epoch: int = 1) -> SkillContext:
    """A skill's view of this robot."""

    async def say(text: str) -> None: ...

    def progress(*told: object, **more: object) -> None: ...

    return SkillContext(
        robot=robot, epoch=epoch, places=Places(PLACES), say=say, progress=progress,
        describe_skills=lambda: "", see=Eyes(robot, memory).see, world=memory,
    )  # fmt: skip
