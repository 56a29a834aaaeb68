"""A line to type in, as all lines of the console are: backspace edits, and on an empty line goes back.

A key that is held down is sent again and again. Whoever clears a line like that must not leave it as well, for what is
typed next would be taken for commands: a run of backspaces that began in a text ends at its beginning. A pause ends
the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Final, Protocol, cast

from textual import events
from textual.binding import Binding, BindingType
from textual.keys import key_to_character
from textual.message import Message
from textual.widgets import Input

from tui.keys.keys import PUNCTUATION
from tui.words import strings

RUN_S: Final = 0.7
"""A key that is held down is sent again after less than this: the first time after 0.66 s, as X servers do, or less."""

Commands = Callable[[str], str]
"""The action of the console that a key does in the empty line; empty: none, it is text."""


class Clocked(Protocol):
    """The application, as far as a line needs it."""

    clock: Callable[[], float]
    """Monotonic seconds."""


def is_text(key: str) -> bool:
    """Whether the key of this name is typed."""
    character = key_to_character(key)
    return key in PUNCTUATION.values() or (character is not None and character.isprintable())


class TextLine(Input):
    """``commands`` says which keys act while nothing is written; usually none does."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "backspace", show=False),
        Binding("enter", "submit", show=False, id="send"),
    ]

    class Commanded(Message):
        """A key in the empty line does this action of the console."""

        def __init__(self, action: str) -> None:
            super().__init__()
            self.action = action

    class Turned(Message):
        """The line is empty now, or no more."""

    def __init__(self, value: str = "", *, commands: Commands = lambda key: "", **more: Any) -> None:
        super().__init__(value, compact=True, **more)
        self.cursor_blink = False  # a blinking cursor is traffic while nothing happens
        self._commands = commands
        self._was_empty = not value
        self._erased = -math.inf  # when the newest backspace came of a run that had something to take away, s
        self._run_ended = False  # that run has taken all away

    def command(self, key: str) -> str:
        """The action of the console that this key does here; empty: none, it is text."""
        return "" if self.value else self._commands(key)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Textual would scroll by keys that others have: one line has nothing to scroll."""
        return action not in ("scroll_up", "scroll_down") and super().check_action(action, parameters)

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """As if it took none. Textual would leave actions out by their usual keys, also where somebody chose a key that
        is not typed; and a key that is typed has been taken before anything that is bound to it is looked for."""
        return False

    async def _on_key(self, event: events.Key) -> None:
        """As Textual's, which sees a key before anything that is bound to it."""
        if event.key != "backspace":
            self._erased = -math.inf
        if action := self.command(event.key):
            event.stop()
            event.prevent_default()
            self.app.post_message(self.Commanded(action))  # which may take this line away: nobody waits for that here
            return
        await super()._on_key(event)

    def _on_paste(self, event: events.Paste) -> None:
        """As Textual's, which would take the first one of several lines and lose the others."""
        if len([line for line in event.text.splitlines() if line.strip()]) > 1:
            event.stop()
            event.prevent_default()
            self.app.notify(strings.PASTED_LINES, severity="warning", markup=False)

    async def action_backspace(self) -> None:
        """Take the character before the cursor away; where there is no text at all, go back."""
        now = cast("Clocked", self.app).clock()
        runs = now - self._erased <= RUN_S
        if runs and self._run_ended:  # what has come into the line since was not written when it began
            self._erased = now
        elif self.value or runs:
            self._erased = now
            self.action_delete_left()
            self._run_ended = not self.value
        else:
            await self.app.run_action("app.back")

    def on_input_changed(self, event: Input.Changed) -> None:
        """Some keys act in an empty line only."""
        if bool(event.value) is self._was_empty:
            self._was_empty = not event.value
            self.post_message(self.Turned())
