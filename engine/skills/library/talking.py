"""Talking with people: telling, asking, and answering them."""

from __future__ import annotations

import re
from typing import Final

from engine.facts import fact
from engine.han import is_chinese
from engine.perception.people import Answer, PersonSeen
from engine.skills.context import SkillContext
from engine.skills.find import NO_WAY, by_distance
from engine.skills.library.people import as_now, those_in
from engine.skills.meeting import called, go_up_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import skill
from engine.skills.with_people import (
    ANYBODY,
    Sentence,
    Those,
    Where,
    Who,
    addressed,
    in_theirs,
    name_of,
    with_somebody,
)


@skill(occupies=["base", "arm", "camera", "voice"])
async def tell(context: SkillContext, who: Who, text: Sentence) -> Result:
    """Go to somebody and say something to them; the time, the day or a joke are told as they are then."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    words = fact(text) or text
    await context.say(addressed(person, words))
    return ok(f"I told {called(person)}: “{words}”.", said=words)


@skill(occupies=["base", "arm", "camera", "voice"], lasting=True)
async def tell_everyone(context: SkillContext, text: Sentence, who: Those = ANYBODY, where: Where = "") -> Result:
    """Go to each person in a room, or to each of these, and say something to them; without a room, through all of
    them."""
    words = fact(text) or text
    rooms = (where,) if where else tuple(room.name for room in by_distance(context.robot.floor_map, context.pose))
    told: list[PersonSeen] = []
    shut: Result | None = None
    for room in rooms:
        found = await those_in(context, who, room)
        people = () if isinstance(found, Result) else found[1]
        if isinstance(found, Result) and found.error_code != "object_not_found":
            shut = found
            if found.error_code not in NO_WAY:
                break
        for one in people:
            person = as_now(context, one, people)
            went = await go_up_to(context, person)
            if not went.ok:
                return _told_only(told, went)
            await context.say(addressed(person, words))
            told.append(person)
    if shut is not None:
        return _told_only(told, shut)
    if not told:
        return fail("object_not_found", f"I looked in the {where} and saw nobody." if where else "I saw nobody at all.")
    return ok(f"I told {len(told)} people: “{words}”.", said=words, told=len(told))


def _told_only(told: list[PersonSeen], trouble: Result) -> Result:
    """A failure that says who has heard it before."""
    before = f"I told {' and '.join(map(called, told))}. " if told else ""
    return fail(trouble.error_code or "no_progress", f"{before}{trouble.message}", told=len(told))


@skill(occupies=["base", "arm", "camera", "voice"])
async def ask_person(context: SkillContext, who: Who, question: Sentence) -> Result:
    """Go to somebody, ask them something, and remember what they answer."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    if context.ask is None:
        return fail("not_supported", "I cannot hear answers here.")
    answer = await context.ask(addressed(person, question))
    if not answer:
        return fail("no_progress", f"{called(person).capitalize()} did not answer.")
    context.world.people.heard(Answer(called(person), question, answer))
    return ok(f"{name_of(person)} answered: “{answer}”.", answer=answer)


@skill(occupies=["voice"], changes=[])
async def report_answer(context: SkillContext) -> Result:
    """Say what the person who was asked last has answered."""
    told = context.world.people.last_answer
    if told is None:
        return fail("nothing_held", "Nobody has answered me anything yet.")
    await context.say(context.worded(f"{told.who[:1].upper()}{told.who[1:]} said: “{told.answer}”."))
    return ok(f"I said what {told.who} had answered.", answer=told.answer)


_NO_QUESTION: Final = re.compile(
    r"\W*(?:no(?:ne|thing|pe)?|i (?:do not|don't) (?:know|have (?:one|any|a question)))\b[^?]*|"
    r"\W*(?:没有?|不知道|我不知道)[^？?吗]*",
    re.IGNORECASE,
)
"""What somebody says who has no question."""


@skill(occupies=["base", "arm", "camera", "voice"])
async def answer_question(context: SkillContext, who: Who = ANYBODY) -> Result:
    """Go to somebody, ask for their question, and answer it if the robot knows the answer."""
    person = await with_somebody(context, who)
    if isinstance(person, Result):
        return person
    if context.ask is None:
        return fail("not_supported", "I cannot hear questions here.")
    asked = await context.ask(addressed(person, in_theirs(context, person, "What is your question?")))
    if not asked or _NO_QUESTION.fullmatch(asked):
        return fail("no_progress", f"{name_of(person)} asked nothing.")
    answer = fact(asked) or ("我不知道。" if is_chinese(asked) else "I do not know.")
    await context.say(answer)
    return ok(f"{name_of(person)} asked: “{asked}”, and I said: “{answer}”.", question=asked, answer=answer)
