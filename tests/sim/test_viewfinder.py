"""Looking on: a picture for each time of asking, from any thread, and nothing is changed by it."""

from __future__ import annotations

import asyncio
import queue
from typing import Final

from engine.errors import CameraError, SaysoError
from engine.parts.part import Part
from engine.parts.viewfinder import Viewfinder
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight
from engine.robot.robot import Robot
from tests.sim.rig import run, running

RAYS: Final = {"backend": "rays", "width": 160, "height": 120}
PATIENCE_S: Final = 60.0

Found = queue.SimpleQueue[Sight | SaysoError]


def robot_part() -> Part[Robot]:
    return Part("robot", lambda status: None)


def test_whoever_asks_gets_one_picture_with_what_is_recognised_in_it() -> None:
    async def test() -> None:
        found: Found = queue.SimpleQueue()
        async with running(camera=RAYS) as robot:
            part = robot_part()
            part.succeed(robot)
            viewfinder = Viewfinder(part, asyncio.get_running_loop())
            assert robot.camera_pid is None, "nobody looks, and there is no camera"
            for _ in range(2):
                await asyncio.to_thread(viewfinder.look, found.put)
                sight = await asyncio.to_thread(found.get, timeout=PATIENCE_S)
                assert isinstance(sight, Sight)
                assert sight.picture.rgb.shape == (120, 160, 3)
                names = [thing.name for thing in perceive(sight.picture, robot.floor_map).objects]
                assert [thing.name for thing in sight.objects] == names
            assert found.empty(), "one picture for each time of asking"
            await viewfinder.close()

    run(test)


def test_without_a_robot_it_says_so_and_takes_no_picture() -> None:
    async def test() -> None:
        found: Found = queue.SimpleQueue()
        viewfinder = Viewfinder(robot_part(), asyncio.get_running_loop())
        viewfinder.look(found.put)
        error = await asyncio.to_thread(found.get, timeout=PATIENCE_S)
        assert isinstance(error, CameraError)
        assert "not there yet" in error.message
        await viewfinder.close()

    run(test)


def test_a_camera_that_is_gone_is_told_and_no_fault() -> None:
    async def test() -> None:
        found: Found = queue.SimpleQueue()
        part = robot_part()
        async with running(camera=RAYS) as robot:
            part.succeed(robot)
        viewfinder = Viewfinder(part, asyncio.get_running_loop())
        viewfinder.look(found.put)
        assert isinstance(await asyncio.to_thread(found.get, timeout=PATIENCE_S), SaysoError)
        await viewfinder.close()

    run(test)


def test_an_engine_that_has_ended_says_so_at_once() -> None:
    loop = asyncio.new_event_loop()
    viewfinder = Viewfinder(robot_part(), loop)
    loop.close()
    found: Found = queue.SimpleQueue()
    viewfinder.look(found.put)
    assert isinstance(found.get_nowait(), CameraError)
