"""Driving to a pose on the map, however far away.

The way is planned on the fixed map, around what is remembered to lie on the floor, and followed tick by tick. When
the envelope's obstacle stop holds the robot back, what the lidar sees is added to the map and the way is planned anew,
a few times, before the robot gives up. It looks out meanwhile: where landmarks tell that it is elsewhere than it
believed, or where something small comes into view that lies in the way, the way is planned anew as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.perception.memory import Thing
from engine.robot.follow import Follower
from engine.robot.occupancy import Route, Unreachable, route
from engine.robot.robot import Doorway, Pose, RobotState, Scan
from engine.skills.context import SkillContext
from engine.skills.drive import Stall, settle, why_held
from engine.skills.lookout import Lookout, lookout
from engine.skills.outcome import Result, fail, ok

DETOURS = 3  # times that a blocked way is planned anew
SEEN_RANGE = 2.5  # m; what the lidar sees further away does not matter for a detour

ASTRAY = 0.15  # m that a landmark may correct the robot by on its way; after more the way is planned anew
CORRECTIONS = 5  # times that this is done
CHECKS = 3  # times that the robot makes sure that it is there

DOOR_RANGE = 1.5  # m from which the lidar can tell whether a door is shut
FILLED = 0.6  # part of a door's width

TURNING = 0.01  # rad/s

STREWN_LOW = 0.05  # m: what stands lower lies on the floor, where the lidar may not see it
BESIDE = 0.03  # m between the hull's side and something small that it passes

Ending = Literal["arrived", "held", "astray", "strewn"]


async def go_to(context: SkillContext, goal: Pose, name: str) -> Result:
    """Drive to ``goal`` and face its direction; ``name`` is what people call it. Fails with how far away it stopped
    and why."""
    async with lookout(context) as watch:
        return await _go_to(context, goal, name, watch)


async def _go_to(context: SkillContext, goal: Pose, name: str, watch: Lookout) -> Result:
    seen = np.empty((0, 2))
    shut: Doorway | None = None
    detours = corrections = 0
    while True:
        way = _way(context, goal, seen)
        if isinstance(way, Unreachable):
            if shut is not None:
                return fail("door_closed", f"I cannot get to {name}: {_closed(shut)}.")
            if detours:
                return fail("path_blocked", f"The way to {name} is blocked, and there is no other. {way.message}")
            return fail("unreachable", f"I cannot get to {name}. {way.message}")
        follower = Follower(way.points, goal.yaw)
        ending, state = await _follow(context, follower, name, watch)
        if ending == "arrived":
            return ok(f"I am at {name}.", x=state.pose.x, y=state.pose.y, yaw=state.pose.yaw)
        if ending != "held" and corrections < CORRECTIONS:
            corrections += 1
            continue
        code, reason = why_held(state)
        shut = closed_door(context) or shut
        if code != "path_blocked" or detours == DETOURS:
            break
        detours += 1
        seen = points_of(context.robot.scan(), state.pose, SEEN_RANGE)
    left = math.dist((state.pose.x, state.pose.y), (goal.x, goal.y))
    if shut is not None:
        return fail("door_closed", f"I stopped {left:.1f} m before {name}: {_closed(shut)}.")
    return fail(code, f"I stopped {left:.1f} m before {name}: {reason}.")


def _way(context: SkillContext, goal: Pose, seen: NDArray[np.float64]) -> Route | Unreachable:
    """Around what lies about, if there is such a way; else over it rather than not at all."""
    robot, start = context.robot, context.pose
    strewn = np.concatenate([_outline(thing) for thing in _strewn(context)] or [np.empty((0, 2))])
    way = route(robot.floor_map, start, goal, robot.footprint, extra=np.concatenate((seen, strewn)))
    if isinstance(way, Unreachable) and len(strewn):
        way = route(robot.floor_map, start, goal, robot.footprint, extra=seen)
    return way


def _strewn(context: SkillContext) -> list[Thing]:
    """Small things that are remembered to lie on the floor."""
    return [thing for thing in context.world.things if thing.surface < STREWN_LOW and thing.kind != "person"]


def _outline(thing: Thing) -> NDArray[np.float64]:
    """Points around a thing, map frame, shape (n, 2)."""
    angles = np.linspace(0, 2 * math.pi, 8, endpoint=False)
    radius = thing.size[0] / 2
    around = np.column_stack((np.cos(angles), np.sin(angles))) * radius + np.array(thing.position[:2])
    return np.concatenate((around, [thing.position[:2]]))


def _in_the_way(thing: Thing, path: Sequence[tuple[float, float]], half_width: float) -> bool:
    """Whether the hull would touch it on what is left of the path."""
    x, y = thing.position[:2]
    near = half_width + thing.size[0] / 2 + BESIDE
    return any(_distance_to_stretch((x, y), a, b) < near for a, b in pairwise(path))


def _distance_to_stretch(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = dx * dx + dy * dy
    along = 0.0 if length == 0 else max(0.0, min(1.0, ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / length))
    return math.dist(point, (a[0] + along * dx, a[1] + along * dy))


def closed_door(context: SkillContext) -> Doorway | None:
    """The nearest door that the lidar sees to be shut: something fills most of its width."""
    pose = context.pose
    points = points_of(context.robot.scan(), pose, SEEN_RANGE)
    near = [
        door for door in context.robot.floor_map.doors if math.dist((door.x, door.y), (pose.x, pose.y)) < DOOR_RANGE
    ]
    for door in sorted(near, key=lambda door: math.dist((door.x, door.y), (pose.x, pose.y))):
        apart = points - np.array((door.x, door.y))
        inside = apart[np.hypot(apart[:, 0], apart[:, 1]) < 0.9 * door.width / 2]
        if len(inside) > 1 and np.ptp(inside, axis=0).max() > FILLED * door.width:
            return door
    return None


def _closed(door: Doorway) -> str:
    return f"the door between the {door.between[0]} and the {door.between[1]} is closed"


async def _follow(context: SkillContext, follower: Follower, name: str, watch: Lookout) -> tuple[Ending, RobotState]:
    """Drive along the path: how that ended, and the state at rest, or the one in which it was held back."""
    context.progress(0.0, f"to {name}, {follower.length:.1f} m", path=follower.ahead())
    state = context.robot.state()
    stall = Stall(state.t, math.inf, 0.003)
    checks = 0
    known = {thing.number for thing in _strewn(context)}
    while True:
        guidance = follower.guide(state.pose)
        if guidance.arrived:
            state = await settle(context)
            checks += 1
            if checks > CHECKS or not await watch.confirm():
                return "arrived", state
            state = context.robot.state()
            stall = Stall(state.t, math.inf, 0.003)
            continue
        context.drive(guidance.twist)
        await watch.go_on()
        before, state = state, await context.robot.tick()
        if before.pose.distance_to(state.pose) > ASTRAY:
            return "astray", state
        if new := [thing for thing in _strewn(context) if thing.number not in known]:
            known |= {thing.number for thing in new}
            half_width = context.robot.footprint.width / 2
            if any(_in_the_way(thing, follower.ahead(), half_width) for thing in new):
                await settle(context)
                return "strewn", context.robot.state()
        context.progress(follower.progress, f"{guidance.remaining:.1f} m to {name}")
        turning = abs(state.twist.wz) > TURNING  # at a corner, or into the goal's direction: not a stall
        if stall.update(state.t, guidance.remaining) and not turning:
            await settle(context)
            return "held", state


def points_of(scan: Scan, pose: Pose, reach: float) -> NDArray[np.float64]:
    """What the lidar saw within ``reach`` m, as points in the map frame, shape (n, 2)."""
    near = scan.ranges < reach
    angles = scan.angles[near] + pose.yaw
    return np.column_stack((pose.x + scan.ranges[near] * np.cos(angles), pose.y + scan.ranges[near] * np.sin(angles)))
