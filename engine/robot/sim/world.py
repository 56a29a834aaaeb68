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
from engine.robot.geometry import ZERO, Pose, Twist, wrap
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
        self._walkers = Walkers(self.model, self.data, scene.people, again=last is not None)
        mujoco.mj_forward(self.model, self.data)
        # Views of the simulation's own numbers: they are read and written in every step.
        self._base = _consecutive(self.data.qpos, [self.model.joint(name).qposadr[0] for name in BASE_JOINTS])
        self._base_speed = _consecutive(self.data.qvel, [self.model.joint(name).dofadr[0] for name in BASE_JOINTS])
        self._motors = _consecutive(self.data.ctrl, [self.model.actuator(name).id for name in BASE_JOINTS])
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
        self._around: Points = np.empty((0, 2))  # that and the fence, as far as it can matter before the next scan
        moved = math.sqrt(2) * settings.limits.linear_speed * SCAN_LIFETIME
        self._near = self._envelope.reach + moved
        self._blocked: str | None = None
        self._light_rgb = (0, 0, 0)
        self._buzzer_until = 0.0
        if last is not None:
            self._odometry.resume(self.true_pose, Pose(*last["pose"].tolist()), Pose(*last["correction"].tolist()))
            self.arm.resume_grip(float(last["grip"]))
            red, green, blue = last["light"].tolist()
            self.shine((red, green, blue))
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

    def shine(self, rgb: tuple[int, int, int]) -> None:
        """Set the light."""
        self._light_rgb = rgb
        self.model.geom_rgba[self._light] = [*(v / 255 for v in rgb), 1.0] if any(rgb) else [0.95, 0.95, 0.93, 1]

    def beep(self, seconds: float) -> None:
        """Sound the buzzer."""
        self._buzzer_until = self.t + min(seconds, 5.0)

    def correct(self, correction: Pose) -> None:
        """Believe from now on to be where odometry is after this rigid motion of the map; nothing moves."""
        before = self._odometry.pose
        # What was seen stays where it is around the robot.
        self._seen = into_map_frame(into_base_frame(self._seen, before), self._odometry.correct(correction))
        self._look_around()

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

    def rest(self) -> None:
        """The same, but the base comes to rest as gently as it drives."""
        self._envelope.command(ZERO, self.t)
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
        if self._walkers:
            self._walkers.step(TIMESTEP, self.true_pose)
        mujoco.mj_step(self.model, self.data)
        self._steps += 1
        if self._steps % CONTROL_STEPS == 0:
            self._odometry.update(self.true_pose)  # here, so that who reads the state next reads where it is now

    def _control(self) -> None:
        obstacles = None if self._envelope.idle else self._obstacles(self._odometry.pose)
        shaped = self._envelope.shape(self.t, CONTROL_STEPS * TIMESTEP, obstacles)
        self._told, self._blocked = shaped.twist, shaped.blocked

    def _tell(self, twist: Twist) -> None:
        """Command the motors, which push along the map's axes, in the direction the base looks now."""
        self._told = twist
        if twist.is_zero:
            self._motors[:] = 0.0
            return
        yaw = float(self._base[2])
        c, s = math.cos(yaw), math.sin(yaw)
        self._motors[:] = (c * twist.vx - s * twist.vy, s * twist.vx + c * twist.vy, twist.wz)

    # Readings

    @property
    def true_pose(self) -> Pose:
        x, y, yaw = self._base.tolist()
        return Pose(x, y, wrap(yaw))

    @property
    def twist(self) -> Twist:
        """Measured velocity, base frame."""
        vx, vy, wz = self._base_speed.tolist()
        yaw = float(self._base[2])
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
        self._look_around()

    def _look_around(self) -> None:
        pose = self._odometry.pose
        everything = np.concatenate((self._seen, self._fence))
        apart = everything - (pose.x, pose.y)
        self._around = everything[np.einsum("ij,ij->i", apart, apart) < self._near**2]

    def _obstacles(self, pose: Pose) -> Points | None:
        """What must not be driven into, base frame: the newest scan and the edges of the workspace."""
        if self.t - self._scan_time > SCAN_LIFETIME:
            return None
        return into_base_frame(self._around, pose)


def _consecutive(values: NDArray[np.float64], at: Sequence[int]) -> NDArray[np.float64]:
    """A view of the values at these places, which follow one another."""
    first = int(at[0])
    assert [int(place) for place in at] == list(range(first, first + len(at))), "the base was added in one go"
    return values[first : first + len(at)]
