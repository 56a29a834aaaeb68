"""What the rooms of the console stand on: engine, main screen, clock and keys, and how to say and show something.

The console itself (``tui.app``) is the stage with all its rooms.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from textual.app import App
from textual.binding import BindingsMap
from textual.dom import DOMNode
from textual.driver import Driver
from textual.notifications import Notification
from textual.screen import Screen
from textual.widget import Widget

from engine.commands import Command, Interrupt
from engine.errors import SaysoError
from tui.keys.keys import BY_ID, EDITING, LINE_KEYS, all_shown, command_in_line, first_shown, shown
from tui.messages import Failed
from tui.screens.console import ConsoleScreen
from tui.shown.view import View
from tui.shown.watchdog import SILENT_S
from tui.widgets.text_line import TextLine, is_text
from tui.words import strings

if TYPE_CHECKING:
    from engine.handle import EngineHandle
    from engine.offer import Offer


class _Bound(NamedTuple):
    """Who is asked about a key while this screen is on top and this part of it has the keyboard."""

    screen: Screen[Any]
    focused: Widget | None
    chain: Sequence[tuple[DOMNode, BindingsMap]]


class Stage(App[None]):
    """A Textual application with one main screen, over which others come and go."""

    def __init__(
        self, keys: Mapping[str, str], clock: Callable[[], float] = time.monotonic, *, one_line: bool = False
    ) -> None:
        """``keys`` are those in use by action id; ``clock`` is monotonic seconds; ``one_line``: the main screen is a
        line."""
        super().__init__()
        self.clock = clock
        self.keys = {key.id: key.key for key in LINE_KEYS} | dict(keys)
        """The keys in use by action id, several separated by commas, as Textual spells them."""
        self.shown_keys = first_shown(self.keys)
        """The first key of each action, as people read it, whether it acts now or not."""
        self.listed_keys = all_shown(keys)
        """All keys of each action, as people read them in a list."""
        self.handle: EngineHandle | None = None
        """The engine, once it is there."""
        self.offer: Offer | None = None
        """What can be asked of it."""
        self._bound: _Bound | None = None
        self.main = ConsoleScreen(self.command_in_line, self.acting, self.reaching, one_line=one_line)

    def command_in_line(self, key: str) -> str:
        """The action of this key in an empty line."""
        return command_in_line(key, self.keys)

    def use_keys(self, keys: Mapping[str, str]) -> None:
        """These are in use from now on, or have other names."""
        self.keys |= keys
        self.shown_keys |= first_shown(self.keys)
        self.listed_keys |= all_shown(self.keys)
        self._bound = None

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

    def remark(self, text: str, *, here: bool = False) -> None:
        """Something that stands in the status line for a while; ``here``: until the keyboard goes elsewhere."""
        raise NotImplementedError

    def moved(self) -> None:
        """The keyboard has gone elsewhere."""
        raise NotImplementedError

    def withdraw(self, box: Notification) -> None:
        """Take a notification away, if it still stands."""
        if box in self._notifications:
            self._unnotify(box)

    def draw(self) -> None:
        """Bring what is on the screen up to date at once."""
        raise NotImplementedError

    def open_page(self, page: Screen[None]) -> None:
        """Put a page on top, with the keys that are true there."""
        self.push_screen(page)
        self.moved()
        self.draw()

    def step_back(self) -> None:
        """Leave the page on top; what is below it shows what has happened in the meantime."""
        self.pop_screen()
        self.moved()
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
        """The first key of the action that acts now, as people read it; None: none does. Every hint on the screen asks
        this. It goes the way that a key goes which is pressed, and what a key would do is asked of the same
        ``check_action`` that Textual asks before it does that: a key that is named acts."""
        if not self.screen_stack:
            return None
        return next((shown(key) for key in self.keys[action].split(",") if self._does(key, action)), None)

    def _does(self, key: str, action: str) -> bool:
        """Whether this key, pressed now, would do something, and this."""
        line, edits = self.focused, False
        if isinstance(line, TextLine):
            if is_text(key):
                does = line.command(key)
                return bool(does) and does == BY_ID[action].action and bool(self._check_action_state(does, self))
            if key == "backspace":
                return action == "back" and not line.value and bool(self._check_action_state("back", self))
            edits = key in EDITING
        for ahead in (True, False):
            if ahead and edits:
                continue
            for node, bindings in reversed(self._chain) if ahead else self._chain:
                for binding in bindings.key_to_bindings.get(key, ()):
                    if binding.priority is not ahead:
                        continue
                    if (state := self._check_action_state(binding.action, node)) is not False:
                        return bool(state) and binding.id == action
        return False

    @property
    def _chain(self) -> Sequence[tuple[DOMNode, BindingsMap]]:
        """Who is asked about a key, from where the keyboard is up to the console. Textual puts that together anew for
        each key, which takes longer than a hint may."""
        screen, focused = self.screen, self.focused
        if self._bound is None or self._bound.screen is not screen or self._bound.focused is not focused:
            self._bound = _Bound(screen, focused, screen._modal_binding_chain)
        return self._bound.chain

    def possible(self, action: str) -> bool:
        """Whether there is anything here by which it could ever act."""
        return True

    def reaching(self, action: str) -> str:
        """The key that does this where the keyboard is; where it is text, the one that goes back first."""
        if (key := self.acting(action)) is not None:
            return key
        leaves = next((key for key in self.keys["back"].split(",") if key not in EDITING and len(key) > 1), "")
        return " ".join((shown(leaves), self.shown_keys[action])).strip()

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
