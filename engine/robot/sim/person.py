"""People who walk about in a scene: a mannequin on three planar joints, moved along its path step by step.

The joints are ordinary coordinates of the simulation, so that whoever copies those (the camera) sees people where
they are. Nobody pushes a person: each step puts them where they have walked to. They wait while the robot is in their
way, and touch nothing else.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from engine.robot.geometry import Pose, wrap
from engine.robot.sim.body import Node
from engine.robot.sim.figure import WAVE_HZ, WAVE_SWING, Vector, add_figure, holding_point, waving_joint
from engine.robot.sim.scene_parts import Person, Point

TURN_SPEED = 2.0
"""rad/s."""
BERTH = 0.5
"""How near to the robot's middle somebody walks on, m."""

_AHEAD = math.radians(75)  # to either side: where somebody looks while walking
_ARRIVED = 0.05  # m from a point of the path
_JOINTS = ("x", "y", "yaw")


def add_person(spec: Node, name: str, person: Person) -> None:
    """Put somebody at the beginning of their path; the joints are their pose in the map frame, at the first moment too,
    for whoever looks at a scene in which nobody walks."""
    (x, y), yaw = person.path[0], _first_yaw(person)
    c, s = math.cos(yaw), math.sin(yaw)
    turn = [math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
    body = spec.worldbody.add_body(name=name, pos=[x, y, 0], quat=turn, sleep=mujoco.mjtSleepPolicy.mjSLEEP_NEVER)
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    axes = ([c, -s, 0], [s, c, 0], [0, 0, 1])  # those of the map, seen from the body
    for joint, kind, axis, ref in zip(_JOINTS, (slide, slide, hinge), axes, (x, y, yaw), strict=True):
        body.add_joint(name=f"{name} {joint}", type=kind, axis=axis, ref=ref)
    add_figure(body, name, person)


def in_hand(person: Person) -> Vector:
    """Where the middle of a thing is that they hold in the beginning, map frame, m."""
    front, left, height = holding_point(person)
    (x, y), yaw = person.path[0], _first_yaw(person)
    c, s = math.cos(yaw), math.sin(yaw)
    return x + c * front - s * left, y + s * front + c * left, height


class Walkers:
    """Everybody in a scene, on their ways."""

    def __init__(self, model: Any, data: Any, people: dict[str, Person], *, again: bool = False) -> None:
        """Everybody stands at the beginning of their path; with ``again`` where ``data`` has them."""
        self._data = data
        self._walkers = [_Walker(model, name, person) for name, person in people.items()]
        for walker in self._walkers:
            walker.begin(data, again=again)

    def __bool__(self) -> bool:
        """Whether there is anybody."""
        return bool(self._walkers)

    def step(self, seconds: float, robot: Pose) -> None:
        """Everybody walks on for so long, unless the robot is in the way."""
        for walker in self._walkers:
            walker.step(self._data, seconds, robot)


class _Walker:
    def __init__(self, model: Any, name: str, person: Person) -> None:
        joints = [model.joint(f"{name} {joint}") for joint in _JOINTS]
        self._qpos = np.array([joint.qposadr[0] for joint in joints])
        self._dofs = np.array([joint.dofadr[0] for joint in joints])
        self._path, self._speed, self._yaw = person.path, person.speed, _first_yaw(person)
        self._arm: tuple[int, int] | None = None  # place of the angle and of the speed of one that waves
        if person.gesture == "waving":
            arm = model.joint(waving_joint(name))
            self._arm = int(arm.qposadr[0]), int(arm.dofadr[0])
        self._towards = 0

    def begin(self, data: Any, *, again: bool) -> None:
        path = self._path
        self._towards = 1 % len(path)
        if not again:
            data.qpos[self._qpos] = (*path[0], self._yaw)
            return
        x, y = data.qpos[self._qpos[:2]].tolist()
        detours = [
            math.dist(path[i - 1], (x, y)) + math.dist((x, y), end) - math.dist(path[i - 1], end)
            for i, end in enumerate(path)
        ]
        self._towards = detours.index(min(detours))

    def step(self, data: Any, seconds: float, robot: Pose) -> None:
        x, y, yaw = data.qpos[self._qpos].tolist()
        speed = turning = 0.0
        if len(self._path) > 1 and self._speed > 0 and not _in_the_way((x, y), yaw, robot):
            if math.dist((x, y), self._path[self._towards]) < _ARRIVED:
                self._towards = (self._towards + 1) % len(self._path)
            aside = wrap(_direction((x, y), self._path[self._towards]) - yaw)
            turning = math.copysign(min(TURN_SPEED, abs(aside) / seconds), aside)
            speed = self._speed if abs(aside) < 0.5 else 0.0
        velocity = (speed * math.cos(yaw), speed * math.sin(yaw), turning)
        # Velocities alone would let a contact push people about; positions alone would be jumps for it.
        data.qpos[self._qpos] = (x + velocity[0] * seconds, y + velocity[1] * seconds, wrap(yaw + turning * seconds))
        data.qvel[self._dofs] = 0.0
        if self._arm is not None:
            angle, rate = self._arm
            data.qpos[angle] = WAVE_SWING * math.sin(2 * math.pi * WAVE_HZ * data.time)
            data.qvel[rate] = 0.0


def _first_yaw(person: Person) -> float:
    """In which direction somebody looks in the beginning, rad, map frame."""
    path = person.path
    return _direction(path[0], path[1]) if len(path) > 1 else math.radians(person.facing)


def _in_the_way(here: Point, yaw: float, robot: Pose) -> bool:
    there = (robot.x, robot.y)
    return math.dist(here, there) < BERTH and abs(wrap(_direction(here, there) - yaw)) < _AHEAD


def _direction(start: Point, end: Point) -> float:
    """rad, map frame."""
    return math.atan2(end[1] - start[1], end[0] - start[0])
