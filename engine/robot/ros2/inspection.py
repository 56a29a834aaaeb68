"""What answers behind a door, without moving anything: for people who set a robot up."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from engine.robot.description import RosOf
from engine.robot.ros2 import messages
from engine.ros.door import Door, Message


@dataclass(frozen=True, slots=True)
class Found:
    """What was heard."""

    trouble: str
    """Why the door is shut; empty where it is open."""
    heard: tuple[str, ...]
    silent: tuple[str, ...]
    """Topics of the description on which nothing came."""
    mismatched: Mapping[str, str] = field(default_factory=dict)
    """What a peer means another type by, and which, in words; by topic."""
    ahead_s: float | None = None
    """By how much the robot's clock is ahead of ours, s; None where nothing told its time."""


def inspect(door: Door, about: RosOf, seconds: float) -> Found:
    """Listen for so long at most; the door stays open."""
    topics = [(about.odometry, messages.ODOMETRY), (about.scan, messages.SCAN), (about.battery, messages.BATTERY)]
    wanted = {topic: type for topic, type in topics if topic is not None}
    heard: set[str] = set()
    ahead: list[float] = []
    more = threading.Event()

    def take(topic: str, message: Message) -> None:
        heard.add(topic)
        if (stamp := messages.stamp(message)) is not None:
            ahead.append(stamp - time.time())
        more.set()

    for topic, type in wanted.items():
        door.subscribe(topic, type, partial(take, topic))
    until = time.monotonic() + seconds
    while heard < wanted.keys() and (left := until - time.monotonic()) > 0:
        more.wait(left)
        more.clear()
    silent = tuple(sorted(wanted.keys() - heard))
    return Found(door.trouble, tuple(sorted(heard)), silent, dict(door.mismatches()), max(ahead, default=None))
