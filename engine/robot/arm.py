"""The arm's geometry: where hand and camera are for given joints, and which joints bring the hand to a place.

A yaw joint carries three hinges in one plane (shoulder, elbow, wrist) and a hand that rolls about its own axis. The
hand's *pitch* is the sum of the three hinges: 0 points up, π/2 forward, π straight down. With pitch and roll chosen,
the rest is two links in a plane and has two closed solutions, elbow up and elbow down; :meth:`ArmModel.reach` tries
pitches and solutions in the order of preference. Points are in the base frame, m.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Mount
from engine.robot.geometry import Point

ARM_JOINTS = ("yaw", "shoulder", "elbow", "wrist", "roll")
"""The five joints of the arm from base to gripper; with the gripper they are the six servos."""

Joints = tuple[float, float, float, float, float]
"""rad, in the order of ``ARM_JOINTS``; all zero is straight up, positive shoulder/elbow/wrist lean forward."""

ARM_INITIAL: Joints = (0.0, -1.1, 1.85, 1.05, 0.0)
"""The folded pose that the arm starts in and returns to: inside the hull, the camera looking ahead."""
ARM_UP: Joints = (0.0, 0.0, 0.0, 0.0, 0.0)
"""Straight up."""
ARM_DOWN: Joints = (0.0, 0.88, 1.5, 0.76, 0.0)
"""Reaching down in front of the hull, the gripper pointing at the floor."""

EDGE = 0.02
"""rad kept from the ends of the joints' ranges."""


@dataclass(frozen=True, slots=True)
class Grip:
    """Where the point between the fingertips is and how the hand points."""

    point: Point
    pitch: float  # rad: 0 up, π/2 forward, π down
    yaw: float  # rad, direction of the arm's plane
    roll: float  # rad, of the hand about its own axis; at 0 the fingers open to the sides


@dataclass(frozen=True, slots=True)
class ArmModel:
    """One arm. ``eye`` is the camera's place on the wrist: the position in the wrist's frame; it looks along the hand,
    the picture's right is the wrist's right."""

    shoulder: Point  # where the shoulder axis crosses the yaw axis
    upper: float  # shoulder to elbow, m
    fore: float  # elbow to wrist, m
    hand: float  # wrist to the point between the fingertips, m
    jaw: float  # greatest opening between the fingers, m
    ranges: tuple[tuple[float, float], ...]  # rad, in the order of ``ARM_JOINTS``
    eye: Point

    @property
    def rest(self) -> Joints:
        """The folded pose, as far as this arm can take it."""
        return self.possible(ARM_INITIAL)

    def possible(self, joints: Joints) -> Joints:
        """The pose nearest to ``joints`` that is within the ranges."""
        yaw, shoulder, elbow, wrist, roll = (
            max(low, min(high, joint)) for joint, (low, high) in zip(joints, self.ranges, strict=True)
        )
        return yaw, shoulder, elbow, wrist, roll

    def grip(self, joints: Joints) -> Grip:
        """Forward kinematics."""
        yaw, shoulder, elbow, wrist, roll = joints
        pitch = shoulder + elbow + wrist
        radius, height = self._wrist_at(shoulder, elbow)
        radius += self.hand * math.sin(pitch)
        height += self.hand * math.cos(pitch)
        return Grip(self._out(yaw, radius, height), pitch, yaw, roll)

    def camera(self, joints: Joints) -> Mount:
        """Where the camera is, base frame."""
        yaw, shoulder, elbow, wrist, _ = joints
        pitch = shoulder + elbow + wrist
        radius, height = self._wrist_at(shoulder, elbow)
        turned = _about_z(yaw) @ _about_y(pitch)
        position = np.array(self._out(yaw, radius, height)) + turned @ np.array(self.eye)
        axes = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # right is −y, down is +x, ahead is +z
        return Mount(turned @ axes, position)

    def solve(self, point: Point, pitch: float, roll: float = 0.0) -> tuple[Joints, ...]:
        """The joints that bring the fingertips to ``point`` with this pitch: the elbow up first, none out of range."""
        x, y, z = point
        yaw = math.atan2(y - self.shoulder[1], x - self.shoulder[0])
        radius = math.hypot(x - self.shoulder[0], y - self.shoulder[1]) - self.hand * math.sin(pitch)
        height = z - self.shoulder[2] - self.hand * math.cos(pitch)
        way = math.hypot(radius, height)
        if not abs(self.upper - self.fore) < way < self.upper + self.fore:
            return ()
        bend = math.acos((way**2 - self.upper**2 - self.fore**2) / (2 * self.upper * self.fore))
        found = []
        for elbow in (bend, -bend):
            inner = math.atan2(self.fore * math.sin(elbow), self.upper + self.fore * math.cos(elbow))
            shoulder = math.atan2(radius, height) - inner
            joints = (yaw, shoulder, elbow, pitch - shoulder - elbow, roll)
            if self._within(joints):
                found.append(joints)
        return tuple(found)

    def reach(self, point: Point, pitches: Iterable[float], roll: float = 0.0) -> Joints | None:
        """The first solution for the first pitch that has one; None when the point is out of reach."""
        return next((joints for pitch in pitches for joints in self.solve(point, pitch, roll)), None)

    def _wrist_at(self, shoulder: float, elbow: float) -> tuple[float, float]:
        """Of the wrist: distance from the yaw axis and height."""
        radius = self.upper * math.sin(shoulder) + self.fore * math.sin(shoulder + elbow)
        height = self.upper * math.cos(shoulder) + self.fore * math.cos(shoulder + elbow)
        return radius, self.shoulder[2] + height

    def _out(self, yaw: float, radius: float, height: float) -> Point:
        return self.shoulder[0] + radius * math.cos(yaw), self.shoulder[1] + radius * math.sin(yaw), height

    def _within(self, joints: Joints) -> bool:
        pairs = zip(joints, self.ranges, strict=True)
        return all(low + EDGE <= joint <= high - EDGE for joint, (low, high) in pairs)


def _about_y(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def _about_z(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
