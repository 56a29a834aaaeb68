"""Tells people who look at something else that a long task has ended: a desktop notification and the bell.

The terminal shows the notification, wherever it is. Most take OSC 9 (iTerm2), some OSC 777 (rxvt) instead; those that
know neither ignore it. Whether somebody looks at this terminal is told by its focus reports (xterm, DEC mode 1004).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from tui.shown.facts import printable
from tui.words import strings
from tui.words.language import told

if TYPE_CHECKING:
    from tui.shown.model import ConsoleModel
    from tui.stage import Stage

LONG_S: Final = 20.0
"""A task that took longer is long."""
_LONGEST: Final = 120
"""Characters of a notification."""
_OSC_777: Final = ("rxvt", "foot", "xterm-ghostty")
"""How TERM begins of terminals that take OSC 777."""


class Alerting:
    """Follows whether a task is under way, in event time. In the UI thread."""

    def __init__(self, stage: Stage) -> None:
        self.on = True
        """Somebody wants to be told."""
        self.looked_at: bool | None = None
        """Whether the terminal has the keyboard; None: it has not reported that."""
        self._stage = stage
        self._began: float | None = None  # s

    def look(self, model: ConsoleModel) -> None:
        """So things are now."""
        if model.busy or model.waiting:
            self._began = model.t if self._began is None else self._began
            return
        began, self._began = self._began, None
        if began is not None and model.t - began > LONG_S and self.on and not self.looked_at:
            self._tell(model)

    def _tell(self, model: ConsoleModel) -> None:
        turn = model.turns.kept[-1] if model.turns.kept else None
        result = turn.result if turn is not None else None
        asked = turn.heard.text if turn is not None and turn.heard is not None else ""
        outcome = strings.OUTCOMES[result.outcome] if result is not None else strings.OUTCOMES["interrupted"]
        words = strings.COLON.join(filter(None, (asked, outcome, told(result.message) if result is not None else "")))
        stage = self._stage
        if stage.terminal is not None:
            stage.terminal.write(notification(printable(words)[:_LONGEST], os.environ))
        stage.bell()


def notification(text: str, environ: Mapping[str, str]) -> str:
    """What has a terminal show this on the desktop."""
    text = text.replace(";", ",")  # which parts the arguments of both
    if environ.get("TERM", "").startswith(_OSC_777):
        return f"\x1b]777;notify;{strings.NAME};{text}\x07"
    return f"\x1b]9;{strings.NAME}: {text}\x07"
