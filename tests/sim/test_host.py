"""What the robot does when its engine is late, silent, and back, step by step of a clock of our own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from engine.robot.geometry import Twist
from engine.robot.host import memory as m
from engine.robot.host.host import BRAKE_PART, HALT_S, Host
from engine.robot.host.memory import Memory
from engine.robot.robot import PAUSE_LIMIT_S, UNDECIDED
from engine.robot.sim.build import TIMESTEP
from engine.robot.sim.world import World
from tests.sim.rig import in_the_flat, settings

ALLOWED = settings().heartbeat_s
FULL_SPEED = settings().limits.linear_speed
STANDS_WITHIN_S = 0.3


class Rig:
    """The host over a world, a clock, and the engine's side of the memory."""

    def __init__(self, memory: Memory, world: World) -> None:
        self.memory, self.world, self.now = memory, world, 100.0
        self.host = Host(memory, world, settings(speed="real"))

    def let_pass(self, seconds: float, *, beating: bool, speed: float | None = None, epoch: int = 1) -> None:
        """Let time pass, while the engine beats or not, and repeats a command or not."""
        for _ in range(round(seconds / TIMESTEP)):
            if beating:
                self.memory.times[m.HEARTBEAT] = self.now
            if speed is not None:
                box = self.memory.drive
                box.scratch["epoch"], box.scratch["twist"] = epoch, (speed, 0, 0)
                box.put()
            self.now += TIMESTEP
            self.host.step(self.now)
        self.host.publish()

    def pause(self, epoch: int = 1, number: int = 1) -> None:
        self.memory.ints[m.PAUSE] = m.pause_token(epoch, number)

    def resume(self, epoch: int = 1, number: int = 1) -> None:
        self.memory.ints[m.RESUME] = m.pause_token(epoch, number)

    @property
    def paused(self) -> bool:
        return bool(self.memory.state.get()["paused"])

    @property
    def halted(self) -> str:
        return str(self.memory.state.get()["halted"].item().decode())


@contextmanager
def driving(speed: float = FULL_SPEED) -> Iterator[Rig]:
    """A robot at speed, with an engine that beats and commands."""
    memory = Memory.create()
    try:
        rig = Rig(memory, in_the_flat())
        rig.let_pass(1.0, beating=True, speed=speed)
        assert abs(rig.world.twist.vx - speed) < 0.01
        yield rig
    finally:
        os.close(memory.fd)


def test_from_full_speed_the_robot_stands_soon_after_the_last_sign_of_life() -> None:
    with driving() as rig:
        rig.let_pass(STANDS_WITHIN_S, beating=False)
        assert rig.world.at_rest
        rig.let_pass(HALT_S - STANDS_WITHIN_S + 0.01, beating=False)
        assert rig.halted == "heartbeat lost"


def test_an_engine_that_is_late_makes_the_robot_stand_and_finds_it_ready_to_go_on() -> None:
    with driving(0.3) as rig:
        rig.world.move_arm((0.5, 0.2, 1.0, 0.8, -0.3), 1.0)
        rig.let_pass(STANDS_WITHIN_S, beating=False)
        assert rig.world.command.is_zero
        stood = rig.world.arm.targets
        rig.let_pass(HALT_S - STANDS_WITHIN_S - 0.05, beating=False, speed=0.3)
        assert rig.world.command.is_zero, "commands of a silent engine"
        assert rig.world.arm.targets == stood
        assert rig.world.at_rest
        rig.let_pass(0.6, beating=True, speed=0.3)
        assert not rig.halted
        assert rig.world.twist.vx > 0.25
        assert rig.world.arm.joints[0] > 0.2, "the arm went on to where it was told to go"


def test_an_engine_that_is_merely_busy_does_not_make_it_brake() -> None:
    with driving(0.3) as rig:
        rig.let_pass(BRAKE_PART * ALLOWED - 0.01, beating=False)
        assert rig.world.command == Twist(0.3)


def test_a_robot_that_halted_waits_for_a_new_epoch_and_a_living_engine() -> None:
    with driving() as rig:
        rig.let_pass(HALT_S + 0.3, beating=False)
        at = rig.world.true_pose
        rig.let_pass(0.5, beating=True, speed=0.3)
        assert rig.halted
        rig.let_pass(ALLOWED + 0.1, beating=False)
        rig.memory.ints[m.STOP_EPOCH] = 2
        rig.let_pass(0.3, beating=False, speed=0.3, epoch=2)
        assert rig.halted, "the epoch is new, but nobody lives"
        rig.let_pass(0.5, beating=True, speed=0.3, epoch=1)
        assert not rig.halted
        assert rig.world.true_pose.distance_to(at) < 0.005, "released, but what is over stays over"
        rig.let_pass(0.5, beating=True, speed=0.3, epoch=2)
        assert rig.world.twist.vx > 0.25


def test_a_robot_that_halts_a_second_time_waits_for_an_epoch_of_its_own() -> None:
    with driving(0.3) as rig:
        for epoch in (2, 3):
            rig.let_pass(HALT_S + 0.1, beating=False, speed=0.3, epoch=epoch - 1)
            rig.let_pass(0.1, beating=True)
            assert rig.halted
            rig.memory.ints[m.STOP_EPOCH] = epoch
            rig.let_pass(0.3, beating=True, speed=0.3, epoch=epoch)
            assert rig.world.twist.vx > 0.25


def test_the_moments_of_zero_and_rest_are_those_of_the_braking() -> None:
    with driving(0.3) as rig:
        rig.let_pass(BRAKE_PART * ALLOWED + 0.01, beating=False)
        zero = rig.memory.times[m.ZERO_TIME]
        assert zero > 0
        rig.let_pass(HALT_S, beating=False)
        assert rig.halted
        assert rig.memory.times[m.ZERO_TIME] == zero
        assert rig.memory.times[m.REST_TIME] > zero


# Pauses


def test_a_paused_robot_comes_to_rest_gently_and_goes_on_when_it_may() -> None:
    with driving(0.3) as rig:
        rig.world.move_arm((0.5, 0.2, 1.0, 0.8, -0.3), 1.0)
        rig.pause()
        rig.let_pass(0.1, beating=True, speed=0.3)
        assert 0.0 < rig.world.twist.vx < 0.3, "no faster than it may slow down"
        stood = rig.world.arm.targets
        rig.let_pass(0.4, beating=True, speed=0.3)
        assert rig.paused
        assert rig.world.at_rest
        assert rig.world.command.is_zero
        assert rig.world.arm.targets == stood
        rig.resume()
        rig.let_pass(0.8, beating=True, speed=0.3)
        assert not rig.paused
        assert rig.world.twist.vx > 0.25
        assert rig.world.arm.joints[0] > 0.2, "the arm went on to where it was told to go"


def test_what_is_commanded_in_a_pause_waits_but_velocities_are_forgotten() -> None:
    with driving(0.3) as rig:
        rig.pause()
        rig.let_pass(0.3, beating=True, speed=0.3)
        box = rig.memory.gripper
        box.scratch["epoch"], box.scratch["opening"] = 1, 1.0
        box.put()
        rig.let_pass(0.3, beating=True)
        assert rig.world.arm.opening < 0.6
        rig.resume()
        rig.let_pass(0.6, beating=True)
        assert rig.world.at_rest, "nobody has said again to drive"
        assert rig.world.arm.opening > 0.95


def test_a_pause_that_nobody_ends_is_a_halt_until_a_new_epoch() -> None:
    with driving(0.3) as rig:
        rig.pause()
        rig.let_pass(PAUSE_LIMIT_S - 0.05, beating=True, speed=0.3)
        assert not rig.halted
        rig.let_pass(0.1, beating=True, speed=0.3)
        assert rig.halted == UNDECIDED
        rig.resume()
        rig.let_pass(0.5, beating=True, speed=0.3)
        assert rig.halted, "too late"
        assert rig.world.at_rest
        rig.memory.ints[m.STOP_EPOCH] = 2
        rig.let_pass(0.5, beating=True, speed=0.3, epoch=2)
        assert not rig.halted
        assert rig.world.twist.vx > 0.25


def test_a_stop_ends_a_pause_and_the_new_epoch_moves_at_once() -> None:
    with driving(0.3) as rig:
        rig.pause()
        rig.let_pass(0.1, beating=True, speed=0.3)
        rig.memory.ints[m.STOP_EPOCH] = 2
        rig.let_pass(0.01, beating=True, speed=0.3, epoch=1)
        assert not rig.paused
        assert rig.world.command.is_zero
        rig.let_pass(0.5, beating=True, speed=0.3, epoch=2)
        assert rig.world.twist.vx > 0.25


def test_a_pause_of_an_epoch_that_is_over_is_none() -> None:
    with driving(0.3) as rig:
        rig.memory.ints[m.STOP_EPOCH] = 2
        rig.let_pass(0.5, beating=True, speed=0.3, epoch=2)
        rig.pause(epoch=1)
        rig.let_pass(0.3, beating=True, speed=0.3, epoch=2)
        assert not rig.paused
        assert rig.world.twist.vx > 0.25


def test_only_the_newest_of_two_pauses_can_be_ended() -> None:
    with driving(0.3) as rig:
        rig.pause(number=1)
        rig.let_pass(0.1, beating=True)
        rig.pause(number=2)
        rig.resume(number=1)
        rig.let_pass(0.1, beating=True)
        assert rig.paused
        rig.resume(number=2)
        rig.let_pass(0.1, beating=True)
        assert not rig.paused


def test_an_engine_that_is_late_during_a_pause_does_not_end_it() -> None:
    with driving(0.3) as rig:
        rig.world.move_arm((0.5, 0.2, 1.0, 0.8, -0.3), 1.0)
        rig.pause()
        rig.let_pass(BRAKE_PART * ALLOWED + 0.1, beating=False)
        stood = rig.world.arm.targets
        rig.let_pass(0.2, beating=True, speed=0.3)
        assert rig.paused
        assert rig.world.at_rest
        assert rig.world.arm.targets == stood
        rig.resume()
        rig.let_pass(0.6, beating=True, speed=0.3)
        assert rig.world.twist.vx > 0.25


def test_the_time_of_a_pause_is_told() -> None:
    with driving(0.3) as rig:
        for number in (1, 2):
            rig.pause(number=number)
            rig.let_pass(0.5, beating=True)
            rig.resume(number=number)
            rig.let_pass(0.5, beating=True)
        assert abs(float(rig.memory.state.get()["paused_s"]) - 1.0) < 0.02


def test_a_speed_limit_slows_down_a_robot_at_speed_and_halts_nothing() -> None:
    with driving() as rig:
        rig.memory.times[m.SPEED_LIMIT] = 0.25
        rig.let_pass(0.6, beating=True, speed=FULL_SPEED)
        assert abs(rig.world.twist.vx - 0.25 * FULL_SPEED) < 0.01
        assert not rig.halted
        rig.memory.times[m.SPEED_LIMIT] = 0.0  # as it is before anybody set one
        rig.let_pass(0.6, beating=True, speed=FULL_SPEED)
        assert abs(rig.world.twist.vx - FULL_SPEED) < 0.01
