"""The one screen of the console: what is heard, thought and done, side by side.

The screen owns the arrangement and hands each pane its part of the view. It decides nothing and knows no engine.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.reactive import Reactive
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from tui.kept.sizes import Shares
from tui.plan.chart import Moving
from tui.plan.targets import asked_to_go
from tui.screens.panes import Pane, PaneName, Panes
from tui.shown.model import ConsoleModel
from tui.shown.offers import in_pieces, offered
from tui.shown.readiness import loading, named, no_map, no_robot, waited_for
from tui.terminal.spans import WholeCompositor
from tui.terminal.terminal import SHORT_ROWS, TALL_ROWS, layout_for, too_small
from tui.widgets.ask import Ask, AskLine
from tui.widgets.by_hand import ByHand
from tui.widgets.camera import CameraView
from tui.widgets.conversation import Conversation
from tui.widgets.figures import Figures
from tui.widgets.floor_view import FloorView
from tui.widgets.lines import Lines
from tui.widgets.log import LogView
from tui.widgets.mic import MicStrip
from tui.widgets.one_line import OneLine
from tui.widgets.plan import PlanView
from tui.widgets.problem import ProblemPanel
from tui.widgets.queue import ActionQueue
from tui.widgets.said import Said
from tui.widgets.status import StatusLine
from tui.widgets.text_line import Commands
from tui.widgets.timeline import Timeline
from tui.words import strings
from tui.words.hints import JOINT, Acting, hint_line, sentence
from tui.words.language import told

if TYPE_CHECKING:
    from textual.geometry import Size

    from engine.perception.sighting import Sight
    from tui.palette.form import Form
    from tui.palette.palette import Palette
    from tui.shown.facts import LogLine
    from tui.shown.view import View


Titled = TypeVar("Titled", bound=Widget)


class ConsoleScreen(Screen[None], inherit_bindings=False):  # tab is a key of the console, as all others
    """Status line, conversation, plan, actions, map, figures, microphone, log and input."""

    AUTO_FOCUS = ""
    focused: Reactive[Widget | None] = Reactive(None, repaint=False)  # Textual's sends the whole screen each time

    def __init__(
        self, commands: Commands, acting: Acting, reaching: Callable[[str], str], *, one_line: bool = False
    ) -> None:
        """``commands`` says which keys act in an empty line (``TextLine``), ``acting`` which act now, ``reaching``
        which lead to an action, after a step back if need be; ``one_line``: all of it stands on one line, and on a
        second one that is typed in where there are two."""
        super().__init__()
        self._one_line = OneLine() if one_line else None
        self._compositor = WholeCompositor()
        self._acting = acting
        self._reaching = reaching
        self._status = StatusLine()
        self._problem = ProblemPanel(acting)
        self._conversation = Conversation(classes="pane")
        self._plan = PlanView(classes="pane")
        self._queue = ActionQueue(acting, classes="pane")
        self._floor = FloorView(acting)
        self._camera = CameraView()
        self._figures = Figures(acting, classes="pane")
        self._log_view = LogView(acting, classes="pane")
        self._timeline = Timeline(acting, classes="pane")
        self._said = Said()
        self._mic = MicStrip()
        self._ask = AskLine(acting, commands)
        self._by_hand = ByHand(acting)
        self._left, self._right = Vertical(id="left"), Vertical(id="right")
        self._map = Vertical(classes="pane", id="map")
        camera = Vertical(classes="pane", id="camera")
        self._panes = Panes(
            self,
            {
                "conversation": Pane(self._conversation, self._conversation),
                "plan": Pane(self._plan, self._plan),
                "actions": Pane(self._queue, self._queue),
                "map": Pane(self._map, self._floor),
                "log": Pane(self._log_view, self._log_view),
                "turns": Pane(self._timeline, self._timeline),
                "camera": Pane(camera, self._camera),
            },
            (self._left, self._right),
        )
        self._too_small = Static(id="too-small", markup=False)
        self._camera_frame = camera
        self._over: Palette | Form | None = None  # what lies over everything
        self._covered: Widget | None = None  # had the keyboard when that came
        self._rest: Widget | None = self.line  # where the keyboard was before something took it for a while

    def _on_screen_resume(self, event: events.ScreenResume) -> None:
        """Before Textual's own: what is shown for the first time has just got its styles."""
        if not self._size:
            event.refresh_styles = False

    def compose(self) -> ComposeResult:
        self._lay_out(self.app.size)  # before there is anything that would be styled anew
        if self._one_line is not None:
            yield self._one_line
        yield self._status
        yield self._problem
        with Horizontal(id="main"):
            with self._left:
                yield self._conversation
                yield self._plan
                yield self._queue
            with self._right:
                with self._map:
                    yield self._floor
                with self._camera_frame:
                    yield self._camera
                yield _titled(self._figures, strings.PANE_ROBOT)
        with Horizontal(id="below"):
            yield self._log_view
            yield self._timeline
        yield self._said
        yield self._mic
        yield self._by_hand
        yield self._ask
        yield self._too_small
        self.hint()

    def on_mount(self) -> None:
        self.type()

    def on_conversation_covered(self, message: Conversation.Covered) -> None:
        self._said.cover(message.covered)

    def on_screen_suspend(self) -> None:
        """Another page has the keyboard: nobody drives on when it comes back."""
        if self.driving_by_hand:
            self.rest()

    # The keyboard

    def set_focus(self, widget: Widget | None, scroll_visible: bool = True, from_app_focus: bool = False) -> None:
        """As Textual's; the line or pane that the map, a hand or a panel takes the keyboard from gets it back
        (:meth:`rest`)."""
        if not self._is_taken:
            self._rest = self.focused
        before = self.focused
        super().set_focus(widget, scroll_visible, from_app_focus)
        if self.focused is not before:
            self.hint()

    @property
    def _is_taken(self) -> bool:
        """The keyboard is where it does not stay; on a tiny terminal it is nowhere."""
        at = self.focused
        return self.is_hidden or at in (self._floor, self._by_hand) or (at is not None and self._over in at.ancestors)

    def rest(self) -> None:
        """Give the keyboard back to where it was before the map, a hand or a panel took it."""
        there = self._rest
        self._ask.display = True
        self.set_focus(there if there is not None and _has_room(there) else None)

    @property
    def focus_chain(self) -> list[Widget]:
        """As Textual's, without the map: there the same key goes from place to place."""
        return [widget for widget in super().focus_chain if widget is not self._floor]

    async def back(self) -> bool:
        """One step back: from a panel, from what is told of a failure, from driving by hand, out of the line, from a
        pane that has all the room or stands in place of others, from a pane. False where there is none
        (:attr:`is_away`)."""
        if await self.uncover() or self._problem.close():
            return True
        if self.driving_by_hand:
            self.rest()
        elif self._one_line is not None:
            return False  # the line keeps the keyboard: letters are keys where panes show which
        elif self.line.has_focus:
            self.set_focus(None)
        elif self.unzoom():
            return True
        elif self.focused is self._floor:
            self.point()
        elif self._panes.in_front or self.focused is not None:
            self._panes.front("conversation")
            self.set_focus(None)
            self.hint()
        else:
            return False
        return True

    @property
    def asks(self) -> bool:
        """The map asks whether to go somewhere: any key but the answer is a no."""
        return self._floor.asks and self.focused is self._floor

    @property
    def is_away(self) -> bool:
        """There is a step to go back."""
        if self._is_covered or self._problem.display or self.driving_by_hand:
            return True
        if self._one_line is not None:
            return False
        return self._panes.zoomed is not None or self._panes.in_front or self.focused is not None

    def show(self, view: View, *, hint: bool = True) -> None:
        """Bring every pane but the log up to date; without ``hint``, the keys that act are those of the last time."""
        model = view.model
        self.line.wait_for(named(loading(view.parts)), failed=view.failed)
        self._ask.tell(busy=model.unfinished, ended=model.ended is not None)
        if self._one_line is not None:
            self._one_line.update_from(view)
            if hint:
                self.hint()
            return
        self._status.update_from(view)
        self._problem.update_from(model.problem)
        self.set_class(self._problem.display, "-trouble")
        notice, trouble = _microphone(view)
        begin = [sentence(strings.WELCOME, self._acting) or strings.WELCOME_TYPING]
        begin += [hint_line(line, self._acting) for line in strings.TOUR] if view.touring else []
        somewhere = (asked_to_go(place.name) for place in list(view.places.values())[:1])
        examples = (*strings.EXAMPLES, *somewhere)
        if view.failed:  # nothing can be asked
            begin, examples = [], ()
        self._conversation.update_from(model, [line for line in begin if line], examples, view.newest)
        self._said.update_from(model)
        self._plan.update_from(model, named(waited_for(model, view.parts)))
        self._queue.update_from(model, view.now, view.robot.t if view.robot is not None else None)
        self._figures.update_from(view)
        self._figures.tell(view.link)
        kept = model.turns.kept
        self._timeline.offer({turn.id: in_pieces(offered(model, turn.id), self._acting) for turn in kept})
        self._timeline.update_from(kept, view.turn, view.now, view.fresh)
        self._mic.update_from(model.trace, notice=notice, trouble=trouble)
        self._floor.wait_for(no_map(view))
        if view.failed:  # nobody will ever look
            self._camera.show_notice(no_robot(view))
        if view.floor_map is not None:
            self._floor.show_map(view.floor_map, view.places)
        world = view.world
        things, people, held = (world.things, world.people, world.held) if world is not None else ((), (), None)
        now = view.robot.t if view.robot is not None else 0.0
        trail = () if view.bare else model.trail
        moving = Moving(view.robot, model.path, trail, things=things, people=people, held=held, now=now)
        self._floor.show_moving(moving, view.scan, view.no_way)
        self._by_hand.tell(view.standstill)
        if hint:
            self.hint()

    def show_log(self, model: ConsoleModel) -> None:
        """Bring the log up to date; it has a slower pace of its own."""
        self._log_view.update_from(model)

    @property
    def log_pane(self) -> LogView:
        """The log."""
        return self._log_view

    def go_to_line(self, line: LogLine) -> None:
        """Show a line of the log, and give the log the keyboard."""
        self.go_to("log")
        self.call_after_refresh(self._log_view.go_to, line)  # it may have got its size only now

    def toggle_log(self) -> None:
        """Show the log in place of the conversation, where there is no room for both."""
        self._panes.toggle("log")
        self.hint()

    def toggle_timeline(self, on: bool | None = None) -> None:
        """Show the turns in place of the conversation, where there is no room for both."""
        self._panes.toggle("turns", on)
        self.hint()

    @property
    def pane(self) -> PaneName | None:
        """The pane that keys act on: it has the keyboard, or stands in place of all others."""
        return self._panes.meant

    def go_to(self, name: PaneName) -> None:
        """Put the focus on a pane, and show it where it has no room."""
        self._panes.go_to(name)
        if name == "map":
            self._floor.begin()  # before the next key, which may be there already
        self.hint()

    def zoom(self) -> None:
        """Give all the room between status line and microphone to one pane, or give it back."""
        self._panes.zoom()
        self.hint()

    def unzoom(self) -> bool:
        """Give the room back; False when no pane has it."""
        if self._panes.zoomed is None:
            return False
        self._panes.unzoom()
        self.hint()
        return True

    def share(self, shares: Shares) -> None:
        """Share the room between the panes like this."""
        self._panes.share(shares)

    def can_shift(self, steps: int) -> bool:
        """There is a border in sight that goes further in this direction."""
        return self._panes.can_shift(steps)

    def can_toggle(self, name: Literal["log", "turns"]) -> bool:
        """This pane can be shown in place of others, or those again."""
        return self._panes.can_toggle(name)

    def shift(self, steps: int) -> Shares | None:
        """Move the border in sight by so many steps to the right; None when there is none, or it goes no further."""
        return self._panes.shift(steps)

    def point(self, *, stay: bool = False) -> None:
        """Put the focus on the map, which gets all the room that it can have; or take it away again, unless it is to
        ``stay``."""
        if stay or self.focused is not self._floor:
            self.go_to("map")
        else:
            self._panes.unzoom()
            self._panes.front("conversation")
            self.rest()
            self.hint()

    def on_descendant_focus(self, event: events.DescendantFocus) -> None:
        self._panes.remember()

    def on_descendant_blur(self, event: events.DescendantBlur) -> None:
        if event.widget is self._floor is not self.focused and self._panes.zoomed != "map":
            self.remove_class("-map")

    def hint(self) -> None:
        """Name everywhere the keys that act now, and no others."""
        self.line.prompt()
        self._ask.offer()
        if self._one_line is not None:
            return
        self._panes.entitle(self._acting, self._reaching if self.line.has_focus else self._acting)
        self._hint_at_map()
        self._timeline.hint()
        self._log_view.entitle()
        self._queue.hint()
        self._problem.hint()
        self._by_hand.hint()
        self._figures.entitle()
        if self._over is not None and self._over.is_attached:
            self._over.hint()
        self._warn_if_tiny()

    def _hint_at_map(self) -> None:
        """Below the map."""
        points = f"{strings.MAP_FOLLOWS[self._floor.viewport.follows]}{JOINT}{strings.MAP_POINTS}"
        hints = points if self.focused is self._floor else strings.MAP_KEYS
        words = hint_line(hints, self._acting, max(1, self._map.size.width - 2))
        if str(self._map.border_subtitle or "") != words:  # another one repaints the frame
            self._map.border_subtitle = Content(words)

    @property
    def camera_shown(self) -> bool:
        """Somebody looks at what the camera sees."""
        return self.has_class("-camera")

    @property
    def camera_in_sight(self) -> bool:
        """It is shown, and no pane stands in its place."""
        return self.camera_shown and _has_room(self._camera_frame)

    @property
    def figures_in_sight(self) -> bool:
        """The robot's pane is shown, with what stands in its frame."""
        return self._one_line is None and _has_room(self._figures)

    @property
    def has_room_for_all(self) -> bool:
        """The camera takes nothing from others."""
        return self.has_class("-wide") and self.has_class("-tall")

    def show_camera(self, shown: bool) -> None:
        """Show what the camera sees: below the map, or in its place where there is no room for both."""
        self.set_class(shown, "-camera")
        zoomed, narrow = self._panes.zoomed, self.has_class("-narrow")
        if shown and (zoomed is not None or narrow or self._panes.alone is not None or self.has_class("-map")):
            self._panes.reveal("camera")
        elif zoomed == "camera":
            self._panes.reveal("map")
        elif narrow:
            self._panes.reveal("conversation")
        else:
            self._panes.settle()
        if not shown and self._panes.focused == "camera":
            self.set_focus(None)
        self.hint()

    def show_sight(self, sight: Sight) -> int:
        """Show a picture; gives about how many bytes that sends."""
        return self._camera.show_sight(sight)

    @property
    def camera(self) -> CameraView:
        """Where pictures are shown."""
        return self._camera

    def show_no_sight(self, why: str) -> None:
        """Say why there is no picture."""
        self._camera.show_notice(why)

    def scroll_lines(self, lines: int) -> None:
        """Scroll the pane that is meant; the conversation, where that is none of text."""
        self._scrolled.scroll_lines(lines)

    def scroll_page(self, step: int) -> None:
        """By as much as it shows."""
        pane = self._scrolled
        pane.scroll_lines(step * max(5, pane.size.height - 2))

    def follow(self, name: PaneName | None = None) -> None:
        """Show the newest of this pane, or of the one that is meant, now and from now on."""
        self._text_of(name or self.pane).follow()

    def can_scroll(self, lines: int) -> bool:
        """There is more in this direction."""
        return self._scrolled.can_scroll(lines)

    def can_follow(self, name: PaneName | None = None) -> bool:
        """Somebody has scrolled away from the newest of this pane, or of the one that is meant."""
        return self._text_of(name or self.pane).is_held

    @property
    def reads_conversation(self) -> bool:
        """Keys that scroll, scroll the conversation."""
        return self._scrolled is self._conversation

    @property
    def _scrolled(self) -> Lines[Any]:
        return self._text_of(self.pane)

    def _text_of(self, name: PaneName | None) -> Lines[Any]:
        body = self._panes.body(name or "conversation")
        return body if isinstance(body, Lines) else self._conversation

    def type(self) -> None:
        """Put the focus where one types, where that is to be seen."""
        if not self.is_hidden:
            self._ask.begin()

    @property
    def is_one_line(self) -> bool:
        """All of it stands on one line."""
        return self._one_line is not None

    @property
    def has_one_row(self) -> bool:
        """…which is a single row, so that a question of the robot may cut off what is told behind it."""
        return self._one_line is not None and self._one_line.size.height <= 1

    @property
    def is_hidden(self) -> bool:
        """The terminal is too small for anything but saying so."""
        return self.has_class("-tiny") and self._one_line is None

    def drive_by_hand(self) -> ByHand:
        """Have the line that says how to in the place of the one to type in, until it loses the keyboard."""
        self._ask.display = False
        self._by_hand.begin()
        return self._by_hand

    @property
    def driving_by_hand(self) -> bool:
        return self._by_hand.has_focus

    def on_by_hand_ended(self) -> None:
        self._ask.display = True
        if self.focused is None and not self.is_hidden:  # the terminal lost it: it does not come back to a hand
            self.rest()

    def reword(self) -> None:
        """Words are in another language now."""
        self.hint()
        for pane in self.query(Lines):
            pane.redraw()
        for part in (self.line, self._floor, self._problem):
            part.reword()
        self._camera.refresh()
        self._mic.refresh()

    @property
    def queue(self) -> ActionQueue:
        """The actions, and what waits behind them."""
        return self._queue

    @property
    def floor(self) -> FloorView:
        """The map."""
        return self._floor

    @property
    def line(self) -> Ask:
        """Where requests are typed."""
        return self._ask.line

    @property
    def panel(self) -> str:
        """The title of the one over everything; empty: there is none."""
        return str(self._over.border_title) if self._over is not None and self._over.is_attached else ""

    async def cover(self, panel: Palette | Form) -> None:
        """Show a panel over everything, which gets the keyboard before the next key is dealt out."""
        await self.uncover()
        self._over, self._covered = panel, self.focused
        await self.mount(panel)
        panel.begin()
        panel.hint()

    async def uncover(self) -> bool:
        """Take the panel away; False when there is none."""
        panel = self._over
        if panel is None or not self._is_covered:
            return False
        if self._covered is self._floor and _has_room(self._floor):
            self.set_focus(self._floor)  # which keeps it; a hand does not drive on
        else:
            self.rest()
        self._over = None
        await panel.remove()
        return True

    @property
    def _is_covered(self) -> bool:
        """A panel lies over everything."""
        return self._over is not None and self._over.is_attached

    def on_resize(self, event: events.Resize) -> None:
        if self._over is not None and self._over.is_attached:
            self._over.place()
        was_hidden = self.is_hidden
        if self._one_line is None and layout_for(*event.size) == "tiny":
            self.set_focus(None)
        self._lay_out(event.size)
        if was_hidden and not self.is_hidden:
            self.rest()
        self._panes.settle()
        self._panes.share()
        self._warn_if_tiny()
        self.call_after_refresh(self.hint)  # how many keys a frame names depends on its width

    def _lay_out(self, size: Size) -> None:
        """Have the classes that the style sheet goes by."""
        layout = layout_for(*size) if self._one_line is None else "tiny"
        self.set_class(self._one_line is not None, "-one-line")
        self.set_class(self._one_line is not None and size.height < 2, "-one-row")
        for name in ("tiny", "narrow", "wide"):
            self.set_class(name == layout, f"-{name}")
        self.set_class(layout in ("narrow", "compact"), "-compact")
        self.set_class(size.height < SHORT_ROWS, "-short")
        self.set_class(size.height >= TALL_ROWS, "-tall")

    def _warn_if_tiny(self) -> None:
        if self.has_class("-tiny"):
            words = strings.TOO_SMALL_KEYS
            text = too_small(*self.size, hint_line(words, self._acting))
            if str(self._too_small.content) != text:
                self._too_small.update(text)


def _titled(pane: Titled, title: str) -> Titled:
    pane.border_title = title
    return pane


def _has_room(widget: Widget) -> bool:
    """It is shown, and no pane stands in its place."""
    return all(part.display for part in widget.ancestors_with_self if isinstance(part, Widget))


def _microphone(view: View) -> tuple[str, bool]:
    """What the microphone's row says while nobody listens, and whether that is bad news."""
    parts = view.parts
    part = next((part for part in parts if part.name == "microphone"), None)
    if view.failed:
        return strings.ENGINE_FAILED, True
    if not view.started or part is None or part.state == "loading":
        return strings.MIC_LOADING, False
    if part.state == "ready" and any(ears.name == "recogniser" and ears.state == "loading" for ears in parts):
        return f"{strings.LOADING} · {strings.PART_WORDS['recogniser']}", False  # a wake waits for it
    if part.state == "ready":
        return f"{strings.MIC_IDLE} · {told(part.detail)}" if part.detail else strings.MIC_IDLE, False
    return strings.NO_MICROPHONE, True
