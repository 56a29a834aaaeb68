"""The help page: every key, what it does, and what the signs mean."""

from __future__ import annotations

from collections.abc import Mapping

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Static

from tui import strings
from tui.keys import KEYS


class HelpScreen(Screen[None]):
    """Not modal, so that every key of the console works here too: above all the one that stops the robot."""

    CSS_PATH = "help.tcss"
    AUTO_FOCUS = ""

    def __init__(self, keys: Mapping[str, str]) -> None:
        """``keys`` are the keys in use by action id, as they are shown to people."""
        super().__init__()
        self._keys = keys

    def compose(self) -> ComposeResult:
        with VerticalScroll(id="page", can_focus=False) as page:
            page.border_title = f"{strings.NAME} · {strings.HELP_TITLE}"
            page.border_subtitle = strings.HELP_LEAVE.format(help=self._keys["help"], stop=self._keys["interrupt"])
            for key in KEYS:
                gutter = Content.styled(f"{self._keys[key.id]:>10}  ", "bold $text-accent")
                yield Static(gutter, classes="key", markup=False)
                yield Static(key.about, classes="about", markup=False)
            signs = [part for sign, word in strings.SIGN_WORDS for part in ((f"{sign} ", "bold"), (f"{word}  ", ""))]
            yield Static(strings.HELP_SIGNS.rjust(10), classes="key", markup=False)
            yield Static(Content.assemble(*signs), classes="about", markup=False)
