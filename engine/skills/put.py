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
from engine.robot.arm import ArmModel, Grip, Joints
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Point
from engine.skills.aim import PITCHES, STANDOFF, view
from engine.skills.approach import places_to_stand, stand_before
from engine.skills.context import SkillContext
from engine.skills.grasp import lost
from engine.skills.hand import (
    TOUCHING,
    fold,
    from_map,
    grip_again,
    look,
    move_along,
    move_to,
    open_fingers,
    pressed,
    presses,
    still_held,
)
from engine.skills.outcome import Result, fail, ok
from engine.skills.spots import (
    MOST,
    hanging_of,
    is_free_by_memory,
    is_free_by_sight,
    is_reachable,
    lowering,
    reach_of,
    spots_on,
    spots_on_floor,
    viewpoint,
)

HIGHEST: Final = 0.18
"""m: tops that are higher are out of the arm's reach."""
BIN_WALL: Final = 0.015
"""m, of a bin, and how far from it a thing should fall."""
_DEEPER = 0.008  # m beyond where it should stand already: then something holds the hand up
_STRAYED = 0.06  # m from where a thing was put down that it may be seen to stand
_BIN_PITCHES = (*PITCHES, 2.0, 1.8, 1.6)


async def put_on_floor(context: SkillContext) -> Result:
    """Put what is held on the floor before the robot."""
    held = await _checked(context)
    if isinstance(held, Result):
        return held
    for spot in spots_on_floor(context, held):
        if not is_reachable(context, held, spot):
            there = await stand_before(context, spot, reach_of(context, held, 0.0), "a free place on the floor")
            if not still_held(context):
                return await _done(context, lost(context, held))
            if not there.ok or not is_reachable(context, held, spot):
                continue
        result = await _put_at(context, held, spot, "the floor")
        if result is not None:
            return await _done(context, result)
    return await _done(context, fail("no_room", f"There is no free place on the floor near me for the {held.name}."))


async def put_on(context: SkillContext, piece: Furniture) -> Result:
    """Put what is held on a piece of furniture."""
    held = await _checked(context)
    if isinstance(held, Result):
        return held
    if not 0 < piece.height <= HIGHEST:
        high = (
            f"{100 * piece.height:.0f} cm high, and my arm reaches {100 * HIGHEST:.0f} cm"
            if piece.height
            else "new to me"
        )
        return fail("out_of_reach", f"I cannot put anything on the {piece.name}: it is {high}.")
    reach, tried = reach_of(context, held, piece.height), 0
    for spot in spots_on(context, held, piece):
        if not is_reachable(context, held, spot):
            if not places_to_stand(context, spot, reach, 0.0):
                continue
            there = await stand_before(context, spot, reach, f"the {piece.name}")
            if not there.ok:
                return there
        if not still_held(context):
            return await _done(context, lost(context, held))
        if is_reachable(context, held, spot):
            result = await _put_at(context, held, spot, f"the {piece.name}")
            if result is not None:
                return await _done(context, result)
        tried += 1
        if tried == MOST:
            break
    return await _done(context, fail("no_room", f"There is no free place on the {piece.name} that I reach."))


async def put_in(context: SkillContext, piece: Furniture) -> Result:
    """Drop what is held into an open box."""
    held = await _checked(context)
    if isinstance(held, Result):
        return held
    arm = context.robot.arm
    middle = ((piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2)
    high = (piece.height or 0.2) + 0.03 + hanging_of(context, held)
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
    joints = _over_some_of(arm, from_map(context.pose, spot), inside)
    if joints is None:
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


async def _checked(context: SkillContext) -> Thing | Result:
    """What is held, if it is, and firmly."""
    held = context.world.held
    if held is None:
        return fail("nothing_held", "I hold nothing that I could put down.")
    await grip_again(context)
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


def _over(arm: ArmModel, at: tuple[float, float], high: float) -> Joints | None:
    """The joints that hold a thing over a place (base frame), as upright as possible."""
    return arm.reach((*at, high), _BIN_PITCHES)


def _over_some_of(arm: ArmModel, spot: Point, inside: float) -> Joints | None:
    """The same over ``spot``, or else over what is nearer to the robot, by less than ``inside`` m."""
    x, y, high = spot
    away = math.hypot(x, y)
    tried = (_over(arm, (x * (1 - n / away), y * (1 - n / away)), high) for n in np.arange(0.0, inside, 0.01))
    return next((joints for joints in tried if joints is not None), None)


async def _put_at(context: SkillContext, held: Thing, spot: Point, name: str) -> Result | None:
    """Look at the spot and put it there; None when the spot is not free."""
    arm = context.robot.arm
    context.progress(None, f"putting the {held.name} on {name}")
    looking = viewpoint(context, held, from_map(context.pose, spot))
    if looking is None or not await move_to(context, looking):
        return fail("no_progress", f"The arm does not get to where I wanted to look at {name} from.")
    sight = await look(context)
    if not is_free_by_memory(context, held, spot) or not is_free_by_sight(sight.picture, held, spot):
        return None
    here = from_map(context.pose, spot)
    way = lowering(context, held, here)
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
    if not await move_along(context, _behind(arm.grip(context.robot.state().joints)), speed=0.2):
        await move_to(context, before)
    x, y, z = from_map(context.pose, spot)
    looking = view(arm, (x, y, z + held.size[1])) or looking
    if await move_to(context, looking):
        await look(context)
        if all(thing.distance_to(*spot[:2]) > _STRAYED for thing in context.world.things):
            return fail("dropped", f"I put the {held.name} on {name}, but it does not stand there now.")
    return ok(f"I have put the {held.name} on {name}.", put=held.name)


def _behind(grip: Grip) -> Point:
    """Where the fingertips go to be out of the way: back along the hand."""
    back = STANDOFF * math.sin(grip.pitch)
    x, y, z = grip.point
    return x - back * math.cos(grip.yaw), y - back * math.sin(grip.yaw), z - STANDOFF * math.cos(grip.pitch)


async def _let_go(context: SkillContext, position: Point, width: float) -> None:
    """Open the fingers. The memory holds the thing as long as they press on it at all, whatever interrupts: in the air
    they hold what is light with next to nothing."""
    world = context.world
    try:
        await open_fingers(context, width)
    finally:
        if not presses(context, least=TOUCHING):
            world.put(position, context.robot.state().t)
    if world.held is not None:  # nothing was between them
        world.put(position, context.robot.state().t)
