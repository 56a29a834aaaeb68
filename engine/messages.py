"""How messages travel between the engine and the children that it starts: MessagePack, with its length before it."""

from __future__ import annotations

from typing import Final

import msgspec

LENGTH_BYTES: Final = 4
"""The length before each message, little-endian."""


def packed(message: msgspec.Struct) -> bytes:
    """A message as it travels."""
    data = msgspec.msgpack.encode(message)
    return len(data).to_bytes(LENGTH_BYTES, "little") + data
