"""Gestures of the arm, and two of the base: sequences of poses that people recognise."""

from __future__ import annotations

import math
from collections.abc import Sequence

from engine.robot.arm import ARM_INITIAL, Joints
from engine.robot.geometry import Twist
from engine.skills.context import SkillContext
from engine.skills.drive import settle, why_held
from engine.skills.hand import move_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import skill

UP: Joints = (0.0, 0.0, 0.0, 0.0, 0.0)
ARM_SPEED = 1.5  # rad/s


async def _poses(context: SkillContext, poses: Sequence[Joints], done: str, *, speed: float = ARM_SPEED) -> Result:
    for index, joints in enumerate(poses):
        context.progress(index / len(poses))
        if not await move_to(context, joints, speed=speed):
            return fail("no_progress", f"The arm stopped before it reached pose {index + 1} of {len(poses)}.")
    return ok(done)


@skill(occupies=["arm"], changes=["arm"])
async def arm_up(context: SkillContext) -> Result:
    """Raise (lift) the arm."""
    return await _poses(context, [UP], "The arm is up.")


@skill(occupies=["arm"], changes=["arm"])
async def arm_down(context: SkillContext) -> Result:
    """Lower the arm to its folded initial pose."""
    return await _poses(context, [ARM_INITIAL], "The arm is down.")


@skill(occupies=["arm"], changes=["arm"])
async def arm_nod(context: SkillContext) -> Result:
    """Nod with the arm, as a yes."""
    before = context.robot.state().joint_targets
    high, low = (0.0, 0.2, 0.4, 0.2, 0.0), (0.0, 0.2, 0.4, 1.0, 0.0)
    return await _poses(context, [high, low, high, low, high, before], "Nodded.", speed=2.5)


@skill(occupies=["arm"], changes=["arm"])
async def arm_shake(context: SkillContext) -> Result:
    """Shake the arm from side to side, as a no."""
    before = context.robot.state().joint_targets
    left, right = (0.5, 0.2, 0.4, 0.4, 0.0), (-0.5, 0.2, 0.4, 0.4, 0.0)
    return await _poses(context, [left, right, left, right, before], "Shook the arm.", speed=2.5)


@skill(occupies=["arm"], changes=["arm"])
async def arm_applaud(context: SkillContext) -> Result:
    """Applaud (clap) by opening and closing the gripper."""
    before = context.robot.state()
    if not await move_to(context, (0.0, 0.2, 0.4, 0.4, 0.0)):
        return fail("no_progress", "The arm stopped before it was raised.")
    for clap in range(4):
        context.progress(clap / 4)
        for opening in (1.0, 0.2):
            context.robot.set_gripper(opening, context.epoch)
            await context.sleep(0.25)
    context.robot.set_gripper(before.gripper, context.epoch)
    await move_to(context, before.joint_targets)
    return ok("Applauded.")


@skill(occupies=["base", "arm"], changes=["pose", "arm"])
async def dance(context: SkillContext) -> Result:
    """Dance on the spot: sway with the base and swing the arm."""
    before = context.robot.state().joint_targets
    left, right = (0.6, 0.1, 0.5, 0.3, 0.0), (-0.6, 0.1, 0.5, 0.3, 0.0)
    for beat in range(8):
        context.progress(beat / 8)
        side = 1 if beat % 2 == 0 else -1
        context.robot.move_arm(left if side > 0 else right, context.epoch, speed=2.5)
        if (held := await _sway(context, Twist(0.0, 0.0, side * 1.2), 0.5)) is not None:
            return held
    await settle(context)
    await move_to(context, before)
    return ok("Danced.")


@skill(occupies=["base"], changes=["pose"])
async def drift(context: SkillContext) -> Result:
    """Drift: drive half a circle sideways while turning, as a mecanum base can."""
    duration = 3.0
    rate = math.pi / duration
    if (held := await _sway(context, Twist(0.0, -0.25, rate), duration)) is not None:
        return held
    await settle(context)
    return ok("Drifted.")


async def _sway(context: SkillContext, twist: Twist, seconds: float) -> Result | None:
    """Drive ``twist`` for a time; a failure when something holds the robot back."""
    state = context.robot.state()
    begin = state.work_t
    while state.work_t - begin < seconds - 1e-9:
        context.drive(twist)
        state = await context.robot.tick()
        if state.halted or (state.blocked and state.command.is_zero):
            code, reason = why_held(state)
            await settle(context)
            return fail(code, f"I had to stop: {reason}.")
    return None
