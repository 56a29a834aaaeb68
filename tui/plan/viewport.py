"""Which part of the map is shown: how near one looks, at what, and whether the picture goes along with the robot.

A viewport is a frozen value; every wish (nearer, to the left, after the robot) makes the next one. Frames of a zoomed
map lie on the same raster however far it is shifted, so that walls do not flicker while it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from msgspec import Struct
from msgspec.structs import replace

from tui.plan.floor import Frame, fit

if TYPE_CHECKING:
    from engine.robot.floor_map import FloorMap

ZOOMS: Final = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
"""How many times as large as the whole map."""
FOLLOWED: Final = 3.0
"""The zoom that following begins with where the whole map is shown."""
_STEP: Final = 0.2
"""Part of what is shown by which it is shifted at once."""
_MARGIN: Final = 0.25
"""Part of what is shown, at each side, in which a robot that is followed makes the picture go along: rarely, and then
by much, because each time all of it is sent."""

Spot = tuple[float, float]
"""Map frame, m."""


class Viewport(Struct, frozen=True):
    """``centre`` is the spot in the middle; None: that of the whole map."""

    zoom: float = 1.0
    centre: Spot | None = None
    follows: bool = False

    @property
    def is_whole(self) -> bool:
        """Whether the whole map is shown, which does not move."""
        return self.zoom == 1.0

    def frame(self, floor: FloorMap, columns: int, rows: int) -> Frame:
        """Where the map lies on so many characters."""
        return self.within(fit(floor, columns, rows))

    def within(self, whole: Frame) -> Frame:
        """The same, from the frame of the whole map, which takes long to find."""
        if self.is_whole:
            return whole
        width = whole.cell_width / self.zoom
        x, y = self.centre or _middle(whole)
        left = whole.left + round((x - width * whole.columns / 2 - whole.left) / width) * width
        top = whole.top + round((y + width * whole.rows - whole.top) / (2 * width)) * 2 * width
        return Frame(left, top, width, whole.columns, whole.rows)

    def nearer(self, steps: int, about: Spot | None) -> Viewport:
        """Zoomed in by so many steps, or out where negative, with the spot ``about`` in the middle."""
        at = max(0, min(len(ZOOMS) - 1, ZOOMS.index(self.zoom) + steps))
        if ZOOMS[at] == self.zoom:
            return self
        if ZOOMS[at] == 1.0:
            return Viewport()
        return replace(self, zoom=ZOOMS[at], centre=about or self.centre)

    def nearer_at(self, steps: int, spot: Spot, whole: Frame) -> Viewport:
        """The same with this spot where it is, as near as cells allow."""
        found = self.nearer(steps, None)
        if found == self or found.is_whole:
            return found
        x, y = _middle(whole) if self.is_whole else self.centre or _middle(whole)
        share = self.zoom / found.zoom
        return replace(found, centre=(spot[0] + share * (x - spot[0]), spot[1] + share * (y - spot[1])))

    def shifted(self, right: int, up: int, whole: Frame) -> Viewport:
        """Moved over the map by so many steps; it no longer follows, and its middle stays on the map."""
        if self.is_whole:
            return self
        frame = self.within(whole)
        x, y = _middle(frame)
        x += right * _STEP * frame.columns * frame.cell_width
        y += up * _STEP * frame.rows * frame.cell_height
        x = max(whole.left, min(whole.left + whole.columns * whole.cell_width, x))
        y = max(whole.top - whole.rows * whole.cell_height, min(whole.top, y))
        return replace(self, centre=(x, y), follows=False)

    def following(self) -> Viewport:
        """It goes along with the robot from now on, or no longer."""
        if self.follows:
            return replace(self, follows=False)
        return Viewport(FOLLOWED if self.is_whole else self.zoom, self.centre, follows=True)

    def showing(self, spot: Spot, whole: Frame) -> Viewport:
        """Centred on the spot where that lies too near the edge; else as it is."""
        frame = self.within(whole)
        column, row = frame.at(*spot)
        if self.is_whole or (
            _MARGIN <= column / frame.columns <= 1 - _MARGIN and _MARGIN <= row / frame.rows <= 1 - _MARGIN
        ):
            return self
        return replace(self, centre=spot)


def _middle(frame: Frame) -> Spot:
    return (
        frame.left + frame.columns * frame.cell_width / 2,
        frame.top - frame.rows * frame.cell_height / 2,
    )
