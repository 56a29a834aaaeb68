"""Keeps a robot company: its heartbeat, the publication of its state, and word of a robot that halts by itself.

The heartbeat runs in the engine's own loop on purpose: a loop that hangs stops beating, and the robot halts.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable

from engine.bus import Emit
from engine.errors import RobotError
from engine.events import PoseView, RobotStateView, TwistView
from engine.robot.robot import Robot, RobotState

HEARTBEAT_S = 0.05  # three beats before the robot brakes, five before it halts; twice as many cost 0.5 % of a core
PUBLISH_S = 0.1
SETTLE_S = 0.5  # longer than any robot of ours needs to come to rest
_SAGGED_V = 0.15  # less is noise
_MOVED = 0.001  # m or rad; less is not worth an event


async def company(robot: Robot, emit: Emit, halted: Callable[[str, int], None] = lambda reason, epoch: None) -> None:
    """Beat, and publish the robot's state while it changes. Ends by :class:`RobotError` when the robot is gone.

    ``halted`` is told why and in which epoch when the robot has halted by itself, once each time. Stop the
    robot before cancelling this: its last state is published when it rests.
    """
    beating = asyncio.create_task(beat(robot))
    try:
        await _publish(robot, emit, halted)
    except asyncio.CancelledError:
        beating.cancel()  # a robot that nobody has stopped halts by itself now
        with contextlib.suppress(RobotError):
            emit(view(await _at_rest(robot)))
        raise
    finally:
        beating.cancel()


async def _at_rest(robot: Robot) -> RobotState:
    """The state in which the robot rests, or is after ``SETTLE_S``. Raises :class:`RobotError`."""
    state = robot.state()
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(SETTLE_S):
            while view(state).twist != TwistView(0.0, 0.0, 0.0):
                state = await robot.tick()
    return state


async def beat(robot: Robot) -> None:
    """Tell the robot that somebody lives, until this is cancelled."""
    while True:
        robot.heartbeat()
        await asyncio.sleep(HEARTBEAT_S)


async def _publish(robot: Robot, emit: Emit, halted: Callable[[str, int], None]) -> None:
    last: RobotState | None = None
    told: int | None = None
    while True:
        state = robot.state()
        if last is None or _differs(last, state):
            emit(view(state))
            last = state
        if state.halted is not None and state.halted_in is not None and state.halted_in != told:
            told = state.halted_in  # it cannot halt in this epoch again: a newer one has to release it first
            halted(state.halted, state.halted_in)
        await asyncio.sleep(PUBLISH_S)


def view(state: RobotState) -> RobotStateView:
    """The state as an event body."""
    pose, twist = state.pose, state.twist
    return RobotStateView(
        robot_t=round(state.t, 3),
        pose=PoseView(round(pose.x, 4), round(pose.y, 4), round(pose.yaw, 4)),
        twist=TwistView(round(twist.vx, 4), round(twist.vy, 4), round(twist.wz, 4)),
        arm=tuple(round(joint, 3) for joint in state.joints),
        gripper=round(state.gripper, 3),
        moving=state.moving,
        blocked=state.held_back,
        estop=state.estop,
        volts=None if state.battery is None else state.battery.volts,
    )


def _volts(state: RobotState) -> float:
    return state.battery.volts if state.battery is not None else 0.0


def _differs(a: RobotState, b: RobotState) -> bool:
    if (a.moving, a.blocked, a.halted, a.light, a.estop) != (b.moving, b.blocked, b.halted, b.light, b.estop):
        return True
    if abs(_volts(a) - _volts(b)) > _SAGGED_V:
        return True
    pairs = [(a.pose.x, b.pose.x), (a.pose.y, b.pose.y), (a.pose.yaw, b.pose.yaw), (a.gripper, b.gripper)]
    return any(math.fabs(x - y) > _MOVED for x, y in [*pairs, *zip(a.joints, b.joints, strict=True)])
