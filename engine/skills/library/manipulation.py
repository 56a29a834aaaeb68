"""Handling things: picking them up by name or by their place in the picture, and putting them down."""

from __future__ import annotations

import math
from typing import Annotated, Final

from engine.errors import PlanError
from engine.perception.memory import Thing
from engine.perception.naming import Wanted, wanted
from engine.perception.sighting import PixelBox, Sight
from engine.robot.floor_map import Room
from engine.skills.context import SkillContext
from engine.skills.find import find, furniture_called
from engine.skills.grasp import lost, pick
from engine.skills.hand import TOUCHING, close_fingers, gap, grip_again, move_to, open_fingers, presses, still_held
from engine.skills.library.searching import ObjectName
from engine.skills.outcome import Result, fail, ok
from engine.skills.put import put_in, put_on, put_on_floor
from engine.skills.registry import Measure, Word, skill
from engine.skills.travel import go_to

SurfaceName = Annotated[str, Word("surface")]
Pixel = Annotated[float, Measure("", 0, 4096)]
ServoAngle = Annotated[float, Measure("deg", 0, 180)]

LOOKED_FOR: Final = 3
"""Times that a thing is looked for that is not where it was seen."""
OVERLAP: Final = 0.2
"""Part of the area of two boxes together that they must share for one to mean the other."""


@skill(occupies=["base", "arm", "camera"], changes=["pose", "things"])
async def pick_object(context: SkillContext, object: ObjectName) -> Result:
    """Pick something up, looking for it first where it is not known."""
    if (held := context.world.held) is not None:
        return _hand_full(held)
    return await fetch(context, wanted(object))


@skill(occupies=["base", "arm", "camera"])
async def grasp_obj(context: SkillContext, x1: Pixel, y1: Pixel, x2: Pixel, y2: Pixel) -> Result:
    """Pick up what is in a box of the picture.

    (x1, y1) is its upper left corner and (x2, y2) its lower right one, in pixels of the camera as it looks now.
    """
    if (held := context.world.held) is not None:
        return _hand_full(held)
    sight = await context.see()
    thing = _thing_in((round(x1), round(y1), round(x2), round(y2)), sight, context.world.things)
    if thing is None:
        names = ", ".join(f"the {seen.name} at {seen.box}" for seen in sight.objects) or "nothing"
        return fail("object_not_found", f"There is nothing in that box of the picture. I see {names}.")
    return await pick(context, thing)


@skill(occupies=["base", "arm", "camera"], changes=["pose", "things"])
async def putdown(context: SkillContext) -> Result:
    """Put down what is held, on the floor before the robot."""
    return await put_on_floor(context)


@skill(occupies=["base", "arm", "camera"], changes=["pose", "things"])
async def place_object(context: SkillContext, surface: SurfaceName) -> Result:
    """Put what is held on a piece of furniture, into the bin, on the floor, or down at a place."""
    if surface == "floor":
        return await put_on_floor(context)
    if (held := context.world.held) is None:
        return fail("nothing_held", "I hold nothing that I could put down.")
    if (piece := furniture_called(context, surface)) is not None:
        return await (put_in(context, piece) if piece.kind == "bin" else put_on(context, piece))
    try:
        symbol = context.places.symbol(surface)
    except PlanError as error:
        return fail("unknown_place", error.message)
    goal = context.places.pose(symbol)
    if goal is None:
        return fail("unknown_place", "I have not been told to remember a place yet.")
    await grip_again(context)
    went = await go_to(context, goal, context.places.name(symbol))
    if not still_held(context):
        return lost(context, held)
    return await put_on_floor(context) if went.ok else went


@skill(occupies=["base", "arm", "camera"])
async def place_in_bin(context: SkillContext) -> Result:
    """Throw what is held into the nearest bin."""
    piece = furniture_called(context, "bin")
    if piece is None:
        return fail("unknown_place", "There is no bin on the map.")
    return await put_in(context, piece)


@skill(occupies=["arm"], changes=["arm"])
async def servo1_move(context: SkillContext, angle: ServoAngle) -> Result:
    """Turn the arm about its vertical axis: 90 degrees is straight ahead, 180 to the left, 0 to the right."""
    _, *others = context.robot.state().joint_targets
    shoulder, elbow, wrist, roll = others
    if not await move_to(context, (math.radians(angle - 90), shoulder, elbow, wrist, roll)):
        return fail("no_progress", f"The arm did not get to {angle:g}°.")
    return ok(f"The arm points to {angle:g}°.")


@skill(occupies=["arm"])
async def open_gripper(context: SkillContext) -> Result:
    """Open the gripper; what it holds falls."""
    held = context.world.held
    try:
        await open_fingers(context, context.robot.arm.jaw)
    finally:
        if held is not None and not presses(context, least=TOUCHING):
            context.world.put(None, context.robot.state().t)
    return ok("The gripper is open." if held is None else f"The gripper is open; I have let go of the {held.name}.")


@skill(occupies=["arm"])
async def close_gripper(context: SkillContext) -> Result:
    """Close the gripper with force."""
    if await close_fingers(context):
        return ok(f"The gripper is closed; what is between the fingers is {100 * gap(context):.1f} cm wide.")
    return ok("The gripper is closed, with nothing between the fingers.")


def _hand_full(held: Thing) -> Result:
    return fail("hand_full", f"I hold the {held.name} already.")


async def fetch(context: SkillContext, what: Wanted, rooms: tuple[Room, ...] | None = None) -> Result:
    """Find a thing (in ``rooms``, or anywhere) and pick it up. From afar something else may look like it: where it
    turns out not to be there, it is looked for again."""
    for _ in range(LOOKED_FOR - 1):
        found = await find(context, what, rooms=rooms)
        if isinstance(found, Result):
            return found
        if what.beside is not None and what.beside[0] == "under":
            top = what.beside[1]
            return fail("out_of_reach", f"The {found.name} lies under the {top}: I would have to take that away first.")
        picked = await pick(context, found)
        if picked.error_code != "object_not_found":
            return picked
    found = await find(context, what, rooms=rooms)
    return found if isinstance(found, Result) else await pick(context, found)


def _thing_in(box: PixelBox, sight: Sight, things: tuple[Thing, ...]) -> Thing | None:
    """The thing that the box in the picture means."""
    best = max(sight.objects, key=lambda seen: _shared(seen.box, box), default=None)
    if best is None or _shared(best.box, box) < OVERLAP:
        return None
    seen = [thing for thing in things if thing.seen_at == sight.t]
    return min(seen, key=lambda thing: thing.distance_to(*best.position[:2]), default=None)


def _shared(a: PixelBox, b: PixelBox) -> float:
    """Shared part of the area that both cover."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    areas = [(right - left) * (bottom - top) for left, top, right, bottom in (a, b)]
    return width * height / (sum(areas) - width * height)
