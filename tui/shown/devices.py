"""Devices that are lost and found again, told from how the parts of the engine are doing.

A part that was there and is not any more is news, and so is one that comes back; one that has never been there is not,
and neither is one that loads. A plug that is loose is told once, with a count.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from msgspec import Struct

from engine.events import Log

if TYPE_CHECKING:
    from typing import Literal

    from engine.handle import PartName, PartStatus

    Device = PartName | Literal["satellite", "service"]

QUIET_S: Final = 5.0
"""Between two pieces of news of one device at least, s."""
_RESTARTS: Final = frozenset({"robot", "camera"})
"""Parts that load again when they were lost, and are not there meanwhile."""
_PLATFORM: Final = {" is asked instead.": False, " answers again.": True}
"""How sentences of the log end that say that another model is asked than before, or the first one again."""


class News(Struct, frozen=True):
    """A device is there again, or no longer. ``times``: how often it came or went since the last news of it."""

    device: Device
    there: bool
    times: int = 1


class _Known(Struct):
    there: bool
    device: Device
    times: int = 0
    quiet_until: float = float("-inf")


class Devices:
    """What is known of devices, and when that was told last. Time is any clock's, s."""

    def __init__(self) -> None:
        self._known: dict[str, _Known] = {}

    def look(self, parts: Sequence[PartStatus], now: float) -> tuple[News, ...]:
        """Take notice of how the parts are, and say what is news."""
        for part in parts:
            known = self._known.get(part.name)
            there = part.state == "ready"
            if part.state == "loading" and (known is None or part.name not in _RESTARTS):
                continue
            self._is(part.name, there, "satellite" if _is_satellite(part) else part.name)
        return self._news(now)

    def hear(self, line: Log, now: float) -> tuple[News, ...]:
        """Take notice of a line of the log: how services are doing stands nowhere else."""
        if line.source == "model":
            for ending, there in _PLATFORM.items():
                if line.message.endswith(ending):
                    if "service" not in self._known:
                        self._known["service"] = _Known(True, "service")
                    self._is("service", there, "service")
        return self._news(now)

    def _is(self, name: str, there: bool, device: Device) -> None:
        known = self._known.setdefault(name, _Known(there, device))
        if there != known.there:
            known.there = there
            known.times += 1
        if there:  # what is lost was what was there
            known.device = device

    def _news(self, now: float) -> tuple[News, ...]:
        news = []
        for known in self._known.values():
            if known.times and now >= known.quiet_until:
                news.append(News(known.device, known.there, known.times))
                known.times, known.quiet_until = 0, now + QUIET_S
        return tuple(news)

    def due(self, now: float) -> float | None:
        """Seconds until there is something to tell that has to wait; None: nothing waits."""
        return min((known.quiet_until - now for known in self._known.values() if known.times), default=None)


def _is_satellite(part: PartStatus) -> bool:
    return part.name == "microphone" and "satellite" in part.detail.casefold()
