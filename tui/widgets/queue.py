"""The actions of the plan, one a line, with a sign, and a duration that runs while the action does; below them the
requests that wait, which are chosen, dropped, moved and taken back here."""

from __future__ import annotations

from typing import ClassVar, Final, NamedTuple

from textual import events
from textual.binding import BindingType
from textual.content import Content
from textual.message import Message

from tui.keys.bindings import QUEUE_BINDINGS
from tui.shown.facts import Phase, Row, Waiting
from tui.shown.model import ConsoleModel
from tui.shown.offers import in_pieces, offered
from tui.widgets.lines import Drawn, Lines
from tui.words import strings
from tui.words.hints import EDGES, JOINT, Acting, hint_line
from tui.words.language import told

SIGNS: Final[dict[Phase, tuple[str, str]]] = {
    "queued": ("○", "$foreground 60%"),
    "running": ("▸", "$text-primary bold"),
    "ok": ("✓", "$text-success"),
    "failed": ("✗", "$text-error"),
    "interrupted": ("■", "$text-warning"),
    "uncertain": ("?", "$text-warning"),
}
_BAR: Final = 8
_ROOM_FOR_BAR: Final = 48
"""Columns below which the bar gives its room to the words."""
_ROOM_FOR_WORDS: Final = 5
"""Lines below which what runs has one of them, so that the next one is in view, too."""


class Shown(NamedTuple):
    """One line of the queue, with its moving figures already rounded: equal lines are not drawn twice."""

    phase: Phase | None
    number: int
    call: str
    message: str
    seconds: str
    filled: int | None  # eighths of the progress bar
    whole: bool = True  # all of its words, on as many lines as they need


class Waits(NamedTuple):
    """One request that waits, by its place among them."""

    number: int
    text: str
    chosen: bool


class ActionQueue(Lines[Shown | Waits]):
    """The queue; the action that runs is kept in view, and the next one with it. While something runs it has the room
    for its words; afterwards those have it that did not end well. With the keyboard, one of the requests that wait is
    chosen, and that is kept in view with those behind it."""

    BINDINGS: ClassVar[list[BindingType]] = QUEUE_BINDINGS

    class Dropped(Message):
        """Somebody does not want a request any more."""

        def __init__(self, request: Waiting) -> None:
            super().__init__()
            self.request = request

    class Moved(Message):
        """Somebody wants a request to begin before another one, or after all of them."""

        def __init__(self, request: Waiting, before: str | None) -> None:
            super().__init__()
            self.request, self.before = request, before

    class TakenBack(Message):
        """Somebody wants to change a request."""

        def __init__(self, request: Waiting) -> None:
            super().__init__()
            self.request = request

    _summary = Content("")
    _known: tuple[ConsoleModel, float, float | None] | None = None  # what it was told to show
    _told: tuple[Waiting, ...] = ()  # what waits, as far as it has been told
    _waiting: tuple[Waiting, ...] = ()  # the same, as the keys since then have moved them
    _chosen = ""  # the id of a request
    _place = 0  # where that stood

    def __init__(self, acting: Acting, *, classes: str | None = None) -> None:
        super().__init__(classes=classes)
        self._acting = acting

    def update_from(self, model: ConsoleModel, now: float, robot_now: float | None = None) -> None:
        """Show the queue with durations as of event time ``now``, which is ``robot_now`` on the robot's clock."""
        self._known = model, now, robot_now
        running = next((number for number, row in enumerate(model.queue) if row.phase == "running"), None)
        if (told := tuple(request for request in model.waiting if request.id)) != self._told:
            self._told = told
            self._know(told)
        roomy = self.size.height >= _ROOM_FOR_WORDS
        rows = [
            _shown(
                row,
                row.elapsed(now, robot_now),
                roomy if row.phase == "running" else running is None and row.phase not in ("queued", "ok"),
            )
            for row in model.queue
        ]
        following = None if running is None else min(running + 1, len(rows) - 1)
        waiting = [
            Waits(number, request.text, self.has_focus and request.id != "" and request.id == self._chosen)
            for number, request in enumerate(model.waiting, 1)
        ]
        if (chosen := next((at for at, item in enumerate(waiting) if item.chosen), None)) is not None:
            following = len(rows) + min(len(waiting), chosen + self.size.height) - 1
        elif running is None and rows:
            following = len(rows) - 1
        nothing = [] if rows or waiting else [Shown(None, 0, strings.NO_ACTIONS, "", "", None)]
        self.show([*rows, *waiting, *nothing], matters=following)

    def _know(self, waiting: tuple[Waiting, ...]) -> None:
        """What waits now. In the place of what was chosen and is gone, its neighbour is."""
        self._waiting = waiting
        if not any(request.id == self._chosen for request in waiting):
            self._chosen = waiting[min(self._place, len(waiting) - 1)].id if waiting else ""
            self._held = False
        self._place = next((at for at, request in enumerate(waiting) if request.id == self._chosen), 0)

    @property
    def has_waiting(self) -> bool:
        """There is a request that waits, and can be chosen."""
        return bool(self._waiting)

    def hint(self) -> None:
        """Write into the frame what belongs there now."""
        if self._known is None:
            return
        summary = self._summed_up(self._known[0])
        if not summary.is_same(self._summary):  # another one repaints the pane
            self._summary = self.border_subtitle = summary

    def _summed_up(self, model: ConsoleModel) -> Content:
        """What stands in the frame: what the keys do, or how it goes; when all is over, what is offered."""
        if self._waiting and self.has_focus:
            return Content(hint_line(strings.QUEUE_KEYS, self._acting, self.size.width - EDGES))
        if model.waiting or any(row.phase == "running" for row in model.queue):
            return Content(_summary(model, self._acting))
        return Content.assemble(*in_pieces(offered(model), self._acting) if model.queue else ())

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Where no request waits, these keys do what they do everywhere."""
        if action not in ("choose", "drop", "move", "change"):
            return super().check_action(action, parameters)
        if not self._waiting:
            return False
        if action in ("choose", "move") and isinstance(step := parameters[0], int):
            return 0 <= self._place + step < len(self._waiting) or None
        return True

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """A request that is clicked on is chosen, and nothing scrolls below the hand."""
        offset = event.get_content_offset(self)
        at = self._item_at(self._top + offset.y) if offset is not None else None
        if at is None or not isinstance(at[0], Waits) or self._known is None:
            return
        clicked = self._known[0].waiting[at[0].number - 1].id
        place = next((n for n, request in enumerate(self._waiting) if request.id == clicked), None)
        if place is not None:
            self._choose(place)
            self._held = True

    def action_choose(self, step: int) -> None:
        self._held = False
        self._choose(self._place + step)

    def _choose(self, place: int) -> None:
        self._place = max(0, min(len(self._waiting) - 1, place))
        self._chosen = self._waiting[self._place].id
        if self._known is not None:
            self.update_from(*self._known)

    def action_drop(self) -> None:
        self.post_message(self.Dropped(self._waiting[self._place]))

    def action_move(self, step: int) -> None:
        """One place earlier (−1) or later (1)."""
        if 0 <= self._place + step < len(self._waiting):
            self.post_message(self.Moved(self._waiting[self._place], self._following(step if step < 0 else step + 1)))
            order = list(self._waiting)  # the next key may come before anybody tells the new one
            order.insert(self._place + step, order.pop(self._place))
            self._waiting, self._place = tuple(order), self._place + step

    def action_change(self) -> None:
        self.post_message(self.TakenBack(self._waiting[self._place]))

    def _following(self, step: int) -> str | None:
        """The request so many places further than the chosen one; None behind the last."""
        at = self._place + step
        return self._waiting[at].id if at < len(self._waiting) else None

    def drawn(self, item: Shown | Waits) -> Drawn:
        if isinstance(item, Waits):
            return _drawn_waiting(item)
        if item.phase is None:
            return Drawn(Content(""), Content.styled(item.call, "$foreground 60%"))
        sign, style = SIGNS[item.phase]
        gutter = Content.assemble((f"{sign} ", style), (f"{item.number} ", "$foreground 60%"))
        body = Content.styled(item.call, _CALL_STYLES.get(item.phase, "$foreground"))
        if item.message:
            reason = "$foreground 80%" if item.phase == "failed" else _DIM
            body = Content.assemble(body, ("  " + item.message, reason))
        bar = _bar(item.filled) if item.filled is not None and self.size.width >= _ROOM_FOR_BAR else Content("")
        aside = Content.assemble(bar, (f"{item.seconds:>7}", "$foreground" if item.phase == "running" else _DIM))
        return Drawn(gutter, body, aside, nowrap=not item.whole)


_DIM: Final = "$foreground 60%"
_CALL_STYLES: Final[dict[Phase, str]] = {"queued": "$foreground 60%", "running": "bold $foreground"}


def _drawn_waiting(item: Waits) -> Drawn:
    sign = ("› ", "$text-accent bold") if item.chosen else ("○ ", "$foreground 60%")
    gutter = Content.assemble(sign, (f"{item.number} ", _DIM))
    body = Content.styled(item.text, "bold $foreground" if item.chosen else "$foreground")
    return Drawn(gutter, body, Content.styled(strings.WAITS, _DIM), nowrap=True)


def _shown(row: Row, elapsed: float | None, whole: bool) -> Shown:
    filled = None if row.fraction is None else round(max(0.0, min(1.0, row.fraction)) * _BAR)
    seconds = "" if elapsed is None else f"{elapsed:.1f} s"
    return Shown(row.phase, row.index, told(row.call), told(row.message), seconds, filled, whole)


def _summary(model: ConsoleModel, acting: Acting) -> str:
    """How far the plan is, how many requests wait behind it, and what stops all that."""
    ended = sum(row.phase not in ("queued", "running") for row in model.queue)
    failed = sum(row.phase == "failed" for row in model.queue)
    parts = [strings.STEPS_ENDED.format(ended, len(model.queue))] if len(model.queue) > 1 else []
    parts += [strings.STEPS_FAILED.format(failed)] if failed else []
    parts += [strings.REQUESTS_WAIT.format(len(model.waiting))] if model.waiting else []
    parts += [strings.ANSWER_FIRST] if model.held else []
    return JOINT.join((*parts, hint_line(strings.KEY_STOPS, acting)))


def _bar(filled: int) -> Content:
    return Content.assemble(("━" * filled, "$text-primary"), ("━" * (_BAR - filled), "$foreground 20%"))
