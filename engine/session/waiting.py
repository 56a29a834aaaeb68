"""What waits until the running turn has ended, in the order in which it will begin.

Requests in words have ids, by which others see, drop and move them; a command to end the session waits unseen and keeps
its place among them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from engine.events import WaitingRequest
from engine.session.inbox import Request


class Waiting:
    """The requests of one session. ``tell`` is told whenever what others see of them has changed."""

    def __init__(self, tell: Callable[[tuple[WaitingRequest, ...]], object]) -> None:
        self._tell = tell
        self._requests: list[Request] = []
        self._told: tuple[WaitingRequest, ...] = ()

    def __len__(self) -> int:
        return len(self._requests)

    def __iter__(self) -> Iterator[Request]:
        """As of now: what is taken out meanwhile comes nevertheless."""
        return iter(tuple(self._requests))

    @property
    def seen(self) -> tuple[WaitingRequest, ...]:
        """What others see of them."""
        return seen(self._requests)

    def find(self, id: str) -> Request | None:
        """The request in words of this id."""
        return next((one for one in self._requests if one.id == id and one.text is not None), None)

    def add(self, requests: Iterable[Request], *, first: bool = False) -> None:
        """Behind all others, or before them."""
        at = 0 if first else len(self._requests)
        self._requests[at:at] = requests
        self._changed()

    def take(self) -> Request:
        """The one whose turn it is."""
        request = self._requests.pop(0)
        self._changed()
        return request

    def remove(self, requests: Iterable[Request]) -> None:
        """Without these."""
        for request in requests:
            self._requests.remove(request)
        self._changed()

    def move(self, request: Request, before: Request | None) -> None:
        """Have a request in words begin before another one, or (None) after all of them."""
        places = [at for at, one in enumerate(self._requests) if one.text is not None]
        order = [self._requests[at] for at in places if self._requests[at] is not request]
        if before is not request:
            order.insert(len(order) if before is None else order.index(before), request)
            for at, one in zip(places, order, strict=True):
                self._requests[at] = one
        self._changed()

    def move_on(self, epoch: int) -> None:
        """They belong to this epoch from now on: what began it has not interrupted them."""
        self._requests = [replace(request, epoch=epoch) for request in self._requests]

    def _changed(self) -> None:
        if (now := self.seen) != self._told:
            self._told = now
            self._tell(now)


def seen(requests: Iterable[Request]) -> tuple[WaitingRequest, ...]:
    """The requests in words among these, for others."""
    return tuple(
        WaitingRequest(request.id, text, request.sent_as) for request in requests if (text := request.text) is not None
    )
