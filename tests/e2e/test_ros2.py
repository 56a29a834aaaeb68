"""A robot of ROS 2 behind a rosbridge: it is driven by sentences, and its bridge may go and come back."""

from __future__ import annotations

import math
from pathlib import Path

import psutil
import pytest
import yaml

from engine.errors import ExitCode
from engine.robot.description import described
from engine.robot.saved_map import read_map
from engine.robot.sim.floor import floor_map
from tests.e2e.engine import Engine, engine
from tests.e2e.sayso import sayso
from tests.e2e.test_board import ended
from tests.rosbridge import Peer, free_port
from tests.sim.rig import flat

BEDROOM = (1.2, -2.4)
"""Somewhere in it."""


def test_what_it_says_is_listened_to_before_anything_moves(tmp_path: Path) -> None:
    port = free_port()
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}")
    with Peer(port):
        done = sayso("robot", "check", *told, state=tmp_path)
        assert done.returncode == ExitCode.DONE
        assert {b"/odom", b"/scan", b"/battery_state"} <= set(done.stdout.split())
    done = sayso("robot", "check", *told, state=tmp_path)
    assert done.returncode == ExitCode.MISSING
    assert b"Nothing can be heard" in done.stderr


def test_what_it_has_is_found_and_written_down_and_drives_it_then(tmp_path: Path) -> None:
    port = free_port()
    told = ("--set", f"robot.door=ws://127.0.0.1:{port}")
    environ = {"SAYSO_CONFIG_DIR": str(tmp_path / "config")}
    with Peer(port):
        done = sayso("robot", "probe", "ros2", "--as", "mine", *told, state=tmp_path, environ=environ)
        assert done.returncode == ExitCode.DONE, done.stderr
        made = yaml.safe_load((tmp_path / "config" / "robots" / "mine.yaml").read_text("utf-8"))
        assert made["ros"]["velocity"] == "/cmd_vel"
        assert made["ros"]["navigation"] == "/navigate_to_pose"
        assert made["ros"]["map_frame"] == "map"
        assert made["lidar"] == {"range": 12.0, "nearest": 0.05, "at": [0.0, 0.0], "turned": 0.0}
        saved = read_map(tmp_path / "config" / "robots" / "mine-map.yaml")
        assert saved.occupied.tolist() == floor_map(flat()).occupied.tolist()
        chosen = ("--set", "robot.kind=ros2", "--set", "robot.model=mine")
        done = sayso("robot", "check", *told, *chosen, state=tmp_path, environ=environ)
        assert done.returncode == ExitCode.DONE, done.stderr
        done = sayso("robot", "probe", "ros2", "--as", "mine", *told, state=tmp_path, environ=environ)
        assert done.returncode == ExitCode.USAGE, "the first one is kept"
        (tmp_path / "config" / "robots" / "other-map.pgm").symlink_to(tmp_path / "elsewhere")
        done = sayso("robot", "probe", "ros2", "--as", "other", *told, state=tmp_path, environ=environ)
        assert done.returncode == ExitCode.USAGE, "a link is not written through"
        assert not (tmp_path / "elsewhere").exists()


def test_it_is_driven_by_sentences_and_its_bridge_goes_and_comes_back(tmp_path: Path) -> None:
    port = free_port()
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}")
    with Peer(port, "--no-navigation") as peer, engine(tmp_path / "state", "", *told) as running:
        running.until("log", lambda body: body["source"] == "robot" and "ready" in body["message"])
        running.send(do="say", text="go to the kitchen")
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "done", result
        state = peer.until(lambda state: state["speed"] < 0.01)
        assert math.dist((state["x"], state["y"]), (0.2, 2.0)) < 0.1

        running.send(do="say", text="go to the hall")
        peer.until(lambda state: state["speed"] > 0.1)
        running.send(do="interrupt")
        running.until("state.changed", ended)
        peer.until(lambda state: not state["told"] and state["speed"] < 0.01)

        running.send(do="say", text="go to the hall")
        peer.until(lambda state: state["speed"] > 0.1)
        peer.kill()
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "failed"
        assert "is gone" in result["message"] or "no odometry" in result["message"]
        with Peer(port, "--no-navigation") as again:
            for _ in range(10):  # it is found again by itself
                running.send(do="say", text="drive forward 20 centimetres")
                if running.until("state.changed", ended)["result"]["outcome"] == "done":
                    break
            state = again.until(lambda state: state["speed"] < 0.01)
            assert math.hypot(state["x"], state["y"]) > 0.15


def test_its_own_navigation_finds_the_way_and_gives_up_when_told(tmp_path: Path) -> None:
    port = free_port()
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}")
    with Peer(port) as peer, engine(tmp_path / "state", "", *told) as running:
        running.until("log", lambda body: body["source"] == "robot" and "ready" in body["message"])
        running.send(do="say", text="go to the kitchen")
        peer.until(lambda state: state["sent"])
        progress = running.until("action.progress", lambda body: (body["fraction"] or 0) > 0.3)
        assert progress["message"].endswith("to the kitchen")
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "done", result
        state = peer.until(lambda state: state["speed"] < 0.01 and not state["sent"])
        assert math.dist((state["x"], state["y"]), (0.2, 2.0)) < 0.1

        running.send(do="say", text="go to the hall")
        driving = peer.until(lambda state: state["sent"] and state["speed"] > 0.1)
        running.send(do="interrupt")
        running.until("state.changed", ended)
        stopped = peer.until(lambda state: not state["sent"] and not state["told"] and state["speed"] < 0.01)
        assert stopped["zeros"] > driving["zeros"], "it is told zero, and its navigation to give up"

        running.send(do="say", text="drive forward 20 centimetres")
        assert running.until("state.changed", ended)["result"]["outcome"] == "done", "it obeys as before"


def test_a_navigation_that_does_not_give_up_is_held_at_zero_and_told(tmp_path: Path) -> None:
    port = free_port()
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}")
    with Peer(port, "--stubborn") as peer, engine(tmp_path / "state", "", *told) as running:
        running.until("log", lambda body: body["source"] == "robot" and "ready" in body["message"])
        running.send(do="say", text="go to the kitchen")
        driving = peer.until(lambda state: state["sent"] and state["speed"] > 0.1)
        running.send(do="interrupt")
        running.until("state.changed", ended)
        held = peer.until(lambda state: state["zeros"] > driving["zeros"] + 150)  # for longer than it may take to end
        assert held["sent"], "its navigation goes on"
        running.send(do="say", text="drive forward 20 centimetres")
        result = running.until("state.changed", ended)["result"]
        assert result["outcome"] == "failed"
        assert "goes on although it was told to stop" in result["message"]


@pytest.mark.parametrize("victim", ["engine", "host", "guard"])
def test_whatever_is_killed_its_navigation_is_called_back(tmp_path: Path, victim: str) -> None:
    port = free_port()
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}")
    with Peer(port) as peer, engine(tmp_path / "state", "", *told) as running:
        running.until("log", lambda body: body["source"] == "robot" and "ready" in body["message"])
        running.send(do="say", text="go to the bedroom")
        peer.until(lambda state: state["sent"] and state["speed"] > 0.1)
        process_of(running, victim).kill()
        stopped = peer.until(lambda state: not state["sent"] and state["speed"] < 0.01)
        assert math.dist((stopped["x"], stopped["y"]), BEDROOM) > 0.5


def process_of(running: Engine, name: str) -> psutil.Process:
    """The engine, or one of its children."""
    own = psutil.Process(running.process.pid)
    if name == "engine":
        return own
    return next(child for child in own.children(recursive=True) if f"{name}_main" in " ".join(child.cmdline()))


def test_its_camera_on_a_topic_shows_what_it_sees(tmp_path: Path) -> None:
    port = free_port()
    made = described("ros2").model_dump(mode="json")
    made |= {"camera": {"depth": False, "view": 48, "on_arm": False}, "lidar": {"range": 12}}
    made["ros"] |= {"camera": {"image": "/image"}}
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump({key: value for key, value in made.items() if value is not None}), "utf-8")
    told = ("--set", "robot.kind=ros2", "--set", f"robot.door=ws://127.0.0.1:{port}", "--set", f"robot.model={mine}")
    with Peer(port), engine(tmp_path / "state", "", *told) as running:
        ready = running.until("log", lambda body: body["source"] == "camera" and body["message"].startswith("ready"))
        assert "/image 320×240, no depth" in ready["message"]
