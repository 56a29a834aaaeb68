"""The line to type in, with the memory of a shell."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.message import Message
from textual.widgets import Input, Static

from tui import strings

_MAX_HISTORY = 200


class Ask(Input):
    """Sends what was typed; up and down recall it. Enter on an empty line leaves."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "recall(-1)", show=False),
        Binding("down", "recall(1)", show=False),
    ]

    class Asked(Message):
        """Somebody typed a request."""

        def __init__(self, text: str) -> None:
            super().__init__()
            self.text = text

    def __init__(self) -> None:
        super().__init__(placeholder=strings.PLACEHOLDER, compact=True, max_length=1000)
        self.cursor_blink = False  # a blinking cursor is traffic while nothing happens
        self._history: list[str] = []
        self._at = 0  # place in the history; its length stands for the line being written
        self._draft = ""

    async def action_submit(self) -> None:
        text = self.value.strip()
        if not text:
            self.screen.set_focus(None)
            return
        if not self._history or self._history[-1] != text:
            self._history = [*self._history[1 - _MAX_HISTORY :], text]
        self._at, self._draft = len(self._history), ""
        self.value = ""
        self.post_message(self.Asked(text))

    def action_recall(self, step: int) -> None:
        """Go back (−1) or forth (1) in what was sent; what was being written is kept."""
        if self._at == len(self._history):
            self._draft = self.value
        self._at = max(0, min(len(self._history), self._at + step))
        self.value = self._draft if self._at == len(self._history) else self._history[self._at]
        self.cursor_position = len(self.value)

    def _on_focus(self, event: events.Focus) -> None:
        super()._on_focus(event)
        self.placeholder = strings.PLACEHOLDER_TYPING

    def _on_blur(self, event: events.Blur) -> None:
        super()._on_blur(event)
        self.placeholder = strings.PLACEHOLDER


class AskLine(Horizontal):
    """The prompt sign and the line."""

    def __init__(self) -> None:
        super().__init__()
        self._ask = Ask()

    def compose(self) -> ComposeResult:
        yield Static(" › ", id="prompt", markup=False)
        yield self._ask

    def begin(self) -> None:
        """Put the focus where one types."""
        # At once, where focus() would wait for its turn: keys that were typed ahead must not be taken for commands.
        self.screen.set_focus(self._ask)
