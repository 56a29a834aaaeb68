"""The log: what the engine's parts say about themselves."""

from __future__ import annotations

from typing import Final

from textual.content import Content

from tui.shown.facts import LogLine
from tui.shown.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines
from tui.words import strings
from tui.words.language import told

_SIGNS: Final = {
    "debug": ("·", "$foreground 40%"),
    "info": ("·", "$foreground 60%"),
    "warning": ("▲", "$text-warning"),
    "error": ("✗", "$text-error"),
}


class LogView(Lines[LogLine]):
    """Log lines, oldest first."""

    def update_from(self, model: ConsoleModel) -> None:
        self.show(model.log)

    def drawn(self, item: LogLine) -> Drawn:
        sign, style = _SIGNS[item.level]
        gutter = Content.assemble((f"{item.t:8.2f} ", "$foreground 60%"), (f"{sign} ", style))
        source = strings.SOURCES.get(item.source, item.source)
        body = Content.assemble((f"{source} ", "$foreground 60%"), (told(item.message), "$foreground 80%"))
        return Drawn(gutter, body)
