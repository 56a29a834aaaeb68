"""Text in columns of the terminal: a Chinese character takes two of them, and so no width is a number of characters."""

from __future__ import annotations

from rich.cells import cell_len, set_cell_size


def left(text: str, columns: int) -> str:
    """With spaces behind it, at least so many columns wide."""
    return text + " " * (columns - cell_len(text))


def right(text: str, columns: int) -> str:
    """With spaces before it, at least so many columns wide."""
    return " " * (columns - cell_len(text)) + text


def centred(text: str, columns: int) -> str:
    """In the middle of so many columns, and cut where it is wider; a character that is cut in two is left out."""
    room = max(0, columns - cell_len(text))
    before = room // 2 + (room & columns & 1)  # as str.center
    return set_cell_size(" " * before + text, columns)
