"""A robot behind a rosbridge, for tests: ``python -m tests.ros_peer PORT``.

It speaks the operations that sayso uses, with the habits of rosbridge_suite: what comes over one connection is done one
after the other, a goal that is refused gets no answer, and ``cancel_action_goal`` finds a goal of another connection.
It carries the simulated robot, stands when no velocity has come for half a second, as a base controller of ROS does,
and finds its way by ``/navigate_to_pose``. Its odometry begins where it stands: only ``/tf`` tells where that is on the
map. What it does goes out as JSON lines.
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import json
import math
import sys
import time
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from engine.robot.geometry import ZERO, Pose, Twist, compose, inverse
from engine.robot.host.body import STEP_S
from engine.robot.host.memory import Memory
from engine.robot.lidar import LIDAR_ANGLES, RAYS
from engine.robot.robot import Footprint, Scan
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.simulated import SimulatedBody
from tests.pilot import Pilot
from tests.sim.rig import settings

LIFETIME_S = 0.5
"""Of a velocity."""
ACTION = "/navigate_to_pose"
HULL = Footprint(0.3, 0.24)
PICTURE = {
    **{"header": {"frame_id": "camera"}, "width": 320, "height": 240, "step": 960, "encoding": "rgb8"},
    **{"is_bigendian": 0, "data": base64.b64encode(bytes(range(256)) * 900).decode()},
}
TOPICS = {
    "/image": "sensor_msgs/msg/Image",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/cmd_vel": "geometry_msgs/msg/Twist",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/odom": "nav_msgs/msg/Odometry",
    "/rosout": "rcl_interfaces/msg/Log",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
}


class Peer:
    """One robot, and whoever listens to it."""

    def __init__(
        self,
        scene: Scene,
        *,
        navigates: bool = True,
        stubborn: bool = False,
        feedback_hz: float = 20.0,
        witness: Memory | None = None,
    ) -> None:
        self.floor = floor_map(scene)
        self.body = SimulatedBody(scene, settings(), pictures=False)
        self.told, self.told_at = ZERO, -math.inf
        self.start = self.body.true_pose
        self.way: Pilot | None = None
        self.cancelled: set[str] = set()
        self.cancelled_at = self.zero_at = math.inf
        self.zeros = 0
        self._feedback_s = 1 / feedback_hz
        self._witness = witness
        self._navigates, self._stubborn = navigates, stubborn
        self._listeners: dict[str, set[ServerConnection]] = {}

    async def listen(self, connection: ServerConnection) -> None:
        """Take what comes over one connection, one after the other; only a goal is cancelled beside that."""
        waiting: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        working = asyncio.create_task(self._work(connection, waiting))
        try:
            async for text in connection:
                order = json.loads(text)
                if order["op"] == "cancel_action_goal":
                    self.cancelled_at = min(self.cancelled_at, time.monotonic())
                    self.cancelled.add(order["id"])
                else:
                    waiting.put_nowait(order)
        except ConnectionClosed:
            pass  # it was killed
        finally:
            working.cancel()
            for listeners in self._listeners.values():
                listeners.discard(connection)

    async def _work(self, connection: ServerConnection, waiting: asyncio.Queue[dict[str, Any]]) -> None:
        while True:
            order = await waiting.get()
            match order["op"]:
                case "subscribe":
                    self._listeners.setdefault(order["topic"], set()).add(connection)
                    if order["topic"] in (latched := {"/map": self._map, "/tf_static": self._mounts}):
                        await self._say(order["topic"], latched[order["topic"]]())
                case "publish" if order["topic"] == "/cmd_vel":
                    linear, angular = order["msg"]["linear"], order["msg"]["angular"]
                    twist = Twist(linear["x"], linear["y"], angular["z"])
                    if twist.is_zero:
                        self.zeros += 1
                        self.zero_at = min(self.zero_at, time.monotonic())
                    self.drive(twist)
                case "call_service":
                    found = self._called(order["service"], order["args"])
                    about = {"id": order["id"], "service": order["service"], "values": found}
                    result = not isinstance(found, str)
                    await self._send(connection, {"op": "service_response", **about, "result": result})
                case "send_action_goal":
                    await self._navigate(connection, order)

    def _called(self, service: str, args: dict[str, Any]) -> dict[str, Any] | str:
        """The response of a service, or why there is none."""
        actions = [ACTION] if self._navigates else []
        match service:
            case "/rosapi/topics":
                return {"topics": list(TOPICS), "types": list(TOPICS.values())}
            case "/rosapi/services":
                return {"services": ["/rosapi/topics"]}
            case "/rosapi/action_servers":
                return {"action_servers": actions}
            case _ if any(service == f"{action}/_action/cancel_goal" for action in actions):
                everything = not any(args["goal_info"]["goal_id"]["uuid"])
                if everything:
                    self.cancelled_at = min(self.cancelled_at, time.monotonic())
                self.way = None if everything and not self._stubborn else self.way
                return {"return_code": 0 if everything else 2, "goals_canceling": []}
            case _:
                return f"Service {service} does not exist"

    def drive(self, twist: Twist) -> None:
        self.told, self.told_at = twist, self.body.t
        self.body.drive(twist)

    async def _navigate(self, connection: ServerConnection, order: dict[str, Any]) -> None:
        """Drive there as a navigation does: by velocities, 20 times a second."""
        about = {"id": order["id"], "action": order["action"]}
        stamped = order["args"]["pose"]
        at, turn = stamped["pose"]["position"], stamped["pose"]["orientation"]
        goal = Pose(at["x"], at["y"], 2 * math.atan2(turn["z"], turn["w"]))
        if stamped["header"]["frame_id"] == "odom":
            goal = compose(self.start, goal)
        pilot = self.way = Pilot(self.floor, HULL, goal)
        self.cancelled_at = self.zero_at = math.inf  # when it was first told so on this journey
        status, error, due = 4, 0, time.monotonic()
        while self.way is pilot:
            wanted = pilot.guide(self.body.true_pose, Scan(self.body.t, LIDAR_ANGLES, self.body.scan()))
            if isinstance(wanted, int):
                status, error = (6 if wanted else 4), wanted
                break
            if order["id"] in self.cancelled and not self._stubborn:
                status = 5
                break
            self.drive(wanted)
            told = {"distance_remaining": pilot.left}
            await self._send(connection, {"op": "action_feedback", **about, "values": told})
            due = max(due + self._feedback_s, time.monotonic() - 0.1)  # a flood comes in gusts, but all of it
            await asyncio.sleep(max(0.0, due - time.monotonic()))
        self.drive(ZERO)
        self.way = None
        ended = {"op": "action_result", **about, "values": {"error_code": error}, "status": status, "result": True}
        await self._send(connection, ended)

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
                    await self._say("/tf", self._frames())
                    self._tell()
                if steps % 50 == 0 and self._witness is not None:
                    self.body.fill(self._witness.state.scratch)
                    self._witness.state.scratch["t"] = self.body.t
                    self._witness.state.put()
                if steps % 50 == 25:
                    await self._say("/image", PICTURE)
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
        more = {"speed": speed, "told": not self.told.is_zero, "sent": self.way is not None, "zeros": self.zeros}
        more |= {"cancelled_at": self.cancelled_at, "zero_at": self.zero_at}
        print(json.dumps(state | more), flush=True)

    async def _say(self, topic: str, message: dict[str, Any]) -> None:
        for connection in tuple(self._listeners.get(topic, ())):
            await self._send(connection, {"op": "publish", "topic": topic, "msg": message})

    async def _send(self, connection: ServerConnection, order: dict[str, Any]) -> None:
        try:
            await connection.send(json.dumps(order))
        except (OSError, ConnectionClosed):
            for listeners in self._listeners.values():
                listeners.discard(connection)

    def _odometry(self) -> dict[str, Any]:
        pose, twist = compose(inverse(self.start), self.body.true_pose), self.body.twist
        moves = {"linear": {"x": twist.vx, "y": twist.vy, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": twist.wz}}
        at = {"position": {"x": pose.x, "y": pose.y, "z": 0.0}, "orientation": _turn(pose.yaw)}
        header = {"frame_id": "odom", "stamp": {"sec": 0, "nanosec": 0}}
        return {"header": header, "pose": {"pose": at}, "twist": {"twist": moves}}

    def _frames(self) -> dict[str, Any]:
        moved = {"translation": {"x": self.start.x, "y": self.start.y, "z": 0.0}, "rotation": _turn(self.start.yaw)}
        return {"transforms": [{"header": {"frame_id": "map"}, "child_frame_id": "odom", "transform": moved}]}

    def _mounts(self) -> dict[str, Any]:
        mount = {"translation": {"x": 0.0, "y": 0.0, "z": 0.2}, "rotation": _turn(0.0)}
        return {"transforms": [{"header": {"frame_id": "base_link"}, "child_frame_id": "laser", "transform": mount}]}

    def _map(self) -> dict[str, Any]:
        floor = self.floor
        rows, columns = floor.occupied.shape
        corner = {"position": {"x": floor.origin[0], "y": floor.origin[1], "z": 0.0}, "orientation": _turn(0.0)}
        info = {"resolution": floor.resolution, "width": columns, "height": rows, "origin": corner}
        return {"header": {"frame_id": "map"}, "info": info, "data": (100 * floor.occupied).ravel().tolist()}

    def _scan(self) -> dict[str, Any]:
        ranges = [value if math.isfinite(value) else None for value in self.body.scan().tolist()]
        step = 2 * math.pi / RAYS
        limits = {"angle_min": 0.0, "angle_increment": step, "range_min": 0.05, "range_max": 12.0}
        return {"header": {"frame_id": "laser"}, **limits, "time_increment": 0.0, "ranges": ranges}


def _turn(yaw: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


async def main(argv: list[str]) -> None:
    """Serve until killed."""
    parser = argparse.ArgumentParser(prog="python -m tests.ros_peer")
    parser.add_argument("port", type=int)
    parser.add_argument("--no-navigation", action="store_true", help="nobody there finds the way")
    parser.add_argument("--stubborn", action="store_true", help="its navigation ignores who cancels")
    parser.add_argument("--feedback", type=float, default=20.0, metavar="HZ", help="how often its navigation tells")
    parser.add_argument("--scene", default="flat", metavar="SCENE", help="where it lives")
    parser.add_argument("--witness", type=int, metavar="FD", help="memory of a host, to show there how it really is")
    given = parser.parse_args(argv)
    peer = Peer(
        load_scene(scene_path(given.scene)),
        navigates=not given.no_navigation,
        stubborn=given.stubborn,
        feedback_hz=given.feedback,
        witness=Memory(given.witness) if given.witness is not None else None,
    )
    async with serve(peer.listen, "127.0.0.1", given.port, compression=None):
        await peer.live()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1:]))
