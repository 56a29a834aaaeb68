"""A board and a lidar, each on a pseudo-terminal: what the lidar sees keeps the robot from driving into it."""

from __future__ import annotations

import math
from pathlib import Path

import yaml

from engine.robot.sim.scene_file import scene_path
from tests.board import Emulator
from tests.e2e.engine import engine
from tests.e2e.test_board import ended


def test_it_stops_before_what_no_map_has_and_when_it_sees_nothing_any_more(tmp_path: Path) -> None:
    house = yaml.safe_load(scene_path("flat").read_text("utf-8"))
    house["furniture"]["crate"] = {"kind": "carton", "at": [1.0, 0.0], "size": [0.3, 0.5, 0.4], "mapped": False}
    scene, eyes = tmp_path / "crate.yaml", tmp_path / "lidar"
    scene.write_text(yaml.safe_dump(house), "utf-8")
    told = ("--set", f"robot.scene={scene}", "--set", "robot.kind=rosmaster", "--set", "robot.model=emulated")
    with Emulator(tmp_path, f"--lidar={eyes}", "--set", f"robot.scene={scene}", model="emulated") as board:
        ports = ("--set", f"robot.port={board.path}", "--set", f"robot.lidar={eyes}")
        with engine(tmp_path / "state", "", *told, *ports) as running:
            running.until("log", lambda body: body["source"] == "robot")
            board.until(lambda state: state["t"] > 3)  # it has turned
            running.send(do="say", text="drive forward 2 metres")
            result = running.until("state.changed", ended)["result"]
            assert result["outcome"] == "failed"
            assert "obstacle" in result["message"]
            state = board.until(lambda state: not any(state["told"].values()))
            assert 0.3 < state["x"] < 0.85 - 0.15 - 0.03, "the crate begins at 0.85 m, and the hull reaches 0.15 m"
            running.send(do="say", text="drive backwards 1 metre")
            board.until(lambda state: state["speed"]["vx"] < -0.1)
            board.tell("unplug lidar")
            result = running.until("state.changed", ended)["result"]
            assert result["outcome"] == "failed"
            assert "no lidar scan" in result["message"]
            board.tell("plug lidar")
            for _ in range(8):  # one that comes back does not turn at once
                running.send(do="say", text="turn left 90 degrees")
                result = running.until("state.changed", ended)["result"]
                if result["outcome"] == "done":
                    break
            state = board.until(lambda state: not any(state["told"].values()))
            assert state["yaw"] > math.radians(60)
