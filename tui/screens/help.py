"""The help page: every key, what it does, and what the signs mean; first those of where one was, and only those that
fit what is typed."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple, Protocol

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Input, Static

from tui.keys.keys import (
    DOCTOR_KEYS,
    HAND_KEYS,
    KEYS,
    LOG_KEYS,
    MAP_KEYS,
    PANE_KEYS,
    QUEUE_KEYS,
    SETTING_KEYS,
    TURN_KEYS,
    Key,
    all_shown,
)
from tui.widgets.status import StatusLine
from tui.widgets.text_line import Commands, TextLine
from tui.words import strings
from tui.words.hints import EDGES, hint_line, sentence
from tui.words.widths import right

if TYPE_CHECKING:
    from tui.shown.view import View

_GAP: Final = 2
"""Columns between a key and what it does."""
_WIDEST: Final = 24
"""Columns of keys at most; longer lists of them wrap."""


_COLUMNS: Final = 80
"""Of the page, at most."""


class Keyboard(Protocol):
    """The keys in use, by action."""

    shown_keys: dict[str, str]
    """The first key of each."""
    listed_keys: dict[str, str]
    """All keys of each."""

    def acting(self, action: str) -> str | None:
        """The key that acts now."""
        ...

    def possible(self, action: str) -> bool:
        """Whether any key of it could ever act."""
        ...


class Row(NamedTuple):
    """A key, or a title where there is none, and what it does."""

    key: str
    about: str
    words: str = ""
    """What finds it besides these."""


class Section(NamedTuple):
    """Keys that belong together."""

    title: str
    rows: tuple[Row, ...]


class HelpScreen(Screen[None]):
    """Not modal, so that every key of the console works here too, but for those that are typed: above all the one that
    stops the robot."""

    CSS_PATH = "help.tcss"
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "scroll(-1)", show=False),
        Binding("down", "scroll(1)", show=False),
    ]

    def __init__(
        self, keyboard: Keyboard, commands: Commands, place: str = "", idle: Collection[str] = frozenset()
    ) -> None:
        """``commands`` as in ``TextLine``. ``place`` is where one was: the name of a pane, ``line``, ``hand``, ``turn``
        or ``settings``; empty: nowhere in particular. ``idle`` are actions for which there is nothing to do there."""
        super().__init__()
        self._keyboard = keyboard
        self._commands = commands
        self._place = place
        self._idle = idle
        self._typed = ""
        self._status = StatusLine()
        self._view: View | None = None
        self._width = min(_WIDEST, max(map(cell_len, keyboard.listed_keys.values())))  # of the column of keys
        self._shown: list[tuple[Static, Static, Row | None]] = []  # None: the title of a section, or a row below it

    def show(self, view: View) -> None:
        """Bring the status line up to date."""
        self._view = view
        if self._status.is_attached:
            self._status.update_from(view)
            self._hint()

    def on_mount(self) -> None:
        self._begin()
        if self._view is not None:
            self.show(self._view)

    def on_resize(self) -> None:
        self.call_after_refresh(self._hint)

    def _begin(self) -> None:
        self.set_focus(self.query_one(TextLine))
        self.call_after_refresh(self._hint)  # whether all is in sight is known then

    def compose(self) -> ComposeResult:
        yield self._status
        search = TextLine(self._typed, placeholder=strings.HELP_SEARCH, commands=self._commands, id="search")
        search.select_on_focus = False
        yield search
        self._shown = []
        with VerticalScroll(id="page", can_focus=False) as page:
            page.styles.grid_columns = f"{self._width + _GAP} 1fr"
            page.border_title = f"{strings.NAME} · {strings.HELP_TITLE}"
            for number, section in enumerate(self._sections()):
                title = Content.styled(section.title, "bold $text-primary")
                yield from self._cells("", title, None, "part" if number else "first")
                for row in section.rows:
                    yield from self._cells(row.key, row.about, row)
        yield Static(Content.styled(strings.NOTHING_FITS, "$text-muted"), id="nothing", markup=False)

    def _cells(self, key: str, about: str | Content, row: Row | None, classes: str = "") -> ComposeResult:
        gutter = Content.styled(right(key, self._width), "bold $text-accent")
        cells = (
            Static(gutter, classes="key", markup=False),
            Static(about, classes=f"about {classes}".strip(), markup=False),
        )
        self._shown.append((*cells, row))
        yield from cells

    def _sections(self) -> Iterator[Section]:
        """Those of where one was, then how to begin, then all others; no key twice."""
        groups: Mapping[str, tuple[str, Sequence[Key]]] = {
            "map": (strings.HELP_MAP, MAP_KEYS),
            "actions": (strings.HELP_QUEUE, QUEUE_KEYS),
            "log": (strings.HELP_LOG, LOG_KEYS),
            "turn": (strings.HELP_TURN, TURN_KEYS),
            "doctor": (strings.HELP_DOCTOR, DOCTOR_KEYS),
            "hand": (strings.HELP_HAND, HAND_KEYS),
            "settings": (strings.HELP_SETTINGS, SETTING_KEYS),
        }
        about = strings.ABOUT_LINE_KEYS
        line = tuple(Row(key, about[name]) for name, key in all_shown({name: name for name in about}).items())
        of_pane = [name for name in PANE_KEYS.get(self._place, ()) if name not in self._idle]
        first = tuple(key for key in KEYS if key.id in of_pane)
        if self._place == "line":
            yield Section(strings.HELP_LINE, (*line, *self._rows(first)))
        elif self._place in groups:
            title, keys = groups[self._place]
            yield Section(title, (*self._rows(keys), *self._rows(first)))
        elif first:
            yield Section(strings.HELP_PANE.format(strings.PANES[self._place]), self._rows(first))
        welcome = sentence(strings.WELCOME, self._possible) or strings.WELCOME_TYPING
        tour = (hint_line(line, self._possible) for line in strings.TOUR)
        yield Section(strings.HELP_BEGIN, tuple(Row("", line) for line in (welcome, *tour)))
        yield Section(strings.HELP_REST, self._rows([key for key in KEYS if key not in first]))
        if self._place != "line":
            yield Section(strings.HELP_LINE, line)
        for name, (title, keys) in groups.items():
            if name != self._place:
                yield Section(title, self._rows(keys))
        yield Section(strings.HELP_SIGNS, tuple(Row(*pair) for pair in strings.SIGN_WORDS))

    def _possible(self, action: str) -> str | None:
        """The key of an action that can act, if not now and here."""
        return self._keyboard.shown_keys[action] if self._keyboard.possible(action) else None

    def _rows(self, keys: Sequence[Key]) -> tuple[Row, ...]:
        listed, there = self._keyboard.listed_keys, (key for key in keys if self._keyboard.possible(key.id))
        return tuple(Row(listed[key.id], key.about, f"{key.id} {key.word}") for key in there)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Show what fits what is typed, each below the title of its section."""
        self._typed = event.value
        wanted = event.value.casefold().split()
        title: tuple[Static, Static] | None = None
        found = False
        for key, about, row in self._shown:
            if row is None:
                title = key, about
            shown = not wanted if row is None else _fits(row, wanted)
            key.display = about.display = shown
            if shown and title is not None:
                title[0].display = title[1].display = True
                found = True
        self.query_one("#nothing").display = not found
        self.query_one("#page").display = found
        self.query_one("#page", VerticalScroll).scroll_home(animate=False)
        self.call_after_refresh(self._hint)  # whether all is in sight is known then

    def _hint(self) -> None:
        page = self.query_one("#page", VerticalScroll)
        room = min(self.size.width, _COLUMNS) - EDGES
        words = hint_line(strings.HELP_LEAVE, self._keyboard.acting, room, last=2)
        if str(page.border_subtitle or "") != words:  # another one repaints the frame
            page.border_subtitle = Content(words)

    def can_scroll(self, direction: int) -> bool:
        """There is more up (−1) or down (1)."""
        page = self.query_one("#page", VerticalScroll)
        return page.scroll_y > 0 if direction < 0 else page.scroll_y < page.max_scroll_y

    def reword(self) -> None:
        """Words are in another language now."""
        self.refresh(recompose=True)
        self.call_after_refresh(self._begin)

    def action_scroll(self, lines: int) -> None:
        self._scroll(lines)

    def scroll_page(self, step: int) -> None:
        """Show what there is no room for."""
        self._scroll(step * max(1, self.query_one("#page", VerticalScroll).size.height - 2))

    def _scroll(self, lines: int) -> None:
        page = self.query_one("#page", VerticalScroll)
        page.scroll_to(y=page.scroll_y + lines, animate=False, immediate=True)
        self._hint()


def _fits(row: Row, wanted: Sequence[str]) -> bool:
    """Whether every word that was typed is in it, or is its key."""
    text = f"{row.key} {row.about} {row.words}".casefold()
    return all(word in text for word in wanted)
