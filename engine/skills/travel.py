"""Driving to a pose on the map, however far away.

The way is planned on the fixed map, around what is remembered to lie on the floor, and followed tick by tick. When
the envelope's obstacle stop holds the robot back, what the lidar sees is added to the map and the way is planned anew,
a few times, before the robot gives up. It looks out meanwhile: where landmarks tell that it is elsewhere than it
believed, or where something small comes into view that lies in the way, the way is planned anew as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from engine.robot.floor_map import Doorway
from engine.robot.follow import Follower
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.occupancy import Route, Unreachable, route
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext
from engine.skills.doors import closed_door, is_closed
from engine.skills.drive import Stall, settle, stopped_before, why_held
from engine.skills.hand import look
from engine.skills.lookout import Lookout, lookout
from engine.skills.outcome import Result, fail, ok
from engine.skills.sent import send_to
from engine.skills.strewn import away_from, heed, in_the_way, nearest_to, outline, seen_from, strewn

SEEN_RANGE = 2.5  # m; what the lidar sees further away does not matter for a detour
DETOURS = 3  # times that a blocked way is planned anew

ASTRAY = 0.15  # m that a landmark may correct the robot by on its way; after more the way is planned anew
CORRECTIONS = 5  # times that this is done
CHECKS = 3  # times that the robot makes sure that it is there

TURNING = 0.01  # rad/s
NEARLY = 0.06  # m; a base that cannot go sideways, or is told late, may come no nearer

ASKS = 2  # times that somebody in the way is asked to let the robot pass
ASIDE_S = 2.5  # s in which they step aside
BACK_OFF_S = 1.5  # s for which the robot goes straight away from what it stands right beside
AHEAD, AHEAD_S, ASIDE = 1.2, 6.0, 0.9  # m, s and rad within which they are in the way

HEMMED = 3  # times that something small on the floor may leave no way on before the robot gives up

NOTHING_SEEN: Final[NDArray[np.float64]] = np.empty((0, 2))

Ending = Literal["arrived", "enough", "held", "astray", "strewn", "hemmed"]
Enough = Callable[[], bool]
"""Whether to stop on the way, because what the robot drives for is there already."""


SPEED: Final = 0.5
"""m/s, where nobody says otherwise."""


async def go_to(
    context: SkillContext, goal: Pose, name: str, *, speed: float = SPEED, enough: Enough = lambda: False
) -> Result:
    """Drive to ``goal`` and face its direction, no faster than ``speed`` m/s; ``name`` is what people call it. Fails
    with how far away it stopped and why. ``enough``: it stops where this comes true, and has not failed. A robot that
    finds its way itself is sent there, at its own speed."""
    if context.robot.navigates and (result := await send_to(context, goal, name)) is not None:
        return result
    async with lookout(context) as watch:
        return await _go_to(context, goal, name, watch, speed, enough)


async def _go_to(context: SkillContext, goal: Pose, name: str, watch: Lookout, speed: float, enough: Enough) -> Result:
    seen = NOTHING_SEEN
    shut: Doorway | None = None
    detours = corrections = hemmed = asked = 0
    while True:
        way = way_to(context, goal, seen)
        if isinstance(way, Unreachable):
            if shut is not None:
                return fail("door_closed", f"I cannot get to {name}: {is_closed(shut)}.")
            if detours:
                return fail("path_blocked", f"The way to {name} is blocked, and there is no other. {way.message}")
            return fail("unreachable", f"I cannot get to {name}. {way.message}")
        follower = Follower(way.points, goal.yaw, speed=speed)
        ending, state = await _follow(context, follower, name, watch, enough)
        if ending == "enough":
            return ok(f"I stopped on the way to {name}.", x=state.pose.x, y=state.pose.y, yaw=state.pose.yaw)
        if ending == "arrived":
            return ok(f"I am at {name}.", x=state.pose.x, y=state.pose.y, yaw=state.pose.yaw)
        if ending == "hemmed":
            hemmed += 1
            if hemmed == HEMMED:
                return fail("path_blocked", stopped_before(state, goal, name, _lies_there(context)))
            await look(context)  # it may not be there any more, or elsewhere
            continue
        if ending in ("astray", "strewn") and corrections < CORRECTIONS:
            corrections += 1
            continue
        code, reason = why_held(state)
        shut = closed_door(context) or shut
        if code == "path_blocked" and asked < ASKS and _somebody_ahead(context):
            asked += 1
            await context.say(context.worded("May I pass, please?"))
            await _stand(context, ASIDE_S)
            continue
        if code != "path_blocked" or detours == DETOURS:
            break
        detours += 1
        await back_off(context)
        seen = context.robot.scan().on_map(state.pose, SEEN_RANGE)
    if shut is not None:
        return fail("door_closed", stopped_before(state, goal, name, is_closed(shut)))
    return fail(code, stopped_before(state, goal, name, reason))


async def back_off(context: SkillContext) -> None:
    """Straight away from what the lidar sees right beside the hull, where there is such a thing: turning there would
    touch it."""
    robot, hull = context.robot, context.robot.footprint
    state = robot.state()
    end = state.work_t + BACK_OFF_S
    while state.work_t < end:
        points = seen_from(state.pose, robot.scan().on_map(state.pose, SEEN_RANGE))
        points = points[np.hypot(points[:, 0], points[:, 1]) < 1.0]
        away = away_from(points, hull)
        if not away:
            break
        context.drive(away[0])
        state = await robot.tick()
    await settle(context)


def _somebody_ahead(context: SkillContext) -> bool:
    """Whether somebody was seen just now who stands before the robot."""
    pose, now = context.pose, context.robot.state().t
    for person in context.world.people.everybody:
        x, y, _ = person.position
        aside = wrap(math.atan2(y - pose.y, x - pose.x) - pose.yaw)
        if now - person.seen_at < AHEAD_S and person.distance_to(pose.x, pose.y) < AHEAD and abs(aside) < ASIDE:
            return True
    return False


async def _stand(context: SkillContext, seconds: float) -> None:
    state = context.robot.state()
    end = state.work_t + seconds
    while state.work_t < end:
        state = await context.robot.tick()


def way_to(context: SkillContext, goal: Pose, seen: NDArray[np.float64] = NOTHING_SEEN) -> Route | Unreachable:
    """Around what lies about, if there is such a way; else as far as it goes. ``seen``: what else is in the way, as
    points in the map frame, shape (n, 2)."""
    robot, start = context.robot, context.pose
    lying = outline(strewn(context))
    way = route(robot.floor_map, start, goal, robot.footprint, extra=np.concatenate((seen, lying)))
    if isinstance(way, Unreachable) and len(lying):
        way = route(robot.floor_map, start, goal, robot.footprint, extra=seen)
    return way


async def _follow(
    context: SkillContext, follower: Follower, name: str, watch: Lookout, enough: Enough
) -> tuple[Ending, RobotState]:
    """Drive along the path: how that ended, and the state at rest, or the one in which it was held back."""
    context.progress(0.0, f"to {name}, {follower.length:.1f} m", path=follower.ahead())
    state = context.robot.state()
    stall = Stall(state.t, math.inf, 0.003)
    checks = 0
    hull = context.robot.footprint
    known = {thing.number for thing in strewn(context)}
    while True:
        if enough():
            return "enough", await settle(context)
        guidance = follower.guide(state.pose)
        if guidance.arrived:
            state = await settle(context)
            checks += 1
            if checks > CHECKS or not await watch.confirm():
                return "arrived", state
            state = context.robot.state()
            stall = Stall(state.t, math.inf, 0.003)
            continue
        twist = heed(state.pose, strewn(context), hull, _motions(guidance.twist, follower.sidle(state.pose)))
        if twist is None:
            return "hemmed", await settle(context)
        context.drive(twist)
        await watch.go_on()
        before, state = state, await context.robot.tick()
        if before.pose.distance_to(state.pose) > ASTRAY:
            return "astray", state
        if new := [thing for thing in strewn(context) if thing.number not in known]:
            known |= {thing.number for thing in new}
            if any(in_the_way(thing, follower.ahead(), hull.width / 2) for thing in new):
                await settle(context)
                return "strewn", context.robot.state()
        context.progress(follower.progress, f"{guidance.remaining:.1f} m to {name}")
        turning = abs(state.twist.wz) > TURNING  # at a corner, or into the goal's direction: not a stall
        if stall.update(state.t, guidance.remaining) and not turning:
            await settle(context)
            if guidance.remaining < NEARLY and why_held(state)[0] == "no_progress":
                return "arrived", state  # as near as its drive can bring it
            return "held" if twist == guidance.twist else "hemmed", state


def _motions(wanted: Twist, sideways: Twist) -> tuple[Twist, ...]:
    """What is wanted, and what to do rather than that: not to turn, to go sideways, and to turn alone."""
    others = (Twist(wanted.vx, wanted.vy), sideways, Twist(wz=wanted.wz))
    return wanted, *(twist for twist in others if not twist.is_zero)


def _lies_there(context: SkillContext) -> str:
    thing = nearest_to(context.pose, strewn(context))
    return f"the {thing.name} lies in the way" if thing is not None else "something lies in the way"
