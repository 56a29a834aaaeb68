"""The robot of ROS (:mod:`tests.ros.robot`) as a process, and what it tells of itself beside ROS."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tests.ros import environment
from tests.ros.lines import Line, Program

LIMIT_S = 30.0
"""In which what a test waits for has happened, on a busy machine, too."""


class TrueRobot:
    """What the robot tells of itself beside ROS."""

    def __init__(self, surroundings: Mapping[str, str], *more: str) -> None:
        """``more`` goes to :mod:`tests.ros.simulation`."""
        self._ready = threading.Event()
        self._changed = threading.Condition()
        self._told: Line = {}
        self.pose, self.twist = [math.nan] * 3, [0.0] * 3
        self.joints, self.finger = [math.nan] * 5, math.nan
        """rad and m, as the simulation counts them."""
        self.touching: list[str] = []
        """Names of things."""
        command: list[str | Path] = [environment.PYTHON, "-m", "tests.ros.robot", sys.executable, *more]
        self.program = Program(command, surroundings, self._hear)
        assert self._ready.wait(LIMIT_S)

    @property
    def speed(self) -> float:
        return math.hypot(*self.twist)

    def until(self, holds: Any) -> None:
        """Wait until this holds of it; it is asked whenever the robot has told something."""
        with self._changed:
            assert self._changed.wait_for(lambda: holds(self), LIMIT_S), self._told

    def _hear(self, line: Line) -> None:
        if "ready" in line:
            self._ready.set()
            return
        with self._changed:
            self._told = line
            self.pose, self.twist, self.joints = line["pose"], line["twist"], line["joints"]
            self.finger, self.touching = line["finger"], line["touching"]
            self._changed.notify_all()
