"""A panel over the console: what is under it goes on, is seen around it, and every key of the console that is not typed
acts: above all the one that stops the robot, which closes the panel as well."""

from __future__ import annotations

from textual import events
from textual.containers import Vertical
from textual.content import Content

from tui.words.hints import EDGES, Acting, hint_line

COLUMNS = 84
"""At most so wide."""
_EDGE = 4
"""Columns of the console that stay in sight, both sides together."""


class Over(Vertical):
    """Closes when the keyboard goes elsewhere."""

    DEFAULT_CSS = """
    Over {
        position: absolute;
        layer: over;
        height: auto;
        max-height: 80%;
        border: round $primary;
        border-title-color: $text-primary;
        border-title-style: bold;
        border-subtitle-color: $text-muted;
        background: $surface;
        padding: 0 1;
    }
    """

    @property
    def columns(self) -> int:
        """Of the panel with its border."""
        return max(20, min(COLUMNS, self.screen.size.width - _EDGE))

    def on_mount(self) -> None:
        self._place()

    def __init__(self, acting: Acting) -> None:
        """``acting`` says which keys act now."""
        super().__init__()
        self._acting = acting

    @property
    def hints(self) -> str:
        """What to press, for people, with the actions in place of their keys."""
        raise NotImplementedError

    def hint(self) -> None:
        """Say what to press."""
        words = hint_line(self.hints, self._acting, self.columns - EDGES, last=2)
        if str(self.border_subtitle or "") != words:  # another one repaints the frame
            self.border_subtitle = Content(words)

    def place(self) -> None:
        """The terminal has another size."""
        self._place()

    def _place(self) -> None:
        self.styles.width = self.columns
        self.hint()
        self.styles.offset = ((self.screen.size.width - self.columns) // 2, 1)

    def on_descendant_blur(self, event: events.DescendantBlur) -> None:
        self.call_later(self._close_when_left)

    def _close_when_left(self) -> None:
        focused = self.screen.focused
        if self.is_attached and (focused is None or self not in focused.ancestors):
            self.remove()
