"""A page of facts: rows of styled text beside the name of the part that they belong to."""

from __future__ import annotations

from typing import Final, NamedTuple

from textual.content import Content

from tui.widgets.lines import Drawn
from tui.words.widths import left

Piece = tuple[str, str]
"""Text and style."""
MARGIN: Final = 11
"""Columns for the names of parts, and a gap."""


class Row(NamedTuple):
    """One row; its words wrap, ``aside`` stands at the right."""

    part: str
    body: tuple[Piece, ...] = ()
    aside: tuple[Piece, ...] = ()
    indent: int = 0


def drawn_row(row: Row) -> Drawn:
    """How a row looks."""
    gutter = Content.styled(left(row.part, MARGIN) + " " * row.indent, "bold $text-muted")
    aside = Content.assemble(*row.aside) if any(text for text, _ in row.aside) else Content("")
    return Drawn(gutter, Content.assemble(*row.body, strip_control_codes=False), aside)
