"""How rmw_zenoh_cpp writes a ROS 2 graph into zenoh: keys, liveliness tokens and attachments.

A topic or a service is a key ``<domain>/<name>/<type>/<hash>``. Whatever takes part in it declares a liveliness token,
whose key says all about it; the tokens of all peers are the graph. Every message has an attachment that tells its
number, its time and its publisher. (Sources: docs/design.md, liveliness_utils.cpp, qos.cpp and attachment_helpers.cpp
of ros2/rmw_zenoh, as released for Jazzy since 0.2.4.)
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from engine.ros.zenoh.xxh3 import xxh3_128

SPACE: Final = "@ros2_lv"
"""Where all tokens are."""
Kind = Literal["NN", "MP", "MS", "SS", "SC"]
"""A node, a publisher, a subscription, a service's server, and its client."""
KINDS: Final[tuple[Kind, ...]] = ("NN", "MP", "MS", "SS", "SC")

_SLASH: Final = "%"  # what stands for a slash in one part of a key
_DEPTH: Final = 42  # that a token leaves out
_NAME: Final = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_TYPE: Final = re.compile(r"[A-Za-z]\w*/(msg|srv|action)/[A-Za-z]\w*", re.ASCII)
_DDS: Final = re.compile(r"([A-Za-z]\w*)::(msg|srv|action)::dds_::([A-Za-z]\w*)_", re.ASCII)
_ATTACHMENT: Final = struct.Struct("<qqB16s")


@dataclass(frozen=True, slots=True)
class Qos:
    """What a token tells of how messages are handed over; deadlines and the like are never set here."""

    depth: int = 10
    """How many messages are kept."""
    reliable: bool = True
    latched: bool = False
    """Transient local: who comes later gets the last messages, too."""

    def __str__(self) -> str:
        reliability = "" if self.reliable else "2"
        durability = "1" if self.latched else ""
        depth = "" if self.depth == _DEPTH else str(self.depth)
        return f"{reliability}:{durability}:,{depth}:,:,:,,"

    @classmethod
    def parse(cls, text: str) -> Qos:
        """Raises ValueError."""
        reliability, durability, history, *_ = text.split(":")
        depth = history.split(",")[1]
        return cls(int(depth) if depth else _DEPTH, reliability != "2", durability == "1")


LATCHED: Final = Qos(1, latched=True)
"""Of a map, or of the states of goals."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Something that takes part in a topic or a service."""

    name: str
    """With a slash in front, such as ``/cmd_vel``."""
    type: str
    """Such as ``geometry_msgs/msg/Twist``."""
    hash: str

    def key(self, domain: int) -> str:
        """The key that its messages have."""
        return f"{domain}/{self.name.strip('/')}/{dds_type(self.type)}/{self.hash}"


@dataclass(frozen=True, slots=True)
class Entity:
    """What one liveliness token says."""

    domain: int
    session: str
    """Id of the zenoh session."""
    node_id: int
    id: int
    """Within the session; a node has its ``node_id``."""
    kind: Kind
    node: str
    endpoint: Endpoint | None = None
    """Of everything but a node."""
    qos: Qos = Qos()
    namespace: str = "/"
    enclave: str = "/"

    def token(self) -> str:
        """The key of its token."""
        names = (_mangled(name) for name in (self.enclave, self.namespace, self.node))
        parts = [SPACE, self.domain, self.session, self.node_id, self.id, self.kind, *names]
        if self.endpoint is not None:
            found = self.endpoint
            parts += [_mangled(found.name), dds_type(found.type), found.hash, str(self.qos)]
        return "/".join(str(part) for part in parts)

    @classmethod
    def parse(cls, token: str) -> Entity | None:
        """What a token says; None where it says nothing that makes sense. Parts that a later release adds are ignored,
        and so is a type that has no name in ROS."""
        parts = token.split("/")
        if len(parts) < 9 or parts[0] != SPACE or parts[5] not in KINDS:
            return None
        _, domain, session, node_id, id, kind, *names = parts
        try:
            endpoint, qos = None, Qos()
            if kind != "NN":
                name, type, hash, quality = names[3:7]
                endpoint = Endpoint(_plain(name), ros_type(_plain(type)), _plain(hash))
                qos = Qos.parse(quality)
            enclave, namespace, node = (_plain(name) for name in names[:3])
            at = (int(domain), session, int(node_id), int(id))
            return cls(*at, kind, node, endpoint, qos, namespace, enclave)  # type: ignore[arg-type]
        except (ValueError, IndexError):
            return None


class Attachment(NamedTuple):
    """What comes with each message, request and response."""

    number: int
    """From 1, of its publisher; that of a response is that of its request."""
    stamp: int
    """ns since 1970, when it was sent."""
    gid: bytes
    """Of the publisher or client: 16 bytes. A response has that of its request."""

    def pack(self) -> bytes:
        """As the serializer of zenoh-ext writes it: the length of the id is before it."""
        return _ATTACHMENT.pack(self.number, self.stamp, len(self.gid), self.gid)

    @classmethod
    def parse(cls, data: bytes) -> Attachment:
        """Raises ValueError."""
        if len(data) != _ATTACHMENT.size or data[16] != 16:
            raise ValueError("not the attachment of a message of ROS 2")
        number, stamp, _, gid = _ATTACHMENT.unpack(data)
        return cls(number, stamp, gid)


def gid(token: str) -> bytes:
    """The id of what a token announces, 16 bytes."""
    return struct.pack("<QQ", *xxh3_128(token.encode()))


def tokens(domain: int) -> str:
    """The key of all tokens of a domain."""
    return f"{SPACE}/{domain}/**"


def ros_name(name: str) -> str:
    """The name of a topic, service or action with a slash in front. Raises ValueError where it can be none."""
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is no name in ROS 2")
    return name if name.startswith("/") else f"/{name}"


def dds_type(type: str) -> str:
    """``std_msgs/msg/String`` as ``std_msgs::msg::dds_::String_``."""
    if not _TYPE.fullmatch(type):
        raise ValueError(f"{type!r} is no type in ROS 2, such as std_msgs/msg/String")
    package, kind, name = type.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def ros_type(type: str) -> str:
    """``std_msgs::msg::dds_::String_`` as ``std_msgs/msg/String``."""
    if (found := _DDS.fullmatch(type)) is None:
        raise ValueError(f"{type!r} is no type of ROS 2 by its name in DDS")
    return "/".join(found.groups())


def _mangled(name: str) -> str:
    return name.replace("/", _SLASH)


def _plain(part: str) -> str:
    return part.replace(_SLASH, "/")
