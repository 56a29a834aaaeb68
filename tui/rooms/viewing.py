"""What the camera sees, while somebody looks and the line to the terminal bears it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from rich.console import RenderableType
from textual.screen import Screen

from engine.errors import SaysoError
from tui.graphics.asking import Asking, GraphicsChoice
from tui.messages import Seen
from tui.rooms.sending import Sending
from tui.shown.facts import printable
from tui.terminal.driver import AnsweringDriver
from tui.terminal.feed import Feed
from tui.terminal.link import Fare
from tui.terminal.spans import regions
from tui.terminal.terminal import cell_here
from tui.words import strings

if TYPE_CHECKING:
    from engine.perception.sighting import Sight
    from tui.graphics.surface import Surface
    from tui.stage import Stage


class Viewing:
    """The camera's pane. In the UI thread."""

    def __init__(self, stage: Stage, sending: Sending) -> None:
        self._stage = stage
        self._sending = sending
        self._feed = Feed(stage, self._ask)
        self._choice: GraphicsChoice = "blocks"
        self._asking: Asking | None = None  # the terminal, what graphics it has
        self._surface: Surface | None = None  # where it has some

    @property
    def _terminal(self) -> AnsweringDriver | None:
        """The one that can be asked, if there is one."""
        driver = self._stage.terminal
        return driver if isinstance(driver, AnsweringDriver) else None

    def choose(self, choice: GraphicsChoice) -> None:
        """Draw pictures like this."""
        self._choice = choice
        if self._stage.main.camera_shown:
            self._look_for_graphics()

    def show(self, shown: bool) -> None:
        """Show what it sees, or no more."""
        self._stage.main.show_camera(shown)
        if shown:
            self._look_for_graphics()
        if not shown:
            self._feed.close()
        elif self._stage.handle is not None:
            self._feed.open()

    def begin(self) -> None:
        """The engine is there: somebody may be looking already."""
        if self._stage.main.camera_shown:
            self._feed.open()

    def seen(self, found: Sight | SaysoError) -> None:
        """A picture that was asked for, or why there is none."""
        sent = 0
        if isinstance(found, SaysoError):
            self._stage.main.show_no_sight(printable(found.message))
        elif self._feed.on:
            sent = self._stage.main.show_sight(found)
        self._feed.drawn(sent)

    def answered(self, answer: str) -> None:
        """The terminal says what it can do."""
        if self._asking is None or self._asking.over:
            return
        self._ask_terminal(self._asking.answered(answer))

    def send(self, screen: Screen[Any], frame: RenderableType) -> None:
        """A frame of text was sent: send the picture behind it."""
        stage, surface, terminal = self._stage, self._surface, self._terminal
        if surface is None or terminal is None:
            return
        place = stage.main.camera.place() if screen is stage.main and stage.main.camera.surface is surface else None
        if behind := surface.behind(place, regions(frame)):
            terminal.write(behind)

    def pace(self, least: float) -> None:
        """So many seconds at least between two pictures."""
        self._feed.least = least

    def hurry(self) -> None:
        """Something moves."""
        self._feed.hurry()

    def spare(self, fare: Fare) -> None:
        """Pictures are what costs a line most: fewer of them, or none."""
        main = self._stage.main
        self._feed.sparing = fare != "full"
        if self._choice == "auto":
            self._look_for_graphics()
            main.camera.draw_on(self._surface if fare == "full" else None)
        if not main.camera_shown or self._stage.handle is None:
            return
        if fare == "bare":
            self._feed.close()
            main.show_no_sight(strings.CAMERA_SPARED)
        elif not self._feed.on:
            self._feed.open()

    def _look_for_graphics(self) -> None:
        """Once, when somebody looks; over a bad line only what somebody has chosen."""
        stage = self._stage
        if self._asking is not None or self._choice == "blocks" or self._terminal is None:
            return
        if not stage.main.camera_shown or (self._choice == "auto" and self._sending.fare != "full"):
            return
        self._asking = Asking(self._choice, os.environ, cell_here())
        self._ask_terminal(self._asking.begin())

    def _ask_terminal(self, question: str) -> None:
        """What is to be asked next; once that is nothing, use what was found."""
        stage, asking, terminal = self._stage, self._asking, self._terminal
        if asking is None or terminal is None:
            return
        if question:
            terminal.ask(question)
        if not asking.over:
            return
        if asking.found is not None:
            from tui.graphics.surface import Surface  # which other terminals do without

            self._surface = Surface(asking.found)
            terminal.farewell = self._surface.gone()
            stage.main.camera.draw_on(self._surface)
        elif self._choice == "sixel":
            stage.note("warning", strings.NO_CELL_SIZE)

    def _ask(self) -> None:
        """Of the engine, for a picture; while another page covers it, nobody looks."""
        stage = self._stage
        if not stage.screen_stack:  # the console is being left
            return
        if stage.handle is None or stage.screen is not stage.main:
            self._feed.drawn(0)
            return
        stage.handle.look(lambda found: stage.post_message(Seen(found)))
