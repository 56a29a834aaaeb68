"""A pane of wrapped, styled lines that sends only the lines that changed.

On a slow link bytes are what counts: a pane that repaints as a whole for one new figure costs kilobytes. This one keeps
the drawn strips of every item, compares line by line, and marks the changed lines alone. It has no scroll bar; it shows
the line that matters (the newest, or the one that runs) until somebody scrolls, and again after scrolling back there.
Who has scrolled keeps the lines in sight, also when lines before them are dropped.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Generic, NamedTuple, TypeVar

from textual import events
from textual.content import Content
from textual.geometry import Region
from textual.strip import Strip
from textual.visual import Visual
from textual.widget import Widget

Item = TypeVar("Item", bound=Hashable)


class Drawn(NamedTuple):
    """How an item looks: ``body`` wraps, ``gutter`` stands before its first line, ``aside`` right-aligned in it."""

    gutter: Content
    body: Content
    aside: Content = Content("")
    nowrap: bool = False
    """Cut the body with an ellipsis instead of wrapping it."""


class Lines(Widget, Generic[Item], can_focus=False):
    """Base of the panes of text. Subclasses say how an item is drawn."""

    ALLOW_SELECT = False
    DEFAULT_CSS = "Lines { height: 1fr; link-color: $text-accent; link-style: none; }"

    def __init__(self, *, id: str | None = None, classes: str | None = None) -> None:
        super().__init__(id=id, classes=classes)
        self._items: tuple[Item, ...] = ()
        self._matters: int | None = None
        self._cache: dict[Item, list[Strip]] = {}
        self._strips: list[Strip] = []
        self._top = 0
        self._held = False  # somebody scrolled away from what matters

    @property
    def items(self) -> tuple[Item, ...]:
        """What is shown, from first to last."""
        return self._items

    def drawn(self, item: Item) -> Drawn:
        """How ``item`` looks."""
        raise NotImplementedError

    def show(self, items: Sequence[Item], *, matters: int | None = None) -> None:
        """Show these items; the one at index ``matters`` (default: the last) is kept in view."""
        items = tuple(items)
        if (items, matters) != (self._items, self._matters):
            first = self._item_at(self._top) if self._held else None
            self._items, self._matters = items, matters
            self._update(first)

    @property
    def is_held(self) -> bool:
        """Somebody has scrolled away from what matters."""
        return self._held

    def can_scroll(self, lines: int) -> bool:
        """There is more up (negative) or down (positive)."""
        return 0 <= self._top + (-1 if lines < 0 else 1) <= self._last_top

    def scroll_lines(self, lines: int) -> None:
        """Scroll by that many lines, down when positive."""
        top = max(0, min(self._top + lines, self._last_top))
        self._held = top != self._top_for_what_matters()
        if top != self._top:
            self._top = top
            self.refresh()

    def follow(self) -> None:
        """Show what matters, now and from now on."""
        self._held = False
        self._update()

    def _show_line(self, number: int) -> None:
        """Scroll as far as the item of this number needs to be seen, and stay there."""
        before = sum(len(self._cache[item]) for item in self._items[:number])
        after = before + len(self._cache[self._items[number]])
        top = min(max(self._top, after - self.size.height), before)
        self.scroll_lines(top - self._top)

    def _item_at(self, strip: int) -> tuple[Item, int] | None:
        """The item that stands at a line of all of them, and how many of its own lines stand before that."""
        for item in self._items:
            height = len(self._cache.get(item, ()))
            if strip < height:
                return item, strip
            strip -= height
        return None

    def focus_on_click(self) -> bool:
        """Not on words that do something themselves: they stand elsewhere once other keys act."""
        return "@click" not in self.screen.get_style_at(*self.app.mouse_position).meta

    def clicked(self, event: events.Click) -> int | None:
        """The number of the item that was clicked on; None beside them, and on words that do something themselves."""
        at = event.get_content_offset(self)
        if at is None or "@click" in event.style.meta:
            return None
        row = self._top + at.y
        for number, item in enumerate(self._items):
            row -= len(self._cache[item])
            if row < 0:
                return number
        return None

    @property
    def _last_top(self) -> int:
        return max(0, len(self._strips) - self.size.height)

    def _update(self, first: tuple[Item, int] | None = None) -> None:
        """Draw what changed. ``first`` stays the first in sight, so many of its lines further up."""
        width = self.size.width
        if not width or not self.is_attached:
            return
        old, old_top = self._strips, self._top
        cache = {item: self._cache.get(item) or self._wrap(item, width) for item in self._items}
        self._cache = cache
        self._strips = [strip for item in self._items for strip in cache[item]]
        if not self._held:
            self._top = self._top_for_what_matters()
        elif first is not None and first[0] in cache:
            self._top = sum(len(cache[item]) for item in self._items[: self._items.index(first[0])]) + first[1]
        self._top = min(self._top, self._last_top)
        for y in range(self.size.height):
            if _at(old, old_top + y) is not _at(self._strips, self._top + y):
                self.refresh(Region(0, y, width, 1))

    def _top_for_what_matters(self) -> int:
        if self._matters is None or any(
            item not in self._cache for item in self._items
        ):  # nothing is drawn without room
            return self._last_top
        if not self._items:
            return 0
        before = sum(len(self._cache[item]) for item in self._items[: self._matters])
        after = before + len(self._cache[self._items[self._matters]])
        return max(0, after - self.size.height)

    def _wrap(self, item: Item, width: int) -> list[Strip]:
        gutter, body, aside, nowrap = self.drawn(item)
        room = max(1, width - gutter.cell_length)
        first_room = max(1, room - aside.cell_length - 1) if aside else room
        lines = [body.rstrip().truncate(first_room, ellipsis=True)] if nowrap else body.wrap(first_room) or [body]
        indent = Content(" " * gutter.cell_length)
        strips = []
        for number, line in enumerate(lines):
            parts = [indent if number else gutter, line]
            if aside and not number:
                parts += [Content(" " * (room - line.rstrip().cell_length - aside.cell_length)), aside]
                parts[1] = line.rstrip()
            whole = Content.assemble(*parts, strip_control_codes=False)
            strips += Visual.to_strips(self, whole, width, 1, self.visual_style, pad=True)
        return strips

    def render_line(self, y: int) -> Strip:
        strip = _at(self._strips, self._top + y)
        return strip if strip is not None else Strip.blank(self.size.width, self.rich_style)

    def on_resize(self, event: events.Resize) -> None:
        self.redraw()

    def notify_style_update(self) -> None:
        """Colours changed (another theme): what was drawn is stale."""
        super().notify_style_update()
        self.redraw()

    def redraw(self) -> None:
        """What was drawn is stale."""
        self._cache = {}
        self._update()
        self.refresh()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self.scroll_lines(-3)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self.scroll_lines(3)


def _at(strips: list[Strip], index: int) -> Strip | None:
    return strips[index] if 0 <= index < len(strips) else None
