"""A robot with an emulated board and no cable: board and body in one process and one time.

Every velocity and every angle goes through frames in both directions, as over a cable; only the cable is left out, and
real time with it. So the tasks that the simulated robot is judged by can be done through a board as well.
"""

from __future__ import annotations

from numpy import float64
from numpy.typing import NDArray

from config.schema import Robot as RobotSettings
from engine.robot.description import Description
from engine.robot.emulation.board import EmulatedBoard
from engine.robot.geometry import Pose
from engine.robot.host.memory import Record
from engine.robot.rosmaster.body import RosmasterBody
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.simulated import SimulatedBody


class BoardInside(RosmasterBody):
    """A :class:`engine.robot.host.body.Body` whose board lets time pass in each of its steps."""

    def __init__(
        self, settings: RobotSettings, description: Description, start: Pose, last: Record | None = None
    ) -> None:
        """``start`` and ``last`` are those of :class:`RosmasterBody`. Raises ``SceneError`` or ``DeviceError``."""
        scene = load_scene(scene_path(settings.scene))
        self.simulated = SimulatedBody(scene, settings, last, pictures=False)
        self._board = EmulatedBoard(self.simulated, description)
        self._to_body = bytearray()
        self._sees = description.lidar is not None
        super().__init__(
            settings.made_as,
            description,
            start,
            last,
            guarded=False,  # nothing drives on when this process dies
            clock=lambda: self.simulated.t,
            open_line=lambda path: self,
        )

    def step(self) -> None:
        self._board.step()
        self._to_body += self._board.send()
        super().step()

    def scan(self) -> NDArray[float64] | None:
        return self.simulated.scan() if self._sees else None

    def fill(self, record: Record) -> None:
        super().fill(record)
        self.simulated.fill(record)

    # The line, of which this is both ends

    def fileno(self) -> int:
        """There is none."""
        return -1

    def read(self) -> bytes:
        data = bytes(self._to_body)
        self._to_body.clear()
        return data

    def write(self, data: bytes) -> int:
        self._board.receive(data)
        return len(data)

    def forget(self) -> None:
        """Nothing waits."""
