"""Closed-loop motion of the base, shared by the skills that drive.

Each function drives until the goal or until it can say why not, one command per control tick, and leaves the base
commanded to zero. Speeds are shaped so that the robot can always brake at ``BRAKING``; the safety envelope below
has the last word.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from engine.robot.geometry import ZERO, Pose, Twist, wrap
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext
from engine.skills.outcome import ErrorCode

BRAKING = 0.8  # m/s², what a mecanum base of this size does without slipping
TURN_BRAKING = 4.0  # rad/s²
DISTANCE_TOLERANCE = 0.005  # m
ANGLE_TOLERANCE = math.radians(0.5)
CREEP = 0.02  # m/s, slowest commanded approach
TURN_CREEP = 0.05  # rad/s
STALL_S = 0.6  # s of robot time without progress that count as held back
LOOK_S = 0.1  # s of robot time, longest between two looks at the robot that counts
SETTLE_S = 1.0  # s of robot time that the base is given to come to rest

Axis = Literal["forward", "sideways"]


@dataclass(frozen=True, slots=True)
class Driven:
    """How far it went (m or rad, signed) and, unless it got there, why not."""

    amount: float
    error: ErrorCode | None = None
    reason: str = ""


def why_held(state: RobotState) -> tuple[ErrorCode, str]:
    """What keeps the robot from moving, as a code and a clause."""
    if state.halted:
        return "robot_halted", state.halted
    if state.blocked:
        return "path_blocked", state.blocked
    return "no_progress", "the wheels turned but I did not move"


def stopped_before(state: RobotState, goal: Pose, name: str, reason: str) -> str:
    """That it stopped on its way to a place of this name, how far from it, and why."""
    left = math.dist((state.pose.x, state.pose.y), (goal.x, goal.y))
    return f"I stopped {left:.1f} m before {name}: {reason}."


class Stall:
    """Notices that a distance to the goal has stopped shrinking."""

    def __init__(self, t: float, remaining: float, step: float) -> None:
        self._t = t
        self._idle = 0.0
        self._best = remaining
        self._step = step

    def update(self, t: float, remaining: float) -> bool:
        """True when ``remaining`` has not shrunk by a step for ``STALL_S`` of watching. Time in which nobody looked
        (the engine was busy, and the robot stood) counts as one look."""
        self._idle += min(t - self._t, LOOK_S)
        self._t = t
        if remaining < self._best - self._step:
            self._best, self._idle = remaining, 0.0
        return self._idle > STALL_S


async def settle(context: SkillContext) -> RobotState:
    """Command zero and wait until the base is at rest."""
    context.drive(ZERO)
    state = await context.robot.tick()
    end = state.t + SETTLE_S
    while state.moving and state.t < end:
        state = await context.robot.tick()
    return state


async def drive_straight(context: SkillContext, distance: float, speed: float, axis: Axis) -> Driven:
    """Drive ``distance`` m (signed) along the axis of the base as it points now, keeping the heading."""
    state = context.robot.state()
    start = state.pose
    direction = start.yaw + (0.0 if axis == "forward" else math.pi / 2)
    sign = math.copysign(1.0, distance)
    goal = abs(distance)
    stall = Stall(state.t, goal, 0.005)
    travelled = 0.0
    while goal - travelled > DISTANCE_TOLERANCE:
        along = max(CREEP, min(speed, math.sqrt(2 * BRAKING * (goal - travelled))))
        ahead, across = _offset(start, state.pose, direction)
        yaw_error = wrap(start.yaw - state.pose.yaw)
        context.drive(_in_base(direction, state.pose.yaw, sign * along, -1.5 * across, 2.0 * yaw_error))
        state = await context.robot.tick()
        ahead, _ = _offset(start, state.pose, direction)
        travelled = sign * ahead
        context.progress(min(1.0, max(0.0, travelled / goal)), f"{travelled:.2f} of {goal:.2f} m")
        if stall.update(state.t, goal - travelled):
            error, reason = why_held(state)
            state = await settle(context)
            return Driven(_offset(start, state.pose, direction)[0], error, reason)
    state = await settle(context)
    return Driven(_offset(start, state.pose, direction)[0])


async def turn(context: SkillContext, angle: float, speed: float) -> Driven:
    """Turn by ``angle`` rad (signed, may be more than a full turn) on the spot."""
    state = context.robot.state()
    sign = math.copysign(1.0, angle)
    goal = abs(angle)
    turned, yaw = 0.0, state.pose.yaw
    stall = Stall(state.t, goal, 0.01)
    while goal - turned > ANGLE_TOLERANCE:
        rate = max(TURN_CREEP, min(speed, math.sqrt(2 * TURN_BRAKING * (goal - turned)) * 0.8))
        context.drive(Twist(wz=sign * rate))
        state = await context.robot.tick()
        turned += sign * wrap(state.pose.yaw - yaw)
        yaw = state.pose.yaw
        context.progress(min(1.0, max(0.0, turned / goal)), f"{math.degrees(turned):.0f} of {math.degrees(goal):.0f}°")
        if stall.update(state.t, goal - turned):
            error, reason = why_held(state)
            await settle(context)
            return Driven(sign * turned, error, reason)
    state = await settle(context)
    return Driven(sign * (turned + sign * wrap(state.pose.yaw - yaw)))


def _offset(start: Pose, now: Pose, direction: float) -> tuple[float, float]:
    """Displacement since ``start`` along and across ``direction`` (across: to its left), m."""
    dx, dy = now.x - start.x, now.y - start.y
    return (
        dx * math.cos(direction) + dy * math.sin(direction),
        dy * math.cos(direction) - dx * math.sin(direction),
    )


def _in_base(direction: float, yaw: float, along: float, across: float, wz: float) -> Twist:
    """The twist that moves ``along`` and ``across`` a map direction, in the base frame."""
    angle = direction - yaw
    return Twist(
        vx=along * math.cos(angle) - across * math.sin(angle),
        vy=along * math.sin(angle) + across * math.cos(angle),
        wz=wz,
    )
