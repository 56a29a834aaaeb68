"""Shoes and legs: in a picture of the floor they look like small things that lie about."""

from __future__ import annotations

from typing import Final

from engine.perception.memory import Thing
from engine.skills.context import SkillContext
from engine.skills.meeting import face_point
from engine.skills.strewn import LOW

_SHOE: Final = "black"
_FARTHEST: Final = 3.0  # m from which somebody is certain to be seen
_CHEST: Final = 1.0  # m


async def is_part_of_somebody(context: SkillContext, thing: Thing) -> bool:
    """Whether somebody stands where a thing lies that may be a part of them: what goes on above the picture's edge, or
    is black. The robot looks up to see that."""
    may_be = thing.tag is None and thing.surface < LOW and (thing.colour == _SHOE or not thing.whole)
    pose = context.pose
    if not may_be or thing.distance_to(pose.x, pose.y) > _FARTHEST:
        return False
    x, y, _ = thing.position
    await face_point(context, (x, y, _CHEST))
    await context.see()
    return all(other.number != thing.number for other in context.world.things)
