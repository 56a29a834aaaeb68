"""A program that turns a robot on the spot, as an engine would: ``python -m tests.turning PORT MODEL [LIDAR]``.

It tells what happens as JSON lines, and takes ``go`` (begin a new epoch and turn) and ``stop`` on stdin. A robot that
is lost is started again, and stands.
"""

from __future__ import annotations

import asyncio
import json
import sys
import threading
import time
from typing import Any

from engine.errors import RobotError
from engine.robot.bodies import make_robot
from engine.robot.geometry import Twist
from engine.robot.robot import Robot
from tests.sim.rig import settings

TURN = Twist(wz=0.6)


def tell(**what: Any) -> None:
    print(json.dumps({"at": time.monotonic(), **what}), flush=True)


async def main(port: str, model: str, lidar: str | None = None) -> None:
    robot = make_robot(settings(kind="rosmaster", port=port, model=model, lidar=lidar, speed="real"))
    await robot.start()
    threading.Thread(target=beat, args=(robot,), daemon=True).start()
    orders: asyncio.Queue[str] = asyncio.Queue()
    loop = asyncio.get_running_loop()
    threading.Thread(target=read, args=(loop, orders), daemon=True).start()
    tell(event="ready", host=getattr(robot, "pid", None))
    epoch, going, halted = 1, False, None
    while True:
        try:
            while not orders.empty():
                order = orders.get_nowait()
                epoch, going = epoch + 1, order == "go"
                at = time.monotonic()
                robot.stop(epoch)
                tell(event=order, epoch=epoch, at=at)
            if going:
                robot.drive(TURN, epoch)
            state = await robot.tick()
            if state.halted != halted:
                halted = state.halted
                tell(event="halted", why=halted)
            if halted and state.halted_in == epoch:
                going = False
        except RobotError as error:
            tell(event="lost", why=error.message)
            epoch, going = epoch + 1, False
            robot.stop(epoch)
            try:
                await robot.start()
                tell(event="ready", host=getattr(robot, "pid", None))
            except RobotError as again:
                tell(event="lost", why=again.message)
                await asyncio.sleep(0.3)


def beat(robot: Robot) -> None:
    while True:
        robot.heartbeat()
        time.sleep(0.02)


def read(loop: asyncio.AbstractEventLoop, orders: asyncio.Queue[str]) -> None:
    for line in sys.stdin:
        loop.call_soon_threadsafe(orders.put_nowait, line.strip())


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
