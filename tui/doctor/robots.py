"""What the doctor finds of a robot: its board, or what comes from a graph of ROS 2. Nothing moves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from config.schema import Settings
from engine.errors import SaysoError
from tui.doctor.finding import Finding

if TYPE_CHECKING:
    from engine.robot.description import RosOf

BOARD_S: Final = 1.0
"""How long a motor board is listened to, s."""
ROS_S: Final = 4.0
"""In which every topic of a robot of ROS 2 must have been heard, s."""
CLOCKS_S: Final = 2.0
"""By so much two clocks may be apart."""


def robot(settings: Settings) -> Finding:
    """The board is asked what it is; nothing moves."""
    from engine.robot.bodies import description_of
    from engine.robot.rosmaster.inspection import inspect

    chosen = settings.robot
    if chosen.kind == "sim":
        return Finding("robot", "ok", "simulated (robot.kind)")
    if chosen.emulated:
        return Finding("robot", "ok", "an emulated board, in the robot's own process (robot.port)")
    try:
        description = description_of(chosen)
        if description.ros is not None:
            return _ros_robot(description.name, chosen.door or "", description.ros)
        assert chosen.port is not None, "the configuration sees to that"
        found = inspect(chosen.port, BOARD_S)
    except SaysoError as error:
        return Finding("robot", "missing", error.message, error.hint, needed=True)
    if not found.reports:
        detail = f"{chosen.port} is open, but no Rosmaster board reports there"
        return Finding("robot", "missing", detail, "Is the robot switched on?", needed=True)
    board = description.board
    assert board is not None, "this kind has one"
    detail = f"{description.name} on {chosen.port}, version {found.version or '?'}, {found.volts:.1f} V"
    if found.car_type not in (None, board.car_type):
        fix = f"robot.model is {chosen.made_as}; is it the right one?"
        return Finding("robot", "limited", f"the board takes itself for car type {found.car_type}", fix)
    if found.volts and found.volts < board.battery.low:
        return Finding("robot", "limited", f"the battery is low: {found.volts:.1f} V", "Charge it.")
    if board.stops_by_itself is None:
        fix = "sayso doctor --wheels-up, with the wheels off the floor"
        return Finding(
            "robot", "limited", "nobody knows whether the board stops by itself when the line falls silent", fix
        )
    return Finding("robot", "ok", detail)


def _ros_robot(name: str, url: str, about: RosOf) -> Finding:
    """Its topics are listened to."""
    from engine.robot.ros2.inspection import inspect
    from engine.ros.opening import open_door

    door = open_door(url)
    try:
        found = inspect(door, about, ROS_S)
    finally:
        door.close()
    if found.trouble:
        fix = "Does it run, and is robot.door right?"
        return Finding("robot", "missing", found.trouble, fix, needed=True)
    if found.mismatched:
        name, how = next(iter(found.mismatched.items()))
        fix = "Put the definition that your robot has into ros2/ of the configuration folder (docs/ros2.md)."
        return Finding("robot", "missing", f"{name} is of another type there: {how}", fix, needed=True)
    fix = "Put the topics of your robot into ros: of its description."
    if about.odometry in found.silent:
        return Finding("robot", "missing", f"no odometry comes on {about.odometry}", fix, needed=True)
    if found.silent:
        return Finding("robot", "limited", f"nothing comes on {', '.join(found.silent)}", fix)
    if found.ahead_s is not None and abs(found.ahead_s) > CLOCKS_S:
        seconds = abs(round(found.ahead_s))
        ahead = f"the robot's clock is {seconds} s ahead of ours"
        apart = ahead if found.ahead_s > 0 else f"the robot's clock is {seconds} s behind ours"
        return Finding("robot", "limited", apart, "Set both by the same server (NTP), or what is seen goes astray.")
    return Finding("robot", "ok", f"{name} at {url}")


def ros_graph(settings: Settings) -> Finding:
    """The way to it is tried; nothing is said there."""
    from engine.ros.opening import open_door, wait_for

    if settings.ros.door is None:
        return Finding("ROS graph", "ok", "none (ros.door)")
    try:
        door = open_door(settings.ros.door, "sayso_doctor")
    except SaysoError as error:
        return Finding("ROS graph", "missing", error.message, error.hint)
    try:
        trouble = wait_for(door, ROS_S)
    finally:
        door.close()
    if trouble:
        return Finding("ROS graph", "missing", trouble, "Is ros.door right, and does what it leads to run?")
    return Finding("ROS graph", "ok", settings.ros.door)
