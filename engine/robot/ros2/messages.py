"""The messages of a robot's base, as doors pass them (:mod:`engine.ros.door`): units are those of ROS (REP 103), which
are ours too. What a peer sends is checked: a message that makes no sense is none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.description import RosOf
from engine.robot.geometry import Pose, Twist

TWIST: Final = "geometry_msgs/msg/Twist"
TWIST_STAMPED: Final = "geometry_msgs/msg/TwistStamped"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
TF: Final = "tf2_msgs/msg/TFMessage"
SCAN: Final = "sensor_msgs/msg/LaserScan"
BATTERY: Final = "sensor_msgs/msg/BatteryState"
_MOST_RAYS: Final = 100_000


def twist_message(twist: Twist) -> dict[str, Any]:
    """A ``Twist``."""
    return {
        "linear": {"x": twist.vx, "y": twist.vy, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": twist.wz},
    }


def velocity_type(about: RosOf) -> str:
    """What the robot is told velocities by."""
    return TWIST_STAMPED if about.stamped else TWIST


def velocity(twist: Twist, about: RosOf, now: float) -> dict[str, Any]:
    """The message that tells it one; ``now`` is in s since 1970."""
    message = twist_message(twist)
    return stamped(message, about.frame, now) if about.stamped else message


def stamped(message: Mapping[str, Any], frame: str, now: float) -> dict[str, Any]:
    """A ``TwistStamped`` of ``now``, s since 1970."""
    seconds = math.floor(now)
    stamp = {"sec": seconds, "nanosec": int((now - seconds) * 1e9)}
    return {"header": {"stamp": stamp, "frame_id": frame}, "twist": dict(message)}


def odometry(message: Mapping[str, Any]) -> tuple[Pose, Twist] | None:
    """Pose in the odometry's frame and velocity in the base frame, of an ``Odometry``; None where it makes no sense."""
    try:
        pose, twist = message["pose"]["pose"], message["twist"]["twist"]
        position = pose["position"]
        found = (float(position["x"]), float(position["y"]), _yaw(pose["orientation"]))
        moves = (float(twist["linear"]["x"]), float(twist["linear"]["y"]), float(twist["angular"]["z"]))
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    if not all(math.isfinite(value) for value in (*found, *moves)):
        return None
    return Pose(*found), Twist(*moves)


def frame(message: Mapping[str, Any]) -> str:
    """The frame of a message that has a header, without the slash of old; empty where it tells none."""
    header = message.get("header")
    found = header.get("frame_id") if isinstance(header, Mapping) else None
    return found.removeprefix("/") if isinstance(found, str) else ""


def stamp(message: Mapping[str, Any]) -> float | None:
    """When a message was stamped, s since 1970; None where it tells no time, or the first second of it."""
    try:
        told = message["header"]["stamp"]
        found = float(told["sec"]) + 1e-9 * float(told["nanosec"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return found if math.isfinite(found) and found > 1 else None


def transforms(message: Mapping[str, Any]) -> list[tuple[str, str, Pose]]:
    """What a ``TFMessage`` says: frames, and where the second one is in the first, on the floor."""
    found = []
    several = message.get("transforms")
    for one in several if isinstance(several, Sequence) else ():
        if (read := _transform(one)) is not None:
            found.append(read)
    return found


def _transform(one: Any) -> tuple[str, str, Pose] | None:
    try:
        parent, child = frame(one), one["child_frame_id"].removeprefix("/")
        moved, turn = one["transform"]["translation"], one["transform"]["rotation"]
        pose = Pose(float(moved["x"]), float(moved["y"]), _yaw(turn))
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
        return None
    return (parent, child, pose) if all(map(math.isfinite, (pose.x, pose.y, pose.yaw))) else None


def _yaw(turn: Mapping[str, Any]) -> float:
    """Of a quaternion, rad; nan where it is none."""
    x, y, z, w = (float(turn[name]) for name in "xyzw")
    if not abs(x * x + y * y + z * z + w * w - 1) < 0.1:
        return math.nan
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def scan_points(message: Mapping[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """The hits of a ``LaserScan`` in the scanner's frame, shape (n, 2), m, and how long after the first ray each was
    measured, s; None where it makes no sense."""
    try:
        first, step = float(message["angle_min"]), float(message["angle_increment"])
        low, most = float(message["range_min"]), message["range_max"]
        high = math.inf if most is None else float(most)  # a bridge has no word for infinity
        took = float(message.get("time_increment") or 0.0)
        ranges = np.array([math.nan if r is None else r for r in message["ranges"]], dtype=np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    known = all(math.isfinite(value) for value in (first, step, low, took)) and high > 0
    if not known or ranges.ndim != 1 or len(ranges) > _MOST_RAYS:
        return None
    ray = np.flatnonzero((ranges >= low) & (ranges <= high) & np.isfinite(ranges))
    angles, away = first + step * ray, ranges[ray]
    after: NDArray[np.float64] = took * ray.astype(np.float64)
    return np.column_stack((np.cos(angles), np.sin(angles))) * away[:, None], after


def volts(message: Mapping[str, Any]) -> float | None:
    """What a ``BatteryState`` says that the battery gives, V."""
    try:
        found = float(message["voltage"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return found if math.isfinite(found) and found > 0 else None
