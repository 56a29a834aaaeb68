"""The map from above: the floor plan stays; the way, what was seen, and the robot move over it, and only their cells
are redrawn. Whoever has the focus here looks closer, points at something, and can send the robot there, which is asked
once more: a slip of the finger moves nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import chain
from typing import TYPE_CHECKING, ClassVar, Final

from msgspec.structs import replace
from rich.color import Color, blend_rgb
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import BindingType
from textual.content import Content
from textual.geometry import Region
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

from tui.keys.bindings import MAP_BINDINGS
from tui.looks.themes import THING_COLOURS
from tui.plan import chart, floor
from tui.plan.chart import Moving, Overlay, Spot
from tui.plan.floor import Cell, Frame
from tui.plan.legend import Row, legend
from tui.plan.targets import Target, pointed_at, targets
from tui.plan.viewport import Viewport
from tui.words import strings
from tui.words.hints import JOINT, Acting, hint_line
from tui.words.widths import centred

if TYPE_CHECKING:
    from config.schema import Place
    from engine.robot.floor_map import FloorMap
    from engine.robot.robot import Scan

SCAN_PERIOD_S: Final = 0.5
"""Robot time between two scans that are shown: the walls that are lit change with each, and every change is sent."""
_FADES: Final = (1.0, 0.8, 0.6, 0.45)
"""How much of its colour a thing has left, by the steps that it has faded."""
_GRASP: Final = 1.5
"""Cells around the cursor within which a target is meant."""
TURN: Final = math.radians(15)
"""By which a person corrects where the robot believes to look, rad."""


class FloorView(Widget, can_focus=True):
    """Rooms, furniture, places, the planned way in braille, things that were seen in their own colours, and the robot
    as an arrow that shows its heading. The last line belongs to the cursor while there is one."""

    ALLOW_SELECT = False
    BINDINGS: ClassVar[list[BindingType]] = MAP_BINDINGS
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "floor--outside",
        "floor--floor",
        "floor--furniture",
        "floor--wall",
        "floor--label",
        "floor--place",
        "floor--path",
        "floor--trail",
        "floor--scan",
        "floor--seen",
        "floor--robot",
        "floor--hand",
        "floor--cursor",
        "floor--hint",
        "floor--caption",
        "floor--question",
    }

    class Put(Message):
        """The robot is here: m and rad on the map."""

        def __init__(self, x: float, y: float, yaw: float) -> None:
            super().__init__()
            self.x, self.y, self.yaw = x, y, yaw

    class Touched(Message):
        """The mouse has pointed, asked or zoomed: other keys act now."""

    class Chosen(Message):
        """Somebody wants the robot to go there, and has said so twice."""

        def __init__(self, request: str) -> None:
            super().__init__()
            self.request = request

    def __init__(self, acting: Acting) -> None:
        """``acting`` says which keys act now."""
        super().__init__()
        self._acting = acting
        self._map: FloorMap | None = None
        self._no_map = strings.NO_MAP  # why there is none
        self._places: Mapping[str, Place] = {}
        self._moving = Moving()
        self._scan: Scan | None = None
        self._viewport = Viewport()
        self._unpointed = self._viewport  # what was shown before pointing
        self._whole: Frame | None = None
        self._frame: Frame | None = None
        self._cells: list[list[Cell]] = []
        self._overlay: Overlay = {}
        self._styles: dict[tuple[str, str, int], Style] = {}
        self._cursor: Spot | None = None
        self._legend: tuple[Row, ...] | None = None  # None: nobody wants to read it
        self._standstill = ""  # why the robot cannot go anywhere, if so
        self._asked: Target | None = None  # where to go: the question that stands…
        self._answering: Target | None = None  # …when the key that acts now was pressed

    @property
    def viewport(self) -> Viewport:
        """Which part of the map is shown."""
        return self._viewport

    def wait_for(self, why: str) -> None:
        """Why there is no map, while there is none."""
        if why != self._no_map:
            self._no_map = why
            if self._map is None:
                self.refresh()

    def show_map(self, floor_map: FloorMap, places: Mapping[str, Place]) -> None:
        """Set what stays."""
        if floor_map is not self._map:
            self._map, self._places = floor_map, places
            self._measure()

    def show_moving(self, moving: Moving, scan: Scan | None = None, standstill: str = "") -> None:
        """Set what moves; marks only the cells that differ. Scans are taken no oftener than they can be sent.
        ``standstill`` says why the robot cannot go anywhere, where that is so: nobody is asked whether to go then."""
        if standstill != self._standstill:
            self._standstill = standstill
            self._asked = None if standstill else self._asked
            self._refresh_caption()
        (seen, loose), robot = (self._moving.seen, self._moving.loose), moving.robot
        if robot is None or scan is None:
            seen, loose = (), ()
        elif self._map is not None and (self._scan is None or abs(scan.t - self._scan.t) >= SCAN_PERIOD_S):
            self._scan, (seen, loose) = scan, chart.hits(scan, robot, self._map)
        self._moving = replace(moving, seen=seen, loose=loose)
        self._mark(self._cursor)
        if self._viewport.follows and self._whole is not None and (here := self._robot_spot) is not None:
            self._look(self._viewport.showing(here, self._whole))
        self._update()
        self._explain()

    # Drawing

    def _measure(self) -> None:
        """Find the frame of the whole map for the present size, and draw."""
        self._whole = None
        if self._map is not None and self.size.width > 1 and self.size.height > 1:
            self._whole = floor.fit(self._map, self.size.width, self.size.height)
        self._redraw()

    def _look(self, viewport: Viewport) -> None:
        if viewport != self._viewport:
            self._viewport = viewport
            self._redraw()

    def _redraw(self) -> None:
        """Draw the plan anew."""
        self._frame = None
        if self._map is not None and self._whole is not None:
            self._frame = self._viewport.within(self._whole)
            self._cells = floor.draw(self._map, self._places, self._frame)
        self._overlay = self._overlaid()
        self.refresh()

    def _update(self) -> None:
        """Mark the cells that differ from what is shown."""
        overlay = self._overlaid()
        old, self._overlay = self._overlay, overlay
        for row, column in {at for at in old.keys() | overlay.keys() if old.get(at) != overlay.get(at)}:
            plan = self._cells[row]
            first = column if plan[column].char else column - 1  # a wide character changes as a whole
            last = column if plan[column + 1 : column + 2] == [] or plan[column + 1].char else column + 1
            self.refresh(Region(first, row, last - first + 1, 1))

    def _explain(self) -> None:
        """Bring the legend up to date, where somebody reads it."""
        if self._legend is None or self._map is None:
            return
        without = self._overlaid(replace(self._moving, cursor=None, goal=None))
        shown = {(cell.char, cell.ink) for cell in (*chain(*self._cells), *without.values())}
        rows = legend(self._moving, self._map, self._places, shown, self.size.width - 2, self.size.height // 2)
        if rows != self._legend:
            top = self._legend_top
            self._legend = rows
            top = min(top, self._legend_top)
            self.refresh(Region(0, top, self.size.width, self.size.height - top))

    @property
    def _legend_top(self) -> int:
        """The line that the legend begins with; the last one is the cursor's."""
        return self.size.height - 1 - len(self._legend or ())

    def _explained(self, row: Row, width: int) -> Strip:
        style = self.get_component_rich_style("floor--caption")
        segments = [Segment(" ", style)]
        for entry in row:
            segments += [Segment(entry.sign.char, self._style(entry.sign)), Segment(f" {entry.words}  ", style)]
        return Strip(segments).adjust_cell_length(width, style)

    def _overlaid(self, moving: Moving | None = None) -> Overlay:
        return {} if self._frame is None else chart.overlay(moving or self._moving, self._frame, self._cells)

    def render_line(self, y: int) -> Strip:
        width = self.size.width
        if self._frame is None or y >= len(self._cells):
            text = centred(self._no_map, width) if y == self.size.height // 2 else " " * width
            return Strip([Segment(text, self.get_component_rich_style("floor--hint"))], width)
        if self._cursor is not None and y == self.size.height - 1:
            return self._captioned(width)
        if self._legend and 0 <= (number := y - self._legend_top) < len(self._legend):
            return self._explained(self._legend[number], width)
        segments: list[Segment] = []
        text, style = "", Style.null()
        for cell in self._row(y):
            its_style = self._style(cell)
            if its_style is not style:
                segments.append(Segment(text, style))
                text, style = "", its_style
            text += cell.char
        return Strip([*segments, Segment(text, style)], width)

    def _row(self, y: int) -> list[Cell]:
        """The cells of a line as they are shown: of a wide character that is half covered, nothing is left."""
        row = [self._overlay.get((y, column), cell) for column, cell in enumerate(self._cells[y])]
        for column, cell in enumerate(self._cells[y]):
            if not cell.char and len({(y, column - 1), (y, column)} & self._overlay.keys()) == 1:
                left = column - 1 if (y, column) in self._overlay else column
                row[left] = replace(row[left], char=" ")
        return row

    def _captioned(self, width: int) -> Strip:
        """What the cursor points at, or the question whether to go there."""
        kind, text = "caption", ""
        if self._asked is not None:
            request = self._asked.request
            asked = f"{request[:1].upper()}{request[1:]}"
            kind, text = "question", hint_line(strings.GO_THERE, self._acting, last=0, asked=asked)
        elif (target := self.pointed) is not None and self._standstill:
            kind, text = "question", f"{target.about}  · {self._standstill}"
        elif target is not None:
            words = strings.NO_WAY_TO_SAY
            if target.name:
                words = strings.ENTER_GOES if target.goal is None else strings.ENTER_GOES_TO
            goal = target.goal[2] if target.goal is not None else ""
            text = f" {JOINT}".join(filter(None, (target.about, hint_line(words, self._acting, goal=goal))))
        style = self.get_component_rich_style(f"floor--{kind}")
        return Strip([Segment(Content(f" {text}").truncate(width, ellipsis=True, pad=True).plain, style)], width)

    def _style(self, cell: Cell) -> Style:
        key = (
            (cell.colour or cell.ink) if cell.char != " " or cell.ink == "cursor" else "label",
            cell.ground,
            cell.fade,
        )  # blank cells join to one run, whatever their ink
        if key not in self._styles:
            ground = self.get_component_rich_style(f"floor--{cell.ground}")
            if cell.colour:
                colour = Color.parse(THING_COLOURS.get(cell.colour, "#808080"))
                assert colour.triplet is not None
                if ground.bgcolor is not None and ground.bgcolor.triplet is not None:
                    mixed = blend_rgb(ground.bgcolor.triplet, colour.triplet, _FADES[cell.fade])
                    colour = Color.from_triplet(mixed)
                self._styles[key] = Style(color=colour, bgcolor=ground.bgcolor)
                return self._styles[key]
            ink = self.get_component_rich_style(f"floor--{key[0]}")
            if key[0] in ("robot", "cursor"):
                self._styles[key] = ink
            else:
                color = ink.bgcolor if key[0] in ("wall", "furniture", "seen") else ink.color
                self._styles[key] = Style(color=color, bold=ink.bold, bgcolor=ground.bgcolor)
        return self._styles[key]

    def on_resize(self, event: events.Resize) -> None:
        self._measure()
        self._explain()

    def reword(self) -> None:
        """Names are in another language now."""
        self._redraw()
        self._explain()

    def notify_style_update(self) -> None:
        """Another theme: colours are looked up anew."""
        super().notify_style_update()
        self._styles = {}
        self.refresh()

    # Pointing

    @property
    def _robot_spot(self) -> Spot | None:
        """Where the robot is, if it is anywhere."""
        robot = self._moving.robot
        if robot is None or not (math.isfinite(robot.pose.x) and math.isfinite(robot.pose.y)):
            return None
        return robot.pose.x, robot.pose.y

    @property
    def pointed(self) -> Target | None:
        """What the cursor points at."""
        if self._cursor is None or self._map is None or self._frame is None:
            return None
        reach = _GRASP * self._frame.cell_width
        return pointed_at(*self._cursor, reach, self._known, self._map, self._places)

    @property
    def _known(self) -> tuple[Target, ...]:
        return targets(self._places, self._moving.things, self._moving.people, self._moving.now)

    def _point(self, spot: Spot | None, *, asked: Target | None = None) -> None:
        self._cursor, self._asked = spot, asked
        self._mark(spot)
        if spot is not None and self._whole is not None and self._frame is not None:
            row = self._frame.at(*spot)[1]
            if self._frame.cell(*spot) is None or row >= self._frame.rows - 1:  # the last line is the cursor's own
                self._look(self._viewport.showing(spot, self._whole))
        self._update()
        self._refresh_caption()

    def _mark(self, spot: Spot | None) -> None:
        """On the map: the cursor, and where the robot would go from there, where that is elsewhere."""
        target = self.pointed
        goal = target.goal[:2] if target is not None and target.goal is not None else None
        self._moving = replace(self._moving, cursor=spot, goal=goal)

    def _refresh_caption(self) -> None:
        self.refresh(Region(0, self.size.height - 1, self.size.width, 1))

    def begin(self) -> None:
        """There is a cursor from now on, where the robot is; before the next key, which may be there already."""
        if self._cursor is None:
            self._unpointed = self._viewport
            self._point(self._robot_spot or (0.0, 0.0))

    def on_focus(self) -> None:
        self.begin()

    def on_blur(self) -> None:
        """Nobody points any more: what was looked at closely need not be where the robot is."""
        self._point(None)
        if not self._viewport.follows:
            self._look(self._unpointed)

    def ask_no_more(self) -> None:
        """The question whether to go there is taken back."""
        if self._asked is not None:
            self._asked = None
            self._refresh_caption()

    @property
    def asks(self) -> bool:
        """The question whether to go there stands."""
        return self._asked is not None

    def on_key(self, event: events.Key) -> None:
        """Before the key acts: any of them takes the question back, unless it is the answer, and does nothing else."""
        if not self._take_back():
            return
        if not any(binding.action == "map_go" for binding in self._bindings.key_to_bindings.get(event.key, ())):
            self._answering = None
            event.stop()

    def _take_back(self) -> bool:
        """The question stands no more, unless what was done is the answer. False where none stood."""
        self._answering, self._asked = self._asked, None
        if self._answering is not None:
            self._refresh_caption()
        return self._answering is not None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether it would change what is shown, or ask or tell something. While a question stands, any key but the
        answer is a no: what else it does is not named then."""
        if not action.startswith("map_"):
            return super().check_action(action, parameters)
        if self._asked is not None:
            return action == "map_go" or None
        return self._would(action, parameters) or None

    def _would(self, action: str, parameters: tuple[object, ...]) -> bool:
        match action, parameters:
            case "map_cursor", (int(right), int(up)):
                return self._beside_cursor(right, up) is not None
            case "map_next", (int(step),):
                return self._following(step) not in (None, self._cursor)
            case "map_go", _:
                if self._standstill:
                    return False
                return self._answering is not None or ((target := self.pointed) is not None and bool(target.name))
            case "map_here", _:
                return self._moving.robot is not None and self._cursor is not None
            case "map_follow", _:
                return self._viewport.follows or self._robot_spot is not None
            case "map_zoom", (int(steps),):
                return self._map is not None and self._zoomed(steps) != self._viewport
            case "map_pan", (int(right), int(up)):
                return self._whole is not None and self._viewport.shifted(right, up, self._whole) != self._viewport
            case "map_whole", _:
                return self._viewport != Viewport()
        return self._map is not None

    def action_map_cursor(self, right: int, up: int) -> None:
        """Move the cursor by so many cells; it stays on the map."""
        if (spot := self._beside_cursor(right, up)) is not None:
            self._point(spot)

    def _beside_cursor(self, right: int, up: int) -> Spot | None:
        """So many cells from the cursor; None beside the map."""
        if self._cursor is None or self._frame is None or self._whole is None:
            return None
        x, y = self._cursor[0] + right * self._frame.cell_width, self._cursor[1] + up * self._frame.cell_height
        return (x, y) if self._whole.cell(x, y) is not None else None

    def action_map_next(self, step: int) -> None:
        """Point at the next place or thing, or at the one before."""
        if (spot := self._following(step)) is not None:
            self._point(spot)

    def _following(self, step: int) -> Spot | None:
        """So many places and things further than the cursor."""
        known = self._known
        if not known or self._cursor is None:
            return None
        at = next((n for n, target in enumerate(known) if (target.x, target.y) == self._cursor), None)
        following = (0 if step > 0 else len(known) - 1) if at is None else (at + step) % len(known)
        return known[following].x, known[following].y

    def action_map_go(self) -> None:
        """Ask whether to go where the cursor is; asked, go."""
        if self._standstill:
            self._refresh_caption()  # which says why
        elif self._answering is not None:
            self.post_message(self.Chosen(self._answering.request))
        elif (target := self.pointed) is not None and target.name:
            self._point(self._cursor, asked=target)

    def action_map_here(self, turns: int) -> None:
        """Tell the robot that it is where the cursor is, or (``turns``) that it looks so many steps further to the
        left."""
        robot = self._moving.robot
        if robot is None or self._cursor is None:
            return
        x, y = (robot.pose.x, robot.pose.y) if turns else self._cursor
        self.post_message(self.Put(x, y, robot.pose.yaw + turns * TURN))

    def action_map_zoom(self, steps: int) -> None:
        """Look closer, or from farther away: at the cursor, or at the robot where that is followed."""
        self._look(self._zoomed(steps))

    def _zoomed(self, steps: int) -> Viewport:
        about = self._robot_spot if self._viewport.follows else self._cursor
        return self._viewport.nearer(steps, about)

    def action_map_pan(self, right: int, up: int) -> None:
        """Shift what is shown."""
        if self._whole is not None:
            self._look(self._viewport.shifted(right, up, self._whole))

    def action_map_follow(self) -> None:
        """Go along with the robot, or stay. There is nothing to go along with where nobody knows where that is."""
        if not self._viewport.follows and self._robot_spot is None:
            return
        self._look(self._viewport.following())
        if self._viewport.follows and (here := self._robot_spot) is not None:
            self._look(replace(self._viewport, centre=here))

    def action_map_legend(self) -> None:
        """Say what the signs mean, and who and what was seen; or no longer."""
        self._legend = () if self._legend is None else None
        self._explain()
        self.refresh()

    def action_map_whole(self) -> None:
        """Show the whole map again."""
        self._look(Viewport())

    # The mouse

    def on_click(self, event: events.Click) -> None:
        """Point there and ask; a click on the question is the yes."""
        if self._frame is None:
            return
        self.post_message(self.Touched())
        self._take_back()
        if event.y == self.size.height - 1 and self._answering is not None:
            self.action_map_go()
            return
        self._answering = None
        frame = self._frame
        self._point((frame.left + (event.x + 0.5) * frame.cell_width, frame.top - (event.y + 0.5) * frame.cell_height))
        self.action_map_go()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self._scrolled(1, event)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self._scrolled(-1, event)

    def _scrolled(self, steps: int, event: events.MouseEvent) -> None:
        """Zoom; what lies under the pointer stays there."""
        frame = self._frame
        if frame is not None and self._whole is not None:
            spot = (frame.left + event.x * frame.cell_width, frame.top - event.y * frame.cell_height)
            at, follows = self._viewport, self._viewport.follows
            self._look(at.nearer(steps, None) if follows else at.nearer_at(steps, spot, self._whole))
            self.post_message(self.Touched())
        event.stop()
