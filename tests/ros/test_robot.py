"""A robot of ROS, driven through the door of rclpy: a whole robot for a door, and a check of the robot itself."""

from __future__ import annotations

import itertools
import math
import queue
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from engine.robot.ros2 import pictures
from engine.robot.ros2.arm import FOLLOW, GRIP
from engine.robot.sim.dimensions import CAMERA_VIEW
from engine.ros.door import Door, Message
from tests.ros import environment
from tests.ros.conftest import LIMIT_S, Ending, needs_ros, until_heard
from tests.ros.remote import RemoteDoor
from tests.ros.true_robot import TrueRobot
from tests.ros.ways import free_domain

TWIST, ODOMETRY, NAVIGATE = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry", "nav2_msgs/action/NavigateToPose"
ARM, GRIPPER = "/arm_controller/follow_joint_trajectory", "/gripper_controller/gripper_cmd"
COLOURS, DEPTHS = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
JOINTS = {
    "arm_yaw_joint": (0.0, 1),
    "arm_shoulder_joint": (0.0, -1),
    "arm_elbow_joint": (math.pi / 2, 1),
    "arm_wrist_joint": (0.0, 1),
    "arm_roll_joint": (0.0, -1),
}
"""What each tells where that of the simulation is at 0, and whether it counts the same way."""
ANGLES = [0.5, -0.4, 0.9, 0.6, -0.3]
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
        "/joint_states": ("sensor_msgs/msg/JointState", lambda told: len(told["position"]) == 6),
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


def test_its_arm_goes_along_a_trajectory(robot: TrueRobot, door: Door) -> None:
    ending, told = Ending(), queue.SimpleQueue[Any]()
    goal = trajectory((0.4, [0.3, 0.0, 0.0, 0.0, 0.0]), (0.9, ANGLES))
    door.send_goal(ARM, FOLLOW, goal, ending, feedback=told.put)
    outcome = ending.outcome()
    assert (outcome.code, outcome.result["error_code"]) == ("succeeded", 0), outcome
    robot.until(lambda robot: robot.joints == pytest.approx(ANGLES, abs=0.03))
    assert told.get(timeout=LIMIT_S)["joint_names"] == list(JOINTS)
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/joint_states", "sensor_msgs/msg/JointState", heard.put)
    state = heard.get(timeout=LIMIT_S)
    assert dict(zip(state["name"], state["position"], strict=True)) == pytest.approx(
        {**named(ANGLES), "finger_joint": robot.finger}, abs=0.03
    )


def test_its_arm_holds_where_it_is_when_it_is_cancelled(robot: TrueRobot, door: Door) -> None:
    start, ending = robot.joints[0], Ending()
    goal = door.send_goal(ARM, FOLLOW, trajectory((4.0, [start - 2.0, *robot.joints[1:]])), ending)
    robot.until(lambda robot: robot.joints[0] < start - 0.3)
    goal.cancel()
    assert ending.outcome().code == "canceled"
    held: list[float] = []

    def stays(robot: TrueRobot) -> bool:
        held.append(robot.joints[0])
        return len(held) > 5 and max(held[-5:]) - min(held[-5:]) < 0.002

    robot.until(stays)
    assert held[-1] > start - 1.7


def test_a_new_trajectory_ends_the_one_before(robot: TrueRobot, door: Door) -> None:
    first, second, start = Ending(), Ending(), robot.joints[0]
    door.send_goal(ARM, FOLLOW, trajectory((4.0, [start - 1.0, *robot.joints[1:]])), first)
    robot.until(lambda robot: robot.joints[0] < start - 0.1)
    door.send_goal(ARM, FOLLOW, trajectory((0.5, ANGLES)), second)
    assert first.outcome().code == "aborted"
    assert second.outcome().code == "succeeded"
    robot.until(lambda robot: robot.joints == pytest.approx(ANGLES, abs=0.03))


def test_a_trajectory_of_other_joints_is_refused(robot: TrueRobot, door: Door) -> None:
    ending = Ending()
    goal = trajectory((1.0, ANGLES))
    goal["trajectory"]["joint_names"][0] = "tail_joint"
    door.send_goal(ARM, FOLLOW, goal, ending)
    assert ending.outcome().code == "rejected"


def test_its_gripper_opens_and_closes(robot: TrueRobot, door: Door) -> None:
    for position in (0.034, 0.0, 0.02):
        ending = Ending()
        door.send_goal(GRIPPER, GRIP, {"command": {"position": position, "max_effort": 0.0}}, ending)
        outcome = ending.outcome()
        assert outcome.code == "succeeded", outcome
        assert outcome.result["reached_goal"]
        robot.until(lambda robot: abs(robot.finger - position) < 0.002)  # noqa: B023


def test_its_pictures_are_heard(robot: TrueRobot, door: Door) -> None:
    def heard(topic: str, type: str) -> Message:
        messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
        door.subscribe(topic, type, messages.put)
        message: Message = messages.get(timeout=LIMIT_S)
        return message

    colours = pictures.colours(heard(COLOURS, pictures.IMAGE))
    packed = pictures.unpacked(heard(f"{COLOURS}/compressed", pictures.COMPRESSED))
    depths = pictures.depths(heard(DEPTHS, pictures.IMAGE))
    lens = pictures.lens(heard("/camera/color/camera_info", pictures.INFO), 240, 180)
    assert colours is not None
    assert packed is not None
    assert depths is not None
    assert colours.shape == packed.shape == (180, 240, 3)
    assert np.abs(colours.astype(float) - packed).mean() < 10
    assert depths.shape == (180, 240)
    assert 0.1 < np.median(depths[np.isfinite(depths)]) < 12
    assert lens is not None
    assert lens.fy == pytest.approx(90 / math.tan(CAMERA_VIEW / 2))


def trajectory(*points: tuple[float, list[float]]) -> dict[str, Any]:
    """By angles as the simulation counts them, and in another order of joints than its own."""
    names = sorted(JOINTS)
    told = []
    for when, angles in points:
        seconds = math.floor(when)
        after = {"sec": seconds, "nanosec": round(1e9 * (when - seconds))}
        told.append({"positions": [named(angles)[name] for name in names], "time_from_start": after})
    return {"trajectory": {"joint_names": names, "points": told}}


def named(angles: list[float]) -> dict[str, float]:
    """As ROS is told of them."""
    return {name: zero + sign * at for (name, (zero, sign)), at in zip(JOINTS.items(), angles, strict=True)}
