"""Where what is held can be put down, and the joints that bring it there: geometry alone, nothing moves here.

A spot is free as far as the map and the memory know, and then as far as a picture shows it. It is in reach where the
camera can look at it and the hand can lower the thing onto it, pointing as it did when it took it.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from engine.perception.memory import Thing
from engine.robot.arm import Joints
from engine.robot.camera import Picture
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Point
from engine.skills.aim import grip_height, view
from engine.skills.approach import Reach, outlines
from engine.skills.context import SkillContext
from engine.skills.hand import from_map, nearest, on_map
from engine.skills.strewn import FEET

MOST: Final = 6
"""Spots that are tried before there is no room."""
_DECK = 0.14  # m, height of the hull and what is on it
_EDGE = 0.02  # m between a thing and the edge of what it stands on
_APART = 0.035  # m between a thing and its neighbours
_SPOT = 0.04  # m between the spots that are considered
_HAND = 0.1  # m between a thing and walls or furniture: the hand must find room there, too
_ABOVE = 0.07  # m over the spot from which a thing is lowered
_LEANS = (0.0, -0.15, 0.15, -0.3, 0.3)  # rad off upright from which things still come to stand when let go
_VIEW_PITCHES, _VIEW_DISTANCES = (2.7, 2.85, 2.55, 2.4, 3.0), (0.27, 0.3, 0.24, 0.33, 0.21)  # rad, m
_STICKS_UP, _ASIDE = 0.05, 0.3  # m above the fingers, and rad to the side that the camera then looks from


def spots_on_floor(context: SkillContext, held: Thing) -> list[Point]:
    """Free spots on the floor as far as map and memory know: before the robot, then around it."""
    pose = context.pose
    found: list[Point] = []
    ahead = [
        (0.05 + d * math.cos(a), d * math.sin(a)) for d in (0.22, 0.25, 0.28) for a in (0.0, 0.35, -0.35, 0.7, -0.7)
    ]
    around = [
        (d * math.cos(a), d * math.sin(a)) for d in (0.45, 0.7) for a in np.arange(-math.pi, math.pi, math.pi / 6)
    ]
    for x, y in (*ahead, *sorted(around, key=lambda at: abs(math.atan2(at[1], at[0])))):
        spot = on_map(pose, (float(x), float(y), 0.0))
        if _is_free_by_map(context, held, spot) and len(found) < MOST:
            found.append(spot)
    return [spot for spot in found if is_reachable(context, held, spot)] + [
        spot for spot in found if not is_reachable(context, held, spot)
    ]


def spots_on(context: SkillContext, held: Thing, piece: Furniture) -> list[Point]:
    """Free spots on a piece of furniture as far as the memory knows, the nearest to its edge and to the robot first."""
    margin = held.size[0] / 2 + _EDGE
    pose = context.pose

    def inwards(spot: Point) -> float:
        x, y, _ = spot
        return min(x - piece.x_min, piece.x_max - x, y - piece.y_min, piece.y_max - y)

    xs = np.arange(piece.x_min + margin, piece.x_max - margin + 1e-6, _SPOT)
    ys = np.arange(piece.y_min + margin, piece.y_max - margin + 1e-6, _SPOT)
    every = [(float(x), float(y), piece.height) for x in xs for y in ys]
    free = [spot for spot in every if is_free_by_memory(context, held, spot)]
    return sorted(free, key=lambda spot: 5 * max(0.0, inwards(spot) - 0.08) + math.dist(spot[:2], (pose.x, pose.y)))


def is_free_by_memory(context: SkillContext, held: Thing, spot: Point) -> bool:
    """Whether the thing would stand apart from all others there that are remembered, and from people's feet."""
    people = context.world.people.everybody if spot[2] < 0.05 else ()
    return all(person.distance_to(*spot[:2]) > FEET for person in people) and all(
        thing.distance_to(*spot[:2]) > (thing.size[0] + held.size[0]) / 2 + _APART
        for thing in context.world.things
        if abs(thing.surface - spot[2]) < 0.05
    )


def is_free_by_sight(picture: Picture, held: Thing, spot: Point) -> bool:
    """Whether the picture shows the bare surface there; what the hand hides is not counted."""
    optical = picture.lens.grid() * picture.depth.ravel().astype(np.float64)[:, None]
    behind_hand = picture.depth.ravel() > 0.16
    points = picture.on_map(picture.mount.out(optical[behind_hand & np.isfinite(picture.depth.ravel())]))
    near = points[np.hypot(points[:, 0] - spot[0], points[:, 1] - spot[1]) < held.size[0] / 2 + _EDGE]
    return len(near) > 20 and float(np.mean(np.abs(near[:, 2] - spot[2]) > 0.012)) < 0.02


def is_reachable(context: SkillContext, held: Thing, spot: Point) -> bool:
    """Whether the thing can be put on ``spot`` (map frame) from where the robot stands."""
    here = from_map(context.pose, spot)
    in_front = here[0] > context.robot.footprint.length / 2 + held.size[0] / 2 + 0.01
    return in_front and lowering(context, held, here) is not None and viewpoint(context, held, here) is not None


def reach_of(context: SkillContext, held: Thing, height: float) -> Reach:
    """How comfortably the thing is put down straight ahead at this height, by distance."""

    def cost(distance: float) -> float | None:
        spot = (distance, 0.0, height)
        possible = lowering(context, held, spot) is not None and viewpoint(context, held, spot) is not None
        return 6.0 * abs(distance - 0.29) if possible else None

    return cost


def hanging_of(context: SkillContext, held: Thing) -> float:
    """How far it reaches below the point between the fingertips, m."""
    return grip_height(held.size, context.world.held_pitch)


def lowering(context: SkillContext, held: Thing, spot: Point) -> tuple[Joints, Point] | None:
    """To put the thing on ``spot`` (base frame): the joints above it, and where the fingertips go."""
    arm = context.robot.arm
    x, y, z = spot
    hanging, radius = hanging_of(context, held), held.size[0] / 2
    for lean in _LEANS:
        pitch = context.world.held_pitch + lean
        high = z + hanging * math.cos(lean) + radius * abs(math.sin(lean))
        for roll in (0.0, 0.5, -0.5):
            for joints in arm.solve((x, y, high), pitch, roll):
                for above in (_ABOVE, 0.05, 0.035):
                    before = nearest(arm.solve((x, y, high + above), pitch, roll), joints)
                    if before is not None and math.dist(before, joints) < 1.5:
                        return before, (x, y, high)
    return None


def viewpoint(context: SkillContext, held: Thing, spot: Point) -> Joints | None:
    """The joints from which the camera sees ``spot`` (base frame) and what is held stays clear of it."""
    arm, hull = context.robot.arm, context.robot.footprint
    hanging, radius = hanging_of(context, held), held.size[0] / 2

    def clear(joints: Joints) -> bool:
        """Whether both ends of what is held are above the spot, and before the hull or above it."""
        grip = arm.grip(joints)
        lean = grip.pitch - context.world.held_pitch  # 0: upright
        out, down = -hanging * math.sin(lean), -hanging * math.cos(lean)
        x, y, z = grip.point
        lowest = (x + out * math.cos(grip.yaw), y + out * math.sin(grip.yaw), z + down)
        ends = (grip.point, lowest)
        return all(
            end[2] > spot[2] + radius * abs(math.sin(lean)) + 0.02
            and (end[0] > hull.length / 2 + radius + 0.02 or end[2] > _DECK + radius)
            for end in ends
        )

    above = held.size[1] - hanging > _STICKS_UP  # what is above the fingers would hide the middle of the picture
    aims = (_turned(spot, arm.shoulder, aside) for aside in ((_ASIDE, -_ASIDE) if above else (0.0,)))
    views = (view(arm, aim, pitches=_VIEW_PITCHES, distances=_VIEW_DISTANCES, fits=clear) for aim in aims)
    return next((found for found in views if found is not None), None)


def _is_free_by_map(context: SkillContext, held: Thing, spot: Point) -> bool:
    """Whether nothing is there as far as map and memory know."""
    if not is_free_by_memory(context, held, spot):
        return False
    fixed = outlines(context.robot.floor_map, spot, 0.3)
    rooms = context.robot.floor_map.rooms
    inside = not rooms or any(room.holds(spot[0], spot[1]) for room in rooms)
    room = held.size[0] / 2 + _HAND
    return inside and (len(fixed) == 0 or float(np.hypot(*(fixed - np.array(spot[:2])).T).min()) > room)


def _turned(point: Point, about: Point, angle: float) -> Point:
    """A point turned about a vertical axis."""
    c, s = math.cos(angle), math.sin(angle)
    dx, dy = point[0] - about[0], point[1] - about[1]
    return about[0] + c * dx - s * dy, about[1] + s * dx + c * dy, point[2]
