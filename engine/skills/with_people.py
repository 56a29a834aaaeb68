"""Whom a skill means, how the robot comes to stand before them, and how they are spoken to."""

from __future__ import annotations

import re
from typing import Annotated, Final

from config.schema import KnownPerson
from engine.han import is_chinese
from engine.perception.people import PersonSeen
from engine.perception.someone import Gender, Someone
from engine.skills.context import SkillContext
from engine.skills.meeting import (
    APART,
    Seen,
    called,
    face_point,
    find_somebody,
    fits,
    go_up_to,
    look_around,
    may_be,
    seen_now,
)
from engine.skills.outcome import Result, fail
from engine.skills.registry import Word
from engine.skills.vocabulary import ME

Who = Annotated[str, Word("person")]
Those = Annotated[str, Word("people")]
"""Each of several: who is meant of all in a room."""
Where = Annotated[str, Word("surface")]
Sentence = Annotated[str, Word("sentence")]
ANYBODY: Final = "person"
BESIDE: Final = 2.2
"""m within which somebody is there to talk with."""
_JUST_S: Final = 2.0  # s since somebody was seen, within which they are still there
_THEIR_PLACE: Final = 0.6  # m from where they were seen from afar
_STEP_ASIDE: Final = 1.2  # m from there, where whoever fits is they
_APART: Final = 0.25  # m between two people at least
NEAR: Final = BESIDE + 1.0
"""m within which somebody is taken to be meant before anybody is looked for elsewhere."""


def who_is(context: SkillContext, words: str) -> Someone:
    """Whom the argument of a skill means."""
    return Someone() if words == ME else context.people.who(words)


async def with_somebody(
    context: SkillContext, words: str, where: str = "", *, apart: float = APART, named: bool = True
) -> PersonSeen | Result:
    """Somebody who is meant, with the robot standing before them; or why not."""
    who = who_is(context, words)
    person = None if where else _met(context, words) or _beside(context, fits(context, who), BESIDE)
    if person is None:
        found = await find_somebody(context, who, where, named=named)
        if isinstance(found, Result):
            return found
        person = found
    went = await go_up_to(context, person, apart=apart)
    if not went.ok:
        return went
    person = await _there(context, person, fits(context, who) if named else may_be(context, who))
    context.world.people.met = (words, person.number)
    return person


async def _there(context: SkillContext, person: PersonSeen, wanted: Seen) -> PersonSeen:
    """The one who stands where they were seen from afar. From near by their clothes may look different, and they may
    have stepped aside, so that they are remembered as another one: that one it is."""
    began, people = context.robot.state().t, context.world.people
    await context.see()
    now = people.of_number(person.number)
    if now is not None and now.seen_at >= began - _JUST_S:
        return now

    def away(other: PersonSeen) -> float:
        return other.distance_to(*person.position[:2])

    just = [other for other in people.everybody if other.seen_at >= began - _JUST_S]
    here = [other for other in just if away(other) < _THEIR_PLACE or (wanted(other) and away(other) < _STEP_ASIDE)]
    if not here:
        return now or person
    people.forget(person.number)
    return min(here, key=away)


def _met(context: SkillContext, words: str) -> PersonSeen | None:
    """The one whom the robot stands before because of the same words: they may not wave any more."""
    said, number = context.world.people.met
    person = context.world.people.of_number(number) if said == words else None
    if person is None or person.distance_to(context.pose.x, context.pose.y) >= BESIDE:
        return None
    wanted = who_is(context, words).name
    people = context.world.people
    somebody_else = person.name not in (None, wanted) or people.has_denied(person.number, wanted)
    return None if wanted and somebody_else else person  # they have said who they are


def _beside(context: SkillContext, wanted: Seen, within: float) -> PersonSeen | None:
    """The nearest of those who are wanted, within so many m of the robot."""
    pose = context.pose
    return seen_now(context, wanted, lambda person: person.distance_to(pose.x, pose.y) < within)


async def look_for_beside(context: SkillContext, wanted: Seen) -> PersonSeen | None:
    """Somebody who is wanted and is near, looking around where none has been seen just now."""
    if (person := _beside(context, wanted, NEAR)) is None:
        await look_around(context, lambda: _beside(context, wanted, NEAR) is not None)
        person = _beside(context, wanted, NEAR)
    return person


async def nearest_of(context: SkillContext, who: str) -> PersonSeen | Result:
    """Somebody who is meant and is near; else they are looked for and gone up to."""
    person = _met(context, who) or await look_for_beside(context, fits(context, who_is(context, who)))
    if person is not None:
        await face_point(context, person.position)
        return person
    if who == ME:
        return fail("object_not_found", "I see nobody here.")
    return await with_somebody(context, who)


async def ask_for_name(context: SkillContext, person: PersonSeen, expected: str) -> str:
    """Ask somebody for their name and remember it; empty where they do not tell it."""
    asks = f"Hello. Are you {expected}?" if expected else "Hello. What is your name?"
    if context.ask is None:
        await context.say(context.worded("Hello."))
        return expected
    answer = await context.ask(context.worded(asks))
    name = name_told(answer or "", expected)
    if expected and answer and not name:
        context.world.people.deny(person.number, expected)
        name = name_told(await context.ask(context.worded("What is your name?")) or "", "")
    if name:
        know(context, person, name)
    return name


async def gender_of(context: SkillContext, person: PersonSeen) -> Gender | None:
    """As it is known, else as they say when they are asked: nobody's looks tell. None where they do not say."""
    known = context.people.about(person.name).gender if person.name else None
    if known is not None or context.ask is None:
        return known
    if not (await go_up_to(context, person)).ok:
        return None
    await context.see()
    before = _beside(context, lambda other: True, NEAR)
    if before is not None and before.number != person.number and before.distance_to(*person.position[:2]) > _APART:
        return None  # somebody else stands before them, and would answer
    answer = await context.ask(in_theirs(context, person, "Excuse me, are you a man or a woman?")) or ""
    male, female = _MALE.search(answer.casefold()), _FEMALE.search(answer.casefold())
    return None if bool(male) == bool(female) else "male" if male else "female"


def name_told(answer: str, expected: str) -> str:
    """The name in an answer: "I am Robin", "yes" to a name that was asked about; empty where there is none."""
    plain = answer.strip(" .!。！")
    found = _NAME_TOLD.search(plain)
    if found is not None:
        return (found["en"] or found["zh"]).strip()
    if expected and _YES.match(plain.casefold()):
        return expected
    words = plain.split()
    return plain if 0 < len(words) <= 2 and plain[:1].isupper() and not _NO.match(plain.casefold()) else ""


def know(context: SkillContext, person: PersonSeen, name: str) -> None:
    """From now on somebody who was seen has this name, here and later."""
    context.world.people.name_them(person.number, name)
    looks = KnownPerson(shirt=person.shirt, trousers=person.trousers, tag=person.tag)
    context.people.add(context.people.name(name) or name, looks)


def in_theirs(context: SkillContext, person: PersonSeen, words: str) -> str:
    """A sentence of ours in the language of whom it is said to, where it is known; else in that of the request."""
    return context.worded(words, context.people.about(person.name).language if person.name else None)


def addressed(person: PersonSeen, words: str) -> str:
    """With the name of whom it is said to before it."""
    if person.name is None:
        return words[:1].upper() + words[1:]
    if is_chinese(words):
        return f"{person.name}，{words}"
    keeps = words.split(" ", 1)[0] in ("I", "I'm")
    return f"{person.name}, {words if keeps else words[:1].lower() + words[1:]}"


def name_of(person: PersonSeen) -> str:
    name = called(person)
    return name[:1].upper() + name[1:]


def place_of_them(context: SkillContext, person: PersonSeen) -> str:
    room = next((r.name for r in context.robot.floor_map.rooms if r.holds(*person.position[:2])), "")
    return f" in the {room}" if room else ""


def data_of(person: PersonSeen) -> dict[str, str | float]:
    x, y, _ = person.position
    return {"name": person.name or "", "x": round(x, 3), "y": round(y, 3)}


_NAME_TOLD: Final = re.compile(
    r"(?:\b(?:[Ii] am|[Ii]'m|[Mm]y name is|[Cc]all me|[Ii]t is|[Ii]t's|[Tt]his is) (?:called )?)"
    r"(?P<en>[A-Z][\w'-]*(?: [A-Z][\w'-]*)?)|(?:我叫|我是|我的名字是|叫我)(?P<zh>[A-Za-z][\w'-]*|[\u3400-\u9fff]{1,6})"
)
_MALE: Final = re.compile(r"\b(?:man|boy|male|gentleman|he)\b|男|先生")
_FEMALE: Final = re.compile(r"\b(?:woman|girl|female|lady|she)\b|女")
_YES: Final = re.compile(r"(?:yes|yeah|yep|sure|right|that's me|i am)\b|是|对|没错|嗯")
_NO: Final = re.compile(r"(?:no|nope|not|nobody|sorry|i)\b|不|没")
