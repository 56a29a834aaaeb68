"""How the hand takes a thing, and how the camera looks at it: geometry alone, nothing moves here.

A grasp comes from above as long as the arm reaches that way, else along a slanted hand. The fingers close along the
sides of what has sides, low enough to hold it, high enough for the palm, and beside what stands close by.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Final

from engine.perception.memory import Thing
from engine.robot.arm import ArmModel, Joints
from engine.robot.geometry import Point, Pose
from engine.skills.approach import Reach
from engine.skills.hand import FINGER, FINGERTIP, PALM, from_map, nearest

PITCHES: Final = (math.pi, 2.95, 2.79, 2.6, 2.4, 2.2)
"""Of the hand, rad: straight down first, then more and more slanted."""
LIFTS: Final = (0.1, 0.07, 0.05, 0.03)
"""How high a thing is lifted, m, as far as the arm reaches."""
STANDOFF: Final = 0.085
"""m along the hand from which the fingers approach."""
VIEW_PITCHES: Final = (2.3, 2.4, 2.2, 2.5, 2.1, 2.65, 2.8)
"""rad, of a close look: from straight above nothing shows how tall it is."""
VIEW_DISTANCES: Final = (0.24, 0.22, 0.19, 0.27, 0.3, 0.16)
"""m between camera and thing in a close look."""
_SLANT_COST, _STRETCH_COST = 2.0, 6.0  # s per rad of slant, per m away from where the arm is at its best
_BEST = 0.27  # m from the base's centre
_UPRIGHT, _ROLLED = 0.1, 0.12  # sine of a slant that does not matter; how far a slanted hand rolls, times that sine
_TALL = 0.1  # m; what is taller is not taken straight from above, or it could not be put on a table again


@dataclass(frozen=True, slots=True)
class Grasp:
    """How the hand takes a thing."""

    point: Point  # between the fingertips, base frame, m
    pitch: float  # of the hand, rad
    joints: Joints  # there
    before: Joints  # with the fingers still away from it
    lift: float  # m
    opening: float  # between the fingers on the way, m

    @property
    def lifted(self) -> Point:
        x, y, z = self.point
        return x, y, z + self.lift


def grip_height(size: tuple[float, float], pitch: float = math.pi, aside: float = 0.0) -> float:
    """Where fingers take a thing of this width and height, m above what it stands on: in the middle, but with the
    fingertips free and the palm above it. ``aside`` m are how much lower one finger is than the other's middle."""
    slant = math.pi - pitch
    lowest = FINGERTIP * math.cos(slant) + FINGER[0] * math.sin(slant) + aside
    return max(lowest, size[1] / 2, size[1] - PALM)


def plan(arm: ArmModel, thing: Thing, pose: Pose, beside: Iterable[Thing] = ()) -> Grasp | None:
    """The best grasp of ``thing`` with the base at ``pose``, clear of the things ``beside`` it; None when there is
    none."""
    middle = from_map(pose, thing.position)
    neighbours = [
        (from_map(pose, other.position), other.size) for other in beside if other.distance_to(*thing.position[:2]) < 0.2
    ]
    width = min(thing.size[0], arm.jaw - 0.004)
    openings = (arm.jaw, width + 0.5 * (arm.jaw - width)) if neighbours else (arm.jaw,)
    for opening in openings:
        for pitch in PITCHES if thing.size[1] < _TALL else PITCHES[2:]:
            for roll in _rolls(arm, thing, pose, middle, pitch):
                grasp = _grasp(arm, thing, middle, pitch, roll, opening)
                if grasp is not None and _clear(grasp, roll, neighbours, thing.surface):
                    return grasp
    return None


def _rolls(arm: ArmModel, thing: Thing, pose: Pose, middle: Point, pitch: float) -> list[float]:
    """Of the hand, the least turned first: along the sides of what has sides, else any."""
    if thing.yaw is None or thing.kind in ("cup", "bottle", "ball"):
        return [0.0, 0.8, -0.8, 1.5, -1.5] if pitch == math.pi else [0.0]
    plane = math.atan2(middle[1] - arm.shoulder[1], middle[0] - arm.shoulder[0])
    # From above the fingers open along plane + π/2 − roll; of a slanted hand, one finger is lower then.
    turned = math.remainder(plane - (thing.yaw - pose.yaw), math.pi / 2)
    slant = math.sin(math.pi - pitch)
    if slant > _UPRIGHT:
        most = _ROLLED / slant
        return [max(-most, min(most, turned))]  # what is not aligned turns between the fingers
    low, high = arm.ranges[4]
    every = sorted((turned, turned + math.pi / 2, turned - math.pi / 2), key=abs)
    return [roll for roll in every if low + 0.03 < roll < high - 0.03]


def _grasp(arm: ArmModel, thing: Thing, middle: Point, pitch: float, roll: float, opening: float) -> Grasp | None:
    """With this pitch and roll; None when the arm cannot get there, or not from outside, or not up again."""
    x, y, _ = middle
    aside = (opening / 2 + FINGER[1]) * math.sin(math.pi - pitch) * abs(math.sin(roll))
    point = (x, y, thing.surface + grip_height(thing.size, pitch, aside))
    plane = math.atan2(y - arm.shoulder[1], x - arm.shoulder[0])
    there = arm.solve(point, pitch, roll)
    if not there:
        return None
    back = STANDOFF * math.sin(pitch)
    outside = (
        point[0] - back * math.cos(plane),
        point[1] - back * math.sin(plane),
        point[2] - STANDOFF * math.cos(pitch),
    )
    for joints in there:
        before = nearest(arm.solve(outside, pitch, roll), joints)
        if before is None or math.dist(before, joints) > 1.5:
            continue
        for lift in LIFTS:
            up = nearest(arm.solve((x, y, point[2] + lift), pitch, roll), joints)
            if up is not None and math.dist(up, joints) < 1.5:
                return Grasp(point, pitch, joints, before, lift, opening)
    return None


def _clear(grasp: Grasp, roll: float, neighbours: list[tuple[Point, tuple[float, float]]], surface: float) -> bool:
    """Whether the open fingers find room between the neighbours."""
    axis = grasp.joints[0] + math.pi / 2 - roll
    for (x, y, z), (width, height) in neighbours:
        if z + height / 2 < surface + 0.005:
            continue
        for side in (-1, 1):
            out = side * (grasp.opening + FINGER[1]) / 2
            fx, fy = grasp.point[0] + out * math.cos(axis), grasp.point[1] + out * math.sin(axis)
            # In the finger's own directions: across its thickness and along its pad.
            dx, dy = x - fx, y - fy
            across = abs(dx * math.cos(axis) + dy * math.sin(axis)) - FINGER[1] / 2
            along = abs(dy * math.cos(axis) - dx * math.sin(axis)) - FINGER[0]
            if math.hypot(max(across, 0.0), max(along, 0.0)) < 0.55 * width + 0.003:
                return False
    return True


def reach_of(arm: ArmModel, thing: Thing) -> Reach:
    """How comfortably this thing is grasped straight ahead, by distance."""
    ahead = Pose(0.0, 0.0, 0.0)

    def cost(distance: float) -> float | None:
        there = _shifted(thing, (distance, 0.0))
        grasp = plan(arm, there, ahead)
        if grasp is None or view(arm, (distance, 0.0, top_of(thing))) is None:
            return None
        return _SLANT_COST * (math.pi - grasp.pitch) + _STRETCH_COST * abs(distance - _BEST)

    return cost


def _shifted(thing: Thing, to: tuple[float, float]) -> Thing:
    return replace(thing, position=(*to, thing.position[2]), yaw=None)


def top_of(thing: Thing) -> float:
    """Height of its upper side, m."""
    return thing.surface + thing.size[1]


def view(
    arm: ArmModel,
    point: Point,
    *,
    pitches: Iterable[float] = VIEW_PITCHES,
    distances: Iterable[float] = VIEW_DISTANCES,
    fits: Callable[[Joints], bool] = lambda joints: True,
) -> Joints | None:
    """The joints from which the camera looks at ``point`` (base frame) from near; None when there are none, or none
    that ``fits``."""
    x, y, z = point
    plane = math.atan2(y - arm.shoulder[1], x - arm.shoulder[0])
    beside, _, along = arm.eye
    for pitch in pitches:
        for distance in distances:
            # Back along the line of sight to the camera, and from there to the fingertips.
            ahead = arm.hand - along - distance
            out = ahead * math.sin(pitch) - beside * math.cos(pitch)
            up = ahead * math.cos(pitch) + beside * math.sin(pitch)
            grip = (x + out * math.cos(plane), y + out * math.sin(plane), z + up)
            if (found := next(filter(fits, arm.solve(grip, pitch)), None)) is not None:
                return found
    return None
