"""Which bodies there are, by the name of their kind (``robot.kind``). Only the one that is asked for is loaded."""

from __future__ import annotations

from config.schema import Robot as RobotSettings
from engine.robot.host.controller import Controller
from engine.robot.host.memory import Record


def controlled(settings: RobotSettings, last: Record | None) -> Controller:
    """The configured body, open and under control; ``last`` is the state that it goes on from. For the host's process.
    Raises ``SceneError``, ``RobotError`` or ``DeviceError``."""
    from engine.robot.sim.scene_file import load_scene, scene_path
    from engine.robot.sim.world import World

    return World(load_scene(scene_path(settings.scene)), settings, last, pictures=False)
