"""Ahead of somebody who follows: behind the robot the lidar alone sees them, and it waits when it does not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from engine.perception.people import PersonSeen
from engine.robot.geometry import Pose
from engine.skills.context import SkillContext
from engine.skills.drive import settle
from engine.skills.hand import move_to
from engine.skills.legs import Legs
from engine.skills.meeting import face_point, go_up_to, look_around, look_through
from engine.skills.outcome import Result, fail, ok
from engine.skills.outfit import Outfit
from engine.skills.search import room_at
from engine.skills.servo import gaze, place_of
from engine.skills.travel import go_to
from engine.skills.with_people import addressed, in_theirs

GUIDE_SPEED: Final = 0.4
"""m/s ahead of somebody."""
BEHIND: Final = 2.4
"""m that somebody who is guided may fall behind."""
AGAIN: Final = 1.7
"""m within which the robot goes on."""
BESIDE: Final = 1.35
"""m within which they have arrived as well."""
CLOSES_S: Final = 6.0
"""s in which they come so near at the end."""
WAIT_S: Final = 15.0
"""s that it waits for somebody who has stayed behind, before it goes to fetch them."""
_FETCHES: Final = 3  # times that somebody who stays behind is fetched
_UNSEEN_S: Final = 1.5  # s without a sight of them until they count as behind
_CHEST: Final = 1.0  # m, where to look to see what somebody wears
_WAIST: Final = 0.6  # m, as low as it looks
_BESIDE_THEM: Final = 0.9  # m from their legs, within which who wears the same is they
_LATE_S: Final = 1.0  # s for which they are too far behind until the robot stops


class _LeftBehind(Exception):
    """Whoever is guided is too far behind."""


async def lead(context: SkillContext, person: PersonSeen, name: str, goal: Pose, place: str, outfit: Outfit) -> Result:
    """Ahead of somebody to ``goal``: stops when they fall behind, calls them, fetches them, and goes on. Whether it is
    still they who come along is looked at where somebody else has come near them, and at the end."""
    legs = Legs(context.robot, person.position[:2])
    fetched = 0
    while True:
        result = await _drive_ahead(context, legs, goal, place)
        if result is not None and not result.ok:
            return result
        near = result is not None and await _wait(context, legs, BESIDE, CLOSES_S)
        same = await _is_still(context, legs, outfit)
        if near and same:
            return ok(f"I guided {name} to {place}.", x=context.pose.x, y=context.pose.y)
        if same and result is None and legs.away < BEHIND:
            continue
        if same or result is None:  # they may hear it where they do not show
            await call(context, person, outfit)
            if await _wait(context, legs) and await _is_still(context, legs, outfit):
                continue
        fetched += 1
        if fetched > _FETCHES or not await _fetch(context, legs, outfit):
            where = place_of(context.robot.floor_map, *legs.at)
            return fail("target_lost", f"I lost {name} on the way to {place}: I last saw them {where}.")
        await call(context, person, outfit, place)


async def call(context: SkillContext, person: PersonSeen, outfit: Outfit, place: str = "") -> None:
    """Ask somebody to follow the robot to ``place``, or to come along, by their name or by what they wear: there may
    be others who feel addressed."""
    shirt = outfit.shirt if person.name is None else None
    if place:
        words = f"You in {shirt}, please follow me to {place}." if shirt else f"Please follow me to {place}."
    else:
        words = f"You in {shirt}, please come along." if shirt else "Please come along."
    await context.say(addressed(person, in_theirs(context, person, words)))


async def _is_still(context: SkillContext, legs: Legs, outfit: Outfit) -> bool:
    """Turn round and look whether it is they whose legs the lidar sees. Somebody in the same clothes who is seen beside
    them is they."""
    began = context.robot.state().t
    await face_point(context, (*legs.at, _CHEST))
    await context.see()
    legs.update()
    if (seen := _beside_them(context, legs, outfit, began)) is None:
        await _look_down(context, legs)
        seen = _beside_them(context, legs, outfit, began)
    if seen is None:
        return False
    legs.moved_to((seen.position[0], seen.position[1]))
    legs.is_sure()
    return True


def _beside_them(context: SkillContext, legs: Legs, outfit: Outfit, began: float) -> PersonSeen | None:
    here = outfit.worn_since(began, context.world.people.everybody)
    near = [person for person in here if person.distance_to(*legs.at) <= _BESIDE_THEM]
    return min(near, key=lambda person: person.distance_to(*legs.at), default=None)


async def _look_down(context: SkillContext, legs: Legs) -> None:
    """As far as their waist: from close by, only that parts them from somebody who stands right beside them."""
    away = max(0.4, legs.away)
    await move_to(context, gaze(context.robot.arm, (away, 0.0, _WAIST)), speed=2.0)
    await context.see()
    legs.update()


async def _drive_ahead(context: SkillContext, legs: Legs, goal: Pose, place: str) -> Result | None:
    """Drive until it is there; None where they are too far behind."""
    late_since = math.inf

    def watch(
        fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None:
        """Called in every tick of the drive."""
        nonlocal late_since
        context.progress(fraction, message, path=path)
        legs.update()
        now = context.robot.state().t
        late = legs.unseen_s > _UNSEEN_S or legs.away > BEHIND or legs.crossed
        late_since = min(late_since, now) if late else math.inf
        if now - late_since > _LATE_S:
            raise _LeftBehind

    try:
        return await go_to(replace(context, progress=watch), goal, place, speed=GUIDE_SPEED)
    except _LeftBehind:
        await settle(context)
        return None


async def _wait(context: SkillContext, legs: Legs, within: float = AGAIN, limit_s: float = WAIT_S) -> bool:
    """Until they are near, or for so long."""
    state = context.robot.state()
    end = state.work_t + limit_s
    while state.work_t < end:
        legs.update()
        if legs.unseen_s < 0.5 and legs.away < within:
            return True
        state = await context.robot.tick()
    return False


async def _fetch(context: SkillContext, legs: Legs, outfit: Outfit) -> bool:
    """Look for them, first from here, then from where they were last."""
    began = context.robot.state().t
    found: list[PersonSeen] = []

    def seen() -> bool:
        found[:] = outfit.worn_since(began, context.world.people.everybody)
        return bool(found)

    await look_around(context, seen)
    if not found:
        x, y = legs.at
        pose = context.pose
        direction = math.atan2(y - pose.y, x - pose.x)
        goal = Pose(x - math.cos(direction), y - math.sin(direction), direction)
        await go_to(context, goal, "where they stayed", enough=seen)
    if not found:
        await look_around(context, seen)
    if not found:
        await look_through(context, room_at(context.robot.floor_map, *legs.at), seen)
    if not found:
        return False
    legs.update()
    person = min(found, key=lambda p: p.distance_to(*legs.at))
    legs.moved_to((person.position[0], person.position[1]))
    legs.is_sure()
    if legs.away > AGAIN:
        await go_up_to(context, person)
        await _is_still(context, legs, outfit)
    return True
