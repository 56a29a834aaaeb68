"""All of sayso in a graph of ROS 2: it drives a robot of ROS through its own navigation, and a plain node of rclpy has
it carry out sentences and plans. By rclpy it runs in the Python of ROS, by a rosbridge in its own."""

from __future__ import annotations

import json
import math
import queue
import sysconfig
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml

from tests.e2e.engine import Engine, engine
from tests.e2e.test_board import ended
from tests.eval.runner import ROS_ARM_MODEL, ROS_MODEL
from tests.eval.tasks import tasks, trial
from tests.ros import environment
from tests.ros.conftest import LIMIT_S, needs_ros, until_heard
from tests.ros.peers import RosPeer
from tests.ros.true_robot import TrueRobot
from tests.ros.ways import ByRosbridge, free_domain

KITCHEN = (0.2, 2.0)
STUDY = (3.0, 2.0)
STRING = "std_msgs/msg/String"
PLAN, EXECUTE = "sayso_interfaces/srv/GetPlan", "sayso_interfaces/action/ExecutePlan"


@pytest.fixture
def surroundings() -> Mapping[str, str]:
    needs_ros()
    return environment.surroundings(free_domain())


@contextmanager
def in_ros(state: Path, surroundings: Mapping[str, str], *options: str) -> Iterator[Engine]:
    """sayso in the Python of ROS, with the packages of its own."""
    path = f"{environment.CHECKOUT}:{sysconfig.get_path('purelib')}"
    environ = {**surroundings, "PYTHONPATH": path}

    def below(argv: list[str]) -> list[str]:
        return [str(environment.PYTHON), *argv[1:]]

    with engine(state, "", *told(*options), environ=environ, below=below) as running:
        yield running


def told(*settings: str) -> list[str]:
    return [word for setting in settings for word in ("--set", setting)]


def drives(running: Engine, robot: TrueRobot) -> None:
    """It goes to the kitchen by the robot's navigation, and stops in mid-drive when it is interrupted."""
    running.until("log", lambda body: body["source"] == "robot" and "ready" in body["message"])
    running.send(do="say", text="go to the kitchen")
    result = running.until("state.changed", ended)["result"]
    assert result["outcome"] == "done", result
    robot.until(lambda robot: robot.speed < 0.01)
    assert math.dist(robot.pose[:2], KITCHEN) < 0.1
    running.send(do="say", text="go to the hall")
    robot.until(lambda robot: robot.speed > 0.1)
    running.send(do="interrupt")
    running.until("state.changed", ended)
    robot.until(lambda robot: robot.speed < 0.01)


@pytest.fixture
def before_the_table(tmp_path: Path) -> Path:
    """The flat, with the robot before a table on which things stand."""
    kind = "look and describe"
    scene = trial(kind, tasks()[kind], seed=0).scene
    file = tmp_path / "flat.yaml"
    file.write_text(yaml.safe_dump(msgspec.to_builtins(scene.model_dump(mode="json"))), "utf-8")
    return file


def looks(running: Engine) -> None:
    """It tells what the robot's camera shows."""
    running.until("log", lambda body: body["source"] == "camera" and "/camera/color/image_raw" in body["message"])
    result = says(running, "what do you see")
    assert result["outcome"] == "done", result
    assert "white cup" in result["message"]
    assert "green bottle" in result["message"]


def says(running: Engine, sentence: str) -> dict[str, Any]:
    running.send(do="say", text=sentence)
    result: dict[str, Any] = running.until("state.changed", ended)["result"]
    return result


def test_it_sees_and_moves_its_arm_by_rclpy(
    tmp_path: Path, before_the_table: Path, surroundings: Mapping[str, str], request: pytest.FixtureRequest
) -> None:
    robot = TrueRobot(surroundings, str(before_the_table))
    request.addfinalizer(robot.program.close)
    options = ("robot.kind=ros2", "robot.door=rclpy", f"robot.model={ROS_ARM_MODEL}", f"robot.scene={before_the_table}")
    with in_ros(tmp_path, surroundings, *options) as running:
        looks(running)
        assert says(running, "raise your arm")["outcome"] == "done"
        robot.until(lambda robot: robot.joints == pytest.approx([0.0] * 5, abs=0.03))
        running.send(do="say", text="lower your arm")
        robot.until(lambda robot: robot.joints[2] > 0.4)
        running.send(do="interrupt")
        assert running.until("state.changed", ended)["result"]["outcome"] == "interrupted"
        held: list[float] = []

        def stays(robot: TrueRobot) -> bool:
            held.append(robot.joints[2])
            return len(held) > 5 and max(held[-5:]) - min(held[-5:]) < 0.002

        robot.until(stays)
        assert held[-1] < 1.6, "short of where it is folded"


def test_it_picks_something_up_by_a_bridge(
    tmp_path: Path, before_the_table: Path, request: pytest.FixtureRequest
) -> None:
    needs_ros()
    if environment.bridge() is None:
        pytest.skip(f"The published rosbridge is no wheel: {environment.BRIDGE} says in which folder it is.")
    way = ByRosbridge()
    robot = TrueRobot(way.surroundings, str(before_the_table))
    request.addfinalizer(way.close)
    request.addfinalizer(robot.program.close)
    options = ("robot.kind=ros2", f"robot.door={way.address}", f"robot.model={ROS_ARM_MODEL}")
    with engine(tmp_path, "", *told(*options, f"robot.scene={before_the_table}")) as running:
        looks(running)
        result = says(running, "pick up the white cup")
        assert result["outcome"] == "done", result
        robot.until(lambda robot: robot.touching == ["white cup"] and 0.02 < robot.finger < 0.032)


def test_it_drives_a_robot_of_ros_by_rclpy(
    tmp_path: Path, surroundings: Mapping[str, str], request: pytest.FixtureRequest
) -> None:
    robot = TrueRobot(surroundings)
    request.addfinalizer(robot.program.close)
    options = ("robot.kind=ros2", "robot.door=rclpy", f"robot.model={ROS_MODEL}")
    with in_ros(tmp_path, surroundings, *options) as running:
        drives(running, robot)


def test_it_drives_a_robot_of_ros_by_a_bridge_that_goes_and_comes_back(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    needs_ros()
    if environment.bridge() is None:
        pytest.skip(f"The published rosbridge is no wheel: {environment.BRIDGE} says in which folder it is.")
    way = ByRosbridge()
    robot = TrueRobot(way.surroundings)
    request.addfinalizer(way.close)
    request.addfinalizer(robot.program.close)
    options = ("robot.kind=ros2", f"robot.door={way.address}", f"robot.model={ROS_MODEL}")
    with engine(tmp_path, "", *told(*options)) as running:
        drives(running, robot)
        running.send(do="say", text="go to the study")
        robot.until(lambda robot: robot.speed > 0.1)
        way.cut()
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "failed"
        way.mend()
        robot.until(lambda robot: robot.speed < 0.01)
        assert math.dist(robot.pose[:2], STUDY) > 0.5, "its goal was called back before it was there"
        until = time.monotonic() + LIMIT_S
        while time.monotonic() < until:
            running.send(do="say", text="go to the kitchen")
            if running.until("state.changed", ended)["result"]["outcome"] == "done":
                break
        assert math.dist(robot.pose[:2], KITCHEN) < 0.1


def test_a_node_of_rclpy_has_sentences_and_plans_carried_out(
    tmp_path: Path, surroundings: Mapping[str, str], request: pytest.FixtureRequest
) -> None:
    peer = RosPeer(environment.PYTHON, surroundings)
    request.addfinalizer(peer.close)
    outcomes, plans = peer.listen("/outcome", STRING), peer.listen("/plan", STRING)
    options = ("ros.door=rclpy", "robot.speed=real")
    with in_ros(tmp_path, surroundings, *options) as running:
        loading = {"robot", "ros"}
        while loading:
            ready = running.until("log", lambda body: body["message"].startswith("ready"))
            loading.discard(ready["source"])

        sentence = "turn left 45 degrees"
        until_heard(outcomes, lambda: peer.publish("/speech_to_text/command", STRING, {"data": "what time is it?"}))
        peer.publish("/speech_to_text/command", STRING, {"data": sentence})
        assert over(outcomes, sentence)["outcome"] == "done"
        while not made(plans)["actions"]:
            pass

        response = peer.call("/get_plan", PLAN, {"command": "go to the kitchen, then beep", "language": "en"})
        answer = response.get(timeout=LIMIT_S)
        assert answer["success"], answer
        assert json.loads(answer["plan"])["actions"][0].startswith("navigation(")

        goal = peer.goal("/execute_plan", EXECUTE, {"plan": answer["plan"]})
        feedback = goal.feedback.get(timeout=LIMIT_S)
        assert feedback["message"].startswith("executing step 1 of 2")
        running.until("robot.state", lambda body: body["moving"])
        goal.cancel()
        how, result = goal.ended.get(timeout=LIMIT_S)
        assert how == "canceled"
        assert result["outcome"] == "interrupted"
        assert not result["success"]
        (step,) = json.loads(result["results"])
        assert step["outcome"] == "interrupted"
        over(outcomes, outcome="interrupted")

        goal = peer.goal("/execute_plan", EXECUTE, {"plan": "beep(); arm_nod()"})
        how, result = goal.ended.get(timeout=LIMIT_S)
        assert (how, result["outcome"]) == ("succeeded", "done"), result
        assert len(json.loads(result["results"])) == 2

        peer.publish("/speech_to_text/command", STRING, {"data": "patrol"})
        running.until("action.started", lambda body: body["name"] == "patrol")
        stopped = False
        while not stopped:
            heard = until_heard(outcomes, lambda: peer.publish("/stop", "std_msgs/msg/Empty", {}))
            over_now = json.loads(heard["data"])
            stopped = over_now["kind"] == "turn" and over_now["outcome"] == "interrupted"


def made(heard: queue.SimpleQueue[Any]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(heard.get(timeout=LIMIT_S)["data"])
    return found


def over(heard: queue.SimpleQueue[Any], request: str = "", outcome: str = "") -> dict[str, Any]:
    """The end of the next turn with this request, or this outcome."""
    while True:
        found = made(heard)
        if found["kind"] == "turn" and request in found["request"] and outcome in found["outcome"]:
            return found
