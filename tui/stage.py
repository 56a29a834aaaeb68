"""What the rooms of the console stand on: engine, main screen, clock and keys, and how to say and show something.

The console itself (``tui.app``) is the stage with all its rooms.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Literal

from textual.app import App
from textual.driver import Driver

from engine.commands import Command, Interrupt
from engine.errors import SaysoError
from tui.keys.keys import all_shown
from tui.messages import Failed
from tui.screens.console import ConsoleScreen
from tui.shown.view import View
from tui.shown.watchdog import SILENT_S
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
        self.shown_keys = all_shown(keys)
        """The keys in use by action id, as people read them."""
        self.handle: EngineHandle | None = None
        """The engine, once it is there."""
        self.offer: Offer | None = None
        """What can be asked of it."""
        self.main = ConsoleScreen(self.shown_keys, one_line=one_line)

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

    def come_back(self) -> None:
        """To the main screen, which shows what has happened in the meantime."""
        if self.screen is not self.main:
            self.pop_screen()
            self.main.show(self.shown)
            self.redraw()

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
