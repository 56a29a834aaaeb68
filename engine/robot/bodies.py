"""Which robots there are, by the name of their kind (``robot.kind``). Only the one that is asked for is loaded."""

from __future__ import annotations

from collections.abc import Callable

from config.schema import Robot as RobotSettings
from engine.errors import UsageError
from engine.robot.camera_news import TellOfCamera
from engine.robot.description import Description, described
from engine.robot.home import home
from engine.robot.host.controller import Controller
from engine.robot.host.hosted import Build, Eye, HostedRobot
from engine.robot.host.memory import Memory, Record
from engine.robot.robot import Robot


def description_of(settings: RobotSettings) -> Description:
    """How the configured robot is made. Raises ``UsageError``."""
    found = described(settings.made_as)
    if (settings.kind == "rosmaster") != (found.board is not None):
        has = "has a Rosmaster board" if found.board is not None else "has no Rosmaster board"
        raise UsageError(
            f"robot.model {settings.made_as!r} {has}, and robot.kind is {settings.kind}.",
            hint="`sayso robot list` shows which model goes with which kind.",
        )
    return found


def make_robot(settings: RobotSettings, on_camera: TellOfCamera | None = None) -> Robot:
    """The configured robot, not started yet; ``on_camera`` is told how its camera is doing. Raises ``SceneError`` or
    ``UsageError``."""
    if settings.kind == "sim":
        from engine.robot.sim.robot import SimRobot

        return SimRobot(settings, on_camera)
    description = description_of(settings)
    build = Build(
        name=f"{description.name} ({settings.port})",
        capabilities=description.capabilities,
        footprint=description.footprint,
        floor_map=home(settings).floor_map,
        arm=description.arm_model,
        eye=_eye(settings, description),
        battery=description.board.battery if description.board is not None else None,
    )
    return HostedRobot(settings.model_copy(update={"speed": "real"}), build, on_camera)


def _eye(settings: RobotSettings, description: Description) -> Callable[[Memory, TellOfCamera], Eye] | None:
    """The camera on USB, where the robot has one and the settings say which it is."""
    if description.camera is None or settings.camera.device is None:
        return None
    from engine.robot.usb_camera import UsbCamera

    return lambda memory, tell: UsbCamera(settings.camera, description, memory, tell)


def controlled(settings: RobotSettings, last: Record | None) -> Controller:
    """The configured body, open and under control; ``last`` is the state that it goes on from. For the host's process.
    Raises ``SceneError``, ``RobotError`` or ``DeviceError``."""
    if settings.kind == "sim":
        from engine.robot.sim.scene_file import load_scene, scene_path
        from engine.robot.sim.world import World

        return World(load_scene(scene_path(settings.scene)), settings, last, pictures=False)
    from engine.robot.rosmaster.body import RosmasterBody

    description, house = description_of(settings), home(settings)
    assert settings.port is not None, "the configuration sees to that"
    return Controller(
        RosmasterBody(settings.port, description, house.start, last),
        house.start,
        settings.limits,
        description.footprint,
        description.ranges,
        house.edges(blind=not description.lidar),
        last,
        blind=not description.lidar,
    )
