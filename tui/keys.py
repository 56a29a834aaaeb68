"""The keys of the console: one row per action, with the action's id, which settings and help refer to.

An action's id never changes; its key may (Textual's key map replaces keys by binding id).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from textual.binding import Binding, BindingType
from textual.keys import format_key

from tui import strings


@dataclass(frozen=True, slots=True)
class Key:
    """One action of the console and the key that does it."""

    id: str
    """Name of the action in key maps; the app has a method ``action_<id>``."""
    key: str
    """Default key, as Textual spells it."""
    word: str
    """One word for the status line; empty: not shown there."""
    about: str
    """A sentence for the help page."""
    everywhere: bool = False
    """Acts before whatever has the focus sees the key: it cannot be typed."""


KEYS: Final = (
    Key("interrupt", "escape", strings.KEY_STOP, strings.ABOUT_STOP, everywhere=True),
    Key("wake", "space", strings.KEY_WAKE, strings.ABOUT_WAKE),
    Key("end_task", "e", strings.KEY_END, strings.ABOUT_END),
    Key("type", "slash", strings.KEY_TYPE, strings.ABOUT_TYPE, everywhere=True),
    Key("help", "question_mark", strings.KEY_HELP, strings.ABOUT_HELP),
    Key("leave", "q", strings.KEY_QUIT, strings.ABOUT_QUIT),
    Key("leave_now", "ctrl+c", "", strings.ABOUT_QUIT_NOW, everywhere=True),
    Key("log", "l", "", strings.ABOUT_LOG),
    Key("older", "pageup", "", strings.ABOUT_OLDER, everywhere=True),
    Key("newer", "pagedown", "", strings.ABOUT_NEWER, everywhere=True),
)

BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.id, key.word or key.about, show=False, priority=key.everywhere, id=key.id) for key in KEYS
]


def shown(key: str) -> str:
    """How a key is written for people: ``escape`` is ``esc``, ``question_mark`` is ``?``."""
    return strings.KEY_NAMES.get(key) or format_key(key)
