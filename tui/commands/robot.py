"""``sayso robot``: which robots there are, how one is made, whether it answers, and a board to test on."""

from __future__ import annotations

import json
import math
import os
import select
import sys
import time
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import DeviceError, ExitCode, StorageError, UsageError
from engine.robot.geometry import heading_in_degrees
from tui.commands.settings import load_settings
from tui.output import data, json_line, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.robot.description import Description, LidarOf, RosOf
    from engine.robot.emulation.board import BoardState

CHECK_S = 1.5
"""How long a board is listened to, s."""
LIDAR_S = 4.0
"""In which a lidar must have made a turn."""


def run(arguments: Namespace) -> int:
    """The command as the command line gives it."""
    match arguments.action:
        case "list":
            return robot_list(json=arguments.json)
        case "show":
            return robot_show(load_settings(arguments), arguments.name, json=arguments.json)
        case "check":
            return robot_check(load_settings(arguments), json=arguments.json)
        case "probe":
            from tui.commands.probe import robot_probe

            return robot_probe(load_settings(arguments), arguments.name, arguments.called, json=arguments.json)
        case "calibrate":
            from tui.commands.calibrate import run as calibrate

            return calibrate(load_settings(arguments), arguments)
        case "drive":
            from tui.commands.drive import run as drive

            return drive(load_settings(arguments))
        case "estop" | "release":
            return robot_estop(pressed=arguments.action == "estop")
        case _:
            settings = load_settings(arguments)
            return robot_emulate(
                settings,
                arguments.name,
                arguments.port,
                lidar=arguments.lidar,
                stops_after=arguments.stops_after,
                pull=arguments.pull,
                json=arguments.json,
            )


def robot_list(*, json: bool = False) -> int:
    """One line a robot: the name that ``robot.model`` takes, and what it has."""
    from engine.robot.description import described, known

    for name in known():
        try:
            robot = described(name)
        except UsageError as error:  # one of this user's own, which hides none of the others
            say(f"sayso: {error.message}")
            continue
        if json:
            json_line({"name": name, **_facts(robot)})
        else:
            data(f"{name:<10} {robot.name:<18} {', '.join(_parts(robot))}")
    return int(ExitCode.DONE)


def robot_show(settings: Settings, name: str | None, *, json: bool = False) -> int:
    """How one is made. Without a name: the robot of the settings."""
    from engine.robot.description import described
    from engine.robot.usb_camera import how_good

    robot = described(name or settings.robot.made_as)
    if json:
        json_line(robot.model_dump(mode="json"))
        return int(ExitCode.DONE)
    hull, speeds = robot.hull, robot.speeds
    data(f"{robot.name}\n  {robot.source}")
    turn = math.degrees(speeds.turn)
    data(f"  drive    {robot.drive}, {speeds.forward:g} m/s ahead, {speeds.sideways:g} sideways, {turn:.0f}°/s")
    if robot.trim:
        data(f"           {robot.trim:+g} rad/m of trim, to drive straight")
    data(f"  hull     {100 * hull.length:.0f} × {100 * hull.width:.0f} cm")
    for what, found in robot.calibrated.items():
        data(f"           {what}: {found}")
    if robot.board is not None:
        stops = {None: "not known (sayso doctor --wheels-up finds out)", True: "yes", False: "no"}
        data(f"  board    {robot.board.kind}, car type {robot.board.car_type}")
        data(f"           stops by itself when the line falls silent: {stops[robot.board.stops_by_itself]}")
    if robot.arm is not None:
        reach = robot.arm.upper + robot.arm.fore + robot.arm.hand
        grip = 100 * robot.arm.gripper.opens
        data(f"  arm      {len(robot.arm.joints)} joints, {100 * reach:.0f} cm, gripper {grip:.0f} cm")
    data(f"  camera   {_camera(robot)}")
    if robot.camera is not None and not robot.camera.depth:
        data(f"           {how_good(_eye_height(robot))}")
    none = "none: it drives slowly, and stops short of what is on the map alone"
    if robot.dock is not None:
        data(f"  dock     {robot.dock}: with a low battery it goes there by itself")
    data(f"  lidar    {none if robot.lidar is None else _lidar(robot.lidar, robot.ros)}")
    return int(ExitCode.DONE)


def robot_check(settings: Settings, *, json: bool = False) -> int:
    """The ports there are, and what answers on the configured one. Nothing moves."""
    from engine.robot.bodies import description_of
    from engine.robot.rosmaster.inspection import inspect
    from engine.robot.usb_camera import cameras
    from engine.serial_port import attached

    if settings.robot.kind == "ros2":
        return _ros_check(settings, json=json)
    ports = attached()
    port = settings.robot.port
    pictures = cameras()
    if not json:
        for path, name in pictures.items():
            data(f"camera    {path} ({name})")
        for one in ports:
            data(f"port      {one.lasting} ({one.named})")
        if not ports:
            data("port      none attached to USB")
    if port is None:
        say("sayso: robot.port names none of them: --set robot.port=/dev/serial/by-id/…")
        if json:
            json_line({"ports": [one.lasting for one in ports], "board": None})
        return int(ExitCode.MISSING)
    robot = description_of(settings.robot) if settings.robot.kind == "rosmaster" else None
    board = inspect(port, CHECK_S)
    lidar = _lidar_sees(settings, robot) if robot is not None else None
    if json:
        json_line({"ports": [one.lasting for one in ports], "board": asdict(board), "lidar": lidar})
    else:
        data(f"board     version {board.version or '?'}, car type {board.car_type or '?'} on {port}")
        data(f"battery   {board.volts:.1f} V" if board.volts else "battery   not told")
        data(f"reports   {board.reports} in {CHECK_S:g} s")
        data(f"servos    {', '.join(map(str, board.servos)) if board.servos else 'none answered'}")
        if lidar is not None:
            data(f"lidar     {lidar}")
    if robot is not None and robot.board is not None and board.car_type not in (None, robot.board.car_type):
        say(f"sayso: the board takes itself for car type {board.car_type}; robot.model says {robot.board.car_type}.")
    if not board.reports:
        raise DeviceError(f"{port} is open, but no Rosmaster board reports there.", hint="Is the robot switched on?")
    return int(ExitCode.DONE)


def _ros_check(settings: Settings, *, json: bool) -> int:
    """What comes from a robot of ROS 2. Raises ``UsageError`` or ``DeviceError``."""
    from engine.robot.bodies import description_of
    from engine.robot.ros2.inspection import inspect
    from engine.ros.opening import open_door

    about = description_of(settings.robot).ros
    assert about is not None, "this kind has them"
    door = open_door(settings.robot.door or "")
    try:
        found = inspect(door, about, LIDAR_S)
    finally:
        door.close()
    if json:
        json_line(asdict(found))
    for topic in () if json else found.heard:
        data(f"heard     {topic}")
    for topic in () if json else found.silent:
        data(f"silent    {topic}")
    if found.trouble:
        raise DeviceError(f"Nothing can be heard: {found.trouble}.", hint="Is the robot on, and the way to it open?")
    return int(ExitCode.DONE if about.odometry in found.heard else ExitCode.MISSING)


def robot_estop(*, pressed: bool) -> int:
    """Press the emergency stop of every sayso of this user, also of those that are started later, or release it."""
    from config import paths
    from engine.parts.estop import write
    from tui.commands.settings import make_state_folder

    make_state_folder()
    try:
        write(paths().estop, pressed)
    except OSError as error:
        raise StorageError(f"{paths().estop} cannot be changed: {error.strerror}.") from error
    if pressed:
        say("sayso: the emergency stop is pressed. Nothing moves until `sayso robot release`.")
    else:
        say("sayso: the emergency stop is released. Nothing goes on by itself.")
    return int(ExitCode.DONE)


def robot_emulate(
    settings: Settings,
    name: str | None,
    port: Path | None,
    *,
    lidar: Path | None = None,
    stops_after: float | None = None,
    pull: float = 0.0,
    json: bool = False,
) -> int:
    """A board on a pseudo-terminal with the simulated robot behind it, until Ctrl-C; at ``lidar`` another one, with its
    lidar. What goes wrong comes on stdin."""
    from engine.robot.description import described
    from engine.robot.emulation.board import EmulatedBoard
    from engine.robot.emulation.lidar import EmulatedLidar
    from engine.robot.emulation.line import COMMANDS, Line
    from engine.robot.emulation.line import run as run_line
    from engine.robot.sim.scene_file import load_scene, scene_path
    from engine.robot.sim.simulated import SimulatedBody
    from engine.skills.places import Places

    model = name or (settings.robot.made_as if settings.robot.kind == "rosmaster" else "x3plus")
    description = described(model)
    if description.board is None:
        raise UsageError(f"{model!r} has no board to emulate.", hint="`sayso robot list` shows which have.")
    if lidar is not None and description.lidar is None:
        raise UsageError(f"{model!r} has no lidar to emulate.", hint="`sayso robot list` shows which have.")
    scene = load_scene(scene_path(settings.robot.scene))
    body = SimulatedBody(scene, settings.robot, pictures=False)
    places = Places(settings.places)
    known = description.dock is not None and description.dock in places.names()
    dock = places.pose(places.symbol(description.dock or "")) if known else None
    board = EmulatedBoard(body, description, stops_after=stops_after, pull=pull, dock=dock)
    line, eyes = Line((port or Path("board")).absolute()), None
    where = f"--set robot.port={line.path}"
    if lidar is not None and description.lidar is not None:
        eyes = Line(lidar.absolute()), EmulatedLidar(body, description.lidar)
        where += f" --set robot.lidar={eyes[0].path}"
    say(f"sayso: an emulated {description.name} in {scene.name}; drive it from another terminal:")
    say(f"  sayso --set robot.kind=rosmaster --set robot.model={model} {where}")
    say(f"On stdin it takes: {'; '.join(COMMANDS)}.")
    run_line(line, board, _Stdin(), _Shown(json=json).show, eyes)
    return int(ExitCode.DONE)


def _lidar_sees(settings: Settings, robot: Description) -> str | None:
    """What a person can compare with what stands around the robot; None where it has no lidar. Raises
    ``UsageError``."""
    from engine.robot.usb_lidar import UsbLidar, in_words

    if robot.lidar is None or settings.robot.lidar is None:
        return None
    lidar = UsbLidar(settings.robot.lidar, robot.lidar, robot.hull)
    try:
        until = time.monotonic() + LIDAR_S
        while (turn := lidar.newest()) is None and time.monotonic() < until:
            time.sleep(0.05)
        return lidar.trouble or "silent" if turn is None else in_words(turn.points)
    finally:
        lidar.close()


class _Stdin:
    """Lines of stdin, as they come. When stdin ends, the board stays."""

    def __init__(self) -> None:
        self._held = b""
        self._fd = os.dup(0)

    def fileno(self) -> int:
        return self._fd

    def lines(self) -> list[str] | None:
        piece = os.read(self._fd, 4096)
        if not piece:
            os.close(self._fd)
            self._fd, _ = os.pipe()  # from which nothing ever comes
            return []
        *lines, self._held = (self._held + piece).split(b"\n")
        return [line.decode(errors="replace") for line in lines]


class _Shown:
    """States on stdout: all of them as JSON lines, or one line for people when something changes."""

    def __init__(self, *, json: bool) -> None:
        self._json = json
        self._last = ""

    def show(self, state: BoardState) -> None:
        if self._json:
            if select.select([], [1], [], 0)[1]:  # a reader who does not read must not hold up the board
                print(json.dumps({**asdict(state), "at": time.monotonic()}), flush=True)  # noqa: T201
            return
        told = state.told
        line = (
            f"({state.x:6.2f}, {state.y:6.2f}) {heading_in_degrees(state.yaw):3.0f}°"
            f"   told {told.vx:5.2f} {told.vy:5.2f} m/s {math.degrees(told.wz):4.0f}°/s"
            f"   arm {' '.join(f'{joint:5.2f}' for joint in state.joints)}   {state.volts:.1f} V"
        )
        if line != self._last and sys.stdout.isatty():
            print(f"\r{line}", end="", flush=True)  # noqa: T201
        self._last = line


def _facts(robot: Description) -> dict[str, Any]:
    return {
        "title": robot.name,
        "kind": robot.kind,
        "drive": robot.drive,
        "has": sorted(robot.capabilities),
        "lidar": robot.lidar is not None,
    }


def _parts(robot: Description) -> list[str]:
    parts: list[str] = [robot.drive]
    parts += ["arm"] if robot.arm is not None else []
    parts += [f"camera {_camera(robot)}"] if robot.camera is not None else []
    parts += ["lidar"] if robot.lidar else []
    parts.append({"sim": "simulated", "rosmaster": "Rosmaster board", "ros2": "ROS 2"}[robot.kind])
    return parts


def _lidar(lidar: LidarOf, ros: RosOf | None) -> str:
    if ros is not None:
        return f"on {ros.scan}"
    return lidar.model or "simulated"


def _eye_height(robot: Description) -> float:
    """How far the camera is above the floor, m, with the arm as it looks ahead."""
    from engine.perception.looking import LOOK_POSES

    assert robot.camera is not None, "whoever asks knows that there is one"
    mount = robot.arm_model.camera(LOOK_POSES["AHEAD"].joints) if robot.camera.on_arm else robot.camera.mount
    return float(mount.position[2])


def _camera(robot: Description) -> str:
    if robot.camera is None:
        return "none"
    if robot.camera.depth:
        return "with depth"
    return "colour only: it follows lines and tags, and finds no things"
