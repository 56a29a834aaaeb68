"""Topics of a ROS 2 graph over zenoh: what we publish, and what we hear."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from engine.ros.door import Message, Take
from engine.ros.interfaces.cdr import BadMessage
from engine.ros.zenoh.node import Announced, Node
from engine.ros.zenoh.wire import LATCHED, Attachment, Endpoint, Qos

if TYPE_CHECKING:
    from zenoh import Sample, Session

BACKLOG: Final = 1000
"""Messages of a topic that wait for a reader that is too slow; older ones are dropped."""

_HEARTBEAT_S: Final = 0.5  # in which a subscriber notices that it lost the last message of a latched topic


@dataclass(slots=True)
class _Publisher:
    announced: Announced
    put: Any  # of zenoh's publisher
    lock: threading.Lock  # numbers go out in order


class Topics:
    """Thread-safe."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._publishers: dict[tuple[str, str], _Publisher] = {}  # by topic and type
        self._advertised: list[tuple[str, str, bool]] = []
        self._heard: dict[str, _Subscription] = {}

    def publish(self, topic: str, type: str, message: Message, latched: bool) -> None:
        """Send it, if anybody listens. There must be a session."""
        import zenoh

        publisher = self._publishers.get((topic, type)) or self._publisher(topic, type, latched)
        if publisher is None:
            return
        try:
            data = self._node.codec.encode(type, message)
        except BadMessage as error:
            self._node.complaints[topic] = f"a message of ours cannot be sent: {error}"
            return
        with publisher.lock, contextlib.suppress(zenoh.ZError):  # the session has been closed
            publisher.put(data, attachment=publisher.announced.attachment())

    def advertise(self, topic: str, type: str, latched: bool) -> None:
        """Tell peers that it will be published; in the door's thread."""
        self._advertised.append((topic, type, latched))
        if self._node.session is not None:
            self._publisher(topic, type, latched)

    def subscribe(self, topic: str, type: str, take: Take, every_s: float, latched: bool) -> None:
        """Hear a topic from now on, and no more through what it was heard with before; in the door's thread."""
        if (before := self._heard.pop(topic, None)) is not None:
            before.close()
        if (endpoint := self._node.endpoint(topic, type)) is None:
            return
        self._heard[topic] = subscription = _Subscription(self._node, endpoint, take, every_s, latched)
        if self._node.session is not None:
            subscription.open(self._node.session)

    def opened(self, session: Session) -> None:
        """Hear all topics, and advertise what is to be advertised."""
        for topic, type, latched in self._advertised:
            self._publisher(topic, type, latched)
        for subscription in self._heard.values():
            subscription.open(session)

    def _publisher(self, topic: str, type: str, latched: bool) -> _Publisher | None:
        import zenoh
        import zenoh.ext

        if (endpoint := self._node.endpoint(topic, type)) is None:
            return None
        with self._lock:
            if (topic, type) not in self._publishers:
                session = self._node.session
                assert session is not None
                key, drop = endpoint.key(self._node.domain), zenoh.CongestionControl.DROP
                publisher: Any
                if latched:
                    publisher = zenoh.ext.declare_advanced_publisher(
                        session,
                        key,
                        congestion_control=drop,
                        cache=zenoh.ext.CacheConfig(LATCHED.depth),
                        sample_miss_detection=zenoh.ext.MissDetectionConfig(
                            heartbeat=None, sporadic_heartbeat=_HEARTBEAT_S
                        ),
                        publisher_detection=True,
                    )
                else:
                    publisher = session.declare_publisher(key, congestion_control=drop)
                announced = self._node.announce("MP", endpoint, LATCHED if latched else Qos())
                self._publishers[topic, type] = _Publisher(announced, publisher.put, threading.Lock())
        return self._publishers[topic, type]


class _Subscription:
    """One topic that is heard. All but :meth:`_arrive` runs in the door's thread."""

    def __init__(self, node: Node, endpoint: Endpoint, take: Take, every_s: float, latched: bool) -> None:
        self._node = node
        self._endpoint = endpoint
        self._take = take
        self._every_s = every_s
        self._latched = latched
        self._waiting: deque[tuple[Any, Any]] = deque(maxlen=1 if every_s else BACKLOG)
        self._is_due = False  # whether somebody will look into what waits
        self._next = 0.0  # when the next message may be handed on
        self._closed = False
        self._subscriber: Any = None
        self._announced: Announced | None = None

    def open(self, session: Session) -> None:
        import zenoh
        import zenoh.ext

        key = self._endpoint.key(self._node.domain)
        callback = zenoh.handlers.Callback(self._arrive)
        if self._latched:
            self._subscriber = zenoh.ext.declare_advanced_subscriber(
                session,
                key,
                callback,
                history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=LATCHED.depth),
                recovery=zenoh.ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
                subscriber_detection=True,
            )
        else:
            self._subscriber = session.declare_subscriber(key, callback)
        self._announced = self._node.announce("MS", self._endpoint, LATCHED if self._latched else Qos())

    def close(self) -> None:
        self._closed = True
        if self._announced is not None:
            self._subscriber.undeclare()
            self._node.withdraw(self._announced)

    def _arrive(self, sample: Sample) -> None:
        """In a thread of zenoh's: as little as possible, for all topics wait."""
        self._waiting.append((sample.payload, sample.attachment))
        if not self._is_due:
            self._is_due = True
            self._node.thread.soon(self._hand_on)

    def _hand_on(self) -> None:
        if self._every_s:
            now = time.monotonic()
            if now < self._next:
                self._node.thread.later(self._next - now, self._hand_on)
                return
            self._next = now + self._every_s
        self._is_due = False  # before the look: what comes during it is due again
        for _ in range(len(self._waiting)):  # and no longer, for other things wait, too
            if self._closed or not self._waiting:
                return
            payload, attachment = self._waiting.popleft()
            try:
                Attachment.parse(attachment.to_bytes() if attachment is not None else b"")
                message = self._node.codec.decode(self._endpoint.type, payload.to_bytes())
            except ValueError:
                continue  # it is no message of ROS 2, whatever it is
            self._take(message)
