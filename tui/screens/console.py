"""The one screen of the console: what is heard, thought and done, side by side.

The screen owns the arrangement and hands each pane its part of the view. It decides nothing and knows no engine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from tui import strings
from tui.model import ConsoleModel
from tui.terminal import SHORT_ROWS, layout_for, too_small
from tui.widgets.ask import Ask, AskLine
from tui.widgets.conversation import Conversation
from tui.widgets.figures import Figures
from tui.widgets.floor_view import FloorView
from tui.widgets.log import LogView
from tui.widgets.mic import MicStrip
from tui.widgets.plan import PlanView
from tui.widgets.problem import ProblemPanel
from tui.widgets.queue import ActionQueue
from tui.widgets.status import Hint, StatusLine

if TYPE_CHECKING:
    from config.schema import Place
    from engine.handle import PartStatus
    from engine.perception.memory import World
    from engine.robot.robot import FloorMap, RobotState


Pane = TypeVar("Pane", bound=Widget)


@dataclass(frozen=True, slots=True)
class View:
    """Everything the screen shows at one moment."""

    model: ConsoleModel
    now: float = 0.0  # s, event time
    started: bool = False  # the engine is there
    notice: str = ""  # stands in the status line
    hints: tuple[Hint, ...] = ()
    parts: tuple[PartStatus, ...] = ()
    robot: RobotState | None = None
    floor_map: FloorMap | None = None
    places: Mapping[str, Place] = field(default_factory=dict)
    world: World | None = None


class ConsoleScreen(Screen[None]):
    """Status line, conversation, plan, actions, map, figures, microphone, log and input."""

    AUTO_FOCUS = ""

    def __init__(self, keys: Mapping[str, str]) -> None:
        """``keys`` are the keys in use by action id, as they are shown to people."""
        super().__init__()
        self._keys = keys
        self._status = StatusLine()
        self._problem = ProblemPanel()
        self._conversation = Conversation(classes="pane")
        self._plan = PlanView(classes="pane")
        self._queue = ActionQueue(classes="pane")
        self._floor = FloorView()
        self._figures = Figures(classes="pane")
        self._log_view = LogView(classes="pane")
        self._mic = MicStrip()
        self._ask = AskLine()

    def compose(self) -> ComposeResult:
        yield self._status
        yield self._problem
        with Horizontal(id="main"):
            with Vertical(id="left"):
                yield _titled(self._conversation, strings.PANE_CONVERSATION)
                yield _titled(self._plan, strings.PANE_PLAN)
                yield _titled(self._queue, strings.PANE_QUEUE)
            with Vertical(id="right"):
                with _titled(Vertical(classes="pane", id="map"), strings.PANE_MAP):
                    yield self._floor
                yield _titled(self._figures, strings.PANE_ROBOT)
        yield _titled(self._log_view, strings.PANE_LOG)
        yield self._mic
        yield self._ask
        yield Static(id="too-small", markup=False)

    def show(self, view: View) -> None:
        """Bring every pane but the log up to date."""
        model = view.model
        self._status.update_from(model, started=view.started, notice=view.notice, hints=view.hints)
        self._problem.update_from(model.problem)
        notice, trouble = _microphone(view.parts, view.started)
        welcome = strings.WELCOME_TYPING if trouble else strings.WELCOME
        self._conversation.update_from(model, welcome.format(**self._keys))
        self._plan.update_from(model)
        self._queue.update_from(model, view.now)
        self._figures.update_from(view.robot, view.parts, view.world.held if view.world is not None else None)
        self._mic.update_from(model, notice=notice, trouble=trouble)
        if view.floor_map is not None:
            self._floor.show_map(view.floor_map, view.places)
        now = view.robot.t if view.robot is not None else 0.0
        pose = view.robot.pose if view.robot is not None else None
        self._floor.show_robot(pose, model.path, view.world.things if view.world is not None else (), now)

    def show_log(self, model: ConsoleModel) -> None:
        """Bring the log up to date; it has a slower pace of its own."""
        self._log_view.update_from(model)

    def toggle_log(self) -> None:
        """Show the log in place of the conversation, where there is no room for both."""
        self.toggle_class("-log")

    def scroll_conversation(self, lines: int) -> None:
        self._conversation.scroll_lines(lines)

    @property
    def typing(self) -> bool:
        return isinstance(self.focused, Ask)

    def type(self) -> None:
        """Put the focus where one types."""
        self._ask.begin()

    def on_resize(self, event: events.Resize) -> None:
        layout = layout_for(*event.size)
        for name in ("tiny", "compact", "wide"):
            self.set_class(name == layout, f"-{name}")
        self.set_class(event.size.height < SHORT_ROWS, "-short")
        if layout == "tiny":
            text = too_small(*event.size, stop=self._keys["interrupt"], leave=self._keys["leave"])
            self.query_one("#too-small", Static).update(text)


def _titled(pane: Pane, title: str) -> Pane:
    pane.border_title = title
    return pane


def _microphone(parts: Sequence[PartStatus], started: bool) -> tuple[str, bool]:
    """What the microphone's row says while nobody listens, and whether that is bad news."""
    state = next((part.state for part in parts if part.name == "microphone"), "loading")
    if not started or state == "loading":
        return strings.MIC_LOADING, False
    if state == "ready":
        return strings.MIC_IDLE, False
    return strings.NO_MICROPHONE, True
