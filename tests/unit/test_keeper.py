"""A robot that is lost comes back, or it is said that it does not; and nothing that was commanded before moves it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from itertools import pairwise

import pytest

from engine import events
from engine.bus import Bus
from engine.clock import LoopClock
from engine.commands import Halted
from engine.epoch import Epoch
from engine.errors import RobotError, SaysoError
from engine.parts.keeper import PAUSES_S, WINDOW_S, Keeper
from engine.parts.part import Part
from engine.robot.robot import Robot, RobotState
from tests import virtual_time
from tests.session.kinematic import KinematicRobot


class FrailRobot(KinematicRobot):
    """One that can be lost, whose starts can fail, and that can halt by itself."""

    def __init__(self) -> None:
        super().__init__()
        self.lost = True
        self.deaf = True  # before the first start there is nobody to hear a stop
        self.failing = 0  # so many of the next starts fail
        self.starts: list[tuple[float, int]] = []  # (time, epoch in force)
        self.closed = False
        self.halted: str | None = None
        self.halted_in: int | None = None
        self.fault: Exception | None = None

    async def start(self) -> None:
        self.starts.append((self._loop.time(), self._epoch))
        await asyncio.sleep(0.5)
        if self.failing:
            self.failing -= 1
            raise RobotError("It does not start.")
        self.lost = self.deaf = False
        await super().start()

    def stop(self, epoch: int) -> None:
        if not self.deaf:
            super().stop(epoch)

    async def close(self) -> None:
        self.closed = True

    def state(self) -> RobotState:
        if self.fault is not None:
            raise self.fault
        return replace(super().state(), halted=self.halted, halted_in=self.halted_in)


class Kept:
    """A robot, its keeper, and everything that was said about it."""

    def __init__(self) -> None:
        self.robot = FrailRobot()
        self.epoch = Epoch(self.robot.stop)
        self.bus = Bus(LoopClock(asyncio.get_running_loop()))
        self.said: list[events.Body] = []
        self.told: list[Halted] = []
        self.bus.subscribe(lambda event: self.said.append(event.body))
        self.part: Part[Robot] = Part("robot", lambda status: None)
        self.begun = 0
        self.keeper = Keeper(self.robot, self.part, self.epoch, self.bus.bound(turn=None, epoch=0), self.tell)

    def tell(self, halted: Halted) -> None:
        """As the session: a loss advances the epoch at once."""
        self.told.append(halted)
        if halted.lost:
            self.epoch.advance()

    def on_start(self, robot: Robot) -> None:
        self.begun += 1

    def errors(self) -> list[events.ErrorRaised]:
        return [body for body in self.said if isinstance(body, events.ErrorRaised)]

    def logs(self) -> list[str]:
        return [body.message for body in self.said if isinstance(body, events.Log)]

    async def until(self, seen: Callable[[], object]) -> None:
        """Let virtual time pass until it is so; for ten minutes at most."""
        loop = asyncio.get_running_loop()
        end = loop.time() + 600
        while not seen():
            assert loop.time() < end, f"it did not come about: {self.part.status}, {self.said}"
            await asyncio.sleep(0.01)


@asynccontextmanager
async def kept() -> AsyncIterator[Kept]:
    """A robot that has been started and is kept."""
    it = Kept()
    keeping = asyncio.create_task(it.keeper.keep(it.on_start))
    try:
        await it.part.get()
        yield it
    finally:
        keeping.cancel()
        await asyncio.wait([keeping])
        assert it.robot.closed


def test_a_lost_robot_is_started_again_in_an_epoch_of_its_own_and_those_who_need_it_wait() -> None:
    async def main() -> None:
        async with kept() as it:
            epoch = it.epoch.current
            it.robot.lost = True
            await it.until(lambda: it.part.status.state == "loading")
            assert it.part.value is None
            assert await it.part.get() is it.robot
            assert it.part.status.state == "ready"
            assert it.epoch.current == epoch + 1
            assert it.robot.starts[-1][1] == epoch + 1, "the epoch had advanced before the robot was started"
            assert it.told == [Halted("The robot process died.", lost=True)]
            assert [(error.code, error.fatal) for error in it.errors()] == [("robot_lost", False)]
            await it.until(lambda: "The robot is running again where it was." in it.logs())
            assert it.begun == 1, "coming back is no new beginning"

    virtual_time.run(main())


def test_several_tries_are_made_before_it_is_given_up() -> None:
    async def main() -> None:
        async with kept() as it:
            it.robot.failing = len(PAUSES_S)
            it.robot.lost = True
            await it.until(lambda: it.part.status.state == "loading")
            with pytest.raises(SaysoError, match="does not start"):
                await it.part.get()
            times = [when for when, _ in it.robot.starts[1:]]
            assert [b - a - 0.5 for a, b in pairwise(times)] == pytest.approx(PAUSES_S[1:])
            await it.until(lambda: it.errors()[-1].fatal)
            assert it.errors()[-1].code == "robot_lost"
            assert it.part.status.state == "missing"

    virtual_time.run(main())


def test_a_start_that_fails_once_is_no_loss() -> None:
    async def main() -> None:
        async with kept() as it:
            it.robot.failing = 1
            it.robot.lost = True
            await it.until(lambda: it.part.status.state == "loading")
            assert await it.part.get() is it.robot
            assert not any(error.fatal for error in it.errors())

    virtual_time.run(main())


def test_a_robot_that_is_lost_again_and_again_is_given_up() -> None:
    async def main() -> None:
        async with kept() as it:
            for _ in PAUSES_S:
                it.robot.lost = True
                await it.until(lambda: it.part.value is None)
                await it.part.get()
            it.robot.lost = True
            await it.until(lambda: it.part.value is None)
            with pytest.raises(SaysoError, match="too often"):
                await it.part.get()

    virtual_time.run(main())


def test_a_robot_that_is_lost_now_and_then_comes_back_every_time() -> None:
    async def main() -> None:
        async with kept() as it:
            for _ in range(3 * len(PAUSES_S)):
                await asyncio.sleep(WINDOW_S / len(PAUSES_S))
                it.robot.lost = True
                await it.until(lambda: it.part.value is None)
                await it.part.get()

    virtual_time.run(main())


def test_a_robot_that_never_starts_is_told_once_and_fatal() -> None:
    async def main() -> None:
        it = Kept()
        it.robot.failing = 1
        await it.keeper.keep(it.on_start)
        assert [(error.code, error.fatal) for error in it.errors()] == [("robot_lost", True)]
        assert it.robot.closed

    virtual_time.run(main())


def test_a_robot_that_halts_by_itself_is_told_once_each_time() -> None:
    async def main() -> None:
        async with kept() as it:
            it.robot.halted, it.robot.halted_in = "heartbeat lost", 1
            await asyncio.sleep(1)
            assert it.told == [Halted("heartbeat lost", epoch=1)]
            it.epoch.advance()
            await asyncio.sleep(1)
            assert len(it.told) == 1, "it is still the same halt, although the epoch is new"
            it.robot.halted_in = 2
            await asyncio.sleep(1)
            assert it.told[1:] == [Halted("heartbeat lost", epoch=2)]

    virtual_time.run(main())


def test_a_fault_in_keeping_the_robot_is_told_and_the_robot_closed() -> None:
    async def main() -> None:
        async with kept() as it:
            epoch = it.epoch.current
            it.robot.fault = ZeroDivisionError("oh")
            await it.until(lambda: it.robot.closed)
            assert it.errors()[-1].fatal
            assert "ZeroDivisionError" in it.errors()[-1].message
            assert it.epoch.current > epoch
            assert it.part.status.state == "missing"

    virtual_time.run(main())


def test_a_stop_that_comes_while_the_robot_starts_is_in_force_when_it_has_started() -> None:
    async def main() -> None:
        it = Kept()
        keeping = asyncio.create_task(it.keeper.keep(it.on_start))
        await asyncio.sleep(0.1)
        it.epoch.advance()
        robot = await it.part.get()
        assert robot.state().epoch == it.epoch.current == 2
        keeping.cancel()
        await asyncio.wait([keeping])

    virtual_time.run(main())
