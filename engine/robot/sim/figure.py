"""What the people of a scene look like: a mannequin in a posture, with a gesture, in the clothes that the scene says.

Its parts are given in a frame of its own (:class:`_Frame`), so that somebody who lies is made like somebody who stands.
Legs and trunk are solid for the robot and for nothing else: who sits on a sofa does not push it. A waving arm is a body
of its own on a hinge (:func:`waving_joint`); everything else of a figure is stiff.
"""

from __future__ import annotations

import itertools
import math
from typing import Final, NamedTuple

import mujoco

from engine.robot.sim.body import LOOSE, UNSEEN, Node
from engine.robot.sim.colours import rgba
from engine.robot.sim.dimensions import LIDAR_HEIGHT
from engine.robot.sim.scene_parts import Person

Vector = tuple[float, float, float]

WAVE_HZ: Final = 1.2
WAVE_SWING: Final = math.radians(25)
"""rad that a waving arm swings to either side of straight up."""

_LEFT, _RIGHT = 1, -1
_RAISED = {"waving": _RIGHT, "raising the left arm": _LEFT, "raising the right arm": _RIGHT}
_POINTING = {"pointing to the left": _LEFT, "pointing to the right": _RIGHT}
_HIP, _SHOULDER, _HEAD = 0.48, 0.82, 0.075  # of the height: above the soles, and the head's half
_ARM = 0.4  # of the height, shoulder to hand
_THIGH, _SHIN = 0.245, 0.24  # of the height
_APART, _ASIDE = 0.09, 0.235  # m of a leg, and of an arm, from the middle
_ROBOT = 2  # the contact bit of the robot's own geoms, which nothing else has
_G = mujoco.mjtGeom
_SKIN, _HAIR = "#d9a57f", "#4a3428"


def waving_joint(name: str) -> str:
    """Of somebody who waves: rad, 0 with the arm straight up, positive towards their right."""
    return f"{name} waves"


def add_figure(body: Node, name: str, person: Person) -> None:
    """Give a body, whose x axis is where the person looks (or where the head is, of one who lies), its parts."""
    frame = _frame(person)
    _trunk_and_head(body, frame, person)
    for side in (_LEFT, _RIGHT):
        _leg(body, frame, person, side)
        _arm(body, frame, name, person, side)


def holding_point(person: Person) -> Vector:
    """Where the middle of a thing is that they hold, in the frame of their body, m."""
    frame, side = _frame(person), holding_side(person)
    front, left, along = _hand(person, side)
    return frame.point(front + 0.08, left, along + (0.02 if _is_bent(person, side) else 0.0))


def holding_side(person: Person) -> int:
    """1 for the left hand, −1 for the right one, which it is unless that arm makes a gesture."""
    busy = _RAISED.get(person.gesture or "") or _POINTING.get(person.gesture or "")
    return _LEFT if busy == _RIGHT else _RIGHT


class _Frame(NamedTuple):
    """A figure's own frame: from between the hips to the front, to their left, and along the trunk to the head, m."""

    height: float  # of the hips above the floor, m
    lies: bool

    def point(self, front: float, left: float, along: float) -> Vector:
        """In the frame of the body."""
        if self.lies:
            return along, -left, self.height + front
        return front, left, self.height + along

    def extent(self, front: float, left: float, along: float) -> Vector:
        """Half sizes along the axes of the body."""
        return (along, left, front) if self.lies else (front, left, along)


def _frame(person: Person) -> _Frame:
    above = {"standing": _HIP * person.height, "sitting": person.seat + 0.08, "lying": person.seat + 0.11}
    return _Frame(above[person.posture], person.posture == "lying")


def _trunk_and_head(body: Node, frame: _Frame, person: Person) -> None:
    tall = person.height
    shoulder, head = (_SHOULDER - _HIP) * tall, _HEAD * tall
    top = (1 - _HIP) * tall

    def round_part(at: Vector, half: Vector, colour: str) -> None:
        _part(body, _G.mjGEOM_ELLIPSOID, frame.point(*at), frame.extent(*half), colour)

    round_part((0, 0, 0), (0.11, 0.165, 0.13), person.trousers)
    trunk = frame.extent(0.1, 0.18, shoulder / 2 + 0.02)
    _part(body, _G.mjGEOM_BOX, frame.point(0, 0, shoulder / 2), trunk, person.shirt, mass=40)
    neck = frame.point(0, 0, shoulder - 0.03), frame.point(0, 0, shoulder + 0.07)
    _limb(body, *neck, 0.045, _SKIN)
    round_part((0, 0, top - head), (0.8 * head, 0.75 * head, head), _SKIN)
    round_part((-0.02, 0, top - 0.8 * head), (0.8 * head, 0.8 * head, 0.85 * head), _HAIR)


def _leg(body: Node, frame: _Frame, person: Person, side: int) -> None:
    left, tall = side * _APART, person.height
    if person.posture != "sitting":
        sole = -_HIP * tall
        foot = frame.extent(0.12, 0.045, 0.035)
        _part(body, _G.mjGEOM_BOX, frame.point(0.03, left, sole + 0.035), foot, "black")
        ends = frame.point(0, left, sole), frame.point(0, left, 0)
        _limb(body, *ends, 0.058, person.trousers, kind=_G.mjGEOM_CYLINDER, mass=12)
        return
    knee, shin = _THIGH * tall, _SHIN * tall
    down = min(frame.height, shin + 0.06)  # a seat that is higher lets the feet dangle; a lower one stretches the legs
    out = math.sqrt(max(0.0, shin**2 - down**2))
    _limb(body, frame.point(0, left, 0), frame.point(knee, left, 0), 0.07, person.trousers, mass=7)
    ankle = frame.point(knee + out, left, 0.06 - down)
    _limb(body, frame.point(knee, left, 0), ankle, 0.055, person.trousers, mass=5)
    _part(body, _G.mjGEOM_BOX, (ankle[0] + 0.05, left, ankle[2] - 0.025), (0.12, 0.045, 0.035), "black")


def _arm(body: Node, frame: _Frame, name: str, person: Person, side: int) -> None:
    """Down along the trunk, into the lap, bent before them with something in it, or as the gesture says."""
    shoulder = (0.0, side * _ASIDE, (_SHOULDER - _HIP) * person.height - 0.03)
    hand = _hand(person, side)
    ends = [frame.point(*shoulder), frame.point(*hand)]
    if _RAISED.get(person.gesture or "") == side:
        ends[1] = (ends[0][0], ends[0][1], ends[0][2] + _ARM * person.height)
        if person.gesture == "waving":
            body, ends = _waving_arm(body, name, ends[0]), [(0, 0, 0), (0, 0, _ARM * person.height)]
    elif _is_bent(person, side):
        ends.insert(1, frame.point(*_elbow(person, side)))
    for start, end in itertools.pairwise(ends):
        _limb(body, start, end, 0.04, person.shirt, shade=0.9)
    _part(body, _G.mjGEOM_SPHERE, ends[-1], (0.045, 0, 0), _SKIN)


def _waving_arm(body: Node, name: str, shoulder: Vector) -> Node:
    """A body that turns about the axis in which the person looks. Gravity does not pull at it, or it would pull them
    about; what it weighs, a moving body must."""
    arm = body.add_body(name=waving_joint(name), pos=shoulder, gravcomp=1)
    arm.add_joint(name=waving_joint(name), type=mujoco.mjtJoint.mjJNT_HINGE, axis=[1, 0, 0])
    weight = arm.add_geom(type=_G.mjGEOM_SPHERE, pos=[0, 0, 0.2], size=[0.03, 0, 0], mass=3, rgba=[0, 0, 0, 0])
    weight.group, weight.contype, weight.conaffinity = UNSEEN, 0, 0
    return arm


def _hand(person: Person, side: int) -> Vector:
    """Where a hand is that is not raised, in the figure's own frame."""
    shoulder = (_SHOULDER - _HIP) * person.height - 0.03
    if _POINTING.get(person.gesture or "") == side:
        return 0.0, side * (_ASIDE + _ARM * person.height), shoulder
    if _is_bent(person, side):
        front, left, along = _elbow(person, side)
        if person.posture == "sitting":
            return front + 0.2 * person.height, side * _APART, 0.1
        return front + 0.18 * person.height, left, along + 0.02
    return 0.01, side * _ASIDE, shoulder - _ARM * person.height


def _elbow(person: Person, side: int) -> Vector:
    shoulder = (_SHOULDER - _HIP) * person.height - 0.03
    return -0.02, side * _ASIDE, max(0.13, shoulder - 0.2 * person.height)


def _is_bent(person: Person, side: int) -> bool:
    holds = person.holds is not None and side == holding_side(person)
    return person.posture == "sitting" or (holds and person.posture == "standing")


def _limb(
    body: Node,
    start: Vector,
    end: Vector,
    radius: float,
    colour: str,
    *,
    kind: Node = _G.mjGEOM_CAPSULE,
    shade: float = 1.0,
    mass: float = 0.0,
) -> None:
    geom = body.add_geom(type=kind, fromto=[*start, *end], size=[radius, 0, 0])
    round_end = 0.0 if kind == _G.mjGEOM_CYLINDER and start[:2] == end[:2] else radius
    low, high = min(start[2], end[2]) - round_end, max(start[2], end[2]) + round_end
    _finish(geom, low, high, colour, shade, mass)


def _part(body: Node, kind: Node, at: Vector, size: Vector, colour: str, *, mass: float = 0.0) -> None:
    geom = body.add_geom(type=kind, pos=at, size=size)
    half = size[0] if kind == _G.mjGEOM_SPHERE else size[2]
    _finish(geom, at[2] - half, at[2] + half, colour, 1.0, mass)


def _finish(geom: Node, low: float, high: float, colour: str, shade: float, mass: float) -> None:
    """What has a mass is solid for the robot; the rest is for the eye. The lidar sees what its plane crosses."""
    geom.rgba, geom.mass = rgba(colour, shade=shade), mass
    geom.group = LOOSE if low <= LIDAR_HEIGHT <= high else UNSEEN
    geom.contype, geom.conaffinity = 0, _ROBOT if mass else 0
