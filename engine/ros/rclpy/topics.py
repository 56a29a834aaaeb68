"""Topics over rclpy. Everything in here is touched in the loop's thread only."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from engine.ros.door import Message, Take
from engine.ros.rclpy.loop import Loop
from engine.ros.rclpy.messages import to_mapping, to_message

DEPTH: Final = 10
"""Messages of one topic that may wait."""
DEEP: Final = 1000
"""The same where every one counts."""
FOUND_S: Final = 1.0
"""In which a subscriber has found a new publisher, if there is one."""


class Publisher:
    """Publishes on one topic, reliably. What comes in its first moment has to wait until a subscriber has found it:
    what is published before that reaches nobody."""

    def __init__(self, loop: Loop, topic: str, type: Any, ready: Callable[[], object]) -> None:
        from rclpy.event_handler import PublisherEventCallbacks  # type: ignore[import-not-found]

        self._type, self._tell = type, ready
        self.ready = False
        self._publisher = loop.node.create_publisher(
            type, topic, DEPTH, event_callbacks=PublisherEventCallbacks(matched=lambda info: self._found())
        )
        loop.later(FOUND_S, self._found)

    def publish(self, message: Message) -> None:
        """Raises BadTypeError."""
        self._publisher.publish(to_message(self._type, message))

    def wait(self, seconds: float) -> None:
        """Until every subscriber has what was published, but no longer than that."""
        from rclpy.duration import Duration  # type: ignore[import-not-found]

        self._publisher.wait_for_all_acked(Duration(seconds=max(0.0, seconds)))

    def _found(self) -> None:
        if not self.ready:
            self.ready = True
            self._tell()


@dataclass(frozen=True, slots=True)
class How:
    """How a topic is listened to; see :meth:`engine.ros.door.Door.subscribe`."""

    every_s: float
    latched: bool
    every: bool


def subscribe(loop: Loop, topic: str, type: Any, take: Take, how: How, unfit: Callable[[], object]) -> Any:
    """A subscription. It is best effort, which hears every publisher; one that latches, or of which every message
    counts, is reliable, and ``unfit`` is told where a publisher is not."""
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.qos import (  # type: ignore[import-not-found]
        DurabilityPolicy,
        QoSProfile,
        ReliabilityPolicy,
    )
    from rclpy.serialization import deserialize_message  # type: ignore[import-not-found]

    due = 0.0

    def taken(message: Any) -> None:
        loop.call(take, to_mapping(message))

    def taken_raw(octets: bytes) -> None:
        """One that comes too soon is not even read."""
        nonlocal due
        if (now := time.monotonic()) >= due:
            due = now + how.every_s
            taken(deserialize_message(octets, type))

    qos = QoSProfile(
        depth=DEEP if how.every else DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if how.latched or how.every else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if how.latched else DurabilityPolicy.VOLATILE,
    )
    told = taken_raw if how.every_s else taken
    callbacks = SubscriptionEventCallbacks(incompatible_qos=lambda info: unfit())
    return loop.node.create_subscription(type, topic, told, qos, raw=bool(how.every_s), event_callbacks=callbacks)
