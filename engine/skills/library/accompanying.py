"""Going with people: behind them, or ahead of them."""

from __future__ import annotations

import math
from typing import Annotated, Final

from engine.perception.people import Looks, PersonSeen
from engine.skills.context import SkillContext
from engine.skills.leading import call, lead
from engine.skills.meeting import called, face_point, go_up_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.outfit import Outfit
from engine.skills.pursuit import STOOD_S, Pursuit
from engine.skills.registry import Duration, Word, skill
from engine.skills.search import room_at
from engine.skills.travel import go_to
from engine.skills.vocabulary import ME
from engine.skills.with_people import (
    ANYBODY,
    Who,
    addressed,
    in_theirs,
    nearest_of,
    who_is,
)

THERE: Final = 1.5
"""m from a place within which somebody has arrived there."""
WALKED: Final = 1.5
"""m that somebody has to have been from where they were met, until they can have arrived anywhere."""


@skill(occupies=["base", "arm", "camera", "voice"], changes=["pose"], endless=True)
async def person_follow(
    context: SkillContext, who: Who = ANYBODY, to: Annotated[str, Word("place")] = "", stands: Duration = 0
) -> Result:
    """Follow somebody at a distance of 1.2 m, to a place if one is named, else until told otherwise.

    stands: it also ends when they have walked somewhere and stand there for so long; 0: it does not.
    """
    person = await nearest_of(context, who)
    if isinstance(person, Result):
        return person
    goal = context.places.pose(to) if to else None
    if to and goal is None:
        return fail("unknown_place", "I do not remember any place yet.")
    room = room_at(context.robot.floor_map, goal.x, goal.y) if goal is not None else None
    began, farthest = person.position[:2], 0.0

    def there(at: tuple[float, float]) -> bool:
        nonlocal farthest
        farthest = max(farthest, math.dist(at, began))
        if goal is None or room is None:
            return stands > 0 and farthest > WALKED
        return room.holds(*at) or math.dist(at, (goal.x, goal.y)) < THERE

    words = f"I follow you to {context.places.name(to)}." if to else "I follow you."
    await context.say(addressed(person, in_theirs(context, person, words)))
    return await Pursuit(context, person, called(person), _outfit(context, person, who)).run(there, stands or STOOD_S)


@skill(occupies=["base", "arm", "camera", "voice"])
async def guide(context: SkillContext, who: Who, to: Annotated[str, Word("place")]) -> Result:
    """Lead somebody to a place: the robot goes ahead, waits when they fall behind, and says when they are there."""
    goal, place = context.places.pose(to), context.places.name(to)
    if goal is None:
        return fail("unknown_place", "I do not remember any place yet.")
    person = await nearest_of(context, who)
    if isinstance(person, Result):
        if who != ME or person.error_code != "object_not_found":
            return person
        went = await go_to(context, goal, place)  # whoever asked for it may come
        return ok(f"I am at {place}. I saw nobody come along.") if went.ok else went
    went = await go_up_to(context, person)  # from afar, somebody else may think that they are meant
    if not went.ok:
        return went
    await context.see()  # whoever walks is elsewhere by now
    person = context.world.people.of_number(person.number) or person
    await face_point(context, person.position)
    name = person.name or "the person"
    outfit = _outfit(context, person, who)
    await call(context, person, outfit, place)
    result = await lead(context, person, name, goal, place, outfit)
    if result.ok:
        await context.say(in_theirs(context, person, f"Here we are: {place}."))
    return result


def _outfit(context: SkillContext, person: PersonSeen, who: str) -> Outfit:
    """What they wear: as it was asked for, else as it was seen."""
    asked = who_is(context, who)
    return Outfit(person, Looks(asked.shirt, asked.trousers))
