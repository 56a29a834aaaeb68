"""What the door of rclpy does that the others do not: it needs a ROS in its own program, with the types installed."""

from __future__ import annotations

import importlib.util
import subprocess

import pytest

from engine.errors import RobotError
from engine.ros.opening import open_door
from tests.ros import environment
from tests.ros.conftest import LIMIT_S, needs_ros
from tests.ros.ways import free_domain

UNUSABLE = """
import queue
from engine.ros.opening import open_door
door, looked = open_door("rclpy"), queue.SimpleQueue()
door.publish("/one", "no_such_msgs/msg/Nothing", {})
door.subscribe("/three", "std_msgs/msg/NoSuchType", print)
door.subscribe("/fo ur", "std_msgs/msg/String", print)
door.serve("/five", "std_msgs/msg/String", print)
door.subscribe("/six", "std_msgs/msg/String", print)
door.graph(looked.put)
graph = looked.get(timeout=10)
print(sorted(door.mismatches()), "/six" in graph.topics, repr(door.trouble))
door.close()
door.publish("/one", "std_msgs/msg/String", {})
door.call("/peer/set", "std_srvs/srv/Trigger", {}, lambda outcome: print(outcome.code))
"""

MESSAGES = """
import numpy as np
from engine.ros.rclpy.messages import BadTypeError, find_type, to_mapping, to_message

def there_and_back(name, **fields):
    type = find_type(name, "msg")
    back = to_mapping(to_message(type, fields))
    return {key: back[key] for key in fields}

def is_refused(name, **fields):
    try:
        to_message(find_type(name, "msg"), fields)
    except BadTypeError as error:
        print(error)
        return True

scan = there_and_back("sensor_msgs/msg/LaserScan", ranges=[1.0, None, *[2.0] * 400], angle_min=-1)
assert isinstance(scan["ranges"], np.ndarray) and np.isnan(scan["ranges"][1]) and scan["angle_min"] == -1.0
picture = there_and_back("sensor_msgs/msg/Image", data=np.arange(100, dtype=np.uint8), width=2**32 - 1)
assert picture == {"data": bytes(range(100)), "width": 2**32 - 1}
odom = there_and_back("nav_msgs/msg/Odometry", pose={"covariance": list(range(36))})
assert odom["pose"]["covariance"] == [float(n) for n in range(36)]
basics = {"bool_values": [True, False, True], "byte_values": b"abc", "string_values": ["x", "y", "世"]}
assert there_and_back("test_msgs/msg/Arrays", **basics) == basics
numbers = {f"{name}_values": [0, 1, 2] for name in ("int8", "uint16", "int32", "int64", "uint64")}
assert there_and_back("test_msgs/msg/UnboundedSequences", **numbers) == numbers
assert there_and_back("test_msgs/msg/Arrays", **numbers) == numbers
nested = there_and_back("geometry_msgs/msg/PoseArray", poses=[{"position": {"x": 1}}, {}])
assert [pose["position"]["x"] for pose in nested["poses"]] == [1.0, 0.0]
assert is_refused("std_msgs/msg/Int8", data=128) and is_refused("std_msgs/msg/Int8", data=1.5)
assert is_refused("std_msgs/msg/String", data=b"octets") and is_refused("std_msgs/msg/String", no_such=1)
assert is_refused("geometry_msgs/msg/Twist", linear=1.0) and is_refused("geometry_msgs/msg/PoseArray", poses={})
assert is_refused("test_msgs/msg/Arrays", int32_values=[1, 2]) and is_refused("std_msgs/msg/Float32", data="fast")
assert is_refused("test_msgs/msg/BoundedSequences", int32_values=[1, 2, 3, 4])
assert is_refused("std_msgs/msg/UInt8MultiArray", data=[300]) and is_refused("std_msgs/msg/Int32MultiArray", data=[1.5])
"""


def run(program: str) -> str:
    """What a program in the Python with ROS says."""
    needs_ros()
    done = subprocess.run(
        [environment.PYTHON, "-c", program],
        env=environment.surroundings(free_domain()),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_where_there_is_no_rclpy_it_says_what_to_do() -> None:
    if importlib.util.find_spec("rclpy") is not None:
        pytest.skip("There is an rclpy here.")
    with pytest.raises(RobotError, match=r"rclpy.*setup\.bash.*rosbridge"):
        open_door("rclpy")


def test_what_cannot_be_used_is_told_and_ends_nothing() -> None:
    said = run(UNUSABLE).splitlines()
    assert said == ["['/five', '/fo ur', '/one', '/three'] True ''", "lost"]


def test_messages_are_plain_mappings() -> None:
    run(MESSAGES)
