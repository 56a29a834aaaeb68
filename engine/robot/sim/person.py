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
from engine.robot.sim.body import LOOSE, UNSEEN, Node
from engine.robot.sim.colours import rgba
from engine.robot.sim.dimensions import LIDAR_HEIGHT
from engine.robot.sim.scene_parts import Person, Point

TURN_SPEED = 2.0
"""rad/s."""
BERTH = 0.5
"""How near to the robot's middle somebody walks on, m."""

_AHEAD = math.radians(75)  # to either side: where somebody looks while walking
_ARRIVED = 0.05  # m from a point of the path
_JOINTS = ("x", "y", "yaw")
_ROBOT = 2  # the contact bit of the robot's own geoms, which nothing else has
_G = mujoco.mjtGeom
_SKIN, _HAIR = "#d9a57f", "#4a3428"


def add_person(spec: Node, name: str, person: Person) -> None:
    """Put somebody at the beginning of their path; the joints are their pose in the map frame."""
    x, y = person.path[0]
    body = spec.worldbody.add_body(name=name, pos=[x, y, 0], sleep=mujoco.mjtSleepPolicy.mjSLEEP_NEVER)
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    axes = ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    for joint, kind, axis, ref in zip(_JOINTS, (slide, slide, hinge), axes, (x, y, 0.0), strict=True):
        body.add_joint(name=f"{name} {joint}", type=kind, axis=axis, ref=ref)
    _figure(body, person)


def _figure(body: Node, person: Person) -> None:
    """Legs, trunk, arms and head, in the proportions of a grown-up; looks along x."""
    tall = person.height
    leg, shoulder, head = 0.48 * tall, 0.82 * tall, 0.075 * tall
    for side in (-1, 1):
        _part(body, _G.mjGEOM_BOX, (0.03, side * 0.09, 0.035), (0.12, 0.045, 0.035), "black")
        _part(body, _G.mjGEOM_CYLINDER, (0, side * 0.09, leg / 2), (0.058, leg / 2, 0), person.trousers, mass=12)
        arm = (shoulder - 0.42 * tall) / 2
        _part(
            body, _G.mjGEOM_CAPSULE, (0, side * 0.235, shoulder - arm), (0.04, arm - 0.02, 0), person.shirt, shade=0.9
        )
        _part(body, _G.mjGEOM_SPHERE, (0.01, side * 0.235, shoulder - 2 * arm - 0.03), (0.045, 0, 0), _SKIN)
    middle, half = (leg + shoulder) / 2, (shoulder - leg) / 2 + 0.02
    _part(body, _G.mjGEOM_ELLIPSOID, (0, 0, leg), (0.11, 0.165, 0.13), person.trousers)
    _part(body, _G.mjGEOM_BOX, (0, 0, middle), (0.1, 0.18, half), person.shirt, mass=40)
    _part(body, _G.mjGEOM_CYLINDER, (0, 0, shoulder + 0.02), (0.045, 0.05, 0), _SKIN)
    _part(body, _G.mjGEOM_ELLIPSOID, (0, 0, tall - head), (0.8 * head, 0.75 * head, head), _SKIN)
    _part(body, _G.mjGEOM_ELLIPSOID, (-0.02, 0, tall - 0.8 * head), (0.8 * head, 0.8 * head, 0.85 * head), _HAIR)


def _part(
    body: Node,
    kind: Node,
    at: tuple[float, float, float],
    size: tuple[float, float, float],
    colour: str,
    *,
    shade: float = 1.0,
    mass: float = 0.0,
) -> None:
    """What has a mass is solid for the robot; the rest is for the eye."""
    geom = body.add_geom(type=kind, pos=at, size=size, rgba=rgba(colour, shade=shade), mass=mass)
    low = at[2] - (size[1] if kind == _G.mjGEOM_CYLINDER else size[2])
    geom.group = LOOSE if low <= LIDAR_HEIGHT <= 2 * at[2] - low else UNSEEN
    geom.contype, geom.conaffinity = 0, _ROBOT if mass else 0


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
        self._path, self._speed, self._facing = person.path, person.speed, math.radians(person.facing)
        self._towards = 0

    def begin(self, data: Any, *, again: bool) -> None:
        path = self._path
        self._towards = 1 % len(path)
        if not again:
            yaw = _direction(path[0], path[self._towards]) if len(path) > 1 else self._facing
            data.qpos[self._qpos] = (*path[0], yaw)
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


def _in_the_way(here: Point, yaw: float, robot: Pose) -> bool:
    there = (robot.x, robot.y)
    return math.dist(here, there) < BERTH and abs(wrap(_direction(here, there) - yaw)) < _AHEAD


def _direction(start: Point, end: Point) -> float:
    """rad, map frame."""
    return math.atan2(end[1] - start[1], end[0] - start[0])
