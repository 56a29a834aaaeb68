"""The simulated robot under control: what a host runs, and what a test may hold in its hand."""

from __future__ import annotations

from typing import Any

from config.schema import Robot as RobotSettings
from engine.robot.geometry import Pose
from engine.robot.host.controller import Controller
from engine.robot.host.envelope import fence
from engine.robot.host.memory import Record
from engine.robot.sim.dimensions import FOOTPRINT, JOINT_RANGES
from engine.robot.sim.scene import Scene
from engine.robot.sim.simulated import SimulatedBody


class World(Controller):
    """The simulated body in a scene, whose edges and keep-out zones it does not cross."""

    def __init__(
        self, scene: Scene, settings: RobotSettings, last: Record | None = None, *, pictures: bool = True
    ) -> None:
        """See :class:`engine.robot.sim.simulated.SimulatedBody`."""
        self.simulated = SimulatedBody(scene, settings, last, pictures=pictures)
        start, edges = scene.start.pose, fence(scene.edges())
        company = self.simulated.company
        super().__init__(self.simulated, start, settings.limits, FOOTPRINT, JOINT_RANGES, edges, last, company=company)

    @property
    def model(self) -> Any:
        """The ``mujoco.MjModel``."""
        return self.simulated.model

    @property
    def data(self) -> Any:
        """The ``mujoco.MjData``."""
        return self.simulated.data

    @property
    def true_pose(self) -> Pose:
        """Where it really is, map frame."""
        return self.simulated.true_pose

    def touching(self) -> tuple[str, ...]:
        """What the robot touches, by name."""
        return self.simulated.touching()
