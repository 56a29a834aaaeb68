"""Messages as mappings, from and to the bytes that ROS 2 sends."""

from __future__ import annotations

import contextlib
import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.ros.door import octets
from engine.ros.interfaces.cdr import BadMessage, Codec
from engine.ros.interfaces.definitions import Definitions, UnknownType

CODEC = Codec(Definitions())
ID = bytes(range(16))

JAZZY: list[tuple[str, dict[str, Any], str]] = [
    ("std_msgs/msg/String", {"data": "grüezi"}, "00010000080000006772c3bc657a6900"),
    (
        "geometry_msgs/msg/Twist",
        {"linear": {"x": 0.25}, "angular": {"z": -1.5}},
        f"00010000{'000000000000d03f'}{'00' * 32}000000000000f8bf",
    ),
    ("geometry_msgs/msg/Quaternion", {}, f"00010000{'00' * 24}000000000000f03f"),
    (
        "sensor_msgs/msg/LaserScan",
        {
            "header": {"stamp": {"sec": 7}, "frame_id": "laser"},
            "angle_min": -1.5,
            "range_max": 8.0,
            "ranges": [1.0, 2.5, math.inf],
        },
        "000100000700000000000000060000006c617365720000000000c0bf"
        "000000000000000000000000000000000000000000000041030000000000803f000020400000807f00000000",
    ),
    ("std_srvs/srv/Trigger_Response", {"success": True, "message": "done"}, "000100000100000005000000646f6e6500"),
    ("std_srvs/srv/Trigger_Request", {}, "0001000000"),
    (
        "test_msgs/action/Fibonacci_SendGoal_Request",
        {"goal_id": {"uuid": ID}, "goal": {"order": 5}},
        "00010000000102030405060708090a0b0c0d0e0f05000000",
    ),
    (
        "test_msgs/action/Fibonacci_GetResult_Response",
        {"status": 4, "result": {"sequence": [0, 1, 1]}},
        "000100000400000003000000000000000100000001000000",
    ),
]
"""With the bytes that rclpy of Jazzy makes of them; where it leaves bytes unset between fields, these are zero."""


@pytest.mark.parametrize(("type", "message", "data"), JAZZY)
def test_a_message_has_the_bytes_that_jazzy_gives_it(type: str, message: dict[str, Any], data: str) -> None:
    assert CODEC.encode(type, message).hex() == data
    assert CODEC.encode(type, CODEC.decode(type, bytes.fromhex(data))).hex() == data


def test_bytes_behind_a_message_are_ignored() -> None:
    """rclpy leaves them, in messages that it has written itself; and garbage between the fields, too."""
    data = "0001000001dbee0205000000646f6e65007eefa20282efa0"
    assert CODEC.decode("std_srvs/srv/Trigger_Response", bytes.fromhex(data)) == {"success": True, "message": "done"}


def test_a_message_of_a_big_endian_machine_is_read() -> None:
    assert CODEC.decode("std_msgs/msg/Int32", bytes.fromhex("0000000000000007")) == {"data": 7}


def test_long_arrays_are_numpy_arrays_and_short_ones_lists() -> None:
    picture = {"height": 2, "width": 60, "encoding": "rgb8", "step": 180, "data": bytes(range(180)) * 2}
    found = CODEC.decode("sensor_msgs/msg/Image", CODEC.encode("sensor_msgs/msg/Image", picture))
    assert isinstance(found["data"], np.ndarray)
    assert found["data"].dtype == np.uint8
    assert octets(found["data"]) == picture["data"]
    uuid = CODEC.decode(
        "unique_identifier_msgs/msg/UUID", CODEC.encode("unique_identifier_msgs/msg/UUID", {"uuid": ID})
    )
    assert uuid == {"uuid": list(ID)}


@pytest.mark.parametrize("ranges", [[1.0, 2.0], (1, 2), np.array([1, 2], np.float32), np.array([1, 2])])
def test_an_array_may_be_written_in_many_ways(ranges: Any) -> None:
    data = CODEC.encode("sensor_msgs/msg/LaserScan", {"ranges": ranges})
    assert CODEC.decode("sensor_msgs/msg/LaserScan", data)["ranges"] == [1.0, 2.0]


@pytest.mark.parametrize(
    ("type", "message"),
    [
        ("geometry_msgs/msg/Twist", {"liner": {}}),
        ("geometry_msgs/msg/Twist", {"linear": 3}),
        ("geometry_msgs/msg/Twist", {"linear": {"x": "fast"}}),
        ("std_msgs/msg/String", {"data": 3}),
        ("std_msgs/msg/UInt8", {"data": 256}),
        ("std_msgs/msg/UInt8", {"data": 1.5}),
        ("std_msgs/msg/UInt8", {"data": None}),
        ("unique_identifier_msgs/msg/UUID", {"uuid": bytes(15)}),
        ("sensor_msgs/msg/LaserScan", {"ranges": [[1.0]]}),
        ("sensor_msgs/msg/LaserScan", {"ranges": "abc"}),
        ("sensor_msgs/msg/Image", {"data": [256]}),
        ("sensor_msgs/msg/JointState", {"name": "elbow"}),
        ("sensor_msgs/msg/JointState", {"name": [3]}),
        ("geometry_msgs/msg/Twist", [1, 2]),
    ],
)
def test_what_does_not_fit_its_type_is_not_sent(type: str, message: Any) -> None:
    with pytest.raises(BadMessage):
        CODEC.encode(type, message)


def test_a_type_that_nobody_knows_is_told_of() -> None:
    with pytest.raises(UnknownType):
        CODEC.encode("foo_msgs/msg/Bar", {})
    with pytest.raises(UnknownType):
        CODEC.decode("foo_msgs/msg/Bar", bytes(8))


TYPES = st.sampled_from(
    (
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs/msg/JointState",
        "nav_msgs/msg/Path",
        "tf2_msgs/msg/TFMessage",
        "action_msgs/msg/GoalStatusArray",
        "std_msgs/msg/Empty",
        "rcl_interfaces/msg/ParameterEvent",
    )
)


@settings(max_examples=300)
@given(TYPES, st.binary(max_size=400) | st.binary(max_size=200).map(lambda data: b"\x00\x01\x00\x00" + data))
def test_bytes_of_a_peer_make_a_message_or_none(type: str, data: bytes) -> None:
    try:
        found = CODEC.decode(type, data)
    except BadMessage:
        return
    CODEC.encode(type, found)


@given(TYPES, st.integers(0, 300), st.sampled_from((0xFFFFFFFF, 0x7FFFFFFF, 0x10000000)))
def test_a_length_that_no_message_has_is_not_believed(type: str, at: int, length: int) -> None:
    data = bytearray(CODEC.encode(type, {}))
    data[4 + at : 8 + at] = struct.pack("<I", length)
    with contextlib.suppress(BadMessage):
        CODEC.decode(type, bytes(data))


NUMBERS = st.floats(width=32, allow_nan=False)


@given(
    st.text(max_size=20).filter(lambda text: "\0" not in text),
    st.lists(NUMBERS, max_size=100),
    NUMBERS,
    st.integers(-(2**31), 2**31 - 1),
)
def test_a_message_comes_through_as_it_was(frame: str, ranges: list[float], angle: float, sec: int) -> None:
    scan = {"header": {"stamp": {"sec": sec, "nanosec": 1}, "frame_id": frame}, "angle_min": angle, "ranges": ranges}
    found = CODEC.decode("sensor_msgs/msg/LaserScan", CODEC.encode("sensor_msgs/msg/LaserScan", scan))
    assert found["header"] == scan["header"]
    assert found["angle_min"] == angle
    assert list(found["ranges"]) == ranges
