"""The camera dies or hangs in mid-drive: whoever drives by it stands, is told, and soon sees again."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable

import psutil
import pytest

from config import load
from engine import events
from engine.commands import Quit
from engine.engine import Engine
from engine.epoch import Epoch
from engine.errors import CameraError
from engine.parts.loading import Sound
from engine.perception.eyes import Eyes
from engine.perception.memory import WorldMemory
from engine.plan import Action, Plan
from engine.robot.camera_news import CameraNews, GivenUp, Lost, Opened
from engine.robot.geometry import Twist
from engine.robot.robot import RobotState
from engine.robot.sim.robot import SimRobot
from engine.session.dispatch import Dispatcher, Report, Run
from engine.session.holds import Holds
from engine.skills.context import SkillContext
from engine.skills.outcome import Result
from engine.skills.places import Places
from engine.skills.registry import Skill, SkillRegistry
from tests.e2e.test_leaks import DEADLINE_S, Running
from tests.sim.rig import beating, settings

STOPS = (signal.SIGKILL, signal.SIGSTOP)
RAYS = {"backend": "rays", "width": 160, "height": 120}


async def chase(context: SkillContext) -> Result:
    """Drive by pictures, one a tick, for ever."""
    while True:
        await context.robot.look()
        context.drive(Twist(0.3, 0.0, 0.0))
        await context.robot.tick()


def in_real_time(test: Callable[[SimRobot, list[CameraNews]], Awaitable[None]]) -> None:
    """Run ``test`` with a robot and what is told of its camera."""

    async def run() -> None:
        news: list[CameraNews] = []
        robot = SimRobot(settings(speed="real", camera=RAYS), news.append)
        await robot.start()
        try:
            async with beating(robot), asyncio.timeout(DEADLINE_S):
                await robot.look()
                await test(robot, news)
        finally:
            await robot.close()
        assert psutil.Process().children() == []

    asyncio.run(run())


async def chasing(robot: SimRobot) -> Report:
    """The plan ``chase()`` as the engine would run it."""
    places = Places(load(environ={}).places)
    registry = SkillRegistry(
        [Skill("chase", "", (), frozenset({"base"}), chase, True)], capabilities=robot.capabilities
    )
    eyes, epoch = Eyes(robot, WorldMemory()), Epoch(robot.stop)
    dispatcher = Dispatcher(registry, robot, places, epoch, Holds(), lambda: "", eyes)

    async def say(text: str) -> None:
        del text

    plan = Plan("chase", (Action("chase", {}),), "", "phrases")
    return await dispatcher.run(Run(plan, epoch.current, lambda body: None, say, lambda ran: None))


@pytest.mark.parametrize("how", STOPS)
def test_a_robot_that_drives_by_a_camera_that_is_lost_stands_and_says_so_and_sees_again(how: signal.Signals) -> None:
    async def test(robot: SimRobot, news: list[CameraNews]) -> None:
        doing = asyncio.create_task(chasing(robot))
        while (await robot.tick()).twist.vx < 0.25:
            assert not doing.done(), doing.result()
        lost, pid = robot.state(), robot.camera_pid
        assert pid is not None
        os.kill(pid, how)
        seen: list[RobotState] = [lost]
        while not doing.done():
            seen.append(await robot.tick())
        while (state := await robot.tick()).moving:
            seen.append(state)
        moved = max(state.t for state in seen if state.moving)
        assert moved - lost.t <= 0.3, "robot time until it stood"
        [ran] = (await doing).ran
        assert (ran.result.outcome, ran.result.error_code) == ("failed", "camera_lost")
        assert "The camera process" in ran.result.message
        assert (await robot.look()).t >= state.t, "the replacement takes pictures of now"
        assert robot.camera_pid not in (None, pid)
        assert [type(told) for told in news if isinstance(told, Lost | Opened)] == [Opened, Lost, Opened]

    in_real_time(test)


def test_everybody_who_waits_for_a_picture_hears_of_the_loss() -> None:
    async def test(robot: SimRobot, news: list[CameraNews]) -> None:
        assert robot.camera_pid is not None
        os.kill(robot.camera_pid, signal.SIGSTOP)
        looks = await asyncio.gather(*(robot.look() for _ in range(3)), return_exceptions=True)
        assert all(isinstance(look, CameraError) for look in looks), looks
        await robot.look()

    in_real_time(test)


def test_a_loss_between_two_pictures_is_told_to_who_asks_next_unless_there_is_another_camera_by_then() -> None:
    async def test(robot: SimRobot, news: list[CameraNews]) -> None:
        async def until(kind: type[CameraNews], count: int) -> None:
            while sum(isinstance(told, kind) for told in news) < count:
                await robot.tick()

        for number, looks_at_once in enumerate((True, False), 1):
            assert robot.camera_pid is not None
            os.kill(robot.camera_pid, signal.SIGKILL)
            await until(Lost, number)
            if looks_at_once:
                with pytest.raises(CameraError, match="SIGKILL"):
                    await robot.look()
            else:
                await until(Opened, number + 1)
            await robot.look()

    in_real_time(test)


async def lose(robot: SimRobot) -> None:
    assert robot.camera_pid is not None
    os.kill(robot.camera_pid, signal.SIGKILL)
    with pytest.raises(CameraError, match="SIGKILL"):
        await robot.look()


def test_a_camera_that_is_lost_again_and_again_is_given_up() -> None:
    async def test(robot: SimRobot, news: list[CameraNews]) -> None:
        for _ in range(3):
            await lose(robot)
            await robot.look()
        await lose(robot)
        with pytest.raises(CameraError, match="too often"):
            await robot.look()
        assert isinstance(news[-1], GivenUp)
        assert len([told for told in news if isinstance(told, Lost)]) == 4
        robot.drive(Twist(0.2, 0, 0), 1)  # the robot itself is well
        await robot.tick()

    in_real_time(test)


def test_the_engine_says_what_became_of_its_camera_and_leaves_nothing() -> None:
    configuration = load(overrides=["robot.speed=max", "session.record_log=false"], environ={})
    engine = Engine(configuration, mode="test", sound=Sound("none"))
    running = Running(engine)
    engine.start()
    try:
        running.until(lambda body: isinstance(body, events.Log) and body.source == "camera")
        [ready] = [part for part in engine.status() if part.name == "camera"]
        assert ready.state == "ready"
        assert ready.detail.endswith("160×120")
        [camera] = [child for child in psutil.Process().children() if "engine.robot.sim.imaging" in child.cmdline()]
        camera.kill()
        running.until(lambda body: isinstance(body, events.ErrorRaised) and body.code == "camera_lost")
        running.until(lambda body: isinstance(body, events.Log) and body.message == "The camera is back.")
    finally:
        engine.send(Quit())
        assert engine.join(DEADLINE_S)
    assert psutil.Process().children() == []
