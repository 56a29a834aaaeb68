"""Who holds which of the robot's capabilities, so that two actions never use the same one.

An action takes all that it occupies at once, or waits; those who wait are served in the order in which they came, as
far as what they want is free. Every invocation gets a :class:`Hold` of its own, and releasing is by that token: an
invocation that was cut off and ends late cannot release what somebody else holds by then. A new epoch revokes every
older hold, because nothing of an older epoch can move the robot any more.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable

from engine.robot.robot import Capability


class Hold:
    """The token of one invocation; compared by identity."""

    __slots__ = ("capabilities", "epoch")

    def __init__(self, capabilities: Iterable[Capability], epoch: int) -> None:
        self.capabilities = frozenset(capabilities)
        self.epoch = epoch


class Holds:
    """All holds on one robot. Belongs to one asyncio loop."""

    def __init__(self) -> None:
        self._holders: dict[Capability, Hold] = {}
        self._waiting: dict[Hold, asyncio.Future[None]] = {}  # in the order of arrival

    def holder(self, capability: Capability) -> Hold | None:
        """Who holds ``capability`` now."""
        return self._holders.get(capability)

    async def acquire(self, capabilities: Iterable[Capability], epoch: int) -> Hold:
        """Wait until all ``capabilities`` are free and take them. Holds of an older epoch are in nobody's way: they are
        revoked, and whoever waited for one returns without holding anything."""
        self._revoke_before(epoch)
        hold = Hold(capabilities, epoch)
        self._waiting[hold] = granted = asyncio.get_running_loop().create_future()
        self._grant()
        try:
            await granted
        except asyncio.CancelledError:
            self.release(hold)  # it may have been granted in the same moment
            raise
        return hold

    def release(self, hold: Hold) -> None:
        """Give back what ``hold`` still holds; a stale one holds nothing, so that this does nothing."""
        self._waiting.pop(hold, None)
        for capability in hold.capabilities:
            if self._holders.get(capability) is hold:
                del self._holders[capability]
        self._grant()

    def _grant(self) -> None:
        wanted: set[Capability] = set()  # by those who came earlier and still wait
        for hold, granted in list(self._waiting.items()):
            if hold.capabilities & (self._holders.keys() | wanted):
                wanted |= hold.capabilities
                continue
            del self._waiting[hold]
            self._holders.update(dict.fromkeys(hold.capabilities, hold))
            if not granted.done():
                granted.set_result(None)

    def _revoke_before(self, epoch: int) -> None:
        self._holders = {capability: hold for capability, hold in self._holders.items() if hold.epoch >= epoch}
        for hold in [hold for hold in self._waiting if hold.epoch < epoch]:  # it wakes up with nothing in its hands
            granted = self._waiting.pop(hold)
            if not granted.done():
                granted.set_result(None)
