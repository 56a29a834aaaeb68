"""What the tests of the simulated robot share: settings, places, a world to hold in one's hand, a running robot."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from functools import cache
from math import degrees
from pathlib import Path
from typing import Any, TypeVar

import yaml

from config.schema import Place
from config.schema import Robot as RobotSettings
from engine.robot.follow import Follower
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.occupancy import Route, route
from engine.robot.robot import Robot, RobotState
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map
from engine.robot.sim.robot import SimRobot
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.world import World

CONFIG = Path(__file__).parents[2] / "config"
TICK_STEPS = 10
T = TypeVar("T")


def settings(**changes: Any) -> RobotSettings:
    """The robot's settings as shipped, at full speed, with these changes."""
    shipped = yaml.safe_load((CONFIG / "robot.yaml").read_text("utf-8"))["robot"]
    return RobotSettings.model_validate({**shipped, "speed": "max", **changes})


def places() -> dict[str, Pose]:
    """The places of the shipped map by symbol."""
    raw = yaml.safe_load((CONFIG / "map.yaml").read_text("utf-8"))["places"]
    found = {symbol: Place.model_validate(place) for symbol, place in raw.items()}
    return {s: Pose(p.position.x, p.position.y, p.orientation.yaw) for s, p in found.items()}


@cache
def flat() -> Scene:
    return load_scene(scene_path("flat"))


def in_the_flat(start: Pose | None = None, **changes: Any) -> World:
    """A world of its own, without a process, with the robot at ``start``."""
    scene = flat()
    if start is not None:
        begin = scene.start.model_copy(update={"x": start.x, "y": start.y, "yaw": degrees(start.yaw)})
        scene = scene.model_copy(update={"start": begin})
    return World(scene, settings(**changes))


def drive(world: World, twist: Twist, seconds: float, each_tick: Callable[[], None] = lambda: None) -> None:
    """Command ``twist`` every tick for ``seconds`` of robot time."""
    for _ in range(round(seconds / 0.02)):
        world.drive(twist)
        tick(world)
        each_tick()


def tick(world: World) -> None:
    for _ in range(TICK_STEPS):
        world.step()


def drive_to(world: World, goal: Pose, each_tick: Callable[[], None] = lambda: None) -> Route:
    """Plan a way from where the robot is and follow it to the end."""
    way = route(floor_map(flat()), world.true_pose, goal, FOOTPRINT)
    assert isinstance(way, Route), way.message
    follower = Follower(way.points, goal.yaw)
    deadline = world.t + 15 + 6 * way.length
    while not (guidance := follower.guide(world.true_pose)).arrived:
        assert world.t < deadline, f"no arrival at {goal}: {world.true_pose}, blocked by {world.blocked}"
        world.drive(guidance.twist)
        tick(world)
        each_tick()
    drive(world, ZERO, 0.3)
    return way


def run(main: Callable[[], Coroutine[Any, Any, T]]) -> T:
    return asyncio.run(main())


@asynccontextmanager
async def running(**changes: Any) -> AsyncIterator[SimRobot]:
    """A started robot in its process, closed in the end."""
    robot = SimRobot(settings(**changes))
    await robot.start()
    try:
        yield robot
    finally:
        await robot.close()


@asynccontextmanager
async def beating(robot: Robot) -> AsyncIterator[None]:
    """An engine's heartbeat."""

    async def beat() -> None:
        while True:
            robot.heartbeat()
            await asyncio.sleep(0.05)

    task = asyncio.create_task(beat())
    try:
        yield
    finally:
        task.cancel()


async def keep_driving(robot: SimRobot, twist: Twist, epoch: int, ticks: int, *, beating: bool = True) -> RobotState:
    """Command ``twist`` for ``ticks`` ticks; returns the last state."""
    for _ in range(ticks):
        if beating:
            robot.heartbeat()
        robot.drive(twist, epoch)
        state = await robot.tick()
    return state


async def ticks_until(robot: SimRobot, met: Callable[[RobotState], bool], *, beating: bool = True) -> RobotState:
    """Let ticks pass until a state meets the condition; a robot that never does is a failure."""
    for _ in range(500):
        if beating:
            robot.heartbeat()
        if met(state := await robot.tick()):
            return state
    raise AssertionError(f"ten seconds of robot time did not bring it about: {state}")
