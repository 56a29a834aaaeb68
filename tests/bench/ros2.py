"""A robot of ROS 2 behind a bridge on this machine: from stop() to the cancel and to the zero velocity that reach it,
at rest and while its navigation floods us with feedback; what listening costs; and how soon a bridge that was killed is
told, and found again."""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import signal
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from config import load
from config.schema import Robot as RobotSettings
from engine.robot.bodies import make_robot
from engine.robot.geometry import Pose
from engine.robot.host.hosted import HostedRobot
from engine.robot.robot import Robot, RobotState
from engine.robot.ros2 import messages, pictures
from engine.ros.door import Message
from engine.ros.opening import open_door
from tests.bench.report import Figure, figures, print_report, report
from tests.rosbridge import Peer, free_port
from tests.sim.rig import beating

KITCHEN = Pose(0.2, 2.0, 0.0)
DOCK = Pose(4.2, -0.3, 0.0)
LISTENED_S = 10.0
FLOOD = "--feedback=1000"


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench ros2", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=100, help="how many stops of each kind")
    parser.add_argument("--blows", type=int, default=10, help="how many times the bridge is killed")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    for name, options in (("", ()), (" in a flood of 1 kHz", (FLOOD,))):
        cancels, zeros = asyncio.run(stops(args.n, options))
        found[f"stop() → cancel{name}"] = figures(cancels, "ms")
        found[f"stop() → zero{name}"] = figures(zeros, "ms")
    for name, number in (("killed", signal.SIGKILL), ("stopped", signal.SIGSTOP)):
        cancels, zeros = asyncio.run(struck(args.blows, number))
        found[f"host {name} → cancel"] = figures(cancels, "ms")
        found[f"host {name} → zero"] = figures(zeros, "ms")
    told, again = asyncio.run(blows(args.blows))
    found["bridge killed → told"] = figures(told, "ms")
    found["bridge back → drives"] = figures(again, "ms")
    print_report(report("ros2", args.n, found, {"a core for odometry, scans and pictures": cost()}), args.json)


@asynccontextmanager
async def driven(port: int) -> AsyncIterator[HostedRobot]:
    robot = make_robot(settings(port))
    assert isinstance(robot, HostedRobot)
    await robot.start()
    try:
        async with beating(robot):
            yield robot
    finally:
        await robot.close()


def settings(port: int) -> RobotSettings:
    return load(overrides=["robot.kind=ros2", f"robot.door=ws://127.0.0.1:{port}"], environ={}).robot


async def stops(n: int, options: tuple[str, ...]) -> tuple[list[float], list[float]]:
    """From stop() in mid-drive to what the robot gets, ms."""
    port, epoch = free_port(), 1
    cancels, zeros = [], []
    with Peer(port, *options) as peer:
        async with driven(port) as robot:
            for _ in range(n):
                robot.go(max(KITCHEN, DOCK, key=robot.state().pose.distance_to), epoch)
                await until(robot, lambda state: math.hypot(state.twist.vx, state.twist.vy) > 0.1)
                epoch += 1
                stopped = time.monotonic()
                robot.stop(epoch)
                state = await asyncio.to_thread(
                    peer.until, lambda s, since=stopped: not s["sent"] and since < s["zero_at"] < math.inf
                )
                cancels.append(1e3 * (state["cancelled_at"] - stopped))
                zeros.append(1e3 * (state["zero_at"] - stopped))
                await until(robot, lambda state: not state.moving)
    return cancels, zeros


async def struck(n: int, number: signal.Signals) -> tuple[list[float], list[float]]:
    """From a blow to the host in mid-drive to what the robot gets, ms."""
    cancels, zeros = [], []
    for _ in range(n):
        port = free_port()
        with Peer(port) as peer:
            async with driven(port) as robot:
                robot.go(DOCK, 1)
                await until(robot, lambda state: math.hypot(state.twist.vx, state.twist.vy) > 0.1)
                assert robot.pid is not None
                blow = time.monotonic()
                os.kill(robot.pid, number)
                state = await asyncio.to_thread(peer.until, lambda s: not s["sent"] and s["zero_at"] < math.inf)
                cancels.append(1e3 * (state["cancelled_at"] - blow))
                zeros.append(1e3 * (state["zero_at"] - blow))
    return cancels, zeros


async def blows(n: int) -> tuple[list[float], list[float]]:
    """From a bridge's death to the robot's saying so, and from its return to a robot that can be driven, ms."""
    port, epoch = free_port(), 1
    told, again = [], []
    with Peer(port) as first:
        async with driven(port) as robot:
            peer = first
            for _ in range(n):
                robot.go(max(KITCHEN, DOCK, key=robot.state().pose.distance_to), epoch)
                await until(robot, lambda state: math.hypot(state.twist.vx, state.twist.vy) > 0.1)
                peer.kill()
                killed = time.monotonic()
                await until(robot, lambda state: state.halted is not None)
                told.append(1e3 * (time.monotonic() - killed))
                peer = await asyncio.to_thread(Peer(port).__enter__)
                back = time.monotonic()
                epoch += 1
                robot.stop(epoch)
                await until(robot, lambda state: state.halted is None)
                again.append(1e3 * (time.monotonic() - back))
            peer.kill()
    return told, again


async def until(robot: Robot, met: Callable[[RobotState], bool]) -> RobotState:
    while not met(state := await robot.tick()):
        pass
    return state


def cost() -> float:
    """The part of a core that a door needs for odometry at 50 Hz, scans at 10 Hz and pictures of 320×240 at 10 Hz."""
    port = free_port()
    came = dict.fromkeys(("odometry", "scans", "pictures"), 0)

    def odometry(message: Message) -> None:
        came["odometry"] += messages.odometry(message) is not None

    def scans(message: Message) -> None:
        came["scans"] += messages.scan_points(message) is not None

    def images(message: Message) -> None:
        came["pictures"] += pictures.colours(message) is not None

    with Peer(port):
        door = open_door(f"ws://127.0.0.1:{port}")
        door.subscribe("/odom", messages.ODOMETRY, odometry)
        door.subscribe("/scan", messages.SCAN, scans)
        door.subscribe("/image", pictures.IMAGE, images)
        time.sleep(1)
        began, before = time.process_time(), dict(came)
        time.sleep(LISTENED_S)
        used = time.process_time() - began
        rates = {name: (count - before[name]) / LISTENED_S for name, count in came.items()}
        door.close()
    assert rates["odometry"] > 45, rates
    assert min(rates.values()) > 9, rates
    return used / LISTENED_S


if __name__ == "__main__":
    main()
