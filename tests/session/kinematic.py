"""A robot without physics that lives in the loop's (virtual) time, for tests of the session alone.

It keeps the protocol's two rules to the letter, stop wins and epochs, and integrates what it is told exactly. It
records every velocity it was made to move with, so that a test can ask what moved when, and in which epoch.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Sequence

import numpy as np

from engine.errors import CameraError, RobotError
from engine.robot.arm import ARM_INITIAL, ArmModel, Joints
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.robot import PAUSE_LIMIT_S, UNDECIDED, BatteryState, Capability, Footprint, RobotState, Scan
from engine.robot.sim.dimensions import ARM

TICK_S = 0.02
LIFETIME_S = 0.25


class KinematicRobot:
    """Moves exactly as told, at once."""

    name = "kinematic robot"
    navigates = False
    company = None
    capabilities: frozenset[Capability] = frozenset({"base", "arm", "camera", "voice"})
    footprint = Footprint(0.3, 0.24)
    arm: ArmModel = ARM
    floor_map = FloorMap(0.05, (-5.0, -4.0), np.zeros((160, 200), dtype=np.bool_))

    def __init__(self) -> None:
        self.moved: list[tuple[float, int, Twist]] = []
        """(time, epoch, velocity) of every tick in which it moved."""
        self.arm_moves: list[tuple[float, int, Joints, float]] = []
        """(time, epoch, joints, speed) of every movement of the arm that was taken."""
        self.refused = 0
        """Commands of an epoch that was over."""
        self.lost = False
        self.relocated: list[tuple[Pose, Pose]] = []
        self.estop = False
        self.battery: BatteryState | None = None
        self._loop = asyncio.get_running_loop()
        self._epoch = 1
        self._pose = Pose(0.0, 0.0, 0.0)
        self._twist = ZERO
        self._dies = 0.0
        self._joints: Joints = ARM_INITIAL
        self._light = (0, 0, 0)
        self._pauses = 0
        self._paused: asyncio.TimerHandle | None = None
        self.speed_limit = 1.0
        self.on_halt: Callable[[str, int], None] = lambda reason, epoch: None
        """Told of a pause that nobody ended, and of its epoch."""
        self._at = self._loop.time()

    async def start(self) -> None:
        self._at = self._loop.time()

    async def close(self) -> None:
        self._twist = ZERO

    def press(self, pressed: bool) -> None:
        self._advance()
        self.estop, self._twist = pressed, ZERO

    def limit_speed(self, share: float) -> None:
        self.speed_limit = share

    def go(self, goal: Pose, epoch: int) -> int:
        raise AssertionError("it does not navigate")

    def stop(self, epoch: int) -> None:
        self._advance()
        self._epoch = epoch
        self._twist = ZERO
        self._end_pause()

    def pause(self, epoch: int) -> int:
        self._advance()
        self._pauses += 1
        if epoch == self._epoch:
            self._end_pause()
            self._twist = ZERO
            self._paused = self._loop.call_later(PAUSE_LIMIT_S, lambda: self.on_halt(UNDECIDED, epoch))
        return self._pauses

    def resume(self, token: int) -> None:
        if token == self._pauses:
            self._end_pause()

    @property
    def paused(self) -> bool:
        return self._paused is not None

    def _end_pause(self) -> None:
        paused, self._paused = self._paused, None
        if paused is not None:
            paused.cancel()

    def heartbeat(self) -> None: ...

    def state(self) -> RobotState:
        if self.lost:
            raise RobotError("The robot process died.")
        self._advance()
        return RobotState(
            t=self._at, epoch=self._epoch, pose=self._pose, twist=self._twist, command=self._twist,
            joints=self._joints, joint_targets=self._joints, gripper=1.0, light=self._light, blocked=None, halted=None,
            paused=self.paused, estop=self.estop, battery=self.battery,
        )  # fmt: skip

    def scan(self) -> Scan:
        return Scan(self._at, np.zeros(0), np.zeros(0))

    async def look(self) -> Picture:
        raise CameraError("This robot has no camera.")

    def relocate(self, believed: Pose, true: Pose) -> None:
        self.relocated.append((believed, true))

    def drive(self, twist: Twist, epoch: int) -> None:
        self._advance()
        if epoch != self._epoch:
            self.refused += 1
            return
        if self.paused or self.estop:
            return
        self._twist, self._dies = twist, self._at + LIFETIME_S

    def move_arm(self, joints: Sequence[float], epoch: int, *, speed: float = 1.0) -> None:
        if epoch == self._epoch and not self.estop:
            self._joints = tuple(joints)  # type: ignore[assignment]
            self.arm_moves.append((self._loop.time(), epoch, self._joints, speed))

    def set_gripper(self, opening: float, epoch: int) -> None: ...

    def set_light(self, rgb: tuple[int, int, int], epoch: int) -> None:
        if epoch == self._epoch:
            self._light = rgb

    def beep(self, seconds: float, epoch: int) -> None: ...

    async def tick(self) -> RobotState:
        while True:
            await asyncio.sleep(TICK_S)
            if not (state := self.state()).paused:
                return state

    def _advance(self) -> None:
        """Move on to now."""
        now = self._loop.time()
        moving = max(0.0, min(now, self._dies) - self._at)
        if not self._twist.is_zero and moving > 0:
            self.moved.append((now, self._epoch, self._twist))
            yaw = self._pose.yaw
            self._pose = Pose(
                self._pose.x + moving * (self._twist.vx * math.cos(yaw) - self._twist.vy * math.sin(yaw)),
                self._pose.y + moving * (self._twist.vx * math.sin(yaw) + self._twist.vy * math.cos(yaw)),
                math.remainder(yaw + moving * self._twist.wz, 2 * math.pi),
            )
        self._at = now
        if now >= self._dies:
            self._twist = ZERO
