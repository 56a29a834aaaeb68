"""What the camera sees, as coloured half blocks; only what changed so that one sees it is sent.

Where the terminal has graphics, the pane is blank and says where the picture belongs. While something lies over it, it
is half blocks again: a picture would cover that, or show through.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import takewhile
from typing import TYPE_CHECKING, ClassVar, Final

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from tui.graphics import tiles
from tui.graphics.pixels import Inks
from tui.graphics.tiles import Colour, Extent, Mark
from tui.words import strings
from tui.words.language import told
from tui.words.widths import centred

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.perception.sighting import Sight
    from tui.graphics.surface import Surface

LIMIT_BYTES: Final = 4000
"""What one picture may send, about."""
_MAX_STYLES: Final = 4096


class CameraView(Widget, can_focus=False):
    """The newest picture, as large as there is room for, with frames around what was recognised in it."""

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {"camera--frame", "camera--name", "camera--hint"}

    def __init__(self) -> None:
        super().__init__()
        self._sight: Sight | None = None
        self._pixels: NDArray[np.uint8] | None = None
        self._extent = Extent(1, 1)
        self._marks: dict[tuple[int, int], Mark] = {}
        self._notice: str | None = None  # none has come yet
        self._styles: dict[tuple[Colour, Colour], Style] = {}
        self._surface: Surface | None = None
        self._covered = False  # something lies over the pane

    @property
    def marks(self) -> dict[tuple[int, int], Mark]:
        """The frames and names that are drawn, by row and column of the picture."""
        return self._marks

    def show_sight(self, sight: Sight) -> int:
        """Show a picture; gives about how many bytes that sends."""
        self._sight = sight
        if not self.size.width or not self.size.height:
            return 0
        if self._surface is not None and not self._covered:
            return self._paint(sight, self._surface)
        if self._notice != "":
            self._notice, self._pixels = "", None
            self.refresh()
        height, width = sight.picture.rgb.shape[:2]
        size = tiles.extent(width, height, self.size.width, self.size.height)
        old = self._pixels if size == self._extent else None
        pixels = tiles.afforded(tiles.shrunk(sight.picture.rgb, size), old, LIMIT_BYTES)
        marks = tiles.frames(sight.objects, width, height, size)
        different = tiles.changed(old, pixels)
        for row, column in {at for at in marks.keys() | self._marks.keys() if marks.get(at) != self._marks.get(at)}:
            if row < size.rows and column < size.columns:
                different[row, column] = True
        if size != self._extent:
            self.refresh()
        self._pixels, self._extent, self._marks = pixels, size, marks
        left, top = self._corner
        sent = 0
        for row in range(size.rows):
            for first, length in tiles.runs(different[row].tolist()):
                self.refresh(Region(left + first, top + row, length, 1))
                sent += tiles.cost(pixels, row, first, length)
        return sent

    def show_notice(self, text: str) -> None:
        """Say why there is no picture."""
        if text != self._notice:
            self._notice, self._pixels, self._sight, self._marks = text, None, None, {}
            if self._surface is not None:
                self._surface.clear()
            self.refresh()

    def draw_on(self, surface: Surface | None) -> None:
        """Show pictures there from now on; None: as half blocks."""
        if surface is not self._surface:
            self._surface = surface
            self._begin_anew()

    @property
    def surface(self) -> Surface | None:
        """Where pictures are shown; None: they are half blocks."""
        return self._surface

    def place(self) -> Region | None:
        """Where on the screen the picture of the surface belongs; None while it is not to be seen. For each frame."""
        compositor = self.screen._compositor
        region, clip = compositor.visible_widgets.get(self, (Region(), Region()))
        place = Region(*self._corner, self._extent.columns, self._extent.rows).translate(region.offset)
        if not place.size or not clip.contains_region(place):
            return None
        covered = any(
            widget.visible and part.overlaps(place)
            for layers in compositor.layers_visible[place.y : place.bottom]
            for widget, part, _ in takewhile(lambda layer: layer[0] is not self, layers)
        )
        if covered != self._covered:
            self._covered = covered
            self._begin_anew()
        return None if covered else place

    def _begin_anew(self) -> None:
        """What was shown is to be shown in another way."""
        self._pixels, self._marks = None, {}
        if self._sight is not None:
            self.show_sight(self._sight)
        self.refresh()

    def _paint(self, sight: Sight, surface: Surface) -> int:
        """Show a picture as pixels; gives how many bytes that sends."""
        height, width = sight.picture.rgb.shape[:2]
        size = tiles.extent(width, height, self.size.width, self.size.height)
        if self._notice != "" or self._pixels is not None or size != self._extent:
            self._notice, self._pixels, self._marks, self._extent = "", None, {}, size
            self.refresh()
        sent = surface.paint(sight.picture.rgb, sight.objects, size, self._inks)
        if (spot := surface.spot) is not None:  # the picture goes behind a frame of text: there has to be one
            self.refresh(Region(*(spot + self._corner), 1, 1))
        return sent

    @property
    def _inks(self) -> Inks:
        frame, name = (self.get_component_styles(f"camera--{part}") for part in ("frame", "name"))
        return Inks(frame.color.rgb, name.color.rgb, name.background.rgb)

    @property
    def _corner(self) -> tuple[int, int]:
        """Column and row of the picture's upper left corner."""
        return (self.size.width - self._extent.columns) // 2, (self.size.height - self._extent.rows) // 2

    def render_line(self, y: int) -> Strip:
        width = self.size.width
        pixels = self._pixels
        if pixels is None:
            notice = strings.NO_PICTURE if self._notice is None else told(self._notice)
            text = centred(notice, width) if y == self.size.height // 2 else " " * width
            return Strip([Segment(text, self.get_component_rich_style("camera--hint"))], width)
        left, top = self._corner
        row = y - top
        if not 0 <= row < self._extent.rows:
            return Strip.blank(width, self.rich_style)
        before, behind = (" " * columns for columns in (left, width - left - self._extent.columns))
        row_drawn = [Segment(before, self.rich_style), *self._row(row, pixels, self._marks)]
        segments = [*row_drawn, Segment(behind, self.rich_style)]
        return Strip([segment for segment in segments if segment.text], width)

    def _row(self, row: int, pixels: NDArray[np.uint8], marks: Mapping[tuple[int, int], Mark]) -> Iterator[Segment]:
        """A row of characters; runs of one look are one segment."""
        text, style = "", Style.null()
        upper, lower = pixels[2 * row].tolist(), pixels[2 * row + 1].tolist()
        for column in range(pixels.shape[1]):
            mark = marks.get((row, column))
            its_style = self._style(tuple(upper[column]), tuple(lower[column]), mark)
            if its_style is not style:
                yield Segment(text, style)
                text, style = "", its_style
            text += mark[0] if mark is not None else " " if upper[column] == lower[column] else "▀"
        yield Segment(text, style)

    def blocks(self) -> list[Strip]:
        """In characters what the terminal shows in pixels, in the same place; nothing where it shows none."""
        sight, size = self._sight, self._extent
        if self._surface is None or sight is None or self._covered:
            return []
        height, width = sight.picture.rgb.shape[:2]
        pixels = tiles.settled(tiles.shrunk(sight.picture.rgb, size), None)
        marks = tiles.frames(sight.objects, width, height, size)
        return [Strip(self._row(row, pixels, marks), size.columns) for row in range(size.rows)]

    def _style(self, upper: Colour, lower: Colour, mark: Mark | None) -> Style:
        if mark is not None and mark[1]:
            return self.get_component_rich_style("camera--name")
        if mark is not None:
            mixed = Color.from_rgb(*((a + b) // 2 for a, b in zip(upper, lower, strict=True)))
            return Style(color=self.get_component_rich_style("camera--frame").color, bgcolor=mixed, bold=True)
        style = self._styles.get((upper, lower))
        if style is None:
            if len(self._styles) >= _MAX_STYLES:
                self._styles.clear()
            ink = Color.from_rgb(*upper) if upper != lower else None  # a blank needs none
            style = Style(color=ink, bgcolor=Color.from_rgb(*lower))
            self._styles[upper, lower] = style
        return style

    def on_resize(self, event: events.Resize) -> None:
        self._pixels = None
        if self._sight is not None:
            self.show_sight(self._sight)
        self.refresh()
