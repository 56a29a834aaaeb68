"""Pictures of the camera, one after another while somebody looks, and none otherwise.

The next picture is asked for when the last one has been drawn, so nothing piles up on a slow line or in a busy engine.
How long to wait before that is decided by what the last one cost: a view that changes as a whole is shown less often,
one in which nothing changes hardly ever, until something moves again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from textual.message_pump import MessagePump
from textual.timer import Timer

FASTEST_S: Final = 0.2
"""Between two pictures at least, s: each takes the camera and perception some time, too."""
CALM_S: Final = 2.0
"""Between two pictures of which the second showed nothing new, s."""
BYTES_PER_S: Final = 15_000
"""What pictures may cost the line."""
SPARE_BYTES_PER_S: Final = 3_000
"""What they may cost a slow one."""


def pause(sent: int, last: float, *, sparing: bool = False) -> float:
    """Seconds to wait after a picture that cost ``sent`` bytes, when the pause before it was ``last``; longer on a line
    that is to be spared."""
    if sent == 0:
        return min(CALM_S, 2 * max(FASTEST_S, last))
    return max(FASTEST_S, sent / (SPARE_BYTES_PER_S if sparing else BYTES_PER_S))


class Feed:
    """Calls ``ask`` for each picture; whoever gets it tells :meth:`drawn`. All in the UI thread."""

    def __init__(self, owner: MessagePump, ask: Callable[[], None]) -> None:
        self._owner = owner
        self._ask = ask
        self._timer: Timer | None = None
        self._pause = FASTEST_S
        self._asked = False  # a picture is on its way
        self.on = False
        self.sparing = False  # the line is slow
        self.least = FASTEST_S
        """Between two pictures at least, s."""

    def open(self) -> None:
        """Somebody looks."""
        self.on = True
        self._pause = FASTEST_S
        self._next()

    def close(self) -> None:
        """Nobody looks any more."""
        self.on = False
        self._halt()

    def drawn(self, sent: int) -> None:
        """The picture has come and is drawn, which sent so many bytes."""
        self._asked = False
        if self.on:
            self._halt()
            self._pause = max(self.least, pause(sent, self._pause, sparing=self.sparing))
            self._timer = self._owner.set_timer(self._pause, self._next)

    def hurry(self) -> None:
        """Something moves: what shows nothing new now may do so soon."""
        if self.on and not self._asked and self._pause >= CALM_S:
            self._pause = FASTEST_S
            self._next()

    def _next(self) -> None:
        self._halt()
        if self.on and not self._asked:
            self._asked = True
            self._ask()

    def _halt(self) -> None:
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.stop()
