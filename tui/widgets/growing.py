"""Lines that get more at their end: transcript and log. They follow the newest until somebody scrolls back; who looks
at older ones stays there, and a mark in the frame says how many are new. A click on it leads to the newest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from textual.content import Content

from tui.widgets.lines import Item, Lines
from tui.words import strings
from tui.words.hints import JOINT

One = TypeVar("One")


class Growing(Lines[Item]):
    """Base of such panes. Subclasses write :func:`mark` into their frame in :meth:`entitle`."""

    def __init__(self, *, classes: str | None = None) -> None:
        super().__init__(classes=classes)
        self._fresh = 0  # lines that came while somebody looked at older ones
        self._foot = Content("")

    def entitle(self) -> None:
        """Write into the frame what belongs there now."""
        raise NotImplementedError

    def write_foot(self, words: Content) -> None:
        """Write this below the pane."""
        if not words.is_same(self._foot):  # another one repaints the pane
            self._foot = self.border_subtitle = words

    def count(
        self, known: Sequence[One], lines: Sequence[One], fits: Callable[[One], bool] = lambda line: True
    ) -> None:
        """``lines`` are there in place of those that were ``known``. Of what was added, all that ``fits`` is new to
        somebody who looks at older ones."""
        added = lines[len(lines) - _added(known, lines) :]
        self._fresh = self._fresh + sum(map(fits, added)) if self._held else 0

    def follow(self) -> None:
        super().follow()
        self._fresh = 0
        self.entitle()

    def redraw(self) -> None:
        super().redraw()
        if self._held and self.size.height:  # in another size, the end may be in sight
            self.scroll_lines(0)

    def scroll_lines(self, lines: int) -> None:
        super().scroll_lines(lines)
        if not self._held:
            self._fresh = 0
        self.entitle()


def mark(words: str, pane: str, key: str = "") -> Content:
    """``words`` that say how many are new in this pane: a click on them leads there, and so does the ``key``."""
    told = JOINT.join(filter(None, (words, key and strings.SHOWS_NEW.format(newest=key))))
    return Content.styled(told, f"bold $text-warning @click=app.newest('{pane}')")


def _added(known: Sequence[One], lines: Sequence[One]) -> int:
    """How many lines were added at the end. The first ones may have been dropped, and the last ones rewritten."""
    places = {id(line): at for at, line in enumerate(lines)}
    for behind, line in enumerate(reversed(known)):
        if (at := places.get(id(line))) is not None:
            return len(lines) - 1 - at - behind
    return len(lines)
