"""Motions of arm and gripper for handling things: to a pose, along a straight line, until something is felt; and what
the fingers tell about what is between them.

Every motion commands one small step per control tick, so an interruption at any moment leaves the arm where it is and
the gripper with its grip. What is held is known from the fingers alone: they were told to close and something keeps
them apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from engine.perception.sighting import Sight
from engine.robot.arm import ARM_INITIAL, ArmModel, Joints
from engine.robot.geometry import Point, Pose
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext

CARRY: Final[Joints] = (0.0, -1.18, 1.33, 1.65, 0.0)
"""Things are carried with the arm folded so far back that a bottle stays above the hull; the camera looks ahead."""
FINGERTIP: Final = 0.026
"""m from the point between the fingers to the ends of the fingers, with a little to spare."""
FINGER: Final = (0.011, 0.011)
"""m, half the width of a finger along its pad, and its thickness: what room it takes beside a thing."""
PALM: Final = 0.06
"""m from the point between the fingers to the palm: what is taller must be gripped further up."""
PRESSING: Final = 0.0014
"""m that the fingers are told to close further than they get, from which something is between them: 0.4 N. In the air
they lag up to 1.1 mm behind what they are told."""
TOUCHING: Final = 0.0003
"""The same for fingers that open, which lag the other way: 0.1 N."""
NOTHING: Final = 0.008
"""Gap in m below which there is nothing between closed fingers."""

_TOLERANCE = 0.012  # rad
_HEARD_S = 0.1  # s in which the controller of the arm has heard of it
_ARM_LIMIT_S = 6.0  # s of robot time for one movement
_GRIP_LIMIT_S = 2.0  # s of robot time for the fingers
_FASTEST = 2.5  # rad/s, along lines, whose speed is set by their steps
_STILL = 0.0006  # m in a tick; slower fingers stand
_SQUEEZED = 4  # ticks that fingers stand on a thing before it counts as held
_FELT = 0.004  # m that the hand lags behind when it is pressed against something


def from_map(pose: Pose, point: Point) -> Point:
    """A point of the map frame in the base frame."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    dx, dy = point[0] - pose.x, point[1] - pose.y
    return c * dx + s * dy, c * dy - s * dx, point[2]


def on_map(pose: Pose, point: Point) -> Point:
    """A point of the base frame in the map frame."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return pose.x + c * point[0] - s * point[1], pose.y + s * point[0] + c * point[1], point[2]


def gap(context: SkillContext, state: RobotState | None = None) -> float:
    """Between the fingers, m."""
    return context.robot.arm.jaw * (state or context.robot.state()).gripper


def presses(context: SkillContext, state: RobotState | None = None, *, least: float = PRESSING) -> bool:
    """Whether the fingers press on what is between them: they are told to close further than they get, by ``least`` m.
    That is so wherever an interruption has left them, half closed or half opened."""
    state = state or context.robot.state()
    apart = gap(context, state)
    return apart > NOTHING and apart - context.robot.arm.jaw * state.grip > least


def still_held(context: SkillContext) -> bool:
    """Whether what the memory says is held is still between the fingers."""
    return context.world.held is not None and presses(context)


async def grip_again(context: SkillContext) -> None:
    """Hold firmly what is held: fingers that were interrupted as they closed or opened press only a little."""
    if context.world.held is not None and context.robot.state().grip > 0:
        await close_fingers(context)


async def look(context: SkillContext) -> Sight:
    """Take a picture and understand it. What it told about where the robot stands is in its state afterwards."""
    sight = await context.see()
    await context.robot.tick()
    return sight


async def fold(context: SkillContext) -> bool:
    """Fold the arm, as far as needed for what it holds; False when it does not get there."""
    return await move_to(context, ARM_INITIAL if context.world.held is None else CARRY, speed=1.2)


async def move_to(context: SkillContext, joints: Joints, *, speed: float = 1.5) -> bool:
    """Move the arm to ``joints``, or as near as its ranges allow, and wait until it is there; False when it does not
    get there in time, or its controller says that it does not."""
    joints = context.robot.arm.possible(joints)
    context.robot.move_arm(joints, context.epoch, speed=speed)
    state = await context.robot.tick()
    sent = state.work_t
    end = sent + _ARM_LIMIT_S
    while any(abs(a - b) > _TOLERANCE for a, b in zip(state.joints, joints, strict=True)):
        if state.work_t > end or _is_refused(state, sent):
            return False
        state = await context.robot.tick()
    return True


def _is_refused(state: RobotState, sent: float) -> bool:
    """Whether the controller of the arm gives up what it was sent, and not what it was sent before that."""
    return bool(state.arm_fault) and state.work_t - sent > _HEARD_S


def nearest(solutions: tuple[Joints, ...], joints: Joints) -> Joints | None:
    """Of several solutions, the one that moves the arm least."""
    return min(solutions, key=lambda found: math.dist(found, joints), default=None)


async def move_along(
    context: SkillContext,
    to: Point,
    *,
    speed: float,
    until: Callable[[RobotState], bool] = lambda state: False,
) -> bool:
    """Move the point between the fingertips on a straight line to ``to`` (base frame) at ``speed`` m/s, the hand
    pointing as it does. Ends early, where it is, when ``until`` says so. False when the arm cannot follow the line."""
    arm, step = context.robot.arm, speed * 0.02
    joints = context.robot.state().joint_targets
    grip = arm.grip(joints)
    length = math.dist(grip.point, to)
    count = max(1, math.ceil(length / step))
    for i in range(1, count + 1):
        part = i / count
        x, y, z = (a + part * (b - a) for a, b in zip(grip.point, to, strict=True))
        following = nearest(arm.solve((x, y, z), grip.pitch, joints[4]), joints)
        if following is None or math.dist(following, joints) > 0.5:  # another branch: no line leads there
            return False
        joints = following
        context.robot.move_arm(joints, context.epoch, speed=_FASTEST)
        state = await context.robot.tick()
        if until(state):
            context.robot.move_arm(state.joint_targets, context.epoch, speed=_FASTEST)
            return True
    end = state.work_t + _ARM_LIMIT_S
    while any(abs(a - b) > _TOLERANCE for a, b in zip(state.joints, joints, strict=True)):
        if until(state):
            return True
        if state.work_t > end or _is_refused(state, end - _ARM_LIMIT_S):
            return False
        state = await context.robot.tick()
    return True


def pressed(arm: ArmModel) -> Callable[[RobotState], bool]:
    """For :func:`move_along` downwards: something holds the hand up."""

    def told(state: RobotState) -> bool:
        return arm.grip(state.joints).point[2] - arm.grip(state.joint_targets).point[2] > _FELT

    return told


async def open_fingers(context: SkillContext, width: float) -> None:
    """Open (or close) the fingers to a gap of ``width`` m."""
    jaw = context.robot.arm.jaw
    context.robot.set_gripper(min(1.0, width / jaw), context.epoch)
    state = await context.robot.tick()
    end = state.work_t + _GRIP_LIMIT_S
    while abs(gap(context, state) - min(jaw, width)) > 0.0015 and state.work_t < end:
        state = await context.robot.tick()


async def close_fingers(context: SkillContext, on_grip: Callable[[], None] = lambda: None) -> bool:
    """Close with force; whether something is between the fingers. ``on_grip`` is told when they press on something,
    also when that is where an interruption left them."""
    context.robot.set_gripper(0.0, context.epoch)
    before, stood = gap(context), 0
    try:
        state = await context.robot.tick()
        end = state.work_t + _GRIP_LIMIT_S
        while stood < _SQUEEZED and state.work_t < end:
            state = await context.robot.tick()
            now = gap(context, state)
            stood = stood + 1 if abs(now - before) < _STILL else 0
            before = now
    finally:
        if pressing := presses(context):
            on_grip()
    if not pressing:
        return False
    for _ in range(8):  # the motor's force builds up
        await context.robot.tick()
    return presses(context)
