"""A robot of ROS: ``.ros/bin/python -m tests.ros.robot PYTHON …``, where PYTHON has the simulation, which gets what
follows. It carries the simulated robot behind the topics that robots of ROS have, and finds its way itself.

| it has | which is |
|---|---|
| /cmd_vel (Twist) | taken; holds for half a second |
| /odom, /joint_states, /scan, /battery_state | published, best effort as drivers do |
| /camera: color/image_raw, its twin compressed, color/camera_info, aligned_depth_to_color/image_raw | published |
| /tf (map → odom → base_footprint), /tf_static (laser) | published; odometry begins where it starts |
| /navigate_to_pose (NavigateToPose) | served; a new goal ends the one before, as in Nav2 |
| /arm_controller/follow_joint_trajectory (FollowJointTrajectory) | served, see :mod:`tests.ros.robot_arm` |
| /gripper_controller/gripper_cmd (GripperCommand) | the same |

In lines of JSON it tells where it and its joints truly are and what it touches, for tests only.
"""

from __future__ import annotations

import math
import os
import sys
import threading
from pathlib import Path
from typing import Any

import rclpy  # type: ignore[import-not-found]
from geometry_msgs.msg import TransformStamped, Twist  # type: ignore[import-not-found]
from nav2_msgs.action import NavigateToPose  # type: ignore[import-not-found]
from nav_msgs.msg import Odometry  # type: ignore[import-not-found]
from rclpy.action import ActionServer, CancelResponse  # type: ignore[import-not-found]
from rclpy.callback_groups import ReentrantCallbackGroup  # type: ignore[import-not-found]
from rclpy.executors import MultiThreadedExecutor  # type: ignore[import-not-found]
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data  # type: ignore[import-not-found]
from sensor_msgs.msg import BatteryState, JointState, LaserScan  # type: ignore[import-not-found]
from tf2_msgs.msg import TFMessage  # type: ignore[import-not-found]

from tests.ros.lines import Line, Program, write
from tests.ros.robot_arm import Arm
from tests.ros.robot_camera import Camera

FEEDBACK_S = 0.1
PICTURE_TELLS = 2
"""Of the scans, after every how many comes a picture."""


class Robot:
    """The node."""

    def __init__(self, python: Path, *more: str) -> None:
        rclpy.init()
        self.node = node = rclpy.create_node("robot", enable_rosout=False)
        group = ReentrantCallbackGroup()
        self._ready = threading.Event()
        self._start = [0.0, 0.0, 0.0]
        self._count = 0
        self._left = math.nan
        self._ended: Any = None  # how the pilot has ended, by a number of Nav2
        self._news = threading.Condition()
        self._journey: Any = None
        sensors = qos_profile_sensor_data
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._odom = node.create_publisher(Odometry, "/odom", sensors)
        self._scan = node.create_publisher(LaserScan, "/scan", sensors)
        self._joints = node.create_publisher(JointState, "/joint_states", sensors)
        self._battery = node.create_publisher(BatteryState, "/battery_state", sensors)
        self._tf = node.create_publisher(TFMessage, "/tf", 10)
        self._tf_static = node.create_publisher(TFMessage, "/tf_static", latched)
        self._tf_static.publish(TFMessage(transforms=[self._frame("base_footprint", "laser", [0.0, 0.0, 0.0])]))
        node.create_subscription(Twist, "/cmd_vel", self._drive, 10)
        self.camera = Camera(node, python, _own_surroundings(), *more)
        self._arm = Arm(node, group, lambda order: self.simulation.tell(order))
        self.simulation = Program([python, "-m", "tests.ros.simulation", *more], _own_surroundings(), self._hear)
        self._ready.wait()
        self._server = ActionServer(
            node,
            NavigateToPose,
            "/navigate_to_pose",
            execute_callback=self._navigate,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=group,
        )

    # What it takes

    def _drive(self, message: Any) -> None:
        twist = [message.linear.x, message.linear.y, message.angular.z]
        self.simulation.tell({"do": "drive", "twist": twist})

    def _navigate(self, goal: Any) -> Any:
        at, turn = goal.request.pose.pose.position, goal.request.pose.pose.orientation
        with self._news:
            self._journey, self._ended, self._left = goal, None, math.nan
            self._news.notify_all()
        self.simulation.tell({"do": "go", "goal": [at.x, at.y, 2 * math.atan2(turn.z, turn.w)]})
        result = NavigateToPose.Result()
        while True:
            with self._news:
                self._news.wait_for(lambda: self._ended is not None or self._journey is not goal, FEEDBACK_S)
                replaced, ended, left = self._journey is not goal, self._ended, self._left
            if replaced or ended:
                result.error_code = ended or 0
                goal.abort()
                break
            if ended is not None:
                goal.succeed()
                break
            if goal.is_cancel_requested:
                self.simulation.tell({"do": "stop"})
                goal.canceled()
                break
            if math.isfinite(left):
                goal.publish_feedback(NavigateToPose.Feedback(distance_remaining=left))
        return result

    # What it tells

    def _hear(self, line: Line) -> None:
        if "ready" in line:
            self._start = line["start"]
            self._ready.set()
            return
        with self._news:
            self._left = line.get("left", self._left)
            if "arrived" in line:
                self._ended = line["arrived"]
                self._news.notify_all()
        self._publish(line)

    def _publish(self, line: Line) -> None:
        stamp = self.node.get_clock().now().to_msg()
        odom = Odometry(child_frame_id="base_footprint")
        odom.header.stamp, odom.header.frame_id = stamp, "odom"
        frame = self._frame("odom", "base_footprint", line["odometry"])
        place, moves = frame.transform.translation, odom.twist.twist
        odom.pose.pose.position.x, odom.pose.pose.position.y = place.x, place.y
        odom.pose.pose.orientation = frame.transform.rotation
        moves.linear.x, moves.linear.y, moves.angular.z = line["twist"]
        self._odom.publish(odom)
        names, positions = self._arm.hear(line)
        joints = JointState(name=names, position=positions)
        joints.header.stamp = stamp
        self._joints.publish(joints)
        if "scan" in line:
            self._publish_slowly(line, stamp, frame)

    def _publish_slowly(self, line: Line, stamp: Any, frame: Any) -> None:
        ranges = [math.inf if value is None else value for value in line["scan"]]
        scan = LaserScan(angle_increment=2 * math.pi / len(ranges), range_min=0.05, range_max=12.0, ranges=ranges)
        scan.header.stamp, scan.header.frame_id = stamp, "laser"
        self._scan.publish(scan)
        self._tf.publish(TFMessage(transforms=[self._frame("map", "odom", self._start), frame]))
        self._count += 1
        if self._count % PICTURE_TELLS == 0:
            self.camera.show(line["qpos"], stamp)
        if self._count % 10 == 0:
            self._battery.publish(BatteryState(voltage=14.2, percentage=0.8))
        write({name: line[name] for name in ("pose", "twist", "joints", "finger", "touching")})

    def _frame(self, parent: str, child: str, pose: list[float]) -> Any:
        frame = TransformStamped(child_frame_id=child)
        frame.header.stamp, frame.header.frame_id = self.node.get_clock().now().to_msg(), parent
        x, y, yaw = pose
        frame.transform.translation.x, frame.transform.translation.y = x, y
        frame.transform.rotation.z, frame.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        return frame


def _own_surroundings() -> dict[str, str]:
    """Without what the libraries of ROS need: the other Python has its own."""
    ours = ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
    return {name: value for name, value in os.environ.items() if name not in ours}


def main(python: Path, *more: str) -> None:
    robot = Robot(python, *more)
    executor = MultiThreadedExecutor(12)  # a journey, a trajectory and a grip each wait in a thread of their own
    executor.add_node(robot.node)
    threading.Thread(target=executor.spin, daemon=True).start()
    write({"ready": True})
    sys.stdin.read()
    robot.simulation.close()
    robot.camera.close()
    os._exit(0)  # a journey has no end that waits for us


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
