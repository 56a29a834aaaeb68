"""The robot process from outside: starting it, noticing its end, and what it died of.

Beside the link of every :class:`engine.child.Child` it shares an unnamed piece of memory with us, which belongs to
whoever starts the process, and may have served one before.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

from config.schema import Robot as RobotSettings
from engine.child import Child
from engine.errors import ProcessError, RobotError
from engine.robot.sim import memory as m
from engine.robot.sim.memory import Memory

LEAN = {"PYDANTIC_DISABLE_PLUGINS": "__all__"}
"""Environment of the simulation's processes: looking for plugins, of which there are none, takes as long as a scene."""
START_LIMIT = 60.0
"""s until the robot process must have built its world."""


class RobotProcess(Child):
    """One running robot process. Whoever makes it closes it."""

    def __init__(self, scene: Path, settings: RobotSettings, memory: Memory) -> None:
        """Start the process. Raises :class:`RobotError`."""
        self._memory: Memory | None = memory
        arguments = [f"--memory={memory.fd}", f"--scene={scene}", f"--settings={settings.model_dump_json()}"]
        try:
            super().__init__(
                "robot",
                "engine.robot.sim.physics",
                arguments,
                shared=(memory.fd,),
                environment={"MUJOCO_GL": "disable", **LEAN},  # it shows nothing
            )
        except ProcessError as error:
            raise RobotError(error.message) from error

    def wait_until_ready(self) -> None:
        """Block until the world is built. Raises :class:`RobotError`."""
        self.link.settimeout(START_LIMIT)
        with contextlib.suppress(OSError):  # time-out or a broken connection: not ready either
            if self.link.recv(1):
                return
        raise RobotError(
            self.epitaph(wait=0.5) or f"The robot process was not ready within {START_LIMIT:.0f} s.",
            hint="Check robot.scene in your configuration.",
        )

    def end(self) -> None:
        """Ask the process to leave and block until it has: it comes to rest first. Kill it when it does not."""
        if self._memory is not None:
            self._memory.ints[m.QUIT] = 1
        super().end()

    def release(self) -> None:
        """Close what is ours, and let go of the memory: the thread that ended us may know us for a moment longer."""
        super().release()
        self._memory = None
