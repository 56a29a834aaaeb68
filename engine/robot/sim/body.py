"""The robot's body in MuJoCo primitives: a mecanum base, an arm of five joints, a gripper and a camera.

The base is a planar body with three velocity actuators, because a mecanum base can push in x, y and yaw alike; the
wheels are for the eye. The force limits give it the deceleration of the real machine: 0.3 m/s to rest in about
50 ms. The gripper's contact parameters (condim 4, friction 1.5, ±12 N, kp 600) were tuned for grasping by contact.

Geoms carry a group, so that the lidar's rays can leave the robot itself out.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco

from engine.robot.arm import ARM_INITIAL, ARM_JOINTS
from engine.robot.geometry import Pose
from engine.robot.sim.colours import rgba
from engine.robot.sim.dimensions import (
    CAMERA_OFFSET,
    CAMERA_VIEW,
    FINGER_TRAVEL,
    FOOTPRINT,
    FOREARM,
    HAND,
    JOINT_RANGES,
    SHOULDER,
    UPPER_ARM,
)

FIXED, LOOSE, UNSEEN = 0, 1, 2
"""Geom groups: what is fixed, loose objects, and what the lidar cannot meet: the robot itself, and everything fixed
that its plane does not cross (left out because 300 geoms cost 0.6 ms a scan)."""

BASE_JOINTS = ("base x", "base y", "base yaw")
CAMERA = "camera"
GRIP_SITE = "grip"
LIGHT_GEOM = "robot light"

_SLIDE, _HINGE = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
_BOX, _CYLINDER = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
_BASE_KV, _BASE_FORCE = 400.0, 40.0  # N·s/m and N: what tyres hold on a floor with 4.2 kg
_YAW_KV, _YAW_TORQUE = 6.0, 4.0  # N·m·s/rad and N·m
_ARM_KP = (40.0, 60.0, 40.0, 20.0, 8.0)  # N·m/rad
_ARM_TORQUE = (8.0, 10.0, 7.0, 4.0, 2.0)  # N·m
_FINGER_KP, _FINGER_FORCE = 600.0, 12.0  # N/m and N, each finger

Node = Any
"""A body, geom or actuator of ``MjSpec``; mujoco has no types for them."""


def add_robot(spec: Node) -> None:
    """Put the robot into a scene. Its base joints are its pose in the map frame (see :func:`initial_qpos`)."""
    base = spec.worldbody.add_body(name="base")
    for name, kind, axis in zip(BASE_JOINTS, (_SLIDE, _SLIDE, _HINGE), ([1, 0, 0], [0, 1, 0], [0, 0, 1]), strict=True):
        base.add_joint(name=name, type=kind, axis=axis)
    _hull(base)
    _arm(spec, base)
    _actuators(spec)


def initial_qpos(model: Node, data: Node, pose: Pose) -> None:
    """Stand at ``pose`` with the arm folded and the gripper half open."""
    values = [pose.x, pose.y, pose.yaw, *ARM_INITIAL, FINGER_TRAVEL / 2, FINGER_TRAVEL / 2]
    names = (*BASE_JOINTS, *ARM_JOINTS, "finger left", "finger right")
    for name, value in zip(names, values, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value


def _solid(
    body: Node,
    kind: Node,
    at: tuple[float, float, float],
    size: tuple[float, ...],
    colour: str,
    *,
    shade: float = 1.0,
    mass: float = 0.0,
    name: str = "",
    turned: tuple[float, float, float] | None = None,
    contact: bool = False,
) -> Node:
    """A geom of the robot; those without contact are for the eye only."""
    geom = body.add_geom(
        type=kind,
        pos=at,
        size=[*size, *[0.0] * (3 - len(size))],
        rgba=rgba(colour, shade=shade),
        mass=mass,
        group=UNSEEN,
    )
    if name:
        geom.name = name
    if turned is not None:
        geom.alt.type, geom.alt.euler = mujoco.mjtOrientation.mjORIENTATION_EULER, turned
    # The robot's own parts never collide with one another: bit 2 meets only the world's conaffinity.
    geom.contype, geom.conaffinity = (2, 1) if contact else (0, 0)
    return geom


def _hull(base: Node) -> None:
    half_length, half_width = FOOTPRINT.length / 2, FOOTPRINT.width / 2
    _solid(base, _BOX, (0, 0, 0.07), (half_length, half_width, 0.03), "slate", mass=3.6, name="hull", contact=True)
    # The contact box is hidden inside what is seen: a chassis between the wheels, a deck and two bumpers.
    base.geoms[-1].rgba = [0, 0, 0, 0]
    _solid(base, _BOX, (0, 0, 0.062), (0.135, 0.075, 0.03), "slate", shade=0.8)
    _solid(base, _BOX, (0, 0, 0.097), (0.142, 0.116, 0.005), "orange")
    _solid(base, _BOX, (0, 0, 0.106), (0.13, 0.09, 0.004), "black", shade=1.2)
    for front in (-1, 1):
        _solid(base, _BOX, (front * 0.143, 0, 0.06), (0.007, 0.085, 0.016), "black")
        for side in (-1, 1):
            _wheel(base, front, side)
    _solid(base, _CYLINDER, (-0.085, 0, 0.121), (0.034, 0.011), "black")
    _solid(base, _CYLINDER, (-0.085, 0, 0.137), (0.031, 0.006), "steel", shade=0.7)
    _solid(base, _BOX, (0.146, 0, 0.081), (0.004, 0.06, 0.005), "white", name=LIGHT_GEOM)


def _wheel(base: Node, front: int, side: int) -> None:
    """A mecanum wheel: tyre, hub, and rollers at 45° as dark bars on the tread."""
    x, y, radius = front * 0.092, side * 0.097, 0.042
    flat = (math.pi / 2, 0.0, 0.0)
    _solid(base, _CYLINDER, (x, y, radius), (radius - 0.004, 0.02), "black", turned=flat)
    _solid(base, _CYLINDER, (x, y + side * 0.0205, radius), (0.022, 0.002), "orange", turned=flat)
    _solid(base, _CYLINDER, (x, y + side * 0.0215, radius), (0.008, 0.0015), "steel", turned=flat)
    for i in range(10):
        angle = 2 * math.pi * i / 10
        at = (x + 0.037 * math.sin(angle), y, radius + 0.037 * math.cos(angle))
        bar = _solid(base, mujoco.mjtGeom.mjGEOM_CAPSULE, at, (0.006, 0.017), "grey", shade=0.75)
        # Roller axis: 45° between the wheel axis (y) and the tread's own direction at this angle.
        slant = front * side * math.sqrt(0.5)
        bar.alt.type = mujoco.mjtOrientation.mjORIENTATION_ZAXIS
        bar.alt.zaxis = [slant * math.cos(angle), math.sqrt(0.5), -slant * math.sin(angle)]


def _arm(spec: Node, base: Node) -> None:
    turret = base.add_body(name="turret", pos=[SHOULDER[0], SHOULDER[1], 0.11], gravcomp=1)
    _hinge(turret, 0)
    _solid(turret, _CYLINDER, (0, 0, 0.012), (0.038, 0.012), "black", shade=1.3, mass=0.12)
    _solid(turret, _BOX, (0, 0, 0.045), (0.02, 0.026, 0.025), "steel", mass=0.08)

    upper = turret.add_body(name="upper arm", pos=[0, 0, SHOULDER[2] - 0.11], gravcomp=1)
    _hinge(upper, 1)
    _joint_cap(upper)
    _solid(upper, _BOX, (0, 0, UPPER_ARM / 2), (0.016, 0.012, UPPER_ARM / 2), "orange", mass=0.12, contact=True)

    fore = upper.add_body(name="forearm", pos=[0, 0, UPPER_ARM], gravcomp=1)
    _hinge(fore, 2)
    _joint_cap(fore)
    _solid(fore, _BOX, (0, 0, FOREARM / 2), (0.014, 0.011, FOREARM / 2), "steel", mass=0.09, contact=True)

    wrist = fore.add_body(name="wrist", pos=[0, 0, FOREARM], gravcomp=1)
    _hinge(wrist, 3)
    _joint_cap(wrist)
    _solid(wrist, _BOX, (0, 0, 0.018), (0.015, 0.018, 0.014), "black", shade=1.3, mass=0.06)
    # The camera rides on the wrist, above the hand when the arm leans forward (local −x is up then).
    _solid(wrist, _BOX, (-0.036, 0, 0.014), (0.012, 0.03, 0.01), "black", mass=0.02)
    _solid(wrist, _CYLINDER, (-0.036, 0, 0.025), (0.008, 0.003), "blue", shade=0.6)
    camera = wrist.add_camera(name=CAMERA, pos=CAMERA_OFFSET, fovy=math.degrees(CAMERA_VIEW))
    camera.alt.type = mujoco.mjtOrientation.mjORIENTATION_XYAXES
    camera.alt.xyaxes = [0, -1, 0, -1, 0, 0]  # looks along local +z, the picture's right is −y and its top −x

    hand = wrist.add_body(name="hand", pos=[0, 0, 0.034], gravcomp=1)
    _hinge(hand, 4)
    _solid(hand, _CYLINDER, (0, 0, 0.006), (0.016, 0.006), "steel")
    _solid(hand, _BOX, (0, 0, 0.02), (0.014, 0.045, 0.009), "slate", mass=0.05, contact=True)
    hand.add_site(name=GRIP_SITE, pos=[0, 0, HAND - 0.034], size=[0.004, 0.004, 0.004], group=4)
    for name, side in (("left", 1), ("right", -1)):
        finger = hand.add_body(name=f"{name} finger", pos=[0, 0, 0.03], gravcomp=1)
        joint = finger.add_joint(name=f"finger {name}", type=_SLIDE, axis=[0, side, 0], range=[0, FINGER_TRAVEL])
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.damping, joint.armature = [2.0, 0, 0], 0.02
        pad = _solid(
            finger, _BOX, (0, side * 0.005, 0.045), (0.011, 0.005, 0.045), "black", shade=1.4, mass=0.02, contact=True
        )
        pad.condim, pad.friction = 4, [1.5, 0.02, 0.0001]
        pad.solref, pad.priority = [0.008, 1.0], 1


def _hinge(body: Node, index: int) -> None:
    axis = [0, 0, 1] if index in (0, 4) else [0, 1, 0]
    joint = body.add_joint(name=ARM_JOINTS[index], type=_HINGE, axis=axis, range=JOINT_RANGES[index])
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    joint.armature = 0.01


def _joint_cap(body: Node) -> None:
    _solid(body, _CYLINDER, (0, 0, 0), (0.02, 0.024), "black", shade=1.3, turned=(math.pi / 2, 0, 0), mass=0.02)


def _actuators(spec: Node) -> None:
    for name, kv, limit in zip(
        BASE_JOINTS, (_BASE_KV, _BASE_KV, _YAW_KV), (_BASE_FORCE, _BASE_FORCE, _YAW_TORQUE), strict=True
    ):
        _actuator(spec, name, limit).set_to_velocity(kv)
    for name, kp, limit in zip(ARM_JOINTS, _ARM_KP, _ARM_TORQUE, strict=True):
        _actuator(spec, name, limit).set_to_position(kp, dampratio=1.0)
    # One motor drives both fingers through a differential, as in a real gripper: each gets half of its force.
    tendon = spec.add_tendon(name="gripper")
    tendon.wrap_joint("finger left", 0.5)
    tendon.wrap_joint("finger right", 0.5)
    motor = _actuator(spec, "gripper", 2 * _FINGER_FORCE)
    motor.trntype = mujoco.mjtTrn.mjTRN_TENDON
    motor.set_to_position(2 * _FINGER_KP, kv=4.0)
    equality = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT, name1="finger left", name2="finger right", objtype=mujoco.mjtObj.mjOBJ_JOINT
    )
    equality.data[:2] = [0.0, 1.0]
    equality.solref = [0.004, 1.0]


def _actuator(spec: Node, target: str, limit: float) -> Node:
    actuator = spec.add_actuator(name=target, target=target, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.forcerange = [-limit, limit]
    actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    return actuator
