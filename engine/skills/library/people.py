"""Finding people, meeting them, and telling who and how many they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from engine.perception.people import PersonSeen
from engine.perception.someone import Someone
from engine.skills.context import SkillContext
from engine.skills.find import room_called
from engine.skills.meeting import (
    called,
    find_somebody,
    fits,
)
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import skill
from engine.skills.search import room_at
from engine.skills.with_people import (
    ANYBODY,
    Sentence,
    Those,
    Where,
    Who,
    ask_for_name,
    data_of,
    gender_of,
    in_theirs,
    know,
    look_for_beside,
    name_of,
    place_of_them,
    who_is,
    with_somebody,
)

MOST_ASKED: Final = 5
"""People who are asked for their name before the robot gives up to look for one of them."""
BETWEEN: Final = 0.6
"""m from one person to the next at least."""
ONE: Final = 0.45
"""m within which two sightings are one person, of whom legs and shirt were seen apart."""
LONG: Final = 0.9
"""m, the same of one who lies."""


@skill(occupies=["base", "arm", "camera"], changes=["pose"])
async def find_person(context: SkillContext, who: Who = ANYBODY, where: Where = "") -> Result:
    """Find somebody and go up to them: in a room or at a place if one is named, else through all rooms."""
    person = await with_somebody(context, who, where)
    if isinstance(person, Result):
        return person
    return ok(f"I found {called(person)}{place_of_them(context, person)}.", **data_of(person))


@skill(occupies=["base", "arm", "camera", "voice"], changes=["pose"])
async def meet(context: SkillContext, who: Who = ANYBODY, where: Where = "") -> Result:
    """Go to somebody, greet them, and learn their name if they are not known by sight. Whoever is somebody else is
    left, and the next one there is asked."""
    wanted = who_is(context, who).name
    others: list[str] = []
    while len(others) < MOST_ASKED:
        person = await with_somebody(context, who, where, named=False)
        if isinstance(person, Result):
            return _met_only(wanted, others) if others and person.error_code == "object_not_found" else person
        if person.name is not None and wanted in ("", person.name):
            await context.say(in_theirs(context, person, f"Hello, {person.name}."))
            return ok(f"I met {person.name}{place_of_them(context, person)}.", **data_of(person))
        name = await ask_for_name(context, person, wanted)
        if not name and context.world.people.has_denied(person.number, wanted):
            name = called(person)
        if not name:
            return ok(f"I met {called(person)}, who did not tell me their name.", **data_of(person))
        if wanted in ("", name):
            return ok(f"I met {name}{place_of_them(context, person)}.", **{**data_of(person), "name": name})
        others.append(name)
    return _met_only(wanted, others)


def _met_only(wanted: str, others: list[str]) -> Result:
    names = " and ".join(others)
    return fail("object_not_found", f"I looked for {wanted}, and met {names} there.", name=others[-1])


@skill(occupies=["camera", "arm", "base"])
async def learn_name(context: SkillContext, name: Sentence) -> Result:
    """Remember that the person before the robot has this name."""
    person = await look_for_beside(context, lambda other: True)
    if person is None:
        return fail("object_not_found", f"I see nobody before me who could be {name}.")
    know(context, person, name)
    return ok(f"Hello, {name}. I know you now.", name=name)


@skill(occupies=["base", "arm", "camera"], changes=["pose"])
async def count_people(context: SkillContext, who: Those = ANYBODY, where: Where = "") -> Result:
    """Look through a room and say how many people, or how many of a kind, are there."""
    meant = who_is(context, who)
    room = room_called(context, where) if where else room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    everybody = await people_in(context, room.name)
    if isinstance(everybody, Result):
        return everybody
    fit = fits(context, meant)
    found = [person for person in everybody if fit(person)]
    if meant.gender is None:
        return ok(f"In the {room.name} I see {_counted(len(found), meant)}.", people=len(found))
    genders = [await gender_of(context, person) for person in found]
    count, untold = genders.count(meant.gender), genders.count(None)
    if not untold:
        return ok(f"In the {room.name} I see {_counted(count, meant)}.", people=count)
    sure = _counted(count, meant)
    return ok(
        f"In the {room.name} I see {sure}, and {_counted(untold, Someone())} of whom I cannot tell.", people=count
    )


async def people_in(context: SkillContext, room_name: str) -> tuple[PersonSeen, ...] | Result:
    """Everybody in a room, which is looked through."""
    began = context.robot.state().t
    nobody = await find_somebody(context, Someone("\0"), room_name)  # nobody is called so: all of it is looked at
    if isinstance(nobody, Result) and nobody.error_code != "object_not_found":
        return nobody
    room = room_called(context, room_name)
    here = [p for p in context.world.people.everybody if p.seen_at >= began and room.holds(*p.position[:2])]
    here.sort(key=lambda p: (p.shirt is None, p.trousers is None))  # of two that are one, the one who showed better
    found: list[PersonSeen] = []
    for number, person in enumerate(here):
        if not any(are_one(person, other) for other in here[:number]):
            found.append(person)
    return tuple(found)


def are_one(one: PersonSeen, other: PersonSeen) -> bool:
    """Whether two sightings may be one person. Of who lies one picture shows an end and another the other end, unless
    both are in one."""
    apart = math.dist(one.position[:2], other.position[:2])
    if one.posture == other.posture == "lying" and one.seen_at != other.seen_at:
        return apart < LONG
    return apart < ONE


async def those_in(context: SkillContext, who: str, where: str) -> tuple[str, tuple[PersonSeen, ...]] | Result:
    """The name of a room, and everybody in it who is meant; why not, where there is nobody. No room is the one where
    the robot is."""
    room = room_called(context, where)
    everybody = await people_in(context, room.name)
    if isinstance(everybody, Result):
        return everybody
    fit = fits(context, who_is(context, who))
    found = tuple(person for person in everybody if fit(person))
    if not found:
        return fail("object_not_found", f"I looked in the {room.name} and saw nobody who is meant.")
    return room.name, found


def as_now(context: SkillContext, one: PersonSeen, together: Sequence[PersonSeen]) -> PersonSeen:
    """One of those who were seen ``together``, as they were seen last: as they were then, where the memory has them at
    the place of another one, for what shows of clothes from close by may be taken for somebody else's."""
    now = context.world.people.of_number(one.number) or one
    others = [other for other in together if other.number != one.number]
    return one if any(now.distance_to(*other.position[:2]) < BETWEEN for other in others) else now


def _counted(count: int, who: Someone) -> str:
    """``no person sitting``, ``one woman``, ``2 people waving``."""
    if count < 2:
        return f"{'one' if count else 'no'} {who}"
    head, _, rest = str(who).partition(" ")
    several = {"person": "people", "woman": "women", "man": "men"}.get(head, head)
    return f"{count} {several} {rest}".rstrip()


@skill(occupies=["base", "arm", "camera", "voice"], changes=["pose"])
async def describe_person(context: SkillContext, who: Who = ANYBODY, what: Sentence = "") -> Result:
    """Say what somebody looks like, or one thing of them: name, gender, pose, gesture or clothes."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    match what:
        case "name":
            if person.name is None:
                name = await ask_for_name(context, person, "")
                if not name:
                    return fail("no_progress", "They did not tell me their name.")
                return ok(f"The person is {name}.", name=name)
            return ok(f"The person is {person.name}.", name=person.name)
        case "gender":
            gender = await gender_of(context, person)
            if gender is None:
                return fail("not_supported", f"I cannot tell whether {called(person)} is a man or a woman.")
            return ok(f"{name_of(person)} is a {'woman' if gender == 'female' else 'man'}.", gender=gender)
        case "pose":
            if person.posture is None:
                return fail("not_supported", f"I cannot see whether {called(person)} sits or stands.")
            return ok(f"{name_of(person)} is {_posture(person)}.", pose=person.posture)
        case "gesture":
            return ok(f"{name_of(person)} is {person.gesture or 'making no gesture'}.", gesture=person.gesture or "")
        case "clothes":
            return ok(f"{name_of(person)} wears {_clothes(person)}.")
    doing = " and ".join(filter(None, (_posture(person), person.gesture)))
    told = f"{name_of(person)} wears {_clothes(person)}.{f' They are {doing}.' if doing else ''}"
    return ok(told, **data_of(person))


def _posture(person: PersonSeen) -> str:
    return {"lying": "lying down"}.get(person.posture or "", person.posture or "")


def _clothes(person: PersonSeen) -> str:
    legs = f"{person.trousers} trousers" if person.trousers else ""
    shirt = f"a {person.shirt} shirt" if person.shirt else ""
    return " and ".join(filter(None, (shirt, legs))) or "something"
