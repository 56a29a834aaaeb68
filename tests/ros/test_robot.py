"""A robot of ROS, driven through the door of rclpy: a whole robot for a door, and a check of the robot itself."""

from __future__ import annotations

import itertools
import math
import queue
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from engine.ros.door import Door, Message
from tests.ros import environment
from tests.ros.conftest import LIMIT_S, Ending, needs_ros, until_heard
from tests.ros.remote import RemoteDoor
from tests.ros.true_robot import TrueRobot
from tests.ros.ways import free_domain

TWIST, ODOMETRY, NAVIGATE = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry", "nav2_msgs/action/NavigateToPose"
FORWARD = {"linear": {"x": 0.3}}


@pytest.fixture(scope="module")
def parts() -> Iterator[tuple[TrueRobot, Door]]:
    needs_ros()
    surroundings = environment.surroundings(free_domain())
    robot = TrueRobot(surroundings)
    door = RemoteDoor("rclpy", environment.PYTHON, surroundings)
    yield robot, door
    door.close()
    robot.program.close()


@pytest.fixture
def robot(parts: tuple[TrueRobot, Door]) -> TrueRobot:
    parts[0].until(lambda robot: robot.speed < 0.005)
    return parts[0]


@pytest.fixture
def door(parts: tuple[TrueRobot, Door]) -> Door:
    return parts[1]


def test_it_drives_and_stops_when_no_velocity_comes(robot: TrueRobot, door: Door) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/odom", ODOMETRY, heard.put)
    first = heard.get(timeout=LIMIT_S)
    assert math.hypot(first["pose"]["pose"]["position"]["x"], first["pose"]["pose"]["position"]["y"]) < 0.01

    moves: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def take(told: Message) -> None:
        if told["twist"]["twist"]["linear"]["x"] > 0.1:
            moves.put(True)

    door.subscribe("/odom", ODOMETRY, take)
    until_heard(moves, lambda: door.publish("/cmd_vel", TWIST, FORWARD))
    robot.until(lambda robot: robot.speed < 0.005)


def test_its_sensors_are_heard(robot: TrueRobot, door: Door) -> None:
    topics: dict[str, tuple[str, Callable[[Message], bool]]] = {
        "/scan": ("sensor_msgs/msg/LaserScan", lambda told: len(told["ranges"]) == 360),
        "/joint_states": ("sensor_msgs/msg/JointState", lambda told: len(told["position"]) == 5),
        "/battery_state": ("sensor_msgs/msg/BatteryState", lambda told: bool(abs(told["voltage"] - 14.2) < 0.01)),
        "/tf": ("tf2_msgs/msg/TFMessage", lambda told: bool(told["transforms"][0]["child_frame_id"] == "odom")),
    }
    for topic, (type, fits) in topics.items():
        heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
        door.subscribe(topic, type, heard.put)
        assert fits(heard.get(timeout=LIMIT_S)), topic


def test_it_finds_its_way(robot: TrueRobot, door: Door) -> None:
    x, y, yaw = robot.pose
    goal = (x - 0.4, y, yaw)
    ending, told = Ending(), queue.SimpleQueue[Any]()
    door.send_goal("/navigate_to_pose", NAVIGATE, _pose(*goal), ending, feedback=told.put)
    outcome = ending.outcome()
    assert outcome.code == "succeeded", outcome.why
    assert math.dist(robot.pose[:2], goal[:2]) < 0.05
    left = [told.get()["distance_remaining"] for _ in range(told.qsize())]
    assert len(left) >= 5
    assert all(a >= b - 0.05 for a, b in itertools.pairwise(left))


def test_it_stops_when_a_journey_is_cancelled(robot: TrueRobot, door: Door) -> None:
    x, y, yaw = robot.pose
    ending = Ending()
    goal = door.send_goal("/navigate_to_pose", NAVIGATE, _pose(x + 0.8, y, yaw), ending)
    robot.until(lambda robot: robot.speed > 0.1)
    goal.cancel()
    assert ending.outcome().code == "canceled"
    robot.until(lambda robot: robot.speed < 0.005)


def test_a_goal_in_a_wall_is_aborted(robot: TrueRobot, door: Door) -> None:
    ending = Ending()
    door.send_goal("/navigate_to_pose", NAVIGATE, _pose(100.0, 100.0, 0.0), ending)
    outcome = ending.outcome()
    assert outcome.code == "aborted"
    assert outcome.result["error_code"] == 208


def _pose(x: float, y: float, yaw: float) -> dict[str, Any]:
    turn = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"pose": {"header": {"frame_id": "map"}, "pose": {"position": {"x": x, "y": y}, "orientation": turn}}}
