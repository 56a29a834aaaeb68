"""The event bus: the one place where events get their number and their time.

Publishing is thread-safe and synchronous: when :meth:`Bus.publish` returns, every subscriber (the event log first)
has the event, in the same order for all. An event that a subscriber publishes while it is called follows the one it
is called with. Subscribers must be quick and must not raise; one that does is dropped, and the failure is published.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

from ulid import ULID

from engine.clock import Clock, iso_utc
from engine.events import Body, ErrorRaised, Event

Subscriber = Callable[[Event], None]


class Emit(Protocol):
    """Publish a body in the context (turn, epoch) that this callable is bound to."""

    def __call__(self, body: Body, /) -> Event: ...


class Bus:
    """Stamps events and hands them to all subscribers."""

    def __init__(self, clock: Clock, *, session: str | None = None) -> None:
        self.session = session or str(ULID())
        self._clock = clock
        self._origin = clock.now()
        self._lock = threading.RLock()  # re-entrant: subscribers may publish, and failing ones are reported here
        self._seq = 0
        self._waiting: deque[Event] = deque()
        self._delivering = False
        self._subscribers: list[Subscriber] = []

    def subscribe(self, subscriber: Subscriber) -> Callable[[], None]:
        """Add a subscriber; the returned callable removes it again."""
        with self._lock:
            self._subscribers.append(subscriber)

        def unsubscribe() -> None:
            with self._lock:
                if subscriber in self._subscribers:
                    self._subscribers.remove(subscriber)

        return unsubscribe

    def publish(self, body: Body, *, turn: str | None = None, epoch: int = 0) -> Event:
        """Number, stamp and deliver ``body``; safe from any thread."""
        with self._lock:
            self._seq += 1
            event = Event(
                seq=self._seq,
                t=self._clock.now() - self._origin,
                wall=iso_utc(self._clock.wall()),
                session=self.session,
                turn=turn,
                epoch=epoch,
                body=body,
            )
            self._waiting.append(event)
            if not self._delivering:  # else the loop below, further up this thread's stack, comes to it
                self._delivering = True
                try:
                    while self._waiting:
                        self._deliver(self._waiting.popleft())
                finally:
                    self._delivering = False
            return event

    def _deliver(self, event: Event) -> None:
        for subscriber in tuple(self._subscribers):
            try:
                subscriber(event)
            except Exception as error:  # noqa: BLE001 - a broken listener must not stop the robot's bookkeeping
                if subscriber in self._subscribers:  # it may have left before it failed
                    self._subscribers.remove(subscriber)
                message = f"A listener of events failed and was dropped: {error!r}"
                self.publish(ErrorRaised("subscriber_failed", message), turn=event.turn, epoch=event.epoch)

    def bound(self, *, turn: str | None, epoch: int) -> Emit:
        """A publisher whose events carry this turn and epoch."""

        def emit(body: Body, /) -> Event:
            return self.publish(body, turn=turn, epoch=epoch)

        return emit
