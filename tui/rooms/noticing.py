"""Tells people when a device is lost or found again: what that means, and what still works.

What happened stands in the log in any case; a notification is for whoever looks at something else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from textual.notifications import Notification, Notify

from engine.events import Log
from tui.shown.devices import Devices, News
from tui.words import strings
from tui.words.hints import hint_line

if TYPE_CHECKING:
    from textual.timer import Timer

    from engine.handle import PartStatus
    from tui.stage import Stage

NOTICE_S: Final = 8.0
"""How long a notification stands."""


class Noticing:
    """Follows the parts of the engine. In the UI thread."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._devices = Devices()
        self._parts: Sequence[PartStatus] = ()
        self._boxes: dict[str, Notification] = {}  # what was told of each device last
        self._again: Timer | None = None

    def look(self, parts: Sequence[PartStatus]) -> None:
        """So the parts are doing now."""
        self._parts = parts
        self._tell(self._devices.look(parts, self._stage.clock()))

    def hear(self, line: Log) -> None:
        """A line of the log."""
        self._tell(self._devices.hear(line, self._stage.clock()))

    def _reaching(self, action: str) -> str | None:
        """The key that leads to this action, now or after a step back."""
        return self._stage.reaching(action) if self._stage.possible(action) else None

    def _tell(self, news: Sequence[News]) -> None:
        stage = self._stage
        for one in news:
            words = hint_line((strings.DEVICE_BACK if one.there else strings.DEVICE_GONE)[one.device], self._reaching)
            if one.times > 1:
                words = f"{words} {strings.DEVICE_LOOSE.format(times=one.times)}"
            box = Notification(
                f"{'✓' if one.there else '!'} {words}",
                severity="information" if one.there else "warning",
                timeout=NOTICE_S,
                markup=False,
            )
            if (before := self._boxes.pop(one.device, None)) is not None:  # which is true no more
                stage.call_later(stage.withdraw, before)  # behind the message that brings it
            self._boxes[one.device] = box
            stage.post_message(Notify(box))
        if self._again is not None:
            self._again.stop()
            self._again = None
        if (due := self._devices.due(stage.clock())) is not None:
            self._again = stage.set_timer(due, lambda: self.look(self._parts))
