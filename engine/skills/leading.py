"""Ahead of somebody who follows: behind the robot the lidar alone sees them, and it waits when it does not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from engine.perception.people import PersonSeen
from engine.robot.geometry import Pose
from engine.skills.context import SkillContext
from engine.skills.drive import settle
from engine.skills.legs import Legs
from engine.skills.meeting import face_point, look_around
from engine.skills.outcome import Result, fail, ok
from engine.skills.servo import place_of
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
_FETCHES: Final = 2  # times that somebody who stays behind is fetched
_UNSEEN_S: Final = 1.5  # s without a sight of them until they count as behind
_LATE_S: Final = 1.0  # s for which they are too far behind until the robot stops


class _LeftBehind(Exception):
    """Whoever is guided is too far behind."""


async def lead(context: SkillContext, person: PersonSeen, name: str, goal: Pose, place: str) -> Result:
    """Ahead of somebody to ``goal``: stops when they fall behind, calls them, fetches them, and goes on."""
    legs = Legs(context.robot, person.position[:2])
    fetched = 0
    while True:
        result = await _drive_ahead(context, legs, goal, place)
        if result is not None and not result.ok:
            return result
        if result is not None and await _wait(context, legs, BESIDE, CLOSES_S):
            await face_point(context, (*legs.at, 1.0))
            return ok(f"I guided {name} to {place}.", x=context.pose.x, y=context.pose.y)
        await face_point(context, (*legs.at, 1.0))
        await context.say(addressed(person, in_theirs(context, person, "Please come along.")))
        if await _wait(context, legs):
            continue
        fetched += 1
        if fetched > _FETCHES or not await _fetch(context, legs, person):
            where = place_of(context.robot.floor_map, *legs.at)
            return fail("target_lost", f"I lost {name} on the way to {place}: I last saw them {where}.")
        await context.say(addressed(person, in_theirs(context, person, f"Please follow me to {place}.")))


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
        late = legs.unseen_s > _UNSEEN_S or legs.away > BEHIND
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


async def _fetch(context: SkillContext, legs: Legs, person: PersonSeen) -> bool:
    """Go back to where they are."""
    x, y = legs.at
    pose = context.pose
    direction = math.atan2(y - pose.y, x - pose.x)
    goal = Pose(x - 1.0 * math.cos(direction), y - 1.0 * math.sin(direction), direction)
    await go_to(context, goal, "where they stayed")

    def same(other: PersonSeen) -> bool:
        return other.number == person.number or (other.shirt == person.shirt and other.trousers == person.trousers)

    began = context.robot.state().t
    await look_around(context, lambda: any(same(p) and p.seen_at > began for p in context.world.people.everybody))
    found = next((p for p in context.world.people.everybody if same(p) and p.seen_at > began), None)
    if found is None:
        return False
    legs.moved_to((found.position[0], found.position[1]))
    return True
