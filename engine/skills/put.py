"""Putting down what is held: on the floor, on a low piece of furniture, or into the bin.

A free spot is chosen by the map and the memory and made sure of by looking. The thing is lowered, the hand pointing as
it did when it took it, until it stands; then the fingers open and go back the way they came. Into a bin it is dropped
from above the opening.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from engine.perception.memory import Thing
from engine.robot.arm import ArmModel, Point
from engine.robot.camera import Picture
from engine.robot.robot import Furniture, Joints
from engine.skills.aim import PITCHES, STANDOFF, grip_height
from engine.skills.aim import view as look_at
from engine.skills.approach import Reach, outlines, places_to_stand, stand_before
from engine.skills.context import SkillContext
from engine.skills.grasp import lost
from engine.skills.hand import (
    fold,
    from_map,
    gap,
    look,
    move_along,
    move_to,
    nearest,
    on_map,
    open_fingers,
    pressed,
    presses,
    still_held,
)
from engine.skills.outcome import Result, fail, ok

HIGHEST: Final = 0.18
"""m: tops that are higher are out of the arm's reach."""
BIN_WALL: Final = 0.015
"""m, of a bin, and how far from it a thing should fall."""
_DECK = 0.14  # m, height of the hull and what is on it
_EDGE = 0.02  # m between a thing and the edge of what it stands on
_APART = 0.035  # m between a thing and its neighbours
_SPOT = 0.04  # m between the spots that are considered
_TRIED = 6  # spots that are tried before there is no room
_HAND = 0.1  # m between a thing and walls or furniture: the hand must find room there, too
_ABOVE = 0.07  # m over the spot from which a thing is lowered
_DEEPER = 0.008  # m beyond where it should stand already: then something holds the hand up
_STRAYED = 0.06  # m from where a thing was put down that it may be seen to stand
_LOOSE = 0.004  # m that the gap must grow for the thing to be let go
_LEANS = (0.0, -0.15, 0.15, -0.3, 0.3)  # rad off upright from which things still come to stand when let go
_VIEW_PITCHES, _VIEW_DISTANCES = (2.7, 2.85, 2.55, 2.4, 3.0), (0.27, 0.3, 0.24, 0.33, 0.21)  # rad, m
_STICKS_UP, _ASIDE = 0.05, 0.3  # m above the fingers, and rad to the side that the camera then looks from
_BIN_PITCHES = (*PITCHES, 2.0, 1.8, 1.6)


async def put_on_floor(context: SkillContext) -> Result:
    """Put what is held on the floor before the robot."""
    held = _checked(context)
    if isinstance(held, Result):
        return held
    for spot in _floor_spots(context, held):
        if not _reachable(context, held, spot):
            there = await stand_before(context, spot, _reach_of(context, held, 0.0), "a free place on the floor")
            if not still_held(context):
                return await _done(context, lost(context, held))
            if not there.ok or not _reachable(context, held, spot):
                continue
        result = await _put_at(context, held, spot, "the floor")
        if result is not None:
            return await _done(context, result)
    return await _done(context, fail("no_room", f"There is no free place on the floor near me for the {held.name}."))


def _floor_spots(context: SkillContext, held: Thing) -> list[Point]:
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
        if _free_by_map(context, held, spot) and (len(found) < _TRIED):
            found.append(spot)
    return [spot for spot in found if _reachable(context, held, spot)] + [
        spot for spot in found if not _reachable(context, held, spot)
    ]


async def put_on(context: SkillContext, piece: Furniture) -> Result:
    """Put what is held on a piece of furniture."""
    held = _checked(context)
    if isinstance(held, Result):
        return held
    if not 0 < piece.height <= HIGHEST:
        high = (
            f"{100 * piece.height:.0f} cm high, and my arm reaches {100 * HIGHEST:.0f} cm"
            if piece.height
            else "new to me"
        )
        return fail("out_of_reach", f"I cannot put anything on the {piece.name}: it is {high}.")
    reach, tried = _reach_of(context, held, piece.height), 0
    for spot in _spots(context, held, piece):
        if not _reachable(context, held, spot):
            if not places_to_stand(context, spot, reach, 0.0):
                continue
            there = await stand_before(context, spot, reach, f"the {piece.name}")
            if not there.ok:
                return there
        if not still_held(context):
            return await _done(context, lost(context, held))
        if _reachable(context, held, spot):
            result = await _put_at(context, held, spot, f"the {piece.name}")
            if result is not None:
                return await _done(context, result)
        tried += 1
        if tried == _TRIED:
            break
    return await _done(context, fail("no_room", f"There is no free place on the {piece.name} that I reach."))


async def put_in(context: SkillContext, piece: Furniture) -> Result:
    """Drop what is held into an open box."""
    held = _checked(context)
    if isinstance(held, Result):
        return held
    arm = context.robot.arm
    middle = ((piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2)
    high = (piece.height or 0.2) + 0.03 + _hanging(context, held)
    inside = min(piece.x_max - piece.x_min, piece.y_max - piece.y_min) / 2 - BIN_WALL - held.size[0] / 2 - BIN_WALL

    def reach(distance: float) -> float | None:
        found = _over(arm, (distance, 0.0), high)
        return None if found is None else 4.0 * max(0.0, 2.2 - arm.grip(found).pitch)

    spot = (*middle, high)
    near = from_map(context.pose, spot)
    if _over(arm, near[:2], high) is None or abs(math.atan2(near[1], near[0])) > 0.3:
        there = await stand_before(context, spot, lambda d: reach(d - max(0.0, inside - 0.03)), f"the {piece.name}")
        if not there.ok:
            return there
    if not still_held(context):
        return await _done(context, lost(context, held))
    x, y, _ = from_map(context.pose, spot)
    away = math.hypot(x, y)
    for nearer in np.arange(0.0, inside, 0.01):
        joints = _over(arm, (x * (1 - nearer / away), y * (1 - nearer / away)), high)
        if joints is not None:
            break
    else:
        return await _done(context, fail("out_of_reach", f"My arm does not reach over the {piece.name}."))
    if not await move_to(context, joints, speed=1.0):
        return await _done(context, fail("no_progress", f"The arm does not get over the {piece.name}."))
    if not still_held(context):
        return await _done(context, lost(context, held))
    await _let_go(context, (*middle, 0.01 + held.size[1] / 2), context.robot.arm.jaw)
    await context.sleep(0.5)  # it falls
    await look(context)
    beside = [thing for thing in context.world.things if _is_beside(thing, held, piece)]
    if beside:
        return await _done(context, fail("dropped", f"The {held.name} fell beside the {piece.name}."))
    return await _done(context, ok(f"The {held.name} is in the {piece.name}.", put=held.name))


def _checked(context: SkillContext) -> Thing | Result:
    """What is held, if it is."""
    held = context.world.held
    if held is None:
        return fail("nothing_held", "I hold nothing that I could put down.")
    return held if still_held(context) else lost(context, held)


async def _done(context: SkillContext, result: Result) -> Result:
    """Fold the arm again."""
    await fold(context)
    held = context.world.held
    if held is not None and not still_held(context):
        return lost(context, held)
    return result


def _is_beside(thing: Thing, held: Thing, piece: Furniture) -> bool:
    """Whether a thing that lies about is what should be in the bin."""
    x, y, _ = thing.position
    alike = thing.colour == held.colour and thing.kind in (held.kind, "thing") and thing.surface < 0.05
    fresh = thing.number != held.number
    return alike and fresh and piece.holds(x, y, margin=-0.3) and not piece.holds(x, y)


def _hanging(context: SkillContext, held: Thing) -> float:
    """How far it reaches below the point between the fingertips, m."""
    return grip_height(held.size, context.world.held_pitch)


def _over(arm: ArmModel, at: tuple[float, float], high: float) -> Joints | None:
    """The joints that hold a thing over a place (base frame), as upright as possible."""
    return arm.reach((*at, high), _BIN_PITCHES)


def _lowering(context: SkillContext, held: Thing, spot: Point) -> tuple[Joints, Point] | None:
    """To put the thing on ``spot`` (base frame): the joints above it, and where the fingertips go."""
    arm = context.robot.arm
    x, y, z = spot
    hanging, radius = _hanging(context, held), held.size[0] / 2
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


def _view(context: SkillContext, held: Thing, spot: Point) -> Joints | None:
    """The joints from which the camera sees ``spot`` (base frame) and what is held stays clear of it."""
    arm, hull = context.robot.arm, context.robot.footprint
    hanging, radius = _hanging(context, held), held.size[0] / 2

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
    views = (look_at(arm, aim, pitches=_VIEW_PITCHES, distances=_VIEW_DISTANCES, fits=clear) for aim in aims)
    return next((view for view in views if view is not None), None)


def _turned(point: Point, about: Point, angle: float) -> Point:
    """A point turned about a vertical axis."""
    c, s = math.cos(angle), math.sin(angle)
    dx, dy = point[0] - about[0], point[1] - about[1]
    return about[0] + c * dx - s * dy, about[1] + s * dx + c * dy, point[2]


def _reachable(context: SkillContext, held: Thing, spot: Point) -> bool:
    here = from_map(context.pose, spot)
    in_front = here[0] > context.robot.footprint.length / 2 + held.size[0] / 2 + 0.01
    return in_front and _lowering(context, held, here) is not None and _view(context, held, here) is not None


def _reach_of(context: SkillContext, held: Thing, height: float) -> Reach:
    """How comfortably the thing is put down straight ahead at this height, by distance."""

    def cost(distance: float) -> float | None:
        spot = (distance, 0.0, height)
        possible = _lowering(context, held, spot) is not None and _view(context, held, spot) is not None
        return 6.0 * abs(distance - 0.29) if possible else None

    return cost


def _free_by_map(context: SkillContext, held: Thing, spot: Point) -> bool:
    """Whether nothing is there as far as map and memory know."""
    if not _free_by_memory(context, held, spot):
        return False
    fixed = outlines(context.robot.floor_map, spot, 0.3)
    rooms = context.robot.floor_map.rooms
    inside = not rooms or any(room.holds(spot[0], spot[1]) for room in rooms)
    room = held.size[0] / 2 + _HAND
    return inside and (len(fixed) == 0 or float(np.hypot(*(fixed - np.array(spot[:2])).T).min()) > room)


def _free_by_memory(context: SkillContext, held: Thing, spot: Point) -> bool:
    return all(
        thing.distance_to(*spot[:2]) > (thing.size[0] + held.size[0]) / 2 + _APART
        for thing in context.world.things
        if abs(thing.surface - spot[2]) < 0.05
    )


def _free_by_sight(picture: Picture, held: Thing, spot: Point) -> bool:
    """Whether the picture shows the bare surface there; what the hand hides is not counted."""
    optical = picture.lens.grid() * picture.depth.ravel().astype(np.float64)[:, None]
    behind_hand = picture.depth.ravel() > 0.16
    points = picture.on_map(picture.mount.out(optical[behind_hand & np.isfinite(picture.depth.ravel())]))
    near = points[np.hypot(points[:, 0] - spot[0], points[:, 1] - spot[1]) < held.size[0] / 2 + _EDGE]
    return len(near) > 20 and float(np.mean(np.abs(near[:, 2] - spot[2]) > 0.012)) < 0.02


def _spots(context: SkillContext, held: Thing, piece: Furniture) -> list[Point]:
    """Free spots on a piece of furniture as far as the memory knows, the nearest to its edge and to the robot first."""
    margin = held.size[0] / 2 + _EDGE
    pose = context.pose

    def inwards(spot: Point) -> float:
        x, y, _ = spot
        return min(x - piece.x_min, piece.x_max - x, y - piece.y_min, piece.y_max - y)

    xs = np.arange(piece.x_min + margin, piece.x_max - margin + 1e-6, _SPOT)
    ys = np.arange(piece.y_min + margin, piece.y_max - margin + 1e-6, _SPOT)
    every = [(float(x), float(y), piece.height) for x in xs for y in ys]
    free = [spot for spot in every if _free_by_memory(context, held, spot)]
    return sorted(free, key=lambda spot: 5 * max(0.0, inwards(spot) - 0.08) + math.dist(spot[:2], (pose.x, pose.y)))


async def _put_at(context: SkillContext, held: Thing, spot: Point, name: str) -> Result | None:
    """Look at the spot and put it there; None when the spot is not free."""
    arm = context.robot.arm
    context.progress(None, f"putting the {held.name} on {name}")
    looking = _view(context, held, from_map(context.pose, spot))
    if looking is None or not await move_to(context, looking):
        return fail("no_progress", f"The arm does not get to where I wanted to look at {name} from.")
    sight = await look(context)
    if not _free_by_memory(context, held, spot) or not _free_by_sight(sight.picture, held, spot):
        return None
    here = from_map(context.pose, spot)
    way = _lowering(context, held, here)
    if way is None:
        return None
    before, down = way
    stuck = fail("no_progress", f"The arm does not get down to {name}.")
    if not await move_to(context, before):
        return stuck
    x, y, z = down
    if not await move_along(context, (x, y, z - _DEEPER), speed=0.06, until=pressed(arm)):
        return stuck
    if not still_held(context):
        return lost(context, held)
    await _let_go(context, (spot[0], spot[1], spot[2] + held.size[1] / 2), held.size[0] + 0.03)
    grip = arm.grip(context.robot.state().joints)
    back = STANDOFF * math.sin(grip.pitch)
    x, y, z = grip.point
    away = (x - back * math.cos(grip.yaw), y - back * math.sin(grip.yaw), z - STANDOFF * math.cos(grip.pitch))
    if not await move_along(context, away, speed=0.2):
        await move_to(context, before)
    x, y, z = from_map(context.pose, spot)
    looking = look_at(arm, (x, y, z + held.size[1])) or looking
    if await move_to(context, looking):
        await look(context)
        if all(thing.distance_to(*spot[:2]) > _STRAYED for thing in context.world.things):
            return fail("dropped", f"I put the {held.name} on {name}, but it does not stand there now.")
    return ok(f"I have put the {held.name} on {name}.", put=held.name)


async def _let_go(context: SkillContext, position: Point, width: float) -> None:
    """Open the fingers. The memory holds the thing until they are off it, and no longer, whatever interrupts."""
    world, before = context.world, gap(context)
    try:
        await open_fingers(context, width)
    finally:
        if gap(context) > before + _LOOSE or not presses(context):
            world.put(position, context.robot.state().t)
    if world.held is not None:  # nothing was between them
        world.put(position, context.robot.state().t)
