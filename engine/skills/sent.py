"""Driving to a pose by a robot that finds its way itself: it is sent there, and what it tells is told on."""

from __future__ import annotations

import math
from typing import Final

from engine.robot.geometry import Pose
from engine.robot.robot import Going, RobotState
from engine.skills.context import SkillContext
from engine.skills.doors import closed_door, is_closed
from engine.skills.drive import stopped_before
from engine.skills.outcome import ErrorCode, Result, fail, ok

TOLD_S: Final = 1.0
"""s in which the robot must have heard where it is sent."""

# What Nav2 means by its numbers (nav2_msgs of Jazzy: those of ComputePathToPose and of FollowPath).
_NO_WAY: Final = {203: "it stands outside its map", 204: "that is outside its map", 206: "something stands there"}
_REASONS: Final[dict[int, tuple[ErrorCode, str]]] = {
    **{code: ("unreachable", why) for code, why in _NO_WAY.items()},
    205: ("unreachable", "it takes itself to stand in something"),
    207: ("unreachable", "looking for a way took it too long"),
    208: ("unreachable", "there is no way"),
    104: ("path_blocked", "something stood in the way for too long"),
    105: ("no_progress", "it made no progress"),
    106: ("path_blocked", "it found no safe way on"),
    9002: ("robot_lost", "it does not know where it is on its map"),
    9003: ("time_limit", "it took too long"),
}


async def send_to(context: SkillContext, goal: Pose, name: str) -> Result | None:
    """Have it go to ``goal`` and face its direction; ``name`` is what people call it. None where nobody there finds the
    way, and nothing has moved."""
    ticket = context.robot.go(goal, context.epoch)
    sent = context.robot.state().work_t
    furthest = 0.0
    while True:
        state = await context.robot.tick()
        going = state.going
        if going is None or going.ticket != ticket:
            if state.work_t - sent > TOLD_S:
                return fail("robot_halted", stopped_before(state, goal, name, state.halted or "it was told to stop"))
            continue
        if going.how != "going":
            return _ended(context, going, state, goal, name)
        left = _left(going, state, goal)
        furthest = max(furthest, left)
        context.progress(1 - left / furthest if furthest else 0.0, f"{left:.1f} m to {name}")


def _left(going: Going, state: RobotState, goal: Pose) -> float:
    """How far it is, m: on its way where it tells that, else as the crow flies."""
    if math.isfinite(going.left) and going.left > 0:
        return going.left
    return math.dist((state.pose.x, state.pose.y), (goal.x, goal.y))


def _ended(context: SkillContext, going: Going, state: RobotState, goal: Pose, name: str) -> Result | None:
    pose = state.pose
    match going.how:
        case "arrived":
            return ok(f"I am at {name}.", x=pose.x, y=pose.y, yaw=pose.yaw)
        case "no_server" | "bad_type":
            return None
        case "rejected":
            return fail("unreachable", f"I cannot get to {name}: my navigation refuses it.")
        case "timed_out":
            return fail("time_limit", stopped_before(state, goal, name, "it took too long"))
        case "lost":
            return fail("robot_lost", stopped_before(state, goal, name, "my navigation is gone"))
        case "canceled":
            return fail("robot_halted", stopped_before(state, goal, name, state.halted or "it was told to stop"))
    code, reason = _REASONS.get(going.code, ("no_progress", going.why or "my navigation gave up"))
    if (door := closed_door(context)) is not None:
        code, reason = "door_closed", is_closed(door)
    return fail(code, stopped_before(state, goal, name, reason), nav2=going.code)
