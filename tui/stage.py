"""What the rooms of the console stand on: engine, main screen, clock and keys, and how to say and show something.

The console itself (``tui.app``) is the stage with all its rooms.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Literal

from textual.app import App
from textual.driver import Driver
from textual.screen import Screen

from engine.commands import Command, Interrupt
from engine.errors import SaysoError
from tui.keys.keys import EVERYWHERE, all_shown, command_in_line, hinted, shown
from tui.messages import Failed
from tui.screens.console import ConsoleScreen
from tui.shown.view import View
from tui.shown.watchdog import SILENT_S
from tui.widgets.text_line import TextLine
from tui.words import strings

if TYPE_CHECKING:
    from engine.handle import EngineHandle
    from engine.offer import Offer


class Stage(App[None]):
    """A Textual application with one main screen, over which others come and go."""

    def __init__(
        self, keys: Mapping[str, str], clock: Callable[[], float] = time.monotonic, *, one_line: bool = False
    ) -> None:
        """``keys`` are those in use by action id; ``clock`` is monotonic seconds; ``one_line``: the main screen is a
        line."""
        super().__init__()
        self.clock = clock
        self.keys = dict(keys)
        """The keys in use by action id, several separated by commas, as Textual spells them."""
        self.shown_keys = hinted(keys)
        """The first key of each action, as people read it in a hint."""
        self.listed_keys = all_shown(keys)
        """All keys of each action, as people read them in a list."""
        self.handle: EngineHandle | None = None
        """The engine, once it is there."""
        self.offer: Offer | None = None
        """What can be asked of it."""
        self.main = ConsoleScreen(self.shown_keys, self.command_in_line, one_line=one_line)

    def command_in_line(self, key: str) -> str:
        """The action of this key in an empty line."""
        return command_in_line(key, self.keys)

    def use_keys(self, keys: Mapping[str, str]) -> None:
        """These are in use from now on, or have other names."""
        self.keys |= keys
        self.shown_keys |= hinted(self.keys)
        self.listed_keys |= all_shown(self.keys)

    @property
    def shown(self) -> View:
        """What is on the screen."""
        raise NotImplementedError

    def redraw(self) -> None:
        """Something has changed: draw as soon as the pace allows."""
        raise NotImplementedError

    def note(self, level: Literal["info", "warning", "error"], text: str) -> None:
        """A line in the log that the console itself has to tell."""
        raise NotImplementedError

    def redraw_later(self) -> None:
        """Panes have another size: some show more where they have more room."""
        self.call_after_refresh(self.redraw)

    def remark(self, text: str) -> None:
        """Something that stands in the status line for a while."""
        raise NotImplementedError

    def draw(self) -> None:
        """Bring what is on the screen up to date at once."""
        raise NotImplementedError

    def open_page(self, page: Screen[None]) -> None:
        """Put a page on top, with the keys that are true there."""
        self.push_screen(page)
        self.draw()

    def step_back(self) -> None:
        """Leave the page on top; what is below it shows what has happened in the meantime."""
        self.pop_screen()
        self.draw()

    def come_back(self) -> None:
        """To the main screen, whatever is on top of it."""
        while self.screen is not self.main:
            self.step_back()

    @property
    def typing(self) -> bool:
        """Somebody types: letters are text."""
        return isinstance(self.focused, TextLine)

    def acting(self, action: str) -> str | None:
        """The first key of the action that acts where the keyboard is, as people read it; None: none does."""
        line, everywhere = self.focused, action in EVERYWHERE
        for key in self.keys[action].split(","):
            if not isinstance(line, TextLine) or everywhere or line.acts(key):
                return shown(key)
        return None

    def reaching(self, action: str) -> str:
        """The key that does this where the keyboard is; where it is text, the one that goes back first."""
        return self.acting(action) or f"{self.shown_keys['back_typing']} {self.shown_keys[action]}"

    @property
    def terminal(self) -> Driver | None:
        """What reads from the terminal and writes to it."""
        return self._driver

    @property
    def engine_hangs(self) -> bool:
        """The engine is there and does not answer; whoever waits for it waits for ever."""
        return self.handle is not None and self.handle.pulse() > SILENT_S

    def send(self, command: Command) -> None:
        """Thread-safe. An interrupting command has stopped the robot when this returns."""
        if self.handle is None:
            return
        try:
            self.handle.send(command)
        except SaysoError as error:
            self.post_message(Failed(error, strings.SOMETHING_FAILED, fatal=False))

    def interrupt(self) -> None:
        """Stop the robot for whoever has pressed no key of the keyboard: that has stopped it already."""
        if not self.is_headless:
            self.send(Interrupt())
