"""What is sent to the terminal: what has changed, once the terminal has drawn what was sent before, and no more than
the line to it bears (see ``tui.terminal.link``)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Literal

from rich.console import RenderableType
from textual.geometry import Region
from textual.screen import Screen

from tui.terminal.link import ASK, Fare, Link, LinkFigures
from tui.terminal.spans import cropped, regions
from tui.terminal.terminal import over_ssh
from tui.words import strings

if TYPE_CHECKING:
    from tui.stage import Stage

SLOWER: Final[Mapping[Fare, int]] = {"full": 1, "spare": 2, "bare": 6}
"""How much longer the time between two frames is on such a line."""


class Sending:
    """The line to the terminal, and what waits for it. In the UI thread."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._link = Link(far=over_ssh(os.environ))
        self._owed: set[Region] = set()  # what has changed on the screen while the line was busy
        self._metered = False  # somebody wants to see how good the line is

    @property
    def fare(self) -> Fare:
        """How much the line bears."""
        return self._link.fare

    @property
    def slower(self) -> int:
        """How much longer the time between two frames is now."""
        return SLOWER[self._link.fare]

    def figures(self) -> LinkFigures | None:
        """How good the line is, if somebody wants to know or has to."""
        return self._link.figures(self._stage.clock()) if self._metered or self._link.fare != "full" else None

    def measured(self) -> LinkFigures:
        """How good the line is now."""
        return self._link.figures(self._stage.clock())

    def meter(self) -> None:
        """Show how good the line is, or no more."""
        self._metered = not self._metered

    def screened(self, renderable: RenderableType | None) -> RenderableType | None:
        """What of a picture is to be drawn now; None: nothing, the terminal is still drawing."""
        if self._link.busy(self._stage.clock()) and (changed := regions(renderable)):
            self._owed |= changed
            return None
        return cropped(renderable)

    def sent(self) -> None:
        """A picture is on its way: ask for a report, if it is time for one."""
        driver = self._stage.terminal
        if driver is not None and hasattr(driver, "written") and self._link.sent(self._stage.clock()):
            driver.write(ASK)

    def reported(self, t: float) -> None:
        """The terminal has drawn what was sent."""
        self._link.reported(t)
        self._pay()

    def feel(self) -> bool:
        """How much the line can bear now; says so where that has changed, which is when this is true."""
        stage = self._stage
        written = getattr(stage.terminal, "written", None)
        if written is None:  # no terminal
            return False
        now = stage.clock()
        changed = self._link.look(now, written)
        if changed:
            fare, delay = self._link.fare, round(1000 * (self._link.figures(now).delay or 0.0))
            level: Literal["info", "warning"] = "info" if fare == "full" else "warning"
            stage.note(level, strings.FARES[fare].format(delay=delay))
        if self.figures() != stage.shown.link:
            stage.redraw()
        self._pay()
        return changed

    def _pay(self) -> None:
        """Draw what has changed while the line was busy, as it is now."""
        stage = self._stage
        if not self._owed or not stage.screen_stack or self._link.busy(stage.clock()):
            return
        screen: Screen[Any] = stage.screen
        owed, self._owed = self._owed, set()
        whole = screen._compositor.size.region
        screen._compositor._dirty_regions.update(part for region in owed if (part := region.intersection(whole)))
        screen._compositor_refresh()
