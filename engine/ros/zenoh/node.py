"""Our node in a ROS 2 graph over zenoh: its session, what it has announced, and how its messages are written."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import UsageError
from engine.ros.door_thread import DoorThread
from engine.ros.interfaces.cdr import Codec
from engine.ros.interfaces.definitions import Definitions
from engine.ros.zenoh.graph import Tokens
from engine.ros.zenoh.wire import Attachment, Endpoint, Entity, Kind, Qos, gid, ros_name

if TYPE_CHECKING:
    from zenoh import Session


@dataclass(slots=True)
class Announced:
    """Something of ours that all peers know of, as long as this is kept."""

    entity: Entity
    gid: bytes
    token: Any
    """Of zenoh's, to take it back."""
    _numbers: Any

    def attachment(self) -> bytes:
        """Of the next message."""
        return Attachment(next(self._numbers), time.time_ns(), self.gid).pack()


class Node:
    """What publishers, subscriptions, clients and servers of one door share. Thread-safe."""

    def __init__(self, domain: int, name: str, definitions: Sequence[Path], thread: DoorThread) -> None:
        """Raises DeviceError where rosbags is not installed."""
        self.domain = domain
        self.name = name
        self.definitions = Definitions(definitions)
        self.codec = Codec(self.definitions)
        self.thread = thread
        self.tokens = Tokens()
        self.complaints: dict[str, str] = {}
        """What cannot work, by topic, service or action, in words."""
        self.session: Session | None = None
        """None until it has been opened for the first time."""
        self._lock = threading.Lock()
        self._ids = itertools.count(1)
        self._announced: dict[int, Entity] = {}

    def opened(self, session: Session) -> None:
        """Announce the node itself."""
        self.session = session
        self._token = session.liveliness().declare_token(self._entity("NN", 0, None, Qos()).token())

    def endpoint(self, name: str, type: str) -> Endpoint | None:
        """How a topic or a service is named on the wire; None, and a complaint, where it cannot be."""
        try:
            endpoint = Endpoint(ros_name(name), type, self.definitions.hash(type))
        except (UsageError, ValueError) as error:
            self.complaints[name] = str(error)
            return None
        self.complaints.pop(name, None)
        return endpoint

    def announce(self, kind: Kind, endpoint: Endpoint, qos: Qos) -> Announced:
        """Tell all peers of it. There must be a session."""
        assert self.session is not None
        with self._lock:
            id = next(self._ids)
            entity = self._entity(kind, id, endpoint, qos)
            self._announced[id] = entity
        token = self.session.liveliness().declare_token(entity.token())
        return Announced(entity, gid(entity.token()), token, itertools.count(1))

    def withdraw(self, announced: Announced) -> None:
        """Tell all peers that it is there no more."""
        with self._lock:
            self._announced.pop(announced.entity.id, None)
        announced.token.undeclare()

    def mismatches(self) -> dict[str, str]:
        """By topic, service or action: why it cannot work, in words."""
        with self._lock:
            ours = list(self._announced.values())
        return {**self.complaints, **self.tokens.mismatches(ours)}

    def _entity(self, kind: Kind, id: int, endpoint: Endpoint | None, qos: Qos) -> Entity:
        assert self.session is not None
        return Entity(self.domain, str(self.session.zid()), 0, id, kind, self.name, endpoint, qos)
