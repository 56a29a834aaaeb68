"""Going to places, remembering one, and saying where the robot is.

The way is planned on the fixed map and followed tick by tick. When the envelope's obstacle stop holds the robot back,
what the lidar sees is added to the map and the way is planned anew, a few times, before the robot gives up.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from engine.robot.follow import Follower
from engine.robot.occupancy import Unreachable, route
from engine.robot.robot import Pose, RobotState, Scan
from engine.skills.context import SkillContext
from engine.skills.drive import Stall, settle, why_held
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Word, skill

DETOURS = 3  # times that a blocked way is planned anew
SEEN_RANGE = 2.5  # m; what the lidar sees further away does not matter for a detour

TURNING = 0.01  # rad/s

PlaceName = Annotated[str, Word("place")]


@skill(occupies=["base"])
async def navigation(context: SkillContext, place: PlaceName) -> Result:
    """Go to a place of the map by its symbol or name; zero is the remembered place."""
    goal, name = context.places.pose(place), context.places.name(place)
    if goal is None:
        return fail("unknown_place", "I have not been told to remember a place yet.")
    seen: NDArray[np.float64] | None = None
    for detour in range(DETOURS + 1):
        start = context.pose
        way = route(context.robot.floor_map, start, goal, context.robot.footprint, extra=seen)
        if isinstance(way, Unreachable):
            if detour:
                return fail("path_blocked", f"The way to {name} is blocked, and there is no other. {way.message}")
            return fail("unreachable", f"I cannot get to {name}. {way.message}")
        follower = Follower(way.points, goal.yaw)
        arrived, state = await _follow(context, follower, name)
        if arrived:
            return ok(f"I am at {name}.", x=state.pose.x, y=state.pose.y, yaw=state.pose.yaw)
        code, reason = why_held(state)
        if code != "path_blocked":
            break
        seen = points_of(context.robot.scan(), state.pose, SEEN_RANGE)
    left = math.dist((state.pose.x, state.pose.y), (goal.x, goal.y))
    return fail(code, f"I stopped {left:.1f} m before {name}: {reason}.")


async def _follow(context: SkillContext, follower: Follower, name: str) -> tuple[bool, RobotState]:
    """Drive along the path: whether it arrived, and the state at rest, or the one in which it was held back."""
    context.progress(0.0, f"to {name}, {follower.length:.1f} m", path=follower.ahead())
    state = context.robot.state()
    stall = Stall(state.t, math.inf, 0.003)
    while True:
        guidance = follower.guide(state.pose)
        if guidance.arrived:
            return True, await settle(context)
        context.drive(guidance.twist)
        state = await context.robot.tick()
        context.progress(follower.progress, f"{guidance.remaining:.1f} m to {name}")
        turning = abs(state.twist.wz) > TURNING  # at a corner, or into the goal's direction: not a stall
        if stall.update(state.t, guidance.remaining) and not turning:
            await settle(context)
            return False, state


def points_of(scan: Scan, pose: Pose, reach: float) -> NDArray[np.float64]:
    """What the lidar saw within ``reach`` m, as points in the map frame, shape (n, 2)."""
    near = scan.ranges < reach
    angles = scan.angles[near] + pose.yaw
    return np.column_stack((pose.x + scan.ranges[near] * np.cos(angles), pose.y + scan.ranges[near] * np.sin(angles)))


@skill()
async def get_current_pose(context: SkillContext) -> Result:
    """Remember where the robot stands as the place zero."""
    pose = context.pose
    context.places.remember(pose)
    return ok(f"I will remember this place. {_words(pose)}", x=pose.x, y=pose.y, yaw=pose.yaw)


@skill()
async def report_pose(context: SkillContext) -> Result:
    """Say where the robot is."""
    pose = context.pose
    room = next((room.name for room in context.robot.floor_map.rooms if room.holds(pose.x, pose.y)), None)
    where = f"I am in the {room}. " if room else ""
    return ok(f"{where}{_words(pose)}", x=pose.x, y=pose.y, yaw=pose.yaw, room=room or "")


def _words(pose: Pose) -> str:
    return f"x {pose.x:.2f} m, y {pose.y:.2f} m, facing {math.degrees(pose.yaw):.0f}°."
