"""The map from above: the floor plan stays; the way, what was seen, and the robot move over it, and only their cells
are redrawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from tui import floor, strings
from tui.floor import Cell, Frame
from tui.themes import THING_COLOURS

if TYPE_CHECKING:
    from config.schema import Place
    from engine.perception.memory import Thing
    from engine.robot.robot import FloorMap, Pose

Overlay = dict[tuple[int, int], Cell]
Sign = tuple[tuple[float, float], str, str]
"""Where (map frame, m), which character, and the word for its colour."""


class FloorView(Widget, can_focus=False):
    """Rooms, furniture, places, the planned way in braille, things that were seen in their own colours, and the robot
    as an arrow that shows its heading."""

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "floor--outside",
        "floor--floor",
        "floor--furniture",
        "floor--wall",
        "floor--label",
        "floor--place",
        "floor--path",
        "floor--robot",
        "floor--hint",
    }

    def __init__(self) -> None:
        super().__init__()
        self._map: FloorMap | None = None
        self._places: Mapping[str, Place] = {}
        self._pose: Pose | None = None
        self._path: tuple[tuple[float, float], ...] = ()
        self._signs: tuple[Sign, ...] = ()
        self._frame: Frame | None = None
        self._cells: list[list[Cell]] = []
        self._overlay: Overlay = {}
        self._styles: dict[tuple[str, str], Style] = {}

    def show_map(self, floor_map: FloorMap, places: Mapping[str, Place]) -> None:
        """Set what stays."""
        if floor_map is not self._map:
            self._map, self._places = floor_map, places
            self._redraw()

    def show_robot(
        self, pose: Pose | None, path: tuple[tuple[float, float], ...], things: Sequence[Thing] = (), now: float = 0.0
    ) -> None:
        """Set what moves, and what is remembered at robot time ``now``; marks only the cells that differ."""
        self._pose, self._path = pose, path
        self._signs = tuple((thing.position[:2], floor.thing_sign(thing, now), thing.colour) for thing in things)
        overlay = self._overlaid()
        old, self._overlay = self._overlay, overlay
        for row, column in {at for at in old.keys() | overlay.keys() if old.get(at) != overlay.get(at)}:
            self.refresh(Region(column, row, 1, 1))

    def _redraw(self) -> None:
        """Draw the plan anew for the present size."""
        self._frame = None
        if self._map is not None and self.size.width > 1 and self.size.height > 1:
            self._frame = floor.fit(self._map, self.size.width, self.size.height)
            self._cells = floor.draw(self._map, self._places, self._frame)
        self._overlay = self._overlaid()
        self.refresh()

    def _overlaid(self) -> Overlay:
        frame = self._frame
        if frame is None:
            return {}
        path = self._path if self._pose is None else floor.ahead(self._path, self._pose.x, self._pose.y)
        overlay: Overlay = {}
        for (row, column), char in floor.way(path, frame).items():
            under = self._cells[row][column]
            if under.ink != "place":
                overlay[row, column] = Cell(char, "path", under.ground)
        for (x, y), sign, colour in self._signs:
            if (at := frame.cell(x, y)) is not None:
                overlay[at] = Cell(sign, "thing", self._cells[at[0]][at[1]].ground, colour)
        at = frame.cell(self._pose.x, self._pose.y) if self._pose is not None else None
        if at is not None and self._pose is not None:
            overlay[at] = Cell(floor.arrow(self._pose.yaw), "robot", "floor")
        return overlay

    def render_line(self, y: int) -> Strip:
        width = self.size.width
        if self._frame is None or y >= len(self._cells):
            text = strings.NO_MAP.center(width) if y == self.size.height // 2 else " " * width
            return Strip([Segment(text[:width], self.get_component_rich_style("floor--hint"))], width)
        segments: list[Segment] = []
        text, style = "", Style.null()
        for column, cell in enumerate(self._cells[y]):
            cell = self._overlay.get((y, column), cell)
            its_style = self._style(cell)
            if its_style is not style:
                segments.append(Segment(text, style))
                text, style = "", its_style
            text += cell.char
        return Strip([*segments, Segment(text, style)], width)

    def _style(self, cell: Cell) -> Style:
        key = (
            (cell.colour or cell.ink) if cell.char != " " else "label",
            cell.ground,
        )  # blank cells join to one run, whatever their ink
        if key not in self._styles:
            ground = self.get_component_rich_style(f"floor--{cell.ground}")
            if cell.colour:
                self._styles[key] = Style(color=THING_COLOURS.get(cell.colour, "#808080"), bgcolor=ground.bgcolor)
                return self._styles[key]
            ink = self.get_component_rich_style(f"floor--{key[0]}")
            if key[0] == "robot":
                self._styles[key] = ink
            else:
                color = ink.bgcolor if key[0] in ("wall", "furniture") else ink.color
                self._styles[key] = Style(color=color, bold=ink.bold, bgcolor=ground.bgcolor)
        return self._styles[key]

    def on_resize(self, event: events.Resize) -> None:
        self._redraw()

    def notify_style_update(self) -> None:
        """Another theme: colours are looked up anew."""
        super().notify_style_update()
        self._styles = {}
        self.refresh()
