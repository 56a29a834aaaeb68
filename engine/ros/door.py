"""What every door to a ROS 2 graph can do. Messages are plain mappings, as rosbridge writes them in JSON: fields by
name, nested messages as mappings, arrays as lists.

Nothing here blocks, and a door that is shut is no error of whoever uses it: what is published meanwhile is dropped but
for the newest of each topic, and subscriptions hold when it opens again. ``trouble`` tells.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

Message = Mapping[str, Any]
Take = Callable[[Message], object]
"""Gets a message, in the door's own thread: it must not block, and raises nothing."""


class Door(Protocol):
    """A way into one graph. Thread-safe."""

    @property
    def trouble(self) -> str:
        """Why nothing passes now, in words for people; empty where it does."""
        ...

    def publish(self, topic: str, type: str, message: Message) -> None:
        """Publish soon; of two that have not gone out yet on one topic, only the newer one does."""
        ...

    def subscribe(self, topic: str, type: str, take: Take, *, every_s: float = 0.0) -> None:
        """Have every message of a topic, but no more than one in ``every_s``."""
        ...

    def close(self) -> None:
        """Shut it; what was published has gone out, if it can within a moment."""
        ...
