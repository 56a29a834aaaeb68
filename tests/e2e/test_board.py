"""A sentence that goes through the whole of sayso into serial frames, and a robot that drives behind them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.board import Emulator
from tests.e2e.engine import Engine, engine


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


def test_what_needs_a_camera_is_not_offered(board: Emulator, running: Engine) -> None:
    running.send(do="say", text="pick up the red cup")
    assert running.until("state.changed", ended)["result"]["outcome"] != "done"
