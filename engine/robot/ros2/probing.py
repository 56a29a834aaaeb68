"""Finding out what a robot of ROS 2 has, from its graph and from what it says: the beginning of a description. Nothing
is told to the robot."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import DeviceError
from engine.robot.geometry import Pose, compose
from engine.robot.ros2 import messages, pictures
from engine.robot.ros2.arm import FOLLOW, STATES
from engine.robot.ros2.navigation import NAVIGATE
from engine.ros.door import Door, Graph, Message
from engine.ros.opening import wait_for

MAP: Final = "nav_msgs/msg/OccupancyGrid"
_USUAL: Final = {
    messages.TWIST: ("/cmd_vel", "/cmd_vel_unstamped", "/diff_drive_controller/cmd_vel_unstamped"),
    messages.TWIST_STAMPED: ("/cmd_vel", "/diff_drive_controller/cmd_vel"),
    messages.ODOMETRY: ("/odom", "/odometry/filtered", "/diff_drive_controller/odom"),
    messages.SCAN: ("/scan", "/scan_filtered"),
    messages.BATTERY: ("/battery_state", "/battery"),
    messages.TF: ("/tf", "/tf_static"),
    MAP: ("/map",),
    STATES: ("/joint_states",),
}
"""Names by type, the likeliest first: what is looked for where nobody lists the graph."""
_MOST_CELLS: Final = 16_000_000


@dataclass(frozen=True, slots=True)
class GridMap:
    """A map as it came: ``cells`` are −1 where nobody knows, else how likely something stands there, 0…100; their shape
    is (rows, columns), row 0 at the bottom."""

    resolution: float  # m
    origin: tuple[float, float]  # of the lower left corner, m
    cells: NDArray[np.int8]


@dataclass(slots=True)
class Probed:
    """What was found."""

    description: dict[str, Any]
    graph: Graph
    map: GridMap | None = None
    remarks: list[str] = field(default_factory=list)
    """What nobody could find out, for people to put in."""


def probe(door: Door, seconds: float) -> Probed:
    """Look and listen for about so long; the door stays open. Raises ``DeviceError``."""
    if trouble := wait_for(door, seconds):
        raise DeviceError(f"Nothing can be found out: {trouble}.", hint="Does it run, and is the door right?")
    graph = _listed(door, seconds)
    heard = _heard(door, _topics(graph), seconds)
    return _described(graph, heard)


def _listed(door: Door, seconds: float) -> Graph:
    found: list[Graph] = []
    came = threading.Event()

    def take(graph: Graph) -> None:
        found.append(graph)
        came.set()

    door.graph(take)
    came.wait(seconds)
    return found[0] if found else Graph(why="the graph was not listed in time")


def _topics(graph: Graph) -> dict[str, str]:
    """What is listened to: topic, and type."""
    if graph.topics:
        kinds = {messages.ODOMETRY, messages.SCAN, messages.BATTERY, messages.TF, MAP, STATES, pictures.INFO}
        return {topic: type for topic, type in graph.topics.items() if type in kinds}
    silent = (messages.TWIST, messages.TWIST_STAMPED)
    return {name: type for type, names in _USUAL.items() if type not in silent for name in names}


def _heard(door: Door, topics: Mapping[str, str], seconds: float) -> dict[str, list[Message]]:
    """The first messages of each, for so long."""
    heard: dict[str, list[Message]] = {topic: [] for topic in topics}
    over = threading.Event()

    def take(topic: str, message: Message) -> None:
        if len(heard[topic]) < 50:
            heard[topic].append(message)
        if all(heard.values()):
            over.set()

    for topic, type in topics.items():
        latched = type == MAP or topic.endswith("static")
        door.subscribe(topic, type, partial(take, topic), latched=latched)
    over.wait(seconds)
    return heard


def _described(graph: Graph, heard: Mapping[str, list[Message]]) -> Probed:
    remarks: list[str] = []
    of_type: dict[str, list[str]] = {}
    listed = graph.topics or {topic: type for topic, type in _topics(graph).items() if heard[topic]}
    for topic, type in sorted(listed.items()):
        of_type.setdefault(type, []).append(topic)

    def said(type: str) -> list[Message]:
        return [message for topic in of_type.get(type, ()) for message in heard.get(topic, ())]

    ros: dict[str, Any] = {}
    stamped, plain = (_best(of_type.get(type, ()), type) for type in (messages.TWIST_STAMPED, messages.TWIST))
    velocity = plain or stamped
    if velocity is None:
        remarks.append("ros.velocity: nobody lists a topic of velocities; is it /cmd_vel, and stamped or not?")
    ros["velocity"], ros["stamped"] = velocity or "/cmd_vel", plain is None and stamped is not None
    for key, type in (("odometry", messages.ODOMETRY), ("scan", messages.SCAN), ("battery", messages.BATTERY)):
        ros[key] = _best(of_type.get(type, ()), type)
    if ros["odometry"] is None:
        ros["odometry"] = "/odom"
        remarks.append("ros.odometry: none was found, and nothing drives without it")
    there = _action(graph, NAVIGATE, "navigate_to_pose")
    ros["navigation"] = "/navigate_to_pose" if graph.why else there  # one that is not there does no harm
    frames = [frame for message in said(messages.TF) for frame in messages.transforms(message)]
    ros["map_frame"] = "map" if any(parent == "map" for parent, _, _ in frames) else None
    if (camera := _camera(of_type)) is not None:
        ros["camera"] = camera
    if trajectory := _action(graph, FOLLOW, "follow_joint_trajectory"):
        names = next((list(message.get("name", ())) for message in said(STATES)), [])
        remarks.append(f"an arm is moved by {trajectory}, its joints are {', '.join(map(str, names))}: arm and ros.arm")
    found: dict[str, Any] = {"name": "robot of ROS 2", "source": "Found by `sayso robot probe ros2`; measure the rest."}
    found |= {"drive": "differential", "hull": {"length": 0.4, "width": 0.4}}
    found |= {"speeds": {"forward": 0.3, "sideways": 0, "turn": 1.0}, "ros": ros}
    remarks.append("drive, hull and speeds are guesses: put in those of your robot before it drives")
    if (lidar := _lidar(ros["scan"], heard, frames, remarks)) is not None:
        found["lidar"] = lidar
    if camera is not None:
        found["camera"] = {"depth": "depth" in camera, "view": _view(said(pictures.INFO)), "on_arm": False}
        remarks.append("camera.at and camera.down: where it is, and how far it looks down")
    return Probed(found, graph, next(filter(None, map(grid_map, said(MAP))), None), remarks)


def _best(names: Iterable[str], type: str) -> str | None:
    """The likeliest of these: a usual name, else the shortest."""
    ranked = sorted(names, key=lambda name: (_rank(name, type), len(name), name))
    return ranked[0] if ranked else None


def _rank(name: str, type: str) -> int:
    usual = _USUAL.get(type, ())
    return usual.index(name) if name in usual else len(usual)


def _action(graph: Graph, type: str, last: str) -> str | None:
    """The action of this type; where types are not told, the one of this last name."""
    typed = [name for name, its in graph.actions.items() if its == type]
    named = [name for name, its in graph.actions.items() if not its and name.rsplit("/", 1)[-1] == last]
    return min(typed or named, key=len, default=None)


def _camera(of_type: Mapping[str, list[str]]) -> dict[str, Any] | None:
    """Topics of the likeliest camera: colours before grey, raw before compressed."""
    raw = [name for name in of_type.get(pictures.IMAGE, ()) if "depth" not in name and "infra" not in name]
    packed = [name for name in of_type.get(pictures.COMPRESSED, ()) if "depth" not in name]
    names = raw or packed
    if not names:
        return None
    image = min(names, key=lambda name: (not ("color" in name or "rgb" in name), len(name), name))
    camera: dict[str, Any] = {"image": image, "compressed": not raw}
    folder = image.rsplit("/", 2 if not raw else 1)[0]
    infos = [name for name in of_type.get(pictures.INFO, ()) if name.rsplit("/", 1)[0] == folder]
    if infos:
        camera["info"] = infos[0]
    aligned = [name for name in of_type.get(pictures.IMAGE, ()) if "aligned_depth" in name and "info" not in name]
    registered = [name for name in of_type.get(pictures.IMAGE, ()) if "depth_registered" in name]
    if depth := aligned or registered:
        camera["depth"] = min(depth, key=len)
    return camera


def _view(infos: Iterable[Message]) -> float:
    """deg, up and down; a usual one where nobody tells."""
    for message in infos:
        if (lens := pictures.lens(message, 640, 480)) is not None:
            return round(math.degrees(2 * math.atan(240 / lens.fy)), 1)
    return 43.0


def _lidar(
    scan: str | None,
    heard: Mapping[str, list[Message]],
    frames: list[tuple[str, str, Pose]],
    remarks: list[str],
) -> dict[str, Any] | None:
    if scan is None:
        remarks.append("no lidar was found: it drives slowly, and stops short of what is on the map alone")
        return None
    told = heard.get(scan) or [{}]
    lidar: dict[str, Any] = {"range": 12.0}
    for name, key in (("range_max", "range"), ("range_min", "nearest")):
        value = told[0].get(name)
        if isinstance(value, int | float) and 0 < value < (100 if key == "range" else 1):
            lidar[key] = round(float(value), 3)
    mount = _place(messages.frame(told[0]), frames)
    if mount is None:
        remarks.append("lidar.at and lidar.turned: where it is on the robot, and where it calls 0°")
    else:
        lidar["at"] = [round(mount.x, 3), round(mount.y, 3)]
        lidar["turned"] = round(math.degrees(mount.yaw), 1)
    return lidar


def _place(frame: str, frames: list[tuple[str, str, Pose]]) -> Pose | None:
    """Where a frame is on the base, as far as the fixed frames tell: one after the other."""
    above = {child: (parent, pose) for parent, child, pose in frames}
    pose = Pose(0.0, 0.0, 0.0)
    for _ in range(10):
        if frame in ("base_link", "base_footprint"):
            return pose
        if frame not in above:
            return None
        frame, step = above[frame]
        pose = compose(step, pose)
    return None


def grid_map(message: Message) -> GridMap | None:
    """The map of an ``OccupancyGrid``; None where it makes no sense."""
    try:
        info = message["info"]
        columns, rows, resolution = int(info["width"]), int(info["height"]), float(info["resolution"])
        corner = info["origin"]["position"]
        origin = float(corner["x"]), float(corner["y"])
        cells = np.asarray(message["data"], dtype=np.int8)
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    sane = 0.005 < resolution <= 1 and all(map(math.isfinite, origin)) and 0 < columns * rows <= _MOST_CELLS
    if not sane or cells.shape != (columns * rows,):
        return None
    return GridMap(resolution, origin, cells.reshape(rows, columns))
