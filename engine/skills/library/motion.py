"""Plain motion: by velocity, by distance, by angle, and waiting."""

from __future__ import annotations

import math
from typing import Annotated

from engine.robot.geometry import Twist
from engine.skills.context import SkillContext
from engine.skills.drive import Axis, Driven, drive_straight, settle, turn, why_held
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Angle, Distance, Duration, Measure, Speed, TurnSpeed, skill

Velocity = Annotated[float, Measure("m/s", -1.0, 1.0)]
TurnVelocity = Annotated[float, Measure("rad/s", -5.0, 5.0)]


@skill(occupies=["base"], changes=["pose"])
async def set_cmdvel(
    context: SkillContext, linear_x: Velocity, linear_y: Velocity, angular_z: TurnVelocity, duration: Duration
) -> Result:
    """Drive with a fixed velocity for a time.

    linear_x is forward, linear_y to the left, angular_z counter-clockwise.
    """
    state = context.robot.state()
    start, begin = state.pose, state.work_t
    twist = Twist(linear_x, linear_y, angular_z)
    held = None
    while state.work_t - begin < duration - 1e-9:
        context.drive(twist)
        state = await context.robot.tick()
        context.progress(min(1.0, (state.work_t - begin) / duration), f"{state.work_t - begin:.1f} of {duration:g} s")
        held = why_held(state) if state.halted or (state.blocked and state.command.is_zero) else None
        if held and state.work_t - begin > 0.2 and not twist.is_zero:
            break
    state = await settle(context)
    moved = start.distance_to(state.pose)
    if held:
        code, reason = held
        return fail(
            code, f"I drove {moved:.2f} m in {state.work_t - begin:.1f} of {duration:g} s, then: {reason}.", moved=moved
        )
    return ok(f"Drove for {duration:g} s and moved {moved:.2f} m.", moved=moved)


@skill(occupies=["base"], changes=[])
async def stop(context: SkillContext) -> Result:
    """Stand still, hold it."""
    await settle(context)
    return ok("Stopped.")


@skill(occupies=["base"], changes=["pose"])
async def move_forward(context: SkillContext, distance: Distance, speed: Speed = 0.3) -> Result:
    """Drive straight ahead by a distance; a negative distance drives backward."""
    return await _straight(context, distance, speed, "forward")


@skill(occupies=["base"], changes=["pose"])
async def move_sideways(context: SkillContext, distance: Distance, speed: Speed = 0.25) -> Result:
    """Move sideways without turning; positive to the left, negative to the right."""
    return await _straight(context, distance, speed, "sideways")


@skill(occupies=["base"], changes=["pose"])
async def move_left(context: SkillContext, angle: Angle, angular_speed: TurnSpeed = 1.0) -> Result:
    """Turn left on the spot by an angle in degrees."""
    return await _turn(context, angle, angular_speed, "left")


@skill(occupies=["base"], changes=["pose"])
async def move_right(context: SkillContext, angle: Angle, angular_speed: TurnSpeed = 1.0) -> Result:
    """Turn right on the spot by an angle in degrees."""
    return await _turn(context, angle, angular_speed, "right")


@skill(changes=[])
async def wait(context: SkillContext, seconds: Duration) -> Result:
    """Do nothing for a time."""
    state = context.robot.state()
    begin = state.t
    while (passed := state.t - begin) < seconds - 1e-9:
        context.progress(passed / seconds, f"{passed:.0f} of {seconds:g} s")
        state = await context.robot.tick()
    return ok(f"Waited {seconds:g} s.")


async def _straight(context: SkillContext, distance: float, speed: float, axis: Axis) -> Result:
    if distance == 0:
        return ok("Already there: the distance is zero.")
    way = {("forward", True): "forward", ("forward", False): "backward"}.get(
        (axis, distance > 0), "to the left" if distance > 0 else "to the right"
    )
    driven = await drive_straight(context, distance, speed, axis)
    return _report(driven, abs(driven.amount), abs(distance), "m", f"moved {{:.2f}} m {way}")


async def _turn(context: SkillContext, angle: float, speed: float, side: str) -> Result:
    if angle == 0:
        return ok("Already there: the angle is zero.")
    driven = await turn(context, math.radians(angle) * (1 if side == "left" else -1), speed)
    return _report(driven, abs(math.degrees(driven.amount)), angle, "°", f"turned {{:.0f}}° {side}")


def _report(driven: Driven, done: float, wanted: float, unit: str, words: str) -> Result:
    did = words.format(done)
    if driven.error is None:
        return ok(f"{did[0].upper()}{did[1:]}.", moved=round(done, 3))
    gap = "" if unit == "°" else " "
    return fail(driven.error, f"I {did} of {wanted:g}{gap}{unit}, then: {driven.reason}.", moved=round(done, 3))
