"""The doors there are, by how a setting writes them. Only the one that is asked for is loaded."""

from __future__ import annotations

import time
from typing import Final
from urllib.parse import urlsplit

from config import paths
from engine.errors import UsageError
from engine.ros.door import Door

FORMS: Final = "ws://HOST:PORT of a rosbridge, zenoh://HOST:PORT[/DOMAIN] of a zenoh router, or rclpy"
"""What a setting may say, in words for people."""
ZENOH_PORT: Final = 7447
LOOK_S: Final = 0.02
"""Between two looks whether a door is open."""


def open_door(door: str, name: str = "sayso") -> Door:
    """The door that a setting names, opening in the background; ``name`` is that of our node. Raises ``UsageError``."""
    if door == "rclpy":
        from engine.ros.rclpy.door import RclpyDoor

        return RclpyDoor(name)
    try:
        parts = urlsplit(door)
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    if parts.scheme in ("ws", "wss") and parts.hostname:
        from engine.ros.rosbridge.door import Rosbridge

        return Rosbridge(door)
    domain = parts.path.strip("/") or "0"
    if parts.scheme == "zenoh" and parts.hostname and domain.isdecimal():
        from engine.ros.zenoh.door import ZenohDoor

        host = f"[{parts.hostname}]" if ":" in parts.hostname else parts.hostname
        mine = paths().config / "ros2"
        folders = [mine] if mine.is_dir() else []
        return ZenohDoor(f"tcp/{host}:{port or ZENOH_PORT}", int(domain), definitions=folders, name=name)
    raise UsageError(f"{door!r} leads to no graph of ROS 2.", hint=f"It may be {FORMS}.")


def wait_for(door: Door, seconds: float) -> str:
    """Wait so long at most until a door is open: its trouble then, empty where it is. For commands that people type."""
    until = time.monotonic() + seconds
    while (trouble := door.trouble) and time.monotonic() < until:
        time.sleep(LOOK_S)
    return trouble
