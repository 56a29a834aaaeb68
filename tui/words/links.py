"""Files that are named on the screen, as links that a terminal opens (OSC 8)."""

from __future__ import annotations

import socket
from pathlib import PurePath
from urllib.parse import quote

from textual.markup import escape


def address(file: PurePath | str) -> str:
    """Where this file is: with the machine, as the terminal may be on another one."""
    return f"file://{socket.gethostname()}{quote(str(file))}"


def marked_up(text: str, file: str) -> str:
    """The text in Textual's markup; the file, where the text names it, leads to it."""
    before, named, behind = text.partition(file) if file else (text, "", "")
    link = f"[link='{address(file)}']{escape(named)}[/link]" if named else ""
    return f"{escape(before)}{link}{escape(behind)}"
