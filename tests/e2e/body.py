"""The robot's body, read from outside: the memory of the robot process, whatever becomes of the processes.

The memory is a file without a name that the robot process holds open; ``/proc`` lends it to us (Linux). Mapped once,
it stays when its process is killed and goes on when another takes over.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from engine.robot.geometry import Pose, Twist
from engine.robot.host.memory import REST_TIME, TICKS, ZERO_TIME, Memory
from tests.children import children

CAN_READ = sys.platform == "linux" and Path("/proc/self/fd").is_dir()
LIMIT_S = 30
DRIVING = 0.2  # m/s
_MODULE = "engine.robot.host_main"
_LOOK_S = 0.001


class Body:
    """The robot below one process of sayso."""

    def __init__(self, sayso: int) -> None:
        """``sayso`` is the process id; waits until it has a robot."""
        until(lambda: children(_MODULE, sayso), "a robot process")
        self.process = children(_MODULE, sayso)[0]
        numbers = [word.partition("=")[2] for word in self.process.cmdline() if word.startswith("--memory=")]
        fd = os.open(f"/proc/{self.process.pid}/fd/{numbers[0]}", os.O_RDWR)
        self.memory = Memory(fd)
        os.close(fd)

    @property
    def twist(self) -> Twist:
        """Measured."""
        return Twist(*self.memory.state.get()["twist"].tolist())

    @property
    def command(self) -> Twist:
        """What the motors are told."""
        return Twist(*self.memory.state.get()["command"].tolist())

    @property
    def pose(self) -> Pose:
        """Where the robot really is."""
        return Pose(*self.memory.state.get()["true_pose"].tolist())

    @property
    def halted(self) -> str:
        """Why it halted by itself."""
        return str(self.memory.state.get()["halted"].item().decode())

    @property
    def driving(self) -> bool:
        return self.twist.vx > DRIVING

    @property
    def resting(self) -> bool:
        """Told to stand, and standing."""
        twist = self.twist
        return self.command.is_zero and max(abs(twist.vx), abs(twist.vy), abs(twist.wz)) < 0.02

    def until_driving(self) -> None:
        until(lambda: self.driving, "the robot drives")

    def until_resting(self, blow: float) -> tuple[float, float]:
        """Wait until it stands. Seconds from ``blow`` (monotonic) to zero commanded, and to rest."""
        times = self.memory.times
        until(lambda: self.resting and times[REST_TIME] >= times[ZERO_TIME] > blow, "the robot stands")
        return times[ZERO_TIME] - blow, times[REST_TIME] - blow

    def stays(self, seconds: float) -> None:
        """Look for so many seconds of robot time: it must not move."""
        end = self.memory.ints[TICKS] + round(seconds / 0.02)

        def over() -> bool:
            assert self.resting, f"it moves by itself: {self.twist}"
            return self.memory.ints[TICKS] >= end

        until(over, "time passes")


def until(met: Callable[[], object], what: str) -> None:
    """Look until it is so; fails loudly when it never is."""
    end = time.monotonic() + LIMIT_S
    while not met():
        assert time.monotonic() < end, f"not within {LIMIT_S} s: {what}"
        time.sleep(_LOOK_S)  # no kernel tells when somebody writes into memory
