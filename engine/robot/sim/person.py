"""Where the people of a scene are: each is a mannequin on three planar joints, moved step by step.

The joints are ordinary coordinates of the simulation, so that whoever copies those (the camera) sees people where
they are. Nobody pushes a person: each step puts them where they have walked to, and they touch nothing else.
"""

from __future__ import annotations

import math
from typing import Any, Final

import mujoco

from engine.robot.geometry import Pose, wrap
from engine.robot.sim.body import Node
from engine.robot.sim.figure import WAVE_HZ, WAVE_SWING, Vector, add_figure, holding_point, waving_joint
from engine.robot.sim.free_floor import direction
from engine.robot.sim.scene_parts import Person
from engine.robot.sim.walking import Walk

TURN_SPEED: Final = 2.0
"""rad/s."""

_JOINTS = ("x", "y", "yaw")
_FACES = 0.5  # rad off their way at which somebody walks; before, they turn


def add_person(spec: Node, name: str, person: Person) -> None:
    """Put somebody at the beginning of their path; the joints are their pose in the map frame, at the first moment too,
    for whoever looks at a scene in which nobody walks."""
    begin = first_pose(person)
    c, s = math.cos(begin.yaw), math.sin(begin.yaw)
    turn = [math.cos(begin.yaw / 2), 0, 0, math.sin(begin.yaw / 2)]
    body = spec.worldbody.add_body(
        name=name, pos=[begin.x, begin.y, 0], quat=turn, sleep=mujoco.mjtSleepPolicy.mjSLEEP_NEVER
    )
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    axes = ([c, -s, 0], [s, c, 0], [0, 0, 1])  # those of the map, seen from the body
    refs = (begin.x, begin.y, begin.yaw)
    for joint, kind, axis, ref in zip(_JOINTS, (slide, slide, hinge), axes, refs, strict=True):
        body.add_joint(name=f"{name} {joint}", type=kind, axis=axis, ref=ref)
    add_figure(body, name, person)


def first_pose(person: Person) -> Pose:
    """Where somebody is in the beginning."""
    path = person.path
    yaw = direction(path[0], path[1]) if len(path) > 1 else math.radians(person.facing)
    return Pose(*path[0], wrap(yaw))


def in_hand(person: Person, pose: Pose, index: int = 0) -> Vector:
    """Where the middle of a thing is that they hold, the first or a later one of several, map frame, m."""
    front, left, height = holding_point(person)
    left -= math.copysign(0.1 * index, left)
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return pose.x + c * front - s * left, pose.y + s * front + c * left, height


class Mover:
    """Moves one person."""

    def __init__(self, model: Any, data: Any, name: str, person: Person) -> None:
        joints = [model.joint(f"{name} {joint}") for joint in _JOINTS]
        at, dof = int(joints[0].qposadr[0]), int(joints[0].dofadr[0])
        # Views of the simulation's own numbers: they are read and written in every step.
        self._qpos, self._qvel = data.qpos[at : at + 3], data.qvel[dof : dof + 3]
        self._data = data
        self._arm: tuple[int, int] | None = None  # place of the angle and of the speed of one that waves
        if person.gesture == "waving":
            arm = model.joint(waving_joint(name))
            self._arm = int(arm.qposadr[0]), int(arm.dofadr[0])

    @property
    def pose(self) -> Pose:
        x, y, yaw = self._qpos.tolist()
        return Pose(x, y, yaw)

    def put(self, pose: Pose) -> None:
        """Stand there."""
        self._qpos[:] = pose.x, pose.y, pose.yaw

    def step(self, walk: Walk | None, seconds: float) -> float:
        """Walk for so long, or stand; returns how far that was, m."""
        metres = self._walk(walk, seconds) if walk is not None else 0.0
        # Velocities alone would let a contact push people about; positions alone would be jumps for it.
        self._qvel[:] = 0.0
        if self._arm is not None:
            angle, rate = self._arm
            self._data.qpos[angle] = WAVE_SWING * math.sin(2 * math.pi * WAVE_HZ * self._data.time)
            self._data.qvel[rate] = 0.0
        return metres

    def _walk(self, walk: Walk, seconds: float) -> float:
        x, y, yaw = self._qpos.tolist()
        way = direction((x, y), walk.to)
        metres = min(walk.speed * seconds, math.dist((x, y), walk.to))
        if not walk.sideways:
            off = wrap(way - yaw)
            yaw = wrap(yaw + math.copysign(min(TURN_SPEED * seconds, abs(off)), off))
            if abs(off) > _FACES:
                metres = 0.0
            way = yaw
        self._qpos[:] = x + metres * math.cos(way), y + metres * math.sin(way), yaw
        return metres
