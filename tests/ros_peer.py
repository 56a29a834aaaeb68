"""A robot behind a rosbridge, for tests: ``python -m tests.ros_peer PORT``. It speaks the operations that sayso uses
(advertise, subscribe, publish), carries the simulated robot, and stands when no velocity has come for half a second, as
a base controller of ROS does. What it does goes out as JSON lines."""

from __future__ import annotations

import asyncio
import json
import math
import sys
import time
from typing import Any

from websockets.asyncio.server import ServerConnection, serve

from engine.robot.geometry import ZERO, Twist
from engine.robot.host.body import STEP_S
from engine.robot.lidar import RAYS
from engine.robot.sim.simulated import SimulatedBody
from tests.sim.rig import flat, settings

LIFETIME_S = 0.5
"""Of a velocity."""


class Peer:
    """One robot, and whoever listens to it."""

    def __init__(self) -> None:
        self.body = SimulatedBody(flat(), settings(), pictures=False)
        self.told, self.told_at = ZERO, -math.inf
        self._listeners: dict[str, set[ServerConnection]] = {}

    async def listen(self, connection: ServerConnection) -> None:
        """Take what comes over one connection."""
        async for text in connection:
            order = json.loads(text)
            match order["op"]:
                case "subscribe":
                    self._listeners.setdefault(order["topic"], set()).add(connection)
                case "publish" if order["topic"] == "/cmd_vel":
                    linear, angular = order["msg"]["linear"], order["msg"]["angular"]
                    self.told, self.told_at = Twist(linear["x"], linear["y"], angular["z"]), self.body.t
                    self.body.drive(self.told)
        for listeners in self._listeners.values():
            listeners.discard(connection)

    async def live(self) -> None:
        """Let time pass, as fast as it does."""
        began, steps = time.monotonic(), 0
        while True:
            while steps * STEP_S < time.monotonic() - began:
                self._step()
                steps += 1
                if steps % 10 == 0:
                    await self._say("/odom", self._odometry())
                if steps % 50 == 0:
                    await self._say("/scan", self._scan())
                    self._tell()
                if steps % 500 == 0:
                    await self._say("/battery_state", {"voltage": 14.2})
            await asyncio.sleep(STEP_S)

    def _step(self) -> None:
        if not self.told.is_zero and self.body.t - self.told_at > LIFETIME_S:
            self.told = ZERO
            self.body.drive(ZERO)
        self.body.step()

    def _tell(self) -> None:
        pose, twist = self.body.true_pose, self.body.twist
        state = {"at": time.monotonic(), "x": pose.x, "y": pose.y, "yaw": pose.yaw}
        speed = math.hypot(twist.vx, twist.vy) + abs(twist.wz)
        print(json.dumps({**state, "speed": speed, "told": not self.told.is_zero}), flush=True)

    async def _say(self, topic: str, message: dict[str, Any]) -> None:
        text = json.dumps({"op": "publish", "topic": topic, "msg": message})
        for connection in tuple(self._listeners.get(topic, ())):
            try:
                await connection.send(text)
            except OSError:
                self._listeners[topic].discard(connection)
            except Exception:  # noqa: BLE001 - whatever a connection that is being closed says
                self._listeners[topic].discard(connection)

    def _odometry(self) -> dict[str, Any]:
        pose, twist = self.body.true_pose, self.body.twist
        half = pose.yaw / 2
        turn = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
        moves = {"linear": {"x": twist.vx, "y": twist.vy, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": twist.wz}}
        at = {"position": {"x": pose.x, "y": pose.y, "z": 0.0}, "orientation": turn}
        return {"pose": {"pose": at}, "twist": {"twist": moves}}

    def _scan(self) -> dict[str, Any]:
        ranges = [value if math.isfinite(value) else None for value in self.body.scan().tolist()]
        step = 2 * math.pi / RAYS
        limits = {"angle_min": 0.0, "angle_increment": step, "range_min": 0.05, "range_max": 12.0}
        return {**limits, "time_increment": 0.0, "ranges": ranges}


async def main(port: int) -> None:
    """Serve until killed."""
    peer = Peer()
    async with serve(peer.listen, "127.0.0.1", port, compression=None):
        await peer.live()


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1])))
