"""Going to places, remembering one, and saying where the robot is."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Annotated, Final

from engine.robot.geometry import Pose, heading_in_degrees, wrap
from engine.skills.context import SkillContext
from engine.skills.outcome import Result, fail, ok
from engine.skills.places import ZERO_SYMBOL, place_at
from engine.skills.registry import Measure, Word, skill
from engine.skills.travel import go_to

LONGEST_NAME = 40
"""Of a place, characters."""
PlaceName = Annotated[str, Word("place")]
Coordinate = Annotated[float, Measure("m", -1000, 1000)]
Heading = Annotated[float, Measure("deg", -360, 360)]


@skill(occupies=["base"], changes=["pose"])
async def navigation(context: SkillContext, place: PlaceName) -> Result:
    """Go to a place of the map by its symbol or name; zero is the remembered place."""
    goal, name = context.places.pose(place), context.places.name(place)
    if goal is None:
        return fail("unknown_place", "I have not been told to remember a place yet.")
    return await go_to(context, goal, name)


@skill()
async def get_current_pose(context: SkillContext) -> Result:
    """Remember (memorise) where the robot stands as the place zero."""
    pose = context.pose
    context.places.remember(pose)
    return ok(f"I will remember this place. {_words(pose)}", x=pose.x, y=pose.y, yaw=pose.yaw)


@skill()
async def remember_place(context: SkillContext, name: Annotated[str, Word("sentence")]) -> Result:
    """Remember where the robot stands as a place of this name."""
    called = _ARTICLE.sub("", " ".join(name.split()).strip(".,!?。，！？ "))
    if not 1 < len(called) <= LONGEST_NAME or not called.isprintable() or called.casefold() == ZERO_SYMBOL:
        return fail("unknown_place", f"“{called}” cannot be the name of a place.")
    pose = context.pose
    symbol = context.places.add(called, place_at(called, pose))
    return ok(
        f"I will remember this as {context.places.name(symbol)}. {_words(pose)}", x=pose.x, y=pose.y, yaw=pose.yaw
    )


_ARTICLE: Final = re.compile(r"^(?:the|an?)\s+(?=\S)", re.IGNORECASE)
"""It is no part of a name: "the nook" is told as "the nook" anyway."""


@skill(occupies=["base"], changes=["pose"])
async def return_to(context: SkillContext, x: Coordinate, y: Coordinate, heading: Heading) -> Result:
    """Go back to a point of the map and a heading: degrees, 0 east, counter-clockwise."""
    went = await go_to(context, Pose(x, y, wrap(math.radians(heading))), "where I was")
    return replace(went, message="I am back where I was.") if went.ok else went


@skill(changes=[])
async def report_pose(context: SkillContext) -> Result:
    """Say where the robot is (whereabouts)."""
    pose = context.pose
    room = next((room.name for room in context.robot.floor_map.rooms if room.holds(pose.x, pose.y)), None)
    where = f"I am in the {room}. " if room else ""
    return ok(f"{where}{_words(pose)}", x=pose.x, y=pose.y, yaw=pose.yaw, room=room or "")


def _words(pose: Pose) -> str:
    return f"x {pose.x:.2f} m, y {pose.y:.2f} m, facing {heading_in_degrees(pose.yaw):.0f}°."
