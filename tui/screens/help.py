"""The help page: every key, what it does, and what the signs mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Static

from tui.keys.keys import HAND_KEYS, KEYS, LOG_KEYS, MAP_KEYS, QUEUE_KEYS, SETTING_KEYS, TURN_KEYS, Key
from tui.widgets.status import StatusLine
from tui.words import strings
from tui.words.widths import right

if TYPE_CHECKING:
    from tui.shown.view import View

_GAP: Final = 2
"""Columns between a key and what it does."""
_WIDEST: Final = 24
"""Columns of keys at most; longer lists of them wrap."""


class HelpScreen(Screen[None]):
    """Not modal, so that every key of the console works here too: above all the one that stops the robot."""

    CSS_PATH = "help.tcss"
    AUTO_FOCUS = ""

    def __init__(self, keys: Mapping[str, str], listed: Mapping[str, str]) -> None:
        """The keys in use by action id, as they are shown to people: ``keys`` in hints, ``listed`` in a list."""
        super().__init__()
        self._keys = keys
        self._listed_keys = listed
        self._status = StatusLine()
        self._view: View | None = None
        self._width = min(_WIDEST, max(map(cell_len, listed.values())))  # of the column of keys

    def show(self, view: View) -> None:
        """Bring the status line up to date."""
        self._view = view
        if self._status.is_attached:
            self._status.update_from(view)

    def on_mount(self) -> None:
        if self._view is not None:
            self.show(self._view)

    def compose(self) -> ComposeResult:
        yield self._status
        with VerticalScroll(id="page", can_focus=False) as page:
            page.styles.grid_columns = f"{self._width + _GAP} 1fr"
            page.border_title = f"{strings.NAME} · {strings.HELP_TITLE}"
            page.border_subtitle = Content(strings.HELP_LEAVE.format(**self._keys))
            yield Static(right(strings.HELP_BEGIN, self._width), classes="key", markup=False)
            begin = "\n".join((strings.WELCOME, *strings.TOUR)).format(**self._keys)
            yield Static(f"{begin}\n", classes="about", markup=False)
            yield from self._listed(KEYS)
            signs = [part for sign, word in strings.SIGN_WORDS for part in ((f"{sign} ", "bold"), (f"{word}  ", ""))]
            yield Static(right(strings.HELP_SIGNS, self._width), classes="key", markup=False)
            yield Static(Content.assemble(*signs), classes="about", markup=False)
            for title, keys in (
                (strings.HELP_MAP, MAP_KEYS),
                (strings.HELP_QUEUE, QUEUE_KEYS),
                (strings.HELP_LOG, LOG_KEYS),
                (strings.HELP_TURN, TURN_KEYS),
                (strings.HELP_HAND, HAND_KEYS),
                (strings.HELP_SETTINGS, SETTING_KEYS),
            ):
                yield Static("", classes="key", markup=False)
                yield Static(Content.styled(title, "bold $text-primary"), classes="about part", markup=False)
                yield from self._listed(keys)

    def _listed(self, keys: Sequence[Key]) -> ComposeResult:
        for key in keys:
            gutter = Content.styled(right(self._listed_keys[key.id], self._width), "bold $text-accent")
            yield Static(gutter, classes="key", markup=False)
            yield Static(key.about, classes="about", markup=False)

    def reword(self) -> None:
        """Words are in another language now."""
        self.refresh(recompose=True)

    def scroll_page(self, step: int) -> None:
        """Show what there is no room for."""
        page = self.query_one("#page", VerticalScroll)
        page.scroll_to(y=page.scroll_y + step * max(1, page.size.height - 2), animate=False)
