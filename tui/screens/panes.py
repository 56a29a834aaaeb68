"""The panes by name: which one stands in front, has the keyboard, or has all the room, and how they share it.

What stands where is written in the style sheet alone. Here the screen gets the classes that it goes by: ``-log``,
``-timeline``, ``-plan``, ``-map`` and ``-aside`` bring a pane to the front where there is no room for all of them,
``-zoom`` with ``-away`` leaves one of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, Literal

from msgspec import Struct
from textual.content import Content
from textual.screen import Screen
from textual.widget import Widget

from tui.kept.sizes import USUAL, Shares, Split, shifted
from tui.widgets.figures import WIDE as FIGURES_COLUMNS
from tui.words import strings
from tui.words.hints import Acting

PaneName = Literal["conversation", "plan", "actions", "map", "log", "turns", "camera"]

_IN_FRONT: Final[Mapping[str, tuple[PaneName, ...]]] = {
    "-log": ("log",),
    "-timeline": ("turns",),
    "-plan": ("plan",),
    "-map": ("map",),
    "-aside": ("map", "camera"),
}
"""The classes that bring a pane to the front."""
_TOGGLED: Final = {"log": "-log", "turns": "-timeline"}
_EDGES: Final = 4
"""Columns of a pane that its border takes."""
_PARTED: Final = ".pane, #main, #left, #right, #below"


class Pane(Struct, frozen=True):
    """A pane with a name: ``frame`` has border and title, ``body`` gets the keyboard. Often they are the same."""

    frame: Widget
    body: Widget


class Panes:
    """Those of one screen."""

    def __init__(self, screen: Screen[None], panes: Mapping[PaneName, Pane], columns: tuple[Widget, Widget]) -> None:
        """``columns`` are the left and the right one."""
        self._screen = screen
        self._panes = panes
        self._columns = columns
        self._zoomed: PaneName | None = None
        self._last: PaneName = "conversation"
        self._shares = USUAL
        self._titles: dict[PaneName, str] = {}
        for pane in panes.values():
            pane.body.can_focus = True

    @property
    def zoomed(self) -> PaneName | None:
        """The one that has all the room."""
        return self._zoomed

    @property
    def focused(self) -> PaneName | None:
        """The one with the keyboard."""
        at = self._screen.focused
        return next((name for name, pane in self._panes.items() if pane.body is at), None) if at is not None else None

    @property
    def meant(self) -> PaneName | None:
        """The one that keys without a pane of their own act on: it has the keyboard, or is all that one sees."""
        return self.focused or self._zoomed or self.alone

    @property
    def alone(self) -> PaneName | None:
        """The one that stands in place of all others on a small terminal."""
        if not self._screen.has_class("-compact"):
            return None
        return "log" if self._screen.has_class("-log") else "turns" if self._screen.has_class("-timeline") else None

    @property
    def in_front(self) -> bool:
        """One stands in place of others."""
        return any(map(self._screen.has_class, _IN_FRONT))

    def body(self, name: PaneName) -> Widget:
        """What gets the keyboard in that pane."""
        return self._panes[name].body

    def entitle(self, acting: Acting, leading: Acting) -> None:
        """Write the titles, with the keys that act now: the one that goes there, and on a pane with all the room the
        way back, which ``leading`` names."""
        for name, pane in self._panes.items():
            key, zoom = acting(f"pane_{name}"), leading("zoom") if name == self._zoomed else None
            back = f" · {strings.ZOOM_BACK.format(zoom=zoom)}" if zoom else ""
            number, words = f"{key} " if key else "", strings.PANES[name] + back
            if self._titles.get(name) != number + words:  # a title that is set repaints the pane
                self._titles[name] = number + words
                title = Content.assemble((number, "not bold $foreground 60%"), words)
                pane.frame.border_title = title

    def remember(self) -> None:
        """The keyboard has gone elsewhere."""
        self._last = self.focused or self._last

    def go_to(self, name: PaneName) -> None:
        """Give the keyboard to a pane, and show it wherever it has no room; one that has all the room gives way."""
        self.front(name)
        if self._zoomed is not None:
            self._leave_only(name)
        self._screen.set_focus(self._panes[name].body)

    def front(self, name: PaneName) -> None:
        """Bring a pane to the front where there is no room for all."""
        lacking = tuple(self._lacking)
        for its_class, names in _IN_FRONT.items():
            self._screen.set_class(name in names and its_class in lacking, its_class)

    def settle(self) -> None:
        """The pane with all the room, or with the keyboard, may have lost its place."""
        if (name := self._zoomed or self.focused) is not None:
            self.front(name)

    @property
    def _lacking(self) -> Iterator[str]:
        """The classes without which something has no room. The others are not set: each repaints every pane."""
        has = self._screen.has_class
        if has("-compact"):
            yield from ("-log", "-timeline", "-map")
            yield from ("-plan",) if has("-short") else ()
            yield from ("-aside",) if has("-narrow") else ()
        elif has("-camera") and not has("-tall"):
            yield from ("-log", "-timeline")

    def reveal(self, name: PaneName) -> None:
        """Bring a pane to the front without the keyboard, also where another one has all the room."""
        if self._zoomed is not None:
            self._leave_only(name)
        self.front(name)
        if self.focused not in (None, name):
            self._screen.set_focus(None)  # a pane that is hidden would pass it on to any other

    def can_toggle(self, name: Literal["log", "turns"]) -> bool:
        """There is no room for all of them, so that one can be brought to the front or back."""
        return self._zoomed is not None or _TOGGLED[name] in self._lacking

    def toggle(self, name: Literal["log", "turns"], on: bool | None = None) -> None:
        """Bring a pane to the front, or the conversation in its place."""
        if on is None:
            its_class = _TOGGLED[name]
            on = not (self._zoomed == name if self._zoomed is not None else self._screen.has_class(its_class))
        there: PaneName = name if on else "conversation"
        if self._zoomed is not None:
            self._leave_only(name if on else None)
        self.front(there)
        if any(self._lacking) and self.focused not in (None, there):
            self._screen.set_focus(None)

    def zoom(self) -> None:
        """Give all the room to the pane that is meant, or was last; or give it back."""
        if self._zoomed is not None:
            self.unzoom()
            return
        name = self.meant or self._last
        if name == "camera" and not self._screen.has_class("-camera"):
            name = "conversation"
        self._leave_only(name)
        self.go_to(name)

    def unzoom(self) -> None:
        """Every pane is in its place again."""
        if self._zoomed is not None:
            self._leave_only(None)

    def _leave_only(self, name: PaneName | None) -> None:
        self._zoomed = name
        frame = self._panes[name].frame if name is not None else None
        self._screen.set_class(name is not None, "-zoom")
        for part in self._screen.query(_PARTED):
            part.set_class(frame is not None and part is not frame and part not in frame.ancestors, "-away")

    # Sizes

    def share(self, shares: Shares | None = None) -> None:
        """Share the room like this, or as before on a terminal that has another size now."""
        self._shares = shares or self._shares
        screen = self._screen
        left = self._shares["wide" if screen.has_class("-wide") else "compact"]
        below = self._shares["below"]
        log, turns = self._panes["log"].frame, self._panes["turns"].frame
        right = screen.size.width * (100 - left) // 100
        screen.set_class(right - _EDGES < FIGURES_COLUMNS, "-slim")
        for part, share in (*zip(self._columns, (left, 100 - left), strict=True), (log, below), (turns, 100 - below)):
            part.styles.width = f"{share}fr"  # whatever is hidden, the rest has all the room

    def shift(self, steps: int) -> Shares | None:
        """Move the border between the columns to the right, or that between log and turns where one of them has the
        keyboard; gives the new shares, or None when nothing can be moved."""
        if (shares := self._shifted(steps)) is not None:
            self.share(shares)
        return shares

    def can_shift(self, steps: int) -> bool:
        """Whether there is anything that :meth:`shift` would move."""
        return self._shifted(steps) is not None

    def _shifted(self, steps: int) -> Shares | None:
        split = self._split
        if split is None or (share := shifted(self._shares[split], steps)) == self._shares[split]:
            return None
        return {**self._shares, split: share}

    @property
    def _split(self) -> Split | None:
        """Which border is in sight."""
        screen = self._screen
        if self._zoomed is not None:
            return None
        if screen.has_class("-wide"):
            return "below" if self.focused in ("log", "turns") else "wide"
        one_column = screen.has_class("-narrow") or screen.has_class("-map") or not screen.has_class("-compact")
        return None if one_column or self.alone is not None else "compact"
