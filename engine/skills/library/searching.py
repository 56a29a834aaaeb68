"""Seeing, looking for things, and going to them."""

from __future__ import annotations

from typing import Annotated, Final

from engine.errors import PlanError
from engine.llm.chat import ChatError
from engine.perception.describe import describe
from engine.perception.memory import Thing
from engine.perception.naming import wanted
from engine.perception.sighting import Sight
from engine.skills.approach import stand_before
from engine.skills.choosing import best_of, seen_here
from engine.skills.context import SkillContext
from engine.skills.find import find, listing, listing_the, room_called, things_in, whereabouts
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Measure, Word, skill
from engine.skills.search import nothing_more, search
from engine.skills.travel import go_to

ObjectName = Annotated[str, Word("object")]
RoomName = Annotated[str, Word("room")]
SurfaceName = Annotated[str, Word("surface")]
Count = Annotated[float, Measure("", 1, 20)]

_BEFORE: Final = 0.33
"""Where the robot stands before what it goes to, m from its centre."""
_STEP: Final = 30.0
"""s by which a step away from that counts, per m."""

_QUESTION: Final = "What do you see? Answer in one or two short sentences."


@skill(occupies=["camera"], changes=[])
async def seewhat(context: SkillContext) -> Result:
    """Look, and say what is there."""
    sight = await context.see()
    description = describe(sight, context.robot.floor_map)
    if shown := await _shown(context, sight):
        description += f" The picture shows: {shown}"
    return ok(description, things=len(sight.objects))


async def _shown(context: SkillContext, sight: Sight) -> str:
    """What a model says that the picture shows; nothing where there is no model, or no answer."""
    if context.ask_about is None:
        return ""
    known = ", ".join(thing.name for thing in sight.objects) or "none"
    question = f"{_QUESTION} Things that I recognised myself: {known}."
    try:
        return await context.ask_about(sight.picture, question)
    except ChatError:
        return ""  # what perception saw is an answer too


@skill(occupies=["base", "arm", "camera"], changes=["pose"], lasting=True)
async def scan_room(context: SkillContext, room: RoomName = "") -> Result:
    """Look through a room, the one that the robot is in unless another is named, and say what lies about there."""
    place = room_called(context, room)
    searched = await search(context, place)
    result = nothing_more(searched, place.name)
    if not result.ok:
        return result
    things = things_in(context, place)
    listed = listing(things) if things else "nothing"
    return ok(f"In the {place.name} I found {listed}.", things=len(things), seen=round(searched.seen, 2))


@skill(occupies=["base", "arm", "camera"], changes=["pose"])
async def list_things(
    context: SkillContext, object: ObjectName = "thing", where: SurfaceName = "", most: Count = 1
) -> Result:
    """Look at a piece of furniture or through a room, and say how many things of a kind are there, and which; or which
    ``most`` of them are the biggest, or the leftmost."""
    what = wanted(object)
    things = await _seen_at(context, where)
    if isinstance(things, Result):
        return things
    found = best_of(things, what, context.pose)
    there = f"in the {where}" if _is_room(context, where) else f"on the {where}" if where else "here"
    if not found:
        return ok(f"I see no {what} {there}.", things=0)
    if not what.is_choice:
        return ok(f"I count {len(found)} {there}: {listing(found)}.", things=len(found))
    meant = found[: round(most)]
    if len(meant) == 1:
        return ok(f"The {what.rank or ''} one {there} is {listing_the(meant)}.".replace("  ", " "), things=1)
    return ok(f"The {len(meant)} {what.rank} ones {there} are {listing_the(meant)}.", things=len(meant))


async def _seen_at(context: SkillContext, place: str) -> tuple[Thing, ...] | Result:
    """All things at a piece of furniture, in a room, or here; the robot goes there."""
    if _is_room(context, place):
        room = room_called(context, place)
        searched = await search(context, room)
        return searched.trouble if searched.trouble is not None else things_in(context, room)
    if place:
        try:
            symbol = context.places.symbol(place)
        except PlanError as error:
            return fail("unknown_place", error.message)
        goal = context.places.pose(symbol)
        if goal is not None and not (went := await go_to(context, goal, place)).ok:
            return went
    return await seen_here(context)


def _is_room(context: SkillContext, place: str) -> bool:
    return any(room.name == place for room in context.robot.floor_map.rooms)


@skill(occupies=["base", "arm", "camera"], changes=["pose"])
async def locate(context: SkillContext, object: ObjectName) -> Result:
    """Find out where something is: from memory if it was seen lately, else by looking for it, room by room."""
    held = context.world.held
    if held is not None and wanted(object).fits(held.kind, held.colour, held.tag):
        return ok(f"I hold the {held.name}.", held=held.name)
    found = await find(context, wanted(object))
    if isinstance(found, Result):
        return found
    x, y, z = found.position
    where = whereabouts(found, context.robot.floor_map)
    return ok(f"The {found.name} is {where}.", x=round(x, 3), y=round(y, 3), z=round(z, 3), sigma=round(found.sigma, 3))


@skill(occupies=["base", "arm", "camera"], changes=["pose"])
async def navigate_to_object(context: SkillContext, object: ObjectName) -> Result:
    """Drive to something and stand before it, looking for it first where it is not known."""
    found = await find(context, wanted(object))
    if isinstance(found, Result):
        return found
    stood = await stand_before(context, found.position, lambda way: _STEP * abs(way - _BEFORE), found.name)
    if not stood.ok:
        return stood
    return ok(f"I stand before the {found.name}.", x=context.pose.x, y=context.pose.y)
