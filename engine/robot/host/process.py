"""The host's process from outside: starting it, noticing its end, and what it died of.

Beside the link of every :class:`engine.child.Child` it shares an unnamed piece of memory with us, which belongs to
whoever starts the process, and may have served one before.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping

from config.schema import Robot as RobotSettings
from engine.child import Child
from engine.errors import ProcessError, RobotError
from engine.robot.host import memory as m
from engine.robot.host.memory import Memory

LEAN = {"PYDANTIC_DISABLE_PLUGINS": "__all__"}
"""Environment of a robot's processes: looking for plugins, of which there are none, takes as long as a scene."""
START_LIMIT = 60.0
"""s until the robot process must have opened its body."""


class HostProcess(Child):
    """One running host. Whoever makes it closes it."""

    def __init__(self, settings: RobotSettings, memory: Memory, environment: Mapping[str, str]) -> None:
        """Start the process; ``environment`` is added to ours. Raises :class:`RobotError`."""
        self._memory: Memory | None = memory
        arguments = [f"--memory={memory.fd}", f"--settings={settings.model_dump_json()}"]
        try:
            super().__init__(
                "robot",
                "engine.robot.host_main",
                arguments,
                shared=(memory.fd,),
                environment={**environment, **LEAN},
            )
        except ProcessError as error:
            raise RobotError(error.message) from error

    def wait_until_ready(self) -> None:
        """Block until the body is open. Raises :class:`RobotError`."""
        self.link.settimeout(START_LIMIT)
        with contextlib.suppress(OSError):  # time-out or a broken connection: not ready either
            if self.link.recv(1):
                return
        raise RobotError(
            self.epitaph(wait=0.5) or f"The robot process was not ready within {START_LIMIT:.0f} s.",
            hint="`sayso doctor` looks at everything that it needs.",
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
