"""Handing things to people, and taking what they hand over."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Final

from engine.perception.memory import Thing as Held
from engine.perception.naming import wanted
from engine.perception.people import PersonSeen
from engine.robot.arm import Joints
from engine.skills.context import SkillContext
from engine.skills.hand import close_fingers, fold, move_to, open_fingers, presses, still_held
from engine.skills.library.manipulation import fetch
from engine.skills.library.people import as_now, those_in
from engine.skills.meeting import NEARER, called, go_up_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Word, skill
from engine.skills.with_people import (
    ANYBODY,
    Those,
    Where,
    Who,
    addressed,
    in_theirs,
    name_of,
    with_somebody,
)

Thing = Annotated[str, Word("object")]
OFFER: Final[Joints] = (0.0, 0.25, 0.55, 0.65, 0.0)
"""The arm stretched out ahead, the hand level."""
TAKE_S: Final = 12.0
"""s in which somebody takes what is held out, or puts something between the fingers."""


@skill(occupies=["base", "arm", "camera", "voice"])
async def hand_over(context: SkillContext, who: Who = ANYBODY) -> Result:
    """Go to somebody with what is held, hold it out, and let go when they take it."""
    held = context.world.held
    if held is None or not still_held(context):
        return fail("nothing_held", "I hold nothing that I could hand over.")
    person = await with_somebody(context, who, apart=NEARER)
    if isinstance(person, Result):
        return person
    return await _hand_to(context, person, held)


@skill(occupies=["base", "arm", "camera", "voice"], lasting=True)
async def serve(context: SkillContext, object: Thing, who: Those = ANYBODY, where: Where = "") -> Result:
    """Bring a thing of a kind to each person in a room, or to each of these: one after the other is fetched and handed
    over."""
    found = await those_in(context, who, where)
    if isinstance(found, Result):
        return found
    room, guests = found
    served: list[PersonSeen] = []
    for guest in guests:
        if context.world.held is None and not (picked := await fetch(context, wanted(object))).ok:
            return _served(served, picked)
        if (held := context.world.held) is None or not still_held(context):
            return _served(served, fail("dropped", f"I have lost the {object}."))
        person = as_now(context, guest, guests)
        went = await go_up_to(context, person, apart=NEARER)
        handed = await _hand_to(context, person, held) if went.ok else went
        if not handed.ok:
            return _served(served, handed)
        served.append(person)
    return ok(f"I served {len(served)} people in the {room}.", served=len(served))


def _served(served: list[PersonSeen], trouble: Result) -> Result:
    """A failure that says who has got something before it."""
    done = f"I served {' and '.join(map(called, served))}. " if served else ""
    return fail(trouble.error_code or "no_progress", f"{done}{trouble.message}", served=len(served))


async def _hand_to(context: SkillContext, person: PersonSeen, held: Held) -> Result:
    """Hold it out to whom the robot stands before, and let go when they take it."""
    await move_to(context, OFFER, speed=0.8)
    await context.say(addressed(person, in_theirs(context, person, f"Please take the {held.name}.")))
    if await _until(context, lambda: not presses(context), TAKE_S):
        context.world.put(None, context.robot.state().t)
        await open_fingers(context, 0.05)
        await fold(context)
        return ok(f"I gave the {held.name} to {called(person)}.", given=held.name)
    await fold(context)
    return fail("no_progress", f"{name_of(person)} did not take the {held.name}; I still hold it.")


@skill(occupies=["base", "arm", "camera", "voice"])
async def take_from(context: SkillContext, who: Who = ANYBODY, thing: Thing = "thing") -> Result:
    """Go to somebody, hold out the open hand, and take what they put into it."""
    if context.world.held is not None and still_held(context):
        return fail("hand_full", f"I hold the {context.world.held.name} already.")
    person = await with_somebody(context, who, apart=NEARER)
    if isinstance(person, Result):
        return person
    await move_to(context, OFFER, speed=0.8)
    await open_fingers(context, context.robot.arm.jaw)
    await context.say(addressed(person, in_theirs(context, person, f"Please give me the {thing}.")))
    state = context.robot.state()
    end = state.work_t + TAKE_S
    while state.work_t < end:
        for _ in range(50):
            state = await context.robot.tick()
        await close_fingers(context)
        if presses(context):
            held = context.world.receive(wanted(thing), context.robot.state().t)
            await fold(context)
            return ok(f"{name_of(person)} gave me the {held.name}.", taken=held.name)
        await open_fingers(context, context.robot.arm.jaw)
    await fold(context)
    return fail("no_progress", f"{name_of(person)} gave me nothing.")


async def _until(context: SkillContext, holds: Callable[[], bool], limit_s: float) -> bool:
    state = context.robot.state()
    end = state.work_t + limit_s
    while not holds():
        if state.work_t > end:
            return False
        state = await context.robot.tick()
    return True
