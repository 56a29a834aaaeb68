"""Sorting: blocks to the places of their numbers, and taking away what stands too high.

What is too high is judged by the height of its top above the floor or the furniture, as the camera sees it. The highest
goes first, so that piles are taken down from the top.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Final

from engine.perception.looking import LOOK_POSES
from engine.perception.memory import Thing
from engine.perception.naming import Wanted
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Pose, wrap
from engine.skills.aim import top_of
from engine.skills.context import SkillContext
from engine.skills.grasp import pick
from engine.skills.hand import move_to
from engine.skills.library.following import ThingColour, enumerated
from engine.skills.library.manipulation import fetch
from engine.skills.outcome import ErrorCode, Result, fail, ok
from engine.skills.put import put_on, put_on_floor
from engine.skills.registry import Measure, skill
from engine.skills.search import room_at, search
from engine.skills.travel import go_to

Tag = Annotated[float, Measure("", 0, 586)]
Height = Annotated[float, Measure("m", 0, 1)]

TRAYS: Final = ("tray", "place", "sorting place")
"""Furniture called so and by a number is where the block of that number belongs."""
MOST: Final = 12
"""Things that one errand takes away."""

_SIDES: Final = (math.pi / 2, -math.pi / 2)
_BEFORE: Final = 0.32  # m from the robot's middle to what it has put on the floor
_APART: Final = 0.28  # m around that place: what is seen there has been taken away
_SAME_PLACE: Final = 0.06  # m: a block there has been visited
_CLOSED: Final[frozenset[ErrorCode]] = frozenset({"path_blocked", "unreachable", "door_closed"})
_DOUBT: Final = 0.012  # m of height within which the camera may be wrong
_HOPELESS: Final[frozenset[ErrorCode]] = frozenset(
    {"robot_lost", "robot_halted", "camera_lost", "cancelled", "hand_full"}
)


@skill(occupies=["base", "arm", "camera"])
async def apriltag_sort(context: SkillContext, id: Tag) -> Result:
    """Take the block with this tag and put it on its place: the tray of its number if the house has one, else the
    floor beside the robot."""
    number, home = round(id), context.pose
    taken = await fetch(context, Wanted(tag=number))
    if not taken.ok:
        return taken
    tray = tray_of(context.robot.floor_map.furniture, number)
    put = await (
        put_on(context, tray)
        if tray is not None
        else _put_aside(context, [Pose(home.x, home.y, wrap(home.yaw + side)) for side in _SIDES])
    )
    if not put.ok:
        return put
    where = f"on the {tray.name}" if tray is not None else "on the floor beside where I stood"
    return ok(f"Block {number} is {where}.", tag=number, place=tray.name if tray is not None else "floor")


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def apriltag_remove_higher(context: SkillContext, height: Height) -> Result:
    """Take away all blocks with tags that reach higher than a height, in metres, and put them aside.

    The height is measured from the floor or the table; a block on another one is as high as both.
    """
    return await _remove(context, lambda thing: thing.kind == "block" or thing.tag is not None, height, "block")


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def color_remove_higher(context: SkillContext, color: ThingColour, height: Height) -> Result:
    """Take away all things of a colour that reach higher than a height, in metres, and put them aside.

    The height is measured from the floor or the table; a thing on another one is as high as both.
    """
    return await _remove(context, lambda thing: thing.colour == color, height, f"{color} thing")


def tray_of(furniture: tuple[Furniture, ...], number: int) -> Furniture | None:
    """Where the block of this number belongs, if the house has such a place."""
    names = {f"{tray} {number}" for tray in TRAYS}
    return next((piece for piece in furniture if piece.name.casefold() in names), None)


async def _remove(context: SkillContext, meant: Callable[[Thing], bool], height: float, name: str) -> Result:
    """Take away what is meant and too high, the highest first, until none is seen any more."""
    room = room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    removed: list[Thing] = []
    landed: list[tuple[float, float]] = []
    failed: dict[int, Result] = {}
    limit = f"{100 * height:.0f} cm"

    def next_one() -> Thing | None:
        high = [
            thing
            for thing in context.world.things
            if meant(thing)
            and thing.number not in failed
            and _stands(context, thing) > height + _DOUBT
            and room.holds(*thing.position[:2])
            and not any(thing.distance_to(*spot) < _APART for spot in landed)
        ]
        return max(high, key=top_of, default=None)

    while len(removed) < MOST:
        await _glance(context)
        if next_one() is None and not removed:
            searched = await search(context, room, lambda: next_one() is not None)
            if searched.trouble is not None and not searched.found:
                return searched.trouble
        if (thing := next_one()) is None:
            break
        context.progress(None, f"the {thing.name} is {100 * _stands(context, thing):.0f} cm high")
        done = await pick(context, thing)
        if done.ok:
            done = await _put_aside(context, _beside(context.pose))
        if done.ok:
            removed.append(thing)
            now = context.pose
            landed.append((now.x + _BEFORE * math.cos(now.yaw), now.y + _BEFORE * math.sin(now.yaw)))
        elif done.error_code in _HOPELESS or context.world.held is not None:
            return fail(done.error_code or "grasp_failed", f"{done.message} {_said(removed)}", removed=len(removed))
        else:
            failed[thing.number] = done
    if failed:
        why = next(iter(failed.values()))
        message = f"Something is still higher than {limit}. {why.message} {_said(removed)}"
        return fail(why.error_code or "grasp_failed", message, removed=len(removed))
    if not removed:
        return ok(f"I see no {name} higher than {limit} in the {room.name}.", removed=0)
    return ok(f"{_said(removed)} I see no other {name} higher than {limit}.", removed=len(removed))


def _stands(context: SkillContext, thing: Thing) -> float:
    """How high its top is above the furniture or the floor below it, m; what lies between is part of the pile."""
    x, y = thing.position[:2]
    below = [piece.height for piece in context.robot.floor_map.furniture if piece.holds(x, y, margin=-0.02)]
    base = max((height for height in below if height < top_of(thing)), default=0.0)
    return top_of(thing) - base


async def _glance(context: SkillContext) -> None:
    """Look ahead, to the left and to the right."""
    for yaw in (0.0, 0.65, -0.65):
        await move_to(context, LOOK_POSES["AHEAD"].turned(yaw))
        await context.see()


def _said(removed: Sequence[Thing]) -> str:
    return f"I took away {enumerated([thing.name for thing in removed])}." if removed else "I took nothing away."


def _beside(pose: Pose) -> list[Pose]:
    """Where to stand to put something beside ``pose``: a little back, turned to the left, or to the right."""
    return [
        Pose(pose.x - back * math.cos(pose.yaw), pose.y - back * math.sin(pose.yaw), wrap(pose.yaw + side))
        for back in (0.35, 0.15)
        for side in _SIDES
    ]


async def _put_aside(context: SkillContext, stands: Sequence[Pose]) -> Result:
    """Put what is held on the floor from the first of these poses that allows it."""
    put = fail("no_room", "There is no room beside me.")
    for stand in stands:
        there = await go_to(context, stand, "the place to put it")
        put = await put_on_floor(context) if there.ok else there
        if put.ok or put.error_code not in ("no_room", "path_blocked", "unreachable", "out_of_reach"):
            break
    return put
