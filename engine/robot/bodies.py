"""Which robots there are, by the name of their kind (``robot.kind``). Only the one that is asked for is loaded."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from config.schema import Robot as RobotSettings
from engine.errors import UsageError
from engine.robot.camera_news import TellOfCamera
from engine.robot.description import Description, described
from engine.robot.geometry import Pose
from engine.robot.home import home
from engine.robot.host.body import Body
from engine.robot.host.controller import Controller
from engine.robot.host.hosted import Build, Eye, HostedRobot
from engine.robot.host.memory import Memory, Record
from engine.robot.robot import Robot

if TYPE_CHECKING:
    from engine.robot.ros2.body import Ros2Body
    from engine.robot.usb_lidar import UsbLidar


EXAMPLES = {"camera": "{depth: false, view: 50, on_arm: false}", "lidar": "{model: RPLIDAR-A1, at: [0.04, 0.0]}"}
"""How a description tells of them."""


def description_of(settings: RobotSettings) -> Description:
    """How the configured robot is made, without a camera or lidar that nothing is plugged in for. Raises
    ``UsageError``."""
    found = described(settings.made_as)
    if settings.kind != found.kind:
        has = {"sim": "is simulated", "rosmaster": "has a Rosmaster board", "ros2": "speaks ROS 2"}[found.kind]
        raise UsageError(
            f"robot.model {settings.made_as!r} {has}, and robot.kind is {settings.kind}.",
            hint="`sayso robot list` shows which model goes with which kind.",
        )
    if settings.kind == "sim" or settings.emulated:
        return found
    devices = {"camera": settings.camera.device, "lidar": settings.lidar}
    if found.ros is not None:  # its lidar is a topic, and its camera may be some
        devices = {} if found.ros.camera is not None else {"camera": settings.camera.device}
    for part, device in devices.items():
        if device is not None and getattr(found, part) is None:
            raise UsageError(
                f"The settings name a {part} ({device}), and the description of {settings.made_as} has none.",
                hint=f"Name in robot.model one that has; in one of yours, {part}: {EXAMPLES[part]}",
            )
    return found.model_copy(update={part: None for part, device in devices.items() if device is None})


def make_robot(settings: RobotSettings, on_camera: TellOfCamera | None = None) -> Robot:
    """The configured robot, not started yet; ``on_camera`` is told how its camera is doing. Raises ``SceneError`` or
    ``UsageError``."""
    if settings.kind == "sim":
        from engine.robot.sim.robot import SimRobot

        return SimRobot(settings, on_camera)
    description = description_of(settings)
    if not settings.emulated:
        settings = settings.model_copy(update={"speed": "real"})
    build = Build(
        name=f"{description.name} ({settings.port or settings.door})",
        capabilities=description.capabilities,
        footprint=description.footprint,
        floor_map=home(settings).floor_map,
        arm=description.arm_model,
        eye=_eye(settings, description),
        battery=description.battery,
        navigates=_navigates(description),
    )
    return HostedRobot(settings, build, on_camera)


def _eye(settings: RobotSettings, description: Description) -> Callable[[Memory, TellOfCamera], Eye] | None:
    """The camera, where the robot has one: on USB, or of the simulation behind an emulated board."""
    if description.camera is None:
        return None
    if settings.emulated:
        from engine.robot.sim.camera import SimCamera
        from engine.robot.sim.scene_file import scene_path

        path = scene_path(settings.scene)
        return lambda memory, tell: SimCamera(path, settings.camera, memory, tell)
    if description.ros is not None and description.ros.camera is not None:
        from engine.robot.ros2.camera import RosCamera
        from engine.ros.opening import open_door

        door = settings.door or ""
        return lambda memory, tell: RosCamera(open_door(door), settings.camera, description, memory, tell)
    from engine.robot.usb_camera import UsbCamera

    return lambda memory, tell: UsbCamera(settings.camera, description, memory, tell)


def controlled(settings: RobotSettings, last: Record | None) -> Controller:
    """The configured body, open and under control; ``last`` is the state that it goes on from. For the host's process.
    Raises ``SceneError``, ``RobotError`` or ``DeviceError``."""
    if settings.kind == "sim":
        from engine.robot.sim.scene_file import load_scene, scene_path
        from engine.robot.sim.world import World

        return World(load_scene(scene_path(settings.scene)), settings, last, pictures=False)
    description, house = description_of(settings), home(settings)
    blind = description.lidar is None
    control = partial(
        Controller,
        start=house.start,
        limits=settings.limits,
        footprint=description.footprint,
        ranges=description.ranges,
        edges=house.edges(blind=blind),
        last=last,
        blind=blind,
    )
    if settings.kind == "ros2":
        body = _of_ros(settings, description, house.start, last)
        arm_mover = body if description.arm is not None else None
        return control(body, navigator=body if _navigates(description) else None, arm_mover=arm_mover)
    return control(_on_board(settings, description, house.start, last))


def _of_ros(settings: RobotSettings, description: Description, start: Pose, last: Record | None) -> Ros2Body:
    from engine.robot.ros2.body import Ros2Body, guard_of
    from engine.ros.opening import open_door

    door, about = settings.door, description.ros
    assert door is not None, "the configuration sees to that"
    assert about is not None, "the same"
    return Ros2Body(open_door(door), description, start, last, guard=lambda: guard_of(door, about))


def _on_board(settings: RobotSettings, description: Description, start: Pose, last: Record | None) -> Body:
    if settings.emulated:
        from engine.robot.emulation.inside import BoardInside

        return BoardInside(settings, description, start, last)
    from engine.robot.rosmaster.body import RosmasterBody

    assert settings.port is not None, "the configuration sees to that"
    return RosmasterBody(settings.port, description, start, last, lidar=_lidar(settings, description))


def _navigates(description: Description) -> bool:
    return description.ros is not None and description.ros.navigation is not None


def _lidar(settings: RobotSettings, description: Description) -> UsbLidar | None:
    if description.lidar is None or settings.lidar is None:
        return None
    from engine.robot.usb_lidar import UsbLidar

    return UsbLidar(settings.lidar, description.lidar, description.hull)
