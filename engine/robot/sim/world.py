"""The simulated world with the robot's own firmware in it: commands in, physics, readings out.

This is what runs in the robot process, and it knows nothing of processes, clocks or shared memory, so that a test
can hold one in its hand. Physics advances in steps of 2 ms; every fifth step is a control period, in which the
safety envelope decides what the base motors are told. :meth:`World.stop` acts at once, between two steps.
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
from engine.robot.clearance import Points
from engine.robot.envelope import SCAN_LIFETIME, Envelope, fence, into_base_frame, into_map_frame
from engine.robot.robot import ZERO, Pose, Twist, wrap
from engine.robot.sim.arm import Arm
from engine.robot.sim.body import BASE_JOINTS, LIGHT_GEOM, initial_qpos
from engine.robot.sim.build import TIMESTEP, build
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.lidar import Lidar, points
from engine.robot.sim.memory import MAX_QPOS, Record
from engine.robot.sim.odometry import Odometry
from engine.robot.sim.person import Walkers
from engine.robot.sim.scene import Scene

CONTROL_STEPS = 5
"""Physics steps per control period (10 ms)."""
SCAN_STEPS = 25
"""Physics steps per turn of the lidar (50 ms)."""

_REST_SPEED, _REST_TURN = 0.003, 0.01  # m/s, rad/s: what RobotState.moving counts as rest


class World:
    """The scene, the robot and its controllers."""

    def __init__(self, scene: Scene, settings: RobotSettings, last: Record | None = None) -> None:
        """``last`` is the state to go on from, in a robot that stands still; without one it begins at the start."""
        self.model: Any = build(scene)
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
        self._walkers = Walkers(self.model, self.data, scene.people, again=last is not None)
        mujoco.mj_forward(self.model, self.data)
        self._base_qpos = np.array([self.model.joint(name).qposadr[0] for name in BASE_JOINTS])
        self._base_dofs = np.array([self.model.joint(name).dofadr[0] for name in BASE_JOINTS])
        self._motors = np.array([self.model.actuator(name).id for name in BASE_JOINTS])
        self._light = self.model.geom(LIGHT_GEOM).id
        self._envelope = Envelope(settings.limits, FOOTPRINT)
        self._odometry = Odometry(scene.start.pose, noise=settings.odometry_noise, seed=settings.seed)
        self._lidar = Lidar(self.model, self.data)
        bounds = scene.bounds
        areas = [(bounds.x[0], bounds.y[0], bounds.x[1], bounds.y[1])]
        areas += [(zone.x[0], zone.y[0], zone.x[1], zone.y[1]) for zone in scene.keep_out]
        self._fence: Points = fence(areas)
        self.arm = Arm(self.model, self.data)
        self._steps = 0
        self._told = ZERO
        self._seen: Points = np.empty((0, 2))  # by the lidar, map frame
        self._blocked: str | None = None
        self._light_rgb = (0, 0, 0)
        self._buzzer_until = 0.0
        if last is not None:
            self._odometry.resume(self.true_pose, Pose(*last["pose"].tolist()), Pose(*last["correction"].tolist()))
            self.arm.resume_grip(float(last["grip"]))
            red, green, blue = last["light"].tolist()
            self.signal((red, green, blue), 0.0)
            self._buzzer_until = float(last["buzzer_until"])
        self._scan()

    # Commands. Each returns False when its values are unusable; nothing moves then.

    def drive(self, twist: Twist) -> bool:
        """Drive until the command lifetime is over."""
        return self._envelope.command(twist, self.t)

    def move_arm(self, joints: Sequence[float], speed: float) -> bool:
        return self.arm.move(joints, speed)

    def grip(self, opening: float) -> bool:
        return self.arm.grip(opening)

    def signal(self, rgb: tuple[int, int, int], beep: float) -> None:
        """Set the light, and sound the buzzer for ``beep`` seconds."""
        self._light_rgb = rgb
        self.model.geom_rgba[self._light] = [*(v / 255 for v in rgb), 1.0] if any(rgb) else [0.95, 0.95, 0.93, 1]
        if beep > 0:
            self._buzzer_until = self.t + min(beep, 5.0)

    def correct(self, correction: Pose) -> None:
        """Believe from now on to be where odometry is after this rigid motion of the map; nothing moves."""
        before = self._odometry.pose
        # What was seen stays where it is around the robot.
        self._seen = into_map_frame(into_base_frame(self._seen, before), self._odometry.correct(correction))

    def stop(self) -> None:
        """Base to zero velocity now, arm where it is, gripper as it grips."""
        self.pause()
        self.arm.hold()
        self.resume()

    def pause(self) -> None:
        """Base to zero velocity now, arm and gripper where they are, until :meth:`resume`."""
        self._envelope.halt()
        self._blocked = None
        self._tell(ZERO)
        self.arm.paused = True

    def resume(self) -> None:
        """The arm goes on to its goal, the base with its next command."""
        self.arm.paused = False

    # Time

    @property
    def t(self) -> float:
        """Robot time, s."""
        return float(self.data.time)

    def step(self) -> None:
        """Advance by one physics step."""
        if self._steps % SCAN_STEPS == 0:
            self._scan()
        if self._steps % CONTROL_STEPS == 0:
            self._control()
        self._tell(self._told)
        self.arm.step(TIMESTEP)
        self._walkers.step(TIMESTEP, self.true_pose)
        mujoco.mj_step(self.model, self.data)
        self._steps += 1

    def _control(self) -> None:
        pose = self._odometry.update(self.true_pose)
        shaped = self._envelope.shape(self.t, CONTROL_STEPS * TIMESTEP, self._obstacles(pose))
        self._told, self._blocked = shaped.twist, shaped.blocked

    def _tell(self, twist: Twist) -> None:
        """Command the motors, which push along the map's axes, in the direction the base looks now."""
        self._told = twist
        yaw = float(self.data.qpos[self._base_qpos[2]])
        c, s = math.cos(yaw), math.sin(yaw)
        self.data.ctrl[self._motors] = (c * twist.vx - s * twist.vy, s * twist.vx + c * twist.vy, twist.wz)

    # Readings

    @property
    def true_pose(self) -> Pose:
        x, y, yaw = self.data.qpos[self._base_qpos].tolist()
        return Pose(x, y, wrap(yaw))

    @property
    def twist(self) -> Twist:
        """Measured velocity, base frame."""
        vx, vy, wz = self.data.qvel[self._base_dofs].tolist()
        yaw = float(self.data.qpos[self._base_qpos[2]])
        c, s = math.cos(yaw), math.sin(yaw)
        return Twist(c * vx + s * vy, c * vy - s * vx, wz)

    @property
    def command(self) -> Twist:
        """What the motors are told."""
        return self._told

    @property
    def blocked(self) -> str | None:
        return self._blocked

    @property
    def at_rest(self) -> bool:
        twist = self.twist
        return math.hypot(twist.vx, twist.vy) <= _REST_SPEED and abs(twist.wz) <= _REST_TURN

    @property
    def ranges(self) -> NDArray[np.float64]:
        """The newest scan (see ``dimensions.LIDAR_ANGLES``), m."""
        return self._ranges

    @property
    def scan_time(self) -> float:
        """When the newest scan was taken, robot time."""
        return self._scan_time

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

    def fill(self, record: Record) -> None:
        """Write the readings into a record of ``memory.STATE``; epoch and halted are not ours."""
        pose, true, twist, told = self._odometry.pose, self.true_pose, self.twist, self._told
        correction = self._odometry.correction
        record["t"] = self.t
        record["pose"] = (pose.x, pose.y, pose.yaw)
        record["correction"] = (correction.x, correction.y, correction.yaw)
        record["true_pose"] = (true.x, true.y, true.yaw)
        record["twist"] = (twist.vx, twist.vy, twist.wz)
        record["command"] = (told.vx, told.vy, told.wz)
        record["joints"], record["joint_targets"] = self.arm.joints, self.arm.targets
        record["gripper"], record["grip"] = self.arm.opening, self.arm.grip_target
        record["light"] = self._light_rgb
        record["buzzer_until"] = self._buzzer_until
        record["blocked"] = (self._blocked or "").encode()
        record["qpos"][: self.model.nq] = self.data.qpos

    # Seeing

    def _scan(self) -> None:
        self._ranges = self._lidar.ranges(self.true_pose)
        self._scan_time = self.t
        self._seen = into_map_frame(points(self._ranges), self._odometry.pose)

    def _obstacles(self, pose: Pose) -> Points | None:
        """What must not be driven into, base frame: the newest scan and the edges of the workspace."""
        if self.t - self._scan_time > SCAN_LIFETIME:
            return None
        return into_base_frame(np.concatenate((self._seen, self._fence)), pose)
