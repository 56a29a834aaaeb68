"""A robot of ROS 2 as a body: what it is told and hears through a door, and what of that makes no sense."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from engine.errors import DeviceError
from engine.robot.description import Description, described
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.controller import Controller
from engine.robot.host.memory import STATE
from engine.robot.host.sent_arm import SentArm
from engine.robot.ros2 import messages, pictures
from engine.robot.ros2.arm import SEND_S
from engine.robot.ros2.body import LATE_S, REPEAT_S, REST_S, Ros2Body
from engine.robot.ros2.moving_action import AGAIN_S, QUIET_S, STUBBORN_S
from engine.ros.door import Graph, Message, Outcome, Reply, Take, Then, Work

ROBOT = described("ros2")
START = Pose(1.0, 2.0, 0.0)


def odometry(x: float, y: float, yaw: float, vx: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    moves = {"linear": {"x": vx, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    header = {"frame_id": "odom"}
    at = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}
    return {"header": header, "pose": {"pose": at}, "twist": {"twist": moves}}


EMPTY: Final[Message] = {
    "angle_min": 0.0, "angle_increment": 0.1, "range_min": 0.1, "range_max": 12.0, "ranges": [None] * 63
}  # fmt: skip
"""A turn of a lidar near which nothing stands."""


def joint_states(angle: float, gripper: float) -> dict[str, Any]:
    """With a wheel that is not measured."""
    return {"name": [*"abcde", "finger", "wheel"], "position": [0.1, angle, 0.0, 0.0, 0.0, gripper, None]}


def tf(x: float, y: float, yaw: float) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    moved = {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": turn}
    return {"transforms": [{"header": {"frame_id": "map"}, "child_frame_id": "odom", "transform": moved}]}


def fares(body: Ros2Body) -> tuple[int, str, int, str]:
    record = np.zeros((), STATE)
    body.fill(record)
    ticket, how, code, why = (record[f"going{name}"].item() for name in ("", "_how", "_code", "_why"))
    return ticket, how.decode(), code, why.decode()


@dataclass
class Sent:
    """A goal that was sent; whoever holds the table ends it."""

    action: str
    goal: Message
    then: Then
    feedback: Take
    cancelled: bool = False

    def cancel(self) -> None:
        self.cancelled = True


class Table:
    """A door that a test holds in its hand, and the clock."""

    def __init__(self) -> None:
        self.trouble = ""
        self.t = 0.0
        self.said: list[Message] = []
        self.goals: list[Sent] = []
        self.calls: list[tuple[str, Message, Then]] = []
        self.answer: Outcome | None = None  # to each of them
        self.takes: dict[str, Take] = {}
        self.closed = False
        self.opens = True

    def __call__(self) -> float:
        self.t += 0.001
        if self.opens and "/odom" in self.takes:
            self.opens = False
            self.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
            if "/joint_states" in self.takes:
                self.takes["/joint_states"](joint_states(0.0, 1.0))
            if "/scan" in self.takes:
                self.takes["/scan"](EMPTY)
        return self.t

    def mismatches(self) -> Mapping[str, str]:
        return {}

    def advertise(self, topic: str, type: str) -> None:
        """Nobody is there who would listen earlier."""

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        assert (topic, type, every) == ("/cmd_vel", messages.TWIST, False)
        self.said.append(message)

    def subscribe(
        self,
        topic: str,
        type: str,
        take: Take,
        *,
        every_s: float = 0.0,
        latched: bool = False,
        every: bool = False,
    ) -> None:
        self.takes[topic] = take

    def send_goal(
        self,
        action: str,
        type: str,
        goal: Message,
        then: Then,
        *,
        feedback: Take = lambda message: None,
        limit_s: float | None = None,
    ) -> Sent:
        self.goals.append(Sent(action, goal, then, feedback))
        return self.goals[-1]

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = 0.0) -> None:
        self.calls.append((service, request, then))
        if self.answer is not None:
            then(self.answer)

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        raise AssertionError("no body does")

    def serve_action(self, action: str, type: str, work: Work) -> None:
        raise AssertionError("no body does")

    def graph(self, then: Callable[[Graph], object]) -> None:
        raise AssertionError("no body does")

    def close(self) -> None:
        self.closed = True

    def body(self, robot: Description = ROBOT) -> Ros2Body:
        return Ros2Body(self, robot, START, clock=self)

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
    table.t += LATE_S
    assert body.trouble == "no odometry comes on /odom"
    table.speeds()
    body.drive(Twist(0.2))
    assert table.speeds() == []
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    body.drive(Twist(0.2))
    assert table.speeds() == [0.2]
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
    table.takes["/scan"]({**scan, "ranges": ranges, "range_max": None})
    assert body.scan() is not None, "what knows no farthest"


def test_where_it_finds_itself_on_its_map_is_where_it_is() -> None:
    table = Table()
    body = table.body()
    table.takes["/tf"](tf(2.0, 1.0, -math.pi / 2))
    at = body.odometry()
    assert (at.x, at.y, at.yaw) == pytest.approx((7.0, -4.0, 0.0))


def test_it_is_sent_in_the_frame_of_its_map_or_in_that_of_its_odometry() -> None:
    table = Table()
    body = table.body()
    body.odometry()
    body.go(Pose(2.0, 2.0, 0.0), 7)
    stamped = table.goals[-1].goal["pose"]
    assert stamped["header"]["frame_id"] == "odom"
    assert stamped["pose"]["position"] == {"x": pytest.approx(5.0), "y": pytest.approx(6.0), "z": 0.0}
    table.takes["/tf"](tf(0.0, 0.0, 0.0))
    body.go(Pose(2.0, 2.0, 0.0), 8)
    stamped = table.goals[-1].goal["pose"]
    assert stamped["header"]["frame_id"] == "map"
    assert stamped["pose"]["position"]["x"] == 2.0


def test_to_stop_is_a_cancel_and_zero_and_zero_again_until_it_has_ended() -> None:
    table = Table()
    body = table.body()
    body.go(Pose(2.0, 2.0, 0.0), 1)
    sent = table.goals[-1]
    table.speeds()
    for _ in range(300):
        body.step()
    assert table.speeds() == [], "others drive it"
    body.give_up()
    assert sent.cancelled
    assert table.speeds() == [0.0], "at once"
    for _ in range(300):
        body.step()
    assert len(table.speeds()) > 10
    assert fares(body)[:2] == (1, "canceled")
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    table.t += STUBBORN_S
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert body.trouble == "its navigation goes on although it was told to stop"
    sent.then(Outcome("canceled"))
    assert not body.trouble


def test_how_a_journey_fares_and_what_of_it_is_over() -> None:
    table = Table()
    body = table.body()
    assert fares(body)[0] == 0
    body.go(Pose(2.0, 2.0, 0.0), 1)
    first = table.goals[-1]
    body.go(Pose(3.0, 2.0, 0.0), 2)
    first.then(Outcome("aborted"))
    assert fares(body)[:2] == (2, "going"), "that was the one before"
    table.goals[-1].then(Outcome("aborted", {"error_code": 208, "error_msg": "no valid path"}))
    assert fares(body) == (2, "failed", 208, "no valid path")
    body.go(Pose(3.0, 2.0, 0.0), 3)
    table.goals[-1].then(Outcome("succeeded", {"error_code": "nonsense"}))
    assert fares(body)[:2] == (3, "arrived")
    body.give_up()
    assert not table.goals[-1].cancelled, "it has ended"


def test_a_goal_that_was_lost_is_called_back_when_the_door_is_open_again() -> None:
    table = Table()
    body = table.body()
    body.go(Pose(2.0, 2.0, 0.0), 1)
    table.trouble = "the bridge is gone"
    table.goals[-1].then(Outcome("lost"))
    body.step()
    assert table.calls == [], "nobody hears it"
    table.trouble = ""
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert body.trouble == "it is not known whether its navigation has stopped"
    table.speeds()
    for _ in range(100):
        body.step()
    assert set(table.speeds()) == {0.0}
    (service, request, then), *more = table.calls
    assert not more, "it is asked once at a time"
    assert service == "/navigate_to_pose/_action/cancel_goal"
    assert request["goal_info"]["goal_id"]["uuid"] == [0] * 16, "whatever there is"
    then(Outcome("no_server"))
    table.t += AGAIN_S
    body.step()
    assert len(table.calls) == 2, "a door that was opened anew has not found it yet"
    assert body.trouble
    table.calls[-1][2](Outcome("succeeded", {"return_code": 0, "goals_canceling": [{}]}))
    table.answer = Outcome("succeeded", {"return_code": 0, "goals_canceling": []})
    body.step()
    assert body.trouble, "what is being cancelled has not ended"
    for _ in range(round(2 * QUIET_S / AGAIN_S)):
        table.t += AGAIN_S
        body.step()
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert body.trouble == ""


def under_control(table: Table) -> tuple[Controller, Ros2Body]:
    body = table.body()
    limits, hull = load(environ={}).robot.limits, ROBOT.footprint
    return Controller(body, START, limits, hull, ROBOT.ranges, np.empty((0, 2)), navigator=body), body


def test_a_pause_rests_on_the_way_and_goes_on_but_not_with_what_has_ended() -> None:
    table = Table()
    table.answer = Outcome("succeeded")
    controller, body = under_control(table)
    controller.go(Pose(2.0, 2.0, 0.0), 1)
    controller.rest()
    controller.pause()
    assert [goal.cancelled for goal in table.goals] == [True]
    record = np.zeros((), STATE)
    controller.fill(record)
    assert record["going_how"].item() == b"going", "whoever waits for it goes on waiting"
    controller.resume()
    assert [goal.cancelled for goal in table.goals] == [True, False]
    table.goals[0].then(Outcome("canceled"))
    assert fares(body)[:2] == (1, "going")
    table.goals[1].then(Outcome("aborted"))
    controller.pause()
    controller.resume()
    assert len(table.goals) == 2, "that has ended"


def test_a_stop_is_not_gone_on_with_and_neither_is_what_somebody_has_driven_since() -> None:
    table = Table()
    controller, _ = under_control(table)
    for end in (controller.stop, lambda: controller.drive(Twist(0.1))):
        controller.go(Pose(2.0, 2.0, 0.0), 1)
        count = len(table.goals)
        end()
        assert table.goals[-1].cancelled
        controller.pause()
        controller.resume()
        assert len(table.goals) == count


def test_a_host_that_was_replaced_calls_back_what_the_one_before_had_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.robot.ros2.moving_action.AGAIN_S", 0.0)  # the clock of a table hardly goes
    monkeypatch.setattr("engine.robot.ros2.moving_action.QUIET_S", 0.0)
    table = Table()
    table.answer = Outcome("succeeded")
    body = Ros2Body(table, ROBOT, START, np.zeros((), STATE), clock=table)
    service, _, _ = table.calls[0]
    assert service == "/navigate_to_pose/_action/cancel_goal"
    assert body.trouble == ""


WITH_ARM = Description.model_validate(
    ROBOT.model_dump()
    | {"arm": described("x3plus").arm}
    | {
        "ros": {
            "arm": {
                "joints": {
                    "yaw": {"name": "a", "zero": 0.1},
                    "shoulder": {"name": "b", "sign": -1},
                    **{ours: {"name": name} for ours, name in zip(("elbow", "wrist", "roll"), "cde", strict=True)},
                },
                "gripper": {"action": "/grip", "joint": "finger", "closed": 0.0, "open": 2.0},
            }
        }
    }
)


def test_an_arm_is_sent_and_holds_when_told() -> None:
    table = Table()
    body = table.body(WITH_ARM)
    assert body.joints == pytest.approx((0, 0, 0, 0, 0))
    assert body.opening == 0.5
    table.takes["/joint_states"](joint_states(0.5, 2.0))
    assert body.joints == pytest.approx((0, -0.5, 0, 0, 0)), "their shoulder turns the other way"
    arm = SentArm(body, body, WITH_ARM.ranges)
    arm.move((0.5, -0.5, 0.0, 0.0, 0.0), 0.25)
    sent = table.goals[-1]
    point = sent.goal["trajectory"]["points"][0]
    assert point["positions"] == pytest.approx([0.6, 0.5, 0, 0, 0])
    assert point["time_from_start"] == {"sec": 2, "nanosec": 0}, "0.5 rad at 0.25 rad/s"
    table.answer = Outcome("succeeded")
    arm.paused = True
    assert sent.cancelled
    table.t += SEND_S
    arm.paused = False
    assert table.goals[-1] is not sent, "it goes on"
    arm.hold()
    assert table.goals[-1].cancelled
    count = len(table.goals)
    arm.hold()
    arm.grip(0.25)
    arm.grip(0.25)
    assert [goal.goal for goal in table.goals[count:]] == [{"command": {"position": 0.5, "max_effort": 0.0}}]


def test_an_arm_that_fails_says_why_and_is_told_the_same_again() -> None:
    table = Table()
    body = table.body(WITH_ARM)
    arm = SentArm(body, body, WITH_ARM.ranges)
    for count in (1, 2):
        arm.move((0.5, 0.0, 0.0, 0.0, 0.0), 0.5)
        assert (len(table.goals), arm.fault) == (count, "")
        table.goals[-1].then(Outcome("aborted", {"error_string": "a joint is outside of its path"}))
        arm.step(0.002)
        assert arm.fault == "a joint is outside of its path"
        assert arm.targets == body.joints, "it is on its way to nowhere"
        table.t += SEND_S
    arm.grip(0.25)
    table.goals[-1].then(Outcome("no_server"))
    arm.grip(0.25)
    assert len(table.goals) == 4


def test_a_hand_that_is_led_along_a_line_is_told_the_newest_now_and_then() -> None:
    table = Table()
    body = table.body(WITH_ARM)
    for hundredth in range(10):
        body.send_arm((0.01 * hundredth, 0.0, 0.0, 0.0, 0.0), 1.0)
    assert len(table.goals) == 1
    table.t += SEND_S
    body.step()
    assert [goal.goal["trajectory"]["points"][0]["positions"][0] for goal in table.goals] == pytest.approx([0.1, 0.19])


def test_a_motion_that_was_replaced_may_tell_its_end_after_the_one_that_replaced_it() -> None:
    table = Table()
    body = table.body(WITH_ARM)
    body.send_arm((0.1, 0.0, 0.0, 0.0, 0.0), 1.0)
    table.t += SEND_S
    body.send_arm((0.2, 0.0, 0.0, 0.0, 0.0), 1.0)
    first, second = table.goals
    second.then(Outcome("succeeded"))
    assert body.trouble == ""
    first.then(Outcome("aborted"))
    table.t += STUBBORN_S
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert body.trouble == ""


def test_a_motion_of_the_arm_that_was_lost_is_called_back() -> None:
    table = Table()
    body = table.body(WITH_ARM)
    body.send_arm((0.5, 0.0, 0.0, 0.0, 0.0), 0.5)
    table.goals[-1].then(Outcome("lost"))
    assert body.trouble == "it is not known whether its arm has stopped"
    table.answer = Outcome("succeeded", {"return_code": 0, "goals_canceling": []})
    for _ in range(round(2 * QUIET_S / AGAIN_S)):
        table.t += AGAIN_S
        body.step()
    table.takes["/odom"](odometry(5.0, 5.0, math.pi / 2))
    assert {service for service, _, _ in table.calls} == {"/arm_controller/follow_joint_trajectory/_action/cancel_goal"}
    assert body.trouble == ""


def test_a_journey_after_a_stop_waits_until_the_stop_has_been_heard() -> None:
    table = Table()
    body = table.body()
    body.go(Pose(2.0, 2.0, 0.0), 1)
    body.give_up()
    _, request, then = table.calls[-1]
    assert request["goal_info"]["goal_id"]["uuid"] == [0] * 16, "whatever there is"
    body.go(Pose(3.0, 2.0, 0.0), 2)
    assert len(table.goals) == 1
    assert fares(body)[:2] == (2, "going")
    then(Outcome("succeeded", {"return_code": 0, "goals_canceling": [{}]}))
    body.step()
    assert len(table.goals) == 2
    assert not table.goals[-1].cancelled
    body.give_up()
    body.go(Pose(4.0, 2.0, 0.0), 3)
    assert body.give_up(), "it waits, and was wanted"
    table.calls[-1][2](Outcome("succeeded"))
    body.step()
    assert len(table.goals) == 2, "nobody wants it any more"


def test_a_goal_that_ends_as_it_is_sent_has_ended() -> None:
    table = Table()
    body = table.body()

    def send_goal(action: str, type: str, goal: Message, then: Then, **more: Any) -> Sent:
        then(Outcome("lost", why="the bridge is gone"))
        return Sent(action, goal, then, lambda message: None)

    table.send_goal = send_goal  # type: ignore[method-assign]
    body.go(Pose(2.0, 2.0, 0.0), 1)
    assert fares(body) == (1, "lost", 0, "the bridge is gone")
    assert not body.give_up()


def test_who_learns_on_the_way_where_it_is_goes_on_to_the_same_place_on_the_map() -> None:
    table = Table()
    table.answer = Outcome("succeeded")
    controller, body = under_control(table)
    controller.go(Pose(2.0, 2.0, 0.0), 1)
    controller.correct(Pose(0.01, 0.0, 0.0))
    assert len(table.goals) == 1, "that is the same place"
    controller.correct(Pose(1.0, 0.0, 0.0))
    first, second = (goal.goal["pose"]["pose"]["position"] for goal in table.goals)
    assert table.goals[0].cancelled
    assert first == {"x": pytest.approx(5.0), "y": pytest.approx(6.0), "z": 0.0}
    assert second == {"x": pytest.approx(5.0), "y": pytest.approx(5.0), "z": 0.0}, "its north is the map's east"
    assert fares(body)[:2] == (1, "going")
    table.goals[-1].then(Outcome("succeeded"))
    controller.correct(Pose(2.0, 0.0, 0.0))
    assert len(table.goals) == 2, "it is there"


def test_what_it_rolls_while_a_host_is_replaced_is_not_lost() -> None:
    record = np.zeros((), STATE)
    table = Table()
    Controller(body := table.body(), START, load(environ={}).robot.limits, ROBOT.footprint, ROBOT.ranges,
               np.empty((0, 2))).fill(record)  # fmt: skip
    body.close()
    for north, expected in ((5.3, 1.3), (0.0, 1.0)):  # the latter has begun anew
        table = Table()
        table.opens, table.answer = False, Outcome("no_server")
        took = table.subscribe

        def subscribe(topic: str, type: str, take: Take, north: float = north, took: Any = took, **more: Any) -> None:
            took(topic, type, take, **more)
            if topic == "/odom":
                take(odometry(5.0 if north else 0.0, north, math.pi / 2))
            if topic == "/scan":
                take(EMPTY)

        table.subscribe = subscribe  # type: ignore[method-assign]
        about = ROBOT.model_copy(update={"ros": ROBOT.ros.model_copy(update={"navigation": None})})  # type: ignore[union-attr]
        at = Ros2Body(table, about, START, record, clock=table).odometry()
        assert (at.x, at.y) == pytest.approx((expected, 2.0))


def test_pictures_of_every_encoding_and_what_fills_up_their_rows() -> None:
    rows = np.array([[[10, 20, 30], [40, 50, 60]], [[1, 2, 3], [4, 5, 6]]], np.uint8)
    padded = b"".join(row.tobytes() + b"xx" for row in rows)
    about = {"width": 2, "height": 2, "step": 8}
    for data in (padded, list(padded), base64.b64encode(padded).decode()):
        found = pictures.colours({**about, "encoding": "rgb8", "data": data})
        assert found is not None
        assert found.tolist() == rows.tolist()
    found = pictures.colours({**about, "encoding": "bgr8", "data": padded})
    assert found is not None
    assert found[0, 0].tolist() == [30, 20, 10]
    millimetres = np.array([[1500, 0]], "<u2").tobytes()
    depth = pictures.depths({"width": 2, "height": 1, "step": 4, "encoding": "16UC1", "data": millimetres})
    assert depth is not None
    assert depth.tolist() == [[pytest.approx(1.5), math.inf]]
    for wrong in ({"data": padded[:9]}, {"step": 2}, {"width": -2}, {"encoding": "bayer"}, {"height": 10**9}):
        assert pictures.colours({**about, "encoding": "rgb8", "data": padded} | wrong) is None


def test_a_lens_is_brought_to_the_size_of_the_pictures() -> None:
    k = [500.0, 0, 320.0, 0, 510.0, 240.0, 0, 0, 1]
    found = pictures.lens({"width": 640, "height": 480, "k": k}, 320, 240)
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == (250, 255, 160, 120)
    assert pictures.lens({"width": 0, "height": 480, "k": k}, 320, 240) is None


NAMES = (
    *("pose", "twist", "position", "orientation", "x", "y", "z", "w"),
    *("linear", "angular", "ranges", "angle_min", "voltage", "transforms", "transform", "translation", "rotation"),
    *("width", "height", "step", "encoding", "data", "k", "name", "header", "frame_id", "child_frame_id"),
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(NAMES), JSON, max_size=5))
def test_whatever_a_peer_says_is_read_or_is_nothing(message: dict[str, Any]) -> None:
    for read in (messages.odometry, messages.scan_points, messages.volts, messages.transforms, messages.frame):
        read(message)
    for see in (pictures.colours, pictures.depths, pictures.unpacked):
        see(message)
    pictures.lens(message, 320, 240)
