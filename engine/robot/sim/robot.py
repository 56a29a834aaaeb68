"""The simulated robot, as the engine holds it: a host with a simulated body, and a camera that shows its world."""

from __future__ import annotations

from config.schema import Robot as RobotSettings
from engine.robot.camera_news import TellOfCamera
from engine.robot.host.hosted import Build, HostedRobot
from engine.robot.sim.camera import SimCamera
from engine.robot.sim.dimensions import ARM, FOOTPRINT
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene_file import load_scene, scene_path


class SimRobot(HostedRobot):
    """A :class:`engine.robot.robot.Robot` that lives in a MuJoCo scene."""

    def __init__(self, settings: RobotSettings, on_camera: TellOfCamera | None = None) -> None:
        """Read the scene; raises :class:`SceneError`. ``on_camera``: see
        :class:`engine.robot.host.hosted.HostedRobot`."""
        path = scene_path(settings.scene)
        self.scene = load_scene(path)
        build = Build(
            name=f"simulated robot ({self.scene.name})",
            capabilities=frozenset({"base", "arm", "camera", "voice"}),
            footprint=FOOTPRINT,
            floor_map=floor_map(self.scene),
            arm=ARM,
            eye=lambda memory, tell: SimCamera(path, settings.camera, memory, tell),
            company=bool(self.scene.people),
            environment={"MUJOCO_GL": "disable"},  # the host shows nothing
        )
        super().__init__(settings, build, on_camera)
