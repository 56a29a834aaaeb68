"""Being with people: find them, meet them, follow and guide them, tell and ask them, hand things over."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Final

from config.schema import KnownPerson
from engine.facts import fact
from engine.han import is_chinese
from engine.perception.naming import wanted
from engine.perception.people import Answer, PersonSeen
from engine.perception.someone import Someone
from engine.robot.arm import Joints
from engine.skills.accompany import STOOD_S, Pursuit, lead
from engine.skills.context import SkillContext
from engine.skills.find import room_called
from engine.skills.hand import close_fingers, fold, move_to, open_fingers, presses, still_held
from engine.skills.meeting import (
    APART,
    NEARER,
    called,
    face_point,
    find_somebody,
    fits,
    go_up_to,
    look_around,
    seen_now,
)
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Duration, Word, skill
from engine.skills.search import room_at
from engine.skills.travel import go_to
from engine.skills.vocabulary import ME

Who = Annotated[str, Word("person")]
Where = Annotated[str, Word("surface")]
RoomName = Annotated[str, Word("room")]
Sentence = Annotated[str, Word("sentence")]

ANYBODY: Final = "person"
THERE: Final = 1.5
"""m from a place within which somebody has arrived there."""
WALKED: Final = 1.5
"""m that somebody has to walk until they have arrived anywhere."""
BESIDE: Final = 2.2
"""m within which somebody is there to talk with."""
OFFER: Final[Joints] = (0.0, 0.25, 0.55, 0.65, 0.0)
"""The arm stretched out ahead, the hand level."""
ONE: Final = 0.45
"""m within which two sightings are one person, of whom legs and shirt were seen apart."""
TAKE_S: Final = 12.0
"""s in which somebody takes what is held out, or puts something between the fingers."""


def who_is(context: SkillContext, words: str) -> Someone:
    """Whom the argument of a skill means."""
    return Someone() if words == ME else context.people.who(words)


async def with_somebody(
    context: SkillContext, words: str, where: str = "", *, apart: float = APART, named: bool = True
) -> PersonSeen | Result:
    """Somebody who is meant, with the robot standing before them; or why not."""
    who = who_is(context, words)
    pose = context.pose

    def near(person: PersonSeen) -> bool:
        return math.dist(person.position[:2], (pose.x, pose.y)) < BESIDE

    person = None if where else _met(context, words) or seen_now(context, fits(context, who), near)
    if person is None:
        found = await find_somebody(context, who, where, named=named)
        if isinstance(found, Result):
            return found
        person = found
    went = await go_up_to(context, person, apart=apart)
    if not went.ok:
        return went
    await context.see()
    context.world.people.met = (words, person.number)
    return next((p for p in context.world.people.everybody if p.number == person.number), person)


def _met(context: SkillContext, words: str) -> PersonSeen | None:
    """The one whom the robot stands before because of the same words: they may not wave any more."""
    said, number = context.world.people.met
    pose = context.pose
    if said != words:
        return None
    person = next((p for p in context.world.people.everybody if p.number == number), None)
    return person if person is not None and person.distance_to(pose.x, pose.y) < BESIDE else None


@skill(occupies=["base", "arm", "camera"])
async def find_person(context: SkillContext, who: Who = ANYBODY, where: Where = "") -> Result:
    """Find somebody and go up to them: in a room or at a place if one is named, else through all rooms."""
    person = await with_somebody(context, who, where)
    if isinstance(person, Result):
        return person
    return ok(f"I found {called(person)}{_place(context, person)}.", **_data(person))


@skill(occupies=["base", "arm", "camera", "voice"])
async def meet(context: SkillContext, who: Who = ANYBODY, where: Where = "") -> Result:
    """Go to somebody, greet them, and learn their name if they are not known by sight."""
    person = await with_somebody(context, who, where, named=False)
    if isinstance(person, Result):
        return person
    meant = who_is(context, who)
    if person.name is not None and meant.name in ("", person.name):
        await context.say(_in_theirs(context, person, f"Hello, {person.name}."))
        return ok(f"I met {person.name}{_place(context, person)}.", **_data(person))
    name = await _learn_name(context, person, meant.name)
    if isinstance(name, Result):
        return name
    if meant.name and name and name != meant.name:
        return fail("object_not_found", f"I looked for {meant.name}, and met {name} there.", name=name)
    if not name:
        return ok(f"I met {called(person)}, who did not tell me their name.", **_data(person))
    return ok(f"I met {name}{_place(context, person)}.", **{**_data(person), "name": name})


async def _learn_name(context: SkillContext, person: PersonSeen, expected: str) -> str | Result:
    """Ask somebody for their name and remember it; empty where they do not tell it."""
    asks = f"Hello. Are you {expected}?" if expected else "Hello. What is your name?"
    if context.ask is None:
        await context.say(context.worded("Hello."))
        return expected
    answer = await context.ask(context.worded(asks))
    name = name_told(answer or "", expected)
    if expected and answer and not name:
        name = name_told(await context.ask(context.worded("What is your name?")) or "", "")
    if name:
        know(context, person, name)
    return name


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


_NAME_TOLD: Final = re.compile(
    r"(?:\b(?:[Ii] am|[Ii]'m|[Mm]y name is|[Cc]all me|[Ii]t is|[Ii]t's|[Tt]his is) (?:called )?)"
    r"(?P<en>[A-Z][\w'-]*(?: [A-Z][\w'-]*)?)|(?:我叫|我是|我的名字是|叫我)(?P<zh>[\u3400-\u9fff\w]{1,6})"
)
_YES: Final = re.compile(r"(?:yes|yeah|yep|sure|right|that's me|i am)\b|是|对|没错|嗯")
_NO: Final = re.compile(r"(?:no|nope|not|nobody|sorry|i)\b|不|没")


def know(context: SkillContext, person: PersonSeen, name: str) -> None:
    """From now on somebody who was seen has this name, here and later."""
    context.world.people.name_them(person.number, name)
    looks = KnownPerson(shirt=person.shirt, trousers=person.trousers, tag=person.tag)
    context.people.add(context.people.name(name) or name, looks)


@skill(occupies=["camera", "arm", "base"])
async def learn_name(context: SkillContext, name: Sentence) -> Result:
    """Remember that the person before the robot has this name."""
    pose = context.pose

    def near(person: PersonSeen) -> bool:
        return math.dist(person.position[:2], (pose.x, pose.y)) < BESIDE + 1.0

    person = seen_now(context, lambda other: True, near)
    if person is None:
        await look_around(context, lambda: seen_now(context, lambda other: True, near) is not None)
        person = seen_now(context, lambda other: True, near)
    if person is None:
        return fail("object_not_found", f"I see nobody before me who could be {name}.")
    know(context, person, name)
    return ok(f"Hello, {name}. I know you now.", name=name)


@skill(occupies=["base", "arm", "camera", "voice"], endless=True)
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
    began = person.position[:2]

    def there(at: tuple[float, float]) -> bool:
        if goal is None or room is None:
            return stands > 0 and math.dist(at, began) > WALKED
        return room.holds(*at) or math.dist(at, (goal.x, goal.y)) < THERE

    await context.say(_addressed(person, _in_theirs(context, person, "I follow you.")))
    return await Pursuit(context, person, called(person)).run(there, stands or STOOD_S)


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
    name = person.name or "the person"
    ask = f"Please follow me to {place}."
    await context.say(_addressed(person, _in_theirs(context, person, ask)))
    result = await lead(context, person, name, goal, place)
    if result.ok:
        await context.say(_in_theirs(context, person, f"Here we are: {place}."))
    return result


async def nearest_of(context: SkillContext, who: str) -> PersonSeen | Result:
    """Somebody who is meant and is near; else they are looked for and gone up to."""
    meant, pose = who_is(context, who), context.pose

    def near(person: PersonSeen) -> bool:
        return math.dist(person.position[:2], (pose.x, pose.y)) < BESIDE + 1.0

    person = _met(context, who) or seen_now(context, fits(context, meant), near)
    if person is None:
        await look_around(context, lambda: seen_now(context, fits(context, meant), near) is not None)
        person = seen_now(context, fits(context, meant), near)
    if person is not None:
        await face_point(context, person.position)
        return person
    if who == ME:
        return fail("object_not_found", "I see nobody here.")
    return await with_somebody(context, who)


@skill(occupies=["base", "arm", "camera", "voice"])
async def tell(context: SkillContext, who: Who, text: Sentence) -> Result:
    """Go to somebody and say something to them; the time, the day or a joke are told as they are then."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    words = fact(text) or text
    await context.say(_addressed(person, words))
    return ok(f"I told {called(person)}: “{words}”.", said=words)


def _in_theirs(context: SkillContext, person: PersonSeen, words: str) -> str:
    """A sentence of ours in the language of whom it is said to, where it is known; else in that of the request."""
    return context.worded(words, context.people.about(person.name).language if person.name else None)


def _addressed(person: PersonSeen, words: str) -> str:
    """With the name of whom it is said to before it."""
    if person.name is None:
        return words[:1].upper() + words[1:]
    if is_chinese(words):
        return f"{person.name}，{words}"
    keeps = words.split(" ", 1)[0] in ("I", "I'm")
    return f"{person.name}, {words if keeps else words[:1].lower() + words[1:]}"


@skill(occupies=["base", "arm", "camera", "voice"])
async def ask_person(context: SkillContext, who: Who, question: Sentence) -> Result:
    """Go to somebody, ask them something, and remember what they answer."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    if context.ask is None:
        return fail("not_supported", "I cannot hear answers here.")
    answer = await context.ask(_addressed(person, question))
    if not answer:
        return fail("no_progress", f"{called(person).capitalize()} did not answer.")
    context.world.people.heard(Answer(called(person), question, answer))
    return ok(f"{_name(person)} answered: “{answer}”.", answer=answer)


@skill(occupies=["voice"])
async def report_answer(context: SkillContext) -> Result:
    """Say what the person who was asked last has answered."""
    told = context.world.people.last_answer
    if told is None:
        return fail("nothing_held", "Nobody has answered me anything yet.")
    await context.say(context.worded(f"{told.who[:1].upper()}{told.who[1:]} said: “{told.answer}”."))
    return ok(f"I said what {told.who} had answered.", answer=told.answer)


@skill(occupies=["base", "arm", "camera", "voice"])
async def answer_question(context: SkillContext, who: Who = ANYBODY) -> Result:
    """Go to somebody, ask for their question, and answer it if the robot knows the answer."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    if context.ask is None:
        return fail("not_supported", "I cannot hear questions here.")
    asked = await context.ask(_addressed(person, _in_theirs(context, person, "What is your question?")))
    if not asked:
        return fail("no_progress", f"{_name(person)} asked nothing.")
    answer = fact(asked) or ("我不知道。" if is_chinese(asked) else "I do not know.")
    await context.say(answer)
    return ok(f"{_name(person)} asked: “{asked}”, and I said: “{answer}”.", question=asked, answer=answer)


@skill(occupies=["base", "arm", "camera"])
async def count_people(context: SkillContext, who: Who = ANYBODY, where: Where = "") -> Result:
    """Look through a room and say how many people, or how many of a kind, are there."""
    meant = who_is(context, who)
    room = room_called(context, where) if where else room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    everybody = await people_in(context, room.name)
    if isinstance(everybody, Result):
        return everybody
    fit = fits(context, meant)
    count = sum(fit(person) for person in everybody)
    return ok(f"In the {room.name} I see {_counted(count, meant)}.", people=count)


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
    for person in here:
        if all(math.dist(person.position[:2], other.position[:2]) > ONE for other in found):
            found.append(person)
    return tuple(found)


def _counted(count: int, who: Someone) -> str:
    """``no person sitting``, ``one woman``, ``2 people waving``."""
    if count < 2:
        return f"{'one' if count else 'no'} {who}"
    head, _, rest = str(who).partition(" ")
    several = {"person": "people", "woman": "women", "man": "men"}.get(head, head)
    return f"{count} {several} {rest}".rstrip()


@skill(occupies=["base", "arm", "camera", "voice"])
async def describe_person(context: SkillContext, who: Who = ANYBODY, what: Sentence = "") -> Result:
    """Say what somebody looks like, or one thing of them: name, gender, pose, gesture or clothes."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    gender = context.people.about(person.name).gender if person.name else None
    match what:
        case "name":
            if person.name is None:
                name = await _learn_name(context, person, "")
                if isinstance(name, Result) or not name:
                    return fail("no_progress", "They did not tell me their name.")
                return ok(f"The person is {name}.", name=name)
            return ok(f"The person is {person.name}.", name=person.name)
        case "gender":
            if gender is None:
                return fail("not_supported", f"I cannot tell whether {called(person)} is a man or a woman.")
            return ok(f"{_name(person)} is a {'woman' if gender == 'female' else 'man'}.", gender=gender)
        case "pose":
            if person.posture is None:
                return fail("not_supported", f"I cannot see whether {called(person)} sits or stands.")
            return ok(f"{_name(person)} is {_posture(person)}.", pose=person.posture)
        case "gesture":
            return ok(f"{_name(person)} is {person.gesture or 'making no gesture'}.", gesture=person.gesture or "")
        case "clothes":
            return ok(f"{_name(person)} wears {_clothes(person)}.")
    doing = " and ".join(filter(None, (_posture(person), person.gesture)))
    told = f"{_name(person)} wears {_clothes(person)}.{f' They are {doing}.' if doing else ''}"
    return ok(told, **_data(person))


def _posture(person: PersonSeen) -> str:
    return {"lying": "lying down"}.get(person.posture or "", person.posture or "")


def _clothes(person: PersonSeen) -> str:
    legs = f"{person.trousers} trousers" if person.trousers else ""
    shirt = f"a {person.shirt} shirt" if person.shirt else ""
    return " and ".join(filter(None, (shirt, legs))) or "something"


@skill(occupies=["base", "arm", "camera", "voice"])
async def hand_over(context: SkillContext, who: Who = ANYBODY) -> Result:
    """Go to somebody with what is held, hold it out, and let go when they take it."""
    held = context.world.held
    if held is None or not still_held(context):
        return fail("nothing_held", "I hold nothing that I could hand over.")
    person = await with_somebody(context, who, apart=NEARER)
    if isinstance(person, Result):
        return person
    await move_to(context, OFFER, speed=0.8)
    await context.say(_addressed(person, _in_theirs(context, person, f"Please take the {held.name}.")))
    if await _until(context, lambda: not presses(context), TAKE_S):
        context.world.put(None, context.robot.state().t)
        await open_fingers(context, 0.05)
        await fold(context)
        return ok(f"I gave the {held.name} to {called(person)}.", given=held.name)
    await fold(context)
    return fail("no_progress", f"{_name(person)} did not take the {held.name}; I still hold it.")


@skill(occupies=["base", "arm", "camera", "voice"])
async def take_from(
    context: SkillContext, who: Who = ANYBODY, thing: Annotated[str, Word("object")] = "thing"
) -> Result:
    """Go to somebody, hold out the open hand, and take what they put into it."""
    if context.world.held is not None and still_held(context):
        return fail("hand_full", f"I hold the {context.world.held.name} already.")
    person = await with_somebody(context, who, apart=NEARER)
    if isinstance(person, Result):
        return person
    await move_to(context, OFFER, speed=0.8)
    await open_fingers(context, context.robot.arm.jaw)
    await context.say(_addressed(person, _in_theirs(context, person, f"Please give me the {thing}.")))
    state = context.robot.state()
    end = state.work_t + TAKE_S
    while state.work_t < end:
        for _ in range(50):
            state = await context.robot.tick()
        await close_fingers(context)
        if presses(context):
            held = context.world.receive(wanted(thing), context.robot.state().t)
            await fold(context)
            return ok(f"{_name(person)} gave me the {held.name}.", taken=held.name)
        await open_fingers(context, context.robot.arm.jaw)
    await fold(context)
    return fail("no_progress", f"{_name(person)} gave me nothing.")


async def _until(context: SkillContext, holds: Callable[[], bool], limit_s: float) -> bool:
    state = context.robot.state()
    end = state.work_t + limit_s
    while not holds():
        if state.work_t > end:
            return False
        state = await context.robot.tick()
    return True


def _name(person: PersonSeen) -> str:
    name = called(person)
    return name[:1].upper() + name[1:]


def _place(context: SkillContext, person: PersonSeen) -> str:
    room = next((r.name for r in context.robot.floor_map.rooms if r.holds(*person.position[:2])), "")
    return f" in the {room}" if room else ""


def _data(person: PersonSeen) -> dict[str, str | float]:
    x, y, _ = person.position
    return {"name": person.name or "", "x": round(x, 3), "y": round(y, 3)}
