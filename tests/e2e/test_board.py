"""A sentence that goes through the whole of sayso into serial frames, and a robot that drives behind them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import yaml

from engine.robot.sim.scene_file import scene_path
from tests.board import Emulator
from tests.e2e.engine import Engine, engine
from tests.unit.test_usb_camera import film


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Emulator]:
    with Emulator(tmp_path) as emulator:
        yield emulator


@pytest.fixture
def running(board: Emulator, tmp_path: Path) -> Iterator[Engine]:
    options = ("--set", "robot.kind=rosmaster", "--set", f"robot.port={board.path}")
    with engine(tmp_path / "state", "", *options) as started:
        started.until("log", lambda body: body["source"] == "robot")
        yield started


def ended(body: dict[str, Any]) -> bool:
    return body["result"] is not None


def test_it_goes_to_the_kitchen_and_raises_its_arm(board: Emulator, running: Engine) -> None:
    running.send(do="say", text="go to the kitchen, then raise your arm")
    result = running.until("state.changed", ended)["result"]
    assert result["outcome"] == "done"
    state = board.until(lambda state: not any(state["told"].values()))
    assert math.dist((state["x"], state["y"]), (0.2, 2.0)) < 0.1
    assert state["joints"] == pytest.approx([0, 0, 0, 0, 0], abs=0.05)


def test_the_cable_is_pulled_in_mid_drive_and_it_goes_on_when_told(board: Emulator, running: Engine) -> None:
    running.send(do="say", text="go to the kitchen")
    board.until(lambda state: state["speed"]["vx"] > 0.15)
    board.tell("unplug")
    result = running.until("state.changed", ended)["result"]
    assert result["outcome"] == "failed"
    assert "was unplugged" in result["message"]
    board.tell("plug")
    board.until(lambda state: not any(state["told"].values()))
    for _ in range(5):  # a board that comes back is not ready at once
        running.send(do="say", text="go to the kitchen")
        result = running.until("state.changed", ended)["result"]
        if result["outcome"] == "done":
            break
    state = board.until(lambda state: not any(state["told"].values()))
    assert math.dist((state["x"], state["y"]), (0.2, 2.0)) < 0.1, "it drove on while the cable was out, and knows"


def test_driving_and_the_arm_go_through_the_frames(board: Emulator, running: Engine) -> None:
    def done(text: str) -> dict[str, Any]:
        running.send(do="say", text=text)
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "done", result
        return board.until(lambda state: not any(state["told"].values()))

    start = board.until(lambda state: True)
    moved = done("drive forward 40 centimetres and turn left 90 degrees")
    assert moved["x"] - start["x"] == pytest.approx(0.4, abs=0.03)
    assert moved["yaw"] - start["yaw"] == pytest.approx(math.pi / 2, abs=0.05)
    aside = done("move 20 centimetres to the right")
    assert aside["x"] - moved["x"] == pytest.approx(0.2, abs=0.03), "it looks to the left by now"
    done("open your gripper")
    board.until(lambda state: state["gripper"] > 0.95)
    done("close your gripper")
    board.until(lambda state: state["gripper"] < 0.05)
    done("nod, then wave")
    done("lower your arm")
    board.until(lambda state: abs(state["joints"][1] + 1.1) < 0.05)


def test_driven_by_hand_it_stops_when_no_more_comes(board: Emulator, running: Engine) -> None:
    for _ in range(10):
        running.send(do="drive", vx=0.2)
        board.comes_to(lambda state: False, 0.05)
    assert board.state["speed"]["vx"] == pytest.approx(0.2, abs=0.03)
    board.until(lambda state: not any(state["told"].values()) and abs(state["speed"]["vx"]) < 0.01)
    running.send(do="estop")
    running.until("ack", lambda body: body["do"] == "estop")
    running.send(do="drive", vx=0.2, id="no")
    assert not running.until("ack", lambda body: body["id"] == "no")["ok"]
    assert board.comes_to(lambda state: any(state["told"].values()), 0.5) is None


def test_a_camera_on_usb_shows_what_it_sees(board: Emulator, tmp_path: Path) -> None:
    made = yaml.safe_load((Path(str(files("assets"))) / "robots" / "x3plus.yaml").read_text("utf-8"))
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump(made | {"camera": {"depth": False, "view": 50, "on_arm": False}}, sort_keys=False))
    options = (f"kind=rosmaster port={board.path} model={mine} camera.device={film(tmp_path / 'film.avi', 50)}").split()
    with engine(tmp_path / "state", "", *(part for one in options for part in ("--set", f"robot.{one}"))) as started:
        ready = started.until("log", lambda body: body["source"] == "camera" and body["message"].startswith("ready"))
        assert "320×240, no depth" in ready["message"]


def test_what_needs_a_camera_is_not_offered(board: Emulator, running: Engine) -> None:
    running.send(do="say", text="pick up the red cup")
    assert running.until("state.changed", ended)["result"]["outcome"] != "done"


def test_with_a_low_battery_it_refuses_what_is_long_and_goes_to_its_dock(tmp_path: Path) -> None:
    house = yaml.safe_load(scene_path("flat").read_text("utf-8"))
    house["start"] = {"x": 2.5, "y": -0.3, "yaw": 0}  # not far from there
    scene = tmp_path / "flat.yaml"
    scene.write_text(yaml.safe_dump(house), "utf-8")
    with Emulator(tmp_path, "--set", f"robot.scene={scene}", model="emulated") as board:
        options = ("robot.kind=rosmaster", "robot.model=emulated", f"robot.port={board.path}", f"robot.scene={scene}")
        told = (word for option in options for word in ("--set", option))
        with engine(tmp_path / "state", "", *told) as running:
            running.until("log", lambda body: body["source"] == "robot")
            board.tell("volts 10.0")
            running.until("log", lambda body: body["message"].startswith("The battery is low"))
            running.send(do="say", text="patrol")
            result = running.until("state.changed", ended)["result"]
            assert result["outcome"] == "failed"
            assert "My battery is low" in result["message"]
            log = running.until("log", lambda body: "going to" in body["message"])
            assert log["message"].endswith("I am going to the charging dock.")
            assert running.until("state.changed", ended)["result"]["outcome"] == "done"
            state = board.until(lambda state: state["volts"] > 11)
            assert math.dist((state["x"], state["y"]), (4.2, -0.3)) < 0.15
            running.until("log", lambda body: body["message"] == "The battery is fine again.")
