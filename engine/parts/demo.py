"""The demo: somebody who wakes the robot whenever it has been idle for a while, and says the next demo command.

Waking by hand works too: then the demo speaks into that wake.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from engine.commands import Command, Wake
from engine.events import Event, StateChanged, WakeHeard

PAUSE_S = 3.0
"""How long the robot is left alone between two commands."""


class Demo:
    """Subscribe :meth:`see` to the bus, in the engine's loop; ``speak`` says the next demo command, and ``send`` gives
    commands to the session."""

    def __init__(self, speak: Callable[[], object], send: Callable[[Command], None]) -> None:
        self._speak = speak
        self._send = send
        self._loop = asyncio.get_running_loop()
        self._next = self._loop.call_later(PAUSE_S, self._wake)

    def see(self, event: Event) -> None:
        """Speak into every wake; plan the next one when the robot comes to rest, and drop it when it is used."""
        match event.body:
            case WakeHeard():
                self._speak()
            case StateChanged(state="IDLE" | "WAITING"):
                self._next.cancel()
                self._next = self._loop.call_later(PAUSE_S, self._wake)
            case StateChanged():
                self._next.cancel()

    def close(self) -> None:
        """No more wakes."""
        self._next.cancel()

    def _wake(self) -> None:
        self._send(Wake("demo"))
