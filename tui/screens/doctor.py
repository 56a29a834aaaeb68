"""What ``sayso doctor`` finds, on a page of its own: each finding as it comes, with a sign, a word and what to do.

The checks run in a thread, one examination at a time; leaving the page ends it after the check that runs.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, ClassVar, Final

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.content import Content
from textual.message import Message
from textual.screen import Screen

from tui.keys.bindings import DOCTOR_BINDINGS
from tui.shown.facts import printable
from tui.widgets.lines import Drawn
from tui.widgets.page import Row
from tui.widgets.status import StatusLine
from tui.widgets.timeline import FromTop
from tui.words import strings
from tui.words.hints import EDGES, Acting, hint_line
from tui.words.language import told
from tui.words.widths import left

if TYPE_CHECKING:
    from tui.doctor.finding import Finding, State
    from tui.shown.view import View

SIGNS: Final[Mapping[State, tuple[str, str]]] = {
    "ok": ("✓", "$text-success"),
    "limited": ("!", "bold $text-warning"),
    "missing": ("✗", "bold $text-error"),
}
_DIM: Final = "$foreground 60%"
_NAMES: Final = 16
"""Columns for what was examined, and a gap."""
_WORDS: Final = 12
"""Columns for the sign and the word of a finding, and a gap."""


class FindingsPage(FromTop[Row]):
    """Findings, each beside its sign."""

    def drawn(self, item: Row) -> Drawn:
        gutter = Content.assemble(*item.aside, (left(item.part, _NAMES), "bold $foreground"))
        indent = " " * (0 if item.aside else _NAMES + _WORDS)
        return Drawn(gutter if item.aside else Content(indent), Content.assemble(*item.body, strip_control_codes=False))


class DoctorScreen(Screen[None]):
    """Not modal, so that every key of the console works here too: above all the one that stops the robot."""

    CSS_PATH = "doctor.tcss"
    AUTO_FOCUS = ""
    place: ClassVar[str] = "doctor"
    BINDINGS: ClassVar[list[BindingType]] = DOCTOR_BINDINGS

    class Found(Message):
        """A check has ended; None: that was the last one."""

        def __init__(self, finding: Finding | None) -> None:
            super().__init__()
            self.finding = finding

    class Begun(Message):
        """This is examined now."""

        def __init__(self, name: str) -> None:
            super().__init__()
            self.name = name

    def __init__(
        self,
        acting: Acting,
        view: View,
        examine: Callable[[Callable[[str], object]], Iterator[Finding]],
    ) -> None:
        """``acting`` says which keys act now. ``examine`` is iterated in a thread, however long that takes, and calls
        what it is given with the name of what it examines next."""
        super().__init__()
        self._acting = acting
        self._view = view
        self._examine = examine
        self._status = StatusLine()
        self._page = FindingsPage(classes="pane")
        self._found: tuple[Finding, ...] = ()
        self.is_examining = False
        """Something is still looked at."""
        self._examined = ""  # at this moment
        self._titles = ("", "")

    def compose(self) -> ComposeResult:
        yield self._status
        yield self._page

    def on_mount(self) -> None:
        self.show(self._view)
        self._title()
        self.begin()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "examine":
            return not self.is_examining or None
        return super().check_action(action, parameters)

    def can_scroll(self, direction: int) -> bool:
        """There is more up (−1) or down (1)."""
        return self._page.can_scroll(direction)

    def action_examine(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Examine everything; nothing happens while that is being done already."""
        if self.is_examining:
            return
        self.is_examining, self._examined, self._found = True, "", ()
        self._page.follow()
        self._draw()
        threading.Thread(target=self._look, name="doctor", daemon=True).start()

    def _look(self) -> None:
        for finding in self._examine(lambda name: self.post_message(self.Begun(name))):
            if not self.is_attached or not self.post_message(self.Found(finding)):
                return  # nobody looks any more
        self.post_message(self.Found(None))

    def on_doctor_screen_begun(self, message: Begun) -> None:
        self._examined = message.name
        self._draw()

    def on_doctor_screen_found(self, message: Found) -> None:
        if message.finding is None:
            self.is_examining = False
        else:
            self._found = (*self._found, message.finding)
        self._draw()

    def show(self, view: View) -> None:
        """Bring the status line up to date. Before it is there, remember."""
        self._view = view
        if self.is_attached and self._status.is_attached:
            self._status.update_from(view)
            self._title()

    def reword(self) -> None:
        """Words are in another language now."""
        self._title()
        self._page.redraw()
        self._draw()
        self.show(self._view)

    def plain(self) -> str:
        """What has been found so far."""
        return "\n".join(_plain(row) for row in self._rows()) if self._found else ""

    def scroll_page(self, direction: int) -> None:
        """A screenful up (−1) or down (1), less two lines to go on from."""
        self._page.scroll_lines(direction * max(1, self._page.size.height - 2))

    def _title(self) -> None:
        hints = hint_line(strings.DOCTOR_KEYS, self._acting, max(1, self.size.width - EDGES), last=2)
        if (titles := (strings.DOCTOR_TITLE, hints)) != self._titles:  # others repaint the frame
            self._titles = titles
            self._page.border_title, self._page.border_subtitle = map(Content, titles)

    def on_resize(self) -> None:
        self._title()

    def _draw(self) -> None:
        if self._page.is_attached:
            self._page.show(self._rows(), matters=0)
            self._title()

    def _rows(self) -> list[Row]:
        rows = [row for finding in self._found for row in _rows(finding)]
        count = Counter(finding.state for finding in self._found)
        figures = " · ".join(f"{SIGNS[state][0]} {count[state]} {strings.FINDINGS[state]}" for state in SIGNS)
        name = strings.CHECKS.get(self._examined, self._examined)
        last = strings.EXAMINING.format(name=name, count=len(self._found)) if self.is_examining else figures
        return [*rows, Row("", (("", ""),)), Row("", ((last, _DIM),))]


def _rows(finding: Finding) -> Iterator[Row]:
    """What was found, and what to do about it."""
    sign, style = SIGNS[finding.state]
    word = (left(f"{sign} {strings.FINDINGS[finding.state]}", _WORDS), style)
    name = strings.CHECKS.get(finding.name, finding.name)
    yield Row(name, ((printable(told(finding.detail)), "$foreground"),), (word,))
    if finding.fix:
        yield Row("", ((f"→ {printable(told(finding.fix))}", _DIM),))


def _plain(row: Row) -> str:
    words = "".join(text for text, _ in row.body)
    gutter = "".join(text for text, _ in row.aside) + left(row.part, _NAMES)
    return f"{gutter if row.aside else ' ' * (_NAMES + _WORDS)}{words}".rstrip()
