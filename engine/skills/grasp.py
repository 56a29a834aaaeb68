"""Picking a thing up: go there, look closely, aim, close the fingers on it, and make sure that it came along.

The fingers go down on a straight line beside the thing and close with force. What keeps them apart tells whether they
hold it: as they close, all the way up, and once more when the arm has folded. A grasp that failed is tried once more
after looking again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from engine.perception.memory import Thing
from engine.perception.sighting import Kind
from engine.robot.arm import ArmModel
from engine.robot.geometry import Pose
from engine.robot.robot import RobotState
from engine.skills.aim import Grasp, plan, reach_of, top_of, view
from engine.skills.approach import stand_before
from engine.skills.context import SkillContext
from engine.skills.feet import is_part_of_somebody
from engine.skills.hand import (
    close_fingers,
    fold,
    from_map,
    look,
    move_along,
    move_to,
    open_fingers,
    presses,
    still_held,
)
from engine.skills.outcome import Result, fail, ok

ATTEMPTS: Final = 2
_LOOKS = 3  # close looks before a place is found to be empty
_AIM_ASIDE = 0.4  # rad to each side that the arm turns rather than the base
_SAME_PLACE = 0.025  # m
_AIMED = 0.02  # m that a thing may be off the middle of a close look
_WIDE = (0.33, 0.3, 0.27)  # m, for a look with more around it
_CLEAR = 1.0  # m from which one sees well how wide a thing is
_SLACK = 0.004  # m that the fingers must open wider than a thing
_PALE: Final = ("white", "grey", "black")
_TALLER = 1.4  # times as high as a cup is a bottle
_LOST = 0.25  # m around which a thing is looked for that is not where it was


async def pick(context: SkillContext, thing: Thing) -> Result:
    """Pick ``thing`` up: the arm is folded and holds it then, and the memory knows."""
    held = context.world.held
    if held is not None:
        return fail("hand_full", f"I hold the {held.name} already.")
    if thing.named_from < _CLEAR and thing.size[0] > context.robot.arm.jaw - _SLACK:
        return fail("out_of_reach", too_wide(context.robot.arm, thing))
    if await is_part_of_somebody(context, thing):
        return fail("object_not_found", f"What I took for the {thing.name} is part of somebody who is there.")
    wanted, trouble = thing, fail("grasp_failed", f"I could not grip the {thing.name}.")
    for attempt in range(ATTEMPTS):
        found = await _meet(context, thing)
        if isinstance(found, Result):
            return await _fold(context, found if attempt == 0 else _after(trouble, found))
        thing, grasp = found
        if _mistaken(wanted, thing):
            message = f"What I took for the {wanted.name} is the {thing.name}."
            return await _fold(context, fail("object_not_found", message))
        trouble = await _seize(context, thing, grasp)
        if trouble.ok:
            return await _fold(context, trouble)
        context.progress(None, f"{trouble.message} I try again.")
    await _fold(context, trouble)
    return _where_now(context, wanted, trouble)


_STANDS: Final[frozenset[Kind]] = frozenset(("box", "block", "cup", "bottle"))


def _mistaken(thing: Thing, seen: Thing) -> bool:
    """Whether a close look showed something else. Labels and caps are pale; a strong colour is a thing's own."""
    if thing.colour != seen.colour:
        return seen.colour not in _PALE
    kinds = {thing.kind, seen.kind}
    if seen.whole and "ball" in kinds and kinds & _STANDS:
        return seen.named_from < thing.named_from  # from close by, what is round is
    if not seen.whole or len(kinds) == 1 or "thing" in kinds or kinds == {"box", "block"}:
        return False
    low, high = sorted((thing.size[1], seen.size[1]))
    return high > _TALLER * low or (kinds == {"cup", "bottle"} and not thing.whole)


def too_wide(arm: ArmModel, thing: Thing) -> str:
    """Why it cannot be gripped at all, for people."""
    widest = 100 * (arm.jaw - _SLACK)
    return f"The {thing.name} is {100 * thing.size[0]:.1f} cm wide, and my fingers grip {widest:.1f} cm at most."


async def _fold(context: SkillContext, result: Result) -> Result:
    """Fold the arm; what is held must survive that."""
    await fold(context)
    held = context.world.held
    if result.ok and held is not None and not still_held(context):
        return lost(context, held)
    return result


def lost(context: SkillContext, held: Thing) -> Result:
    """The fingers are empty: for the memory, and as a result."""
    context.world.put(None, context.robot.state().t)
    pose = context.pose
    return fail("dropped", f"The {held.name} slipped out of my fingers near x {pose.x:.1f} m, y {pose.y:.1f} m.")


def _after(trouble: Result, found: Result) -> Result:
    """The second attempt did not come about: both belong into the report."""
    code = trouble.error_code if found.error_code == "object_not_found" else found.error_code
    return fail(code or "grasp_failed", f"{trouble.message} {found.message}")


def _where_now(context: SkillContext, wanted: Thing, trouble: Result) -> Result:
    """Add to a failure what is known of the thing."""
    now = next((other for other in context.world.things if other.number == wanted.number), None)
    if now is None:
        return trouble
    moved = now.distance_to(*wanted.position[:2])
    if moved < 0.03:
        return fail(trouble.error_code or "grasp_failed", f"{trouble.message} It stands where it was.")
    x, y, _ = from_map(context.pose, now.position)
    x0, y0, _ = from_map(context.pose, wanted.position)
    side = "to the left" if y - y0 > abs(x - x0) else "to the right" if y0 - y > abs(x - x0) else ""
    side = side or ("further away" if x > x0 else "nearer")
    return fail(
        trouble.error_code or "grasp_failed", f"{trouble.message} It lies about {100 * moved:.0f} cm {side} now."
    )


async def _meet(context: SkillContext, thing: Thing) -> tuple[Thing, Grasp] | Result:
    """Stand before the thing, look closely, and aim; or why not."""
    arm = context.robot.arm
    for place in range(3):
        if not _within(arm, thing, context.pose):
            result = await _go_near(context, thing)
            if not result.ok:
                return result
        seen = await _look_closely(context, thing)
        if isinstance(seen, Result):
            return seen
        thing = seen
        beside = _others(context, thing)
        shown = [other for other in beside if other.seen_at == thing.seen_at]  # if nothing else helps: these are real
        grasp = plan(arm, thing, context.pose, beside) or plan(arm, thing, context.pose, shown)
        if grasp is not None:
            return thing, grasp
        if place == 1:
            break
        result = await _go_near(context, thing)
        if not result.ok:
            return result
    return fail("out_of_reach", f"I stand before the {thing.name}, but my fingers find no way to it.")


def _others(context: SkillContext, thing: Thing) -> list[Thing]:
    """What else lies about. Two things cannot be in one place: what was taken for another there is forgotten."""
    rest = [other for other in context.world.things if other.number != thing.number]
    for other in rest:
        if other.distance_to(*thing.position[:2]) < thing.size[0] / 2:
            context.world.forget(other)
    return [other for other in rest if other.distance_to(*thing.position[:2]) >= thing.size[0] / 2]


def _within(arm: ArmModel, thing: Thing, pose: Pose) -> bool:
    """Whether it is in reach from here."""
    x, y, _ = from_map(pose, thing.position)
    if abs(math.atan2(y, x)) > _AIM_ASIDE:
        return False
    return plan(arm, thing, pose) is not None and view(arm, (x, y, top_of(thing))) is not None


async def _go_near(context: SkillContext, thing: Thing) -> Result:
    reach = reach_of(context.robot.arm, thing)
    tall = thing.surface < 0.05 and thing.size[1] > 0.09  # the lidar sees it, and the obstacle stop keeps away from it
    radius = thing.size[0] / 2 + (0.05 if tall else 0.0)
    return await stand_before(context, thing.position, reach, f"the {thing.name}", radius=radius, target=thing)


async def _look_closely(context: SkillContext, thing: Thing) -> Thing | Result:
    """Hold the camera over the thing until a picture shows it in the middle: where it is now."""
    arm = context.robot.arm
    context.progress(None, f"looking at the {thing.name}")
    missed = False
    for _ in range(_LOOKS):
        x, y, _ = from_map(context.pose, thing.position)
        point = (x, y, top_of(thing))
        joints = (view(arm, point, distances=_WIDE) if missed else None) or view(arm, point)
        if joints is None:
            return fail("out_of_reach", f"I cannot look at the {thing.name} from above.")
        if not await move_to(context, joints):
            return fail("no_progress", "The arm does not get to where I wanted to look from.")
        sight = await look(context)
        found = _again(context, thing, sight.t)
        if found is None and missed:
            context.world.forget(thing)
            return fail("object_not_found", f"The {thing.name} is not where I saw it{_last(context, thing)}.")
        missed = found is None  # then once more from further away
        if found is not None:
            off = found.distance_to(*thing.position[:2])
            thing = found
            if off < _AIMED:
                break
    return thing


def _last(context: SkillContext, thing: Thing) -> str:
    ago = context.robot.state().t - thing.seen_at
    return f" {ago:.0f} s ago" if ago >= 2 else ""


def _again(context: SkillContext, thing: Thing, t: float) -> Thing | None:
    """The thing in the sight taken at ``t``: itself, or one like it close by, or whatever is in its very place, which
    looks a little different from near."""
    seen = [other for other in context.world.things if other.seen_at == t]
    same = next((other for other in seen if other.number == thing.number), None)
    if same is not None:
        return same
    like = [
        other
        for other in seen
        if other.kind in (thing.kind, "thing") and other.colour == thing.colour and other.tag in (thing.tag, None)
    ]
    near = min(like, key=lambda other: other.distance_to(*thing.position[:2]), default=None)
    if near is not None and near.distance_to(*thing.position[:2]) < _LOST:
        return near
    there = min(seen, key=lambda other: other.distance_to(*thing.position[:2]), default=None)
    if there is None or there.distance_to(*thing.position[:2]) > _SAME_PLACE:
        return None
    if _mistaken(thing, there):
        return there
    size = (max(there.size[0], thing.size[0]), max(there.size[1], thing.size[1]))
    return replace(there, kind=thing.kind, colour=thing.colour, tag=thing.tag, size=size)


async def _seize(context: SkillContext, thing: Thing, grasp: Grasp) -> Result:
    """Take it. The memory holds it from the moment in which the fingers do, and no longer, whatever interrupts."""
    context.progress(None, f"gripping the {thing.name}")
    stuck = fail("no_progress", f"The arm does not get to the {thing.name}.")
    await open_fingers(context, grasp.opening)
    if not await move_to(context, grasp.before):
        return stuck
    if not await move_along(context, grasp.point, speed=0.12):
        return stuck
    world = context.world
    try:
        if not await close_fingers(context, lambda: world.take(thing, grasp.pitch)):
            return await _missed(context, thing, grasp, "My fingers closed on nothing")
        if not await move_along(context, grasp.lifted, speed=0.12, until=_empty(context)):
            return stuck
    finally:
        if world.held is not None and not still_held(context):
            world.put(thing.position, context.robot.state().t)
    if world.held is None:
        return await _missed(context, thing, grasp, f"The {thing.name} slipped out of my fingers")
    return ok(f"I hold the {thing.name}.", held=thing.name)


def _empty(context: SkillContext) -> Callable[[RobotState], bool]:
    """For :func:`move_along`: nothing keeps the fingers apart."""

    def told(state: RobotState) -> bool:
        return not presses(context, state)

    return told


async def _missed(context: SkillContext, thing: Thing, grasp: Grasp, words: str) -> Result:
    """Nothing between the fingers: get out of the way, and say so."""
    await open_fingers(context, grasp.opening)
    await move_along(context, grasp.lifted, speed=0.15)
    return fail("grasp_failed", f"{words}.")
