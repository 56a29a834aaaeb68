"""A robot of ROS 2 as a body: what it is told and hears through a door, and what of that makes no sense."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import DeviceError
from engine.robot.description import described
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.ros2 import messages
from engine.robot.ros2.body import LATE_S, REPEAT_S, REST_S, Ros2Body
from engine.ros.door import Message, Take

ROBOT = described("ros2")
START = Pose(1.0, 2.0, 0.0)


def odometry(x: float, y: float, yaw: float, vx: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    moves = {"linear": {"x": vx, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    at = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}
    return {"pose": {"pose": at}, "twist": {"twist": moves}}


class Table:
    """A door that a test holds in its hand, and the clock."""

    def __init__(self) -> None:
        self.trouble = ""
        self.t = 0.0
        self.said: list[Message] = []
        self.takes: dict[str, Take] = {}
        self.closed = False
        self.opens = True

    def __call__(self) -> float:
        self.t += 0.001
        if self.opens and "/odom" in self.takes:
            self.opens = False
            self.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
        return self.t

    def publish(self, topic: str, type: str, message: Message) -> None:
        assert (topic, type) == ("/cmd_vel", messages.TWIST)
        self.said.append(message)

    def subscribe(self, topic: str, type: str, take: Take, *, every_s: float = 0.0) -> None:
        self.takes[topic] = take

    def close(self) -> None:
        self.closed = True

    def body(self) -> Ros2Body:
        return Ros2Body(self, ROBOT, START, clock=self)

    def speeds(self) -> list[float]:
        said, self.said = self.said, []
        return [message["linear"]["x"] for message in said]


def test_it_stands_on_the_map_where_it_was_put_and_moves_as_its_odometry_does() -> None:
    table = Table()
    body = table.body()
    at = body.odometry()
    assert (at.x, at.y, at.yaw) == pytest.approx((1.0, 2.0, 0.0))
    table.takes["/odom"](odometry(5.0, 5.1, math.pi / 2, vx=0.3))
    at = body.odometry()
    assert (at.x, at.y) == pytest.approx((1.1, 2.0)), "its north is the map's east"
    assert body.twist == Twist(0.3)


def test_a_peer_that_has_begun_anew_does_not_move_it() -> None:
    table = Table()
    body = table.body()
    table.takes["/odom"](odometry(0.0, 0.0, 0.0))
    at = body.odometry()
    assert (at.x, at.y, at.yaw) == pytest.approx((1.0, 2.0, 0.0))


def test_a_velocity_is_told_at_once_and_again_and_zero_for_a_while() -> None:
    table = Table()
    body = table.body()
    table.speeds()
    body.drive(Twist(0.2))
    assert table.speeds() == [0.2]
    for _ in range(round(REPEAT_S * 1000) + 2):
        body.step()
    assert table.speeds() == [0.2]
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    body.drive(ZERO)
    assert table.speeds() == [0.0]
    for _ in range(round(2 * REST_S * 1000)):
        body.step()
    zeros = table.speeds()
    assert 5 <= len(zeros) <= 12, "then somebody else may drive it"
    assert set(zeros) == {0.0}


def test_it_is_told_no_more_than_it_can_do() -> None:
    table = Table()
    body = table.body()
    body.drive(Twist(3.0, 1.0, 9.0))
    told = table.said[-1]
    assert told["linear"] == {"x": pytest.approx(ROBOT.speeds.forward), "y": 0.0, "z": 0.0}
    assert told["angular"]["z"] == ROBOT.speeds.turn


def test_late_odometry_and_a_shut_door_are_trouble_and_nothing_is_driven_then() -> None:
    table = Table()
    body = table.body()
    assert not body.trouble
    table.t += LATE_S
    assert body.trouble == "no odometry comes on /odom"
    table.speeds()
    body.drive(Twist(0.2))
    assert table.speeds() == []
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert not body.trouble
    table.trouble = "the bridge is gone"
    assert body.trouble == "the bridge is gone"


def test_a_robot_that_never_says_where_it_is_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.robot.ros2.body.time.sleep", lambda seconds: None)
    table = Table()
    table.opens = False
    with pytest.raises(DeviceError, match="no odometry comes on /odom"):
        table.body()
    assert table.closed


def test_a_scan_lies_around_it() -> None:
    table = Table()
    body = table.body()
    body.odometry()
    ranges: list[float | None] = [None] * 360
    ranges[0], ranges[90], ranges[180] = 2.0, 1.0, 0.05
    scan = {"angle_min": 0.0, "angle_increment": math.radians(1), "range_min": 0.1, "range_max": 12.0}
    table.takes["/scan"]({**scan, "ranges": ranges, "time_increment": 0.0})
    found = body.scan()
    assert found is not None
    assert (found[0], found[90]) == pytest.approx((2.0, 1.0))
    assert np.isinf(found[180]), "nearer than it measures"
    assert body.scan() is None, "nothing newer has come"


NAMES = (
    *("pose", "twist", "position", "orientation", "x", "y", "z", "w"),
    *("linear", "angular", "ranges", "angle_min", "voltage"),
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(NAMES), JSON, max_size=5))
def test_whatever_a_peer_says_is_read_or_is_nothing(message: dict[str, Any]) -> None:
    for read in (messages.odometry, messages.scan_points, messages.volts):
        read(message)
