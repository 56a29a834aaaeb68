"""From the engine to the screen: events are folded into the model, and the model is shown at a fixed pace.

What moves by itself (pose, level, running durations) is sampled at that pace, and only while it moves. With nothing
to show no timer runs: an idle console computes and sends nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from msgspec.structs import replace

from engine.errors import ExitCode
from engine.events import ActionProgress, Body, ErrorRaised, Event, InterruptRaised, ListenLevel, Log, RobotStateView
from engine.states import REST
from tui.messages import Woken
from tui.rooms.alerting import Alerting
from tui.rooms.ending import Ending
from tui.rooms.leaving import Leaving
from tui.rooms.noticing import Noticing
from tui.rooms.sending import Sending
from tui.rooms.viewing import Viewing
from tui.screens.pages import Following
from tui.shown.facts import Line, printable
from tui.shown.model import ConsoleModel
from tui.shown.view import RELEASE, Hint, View
from tui.shown.watchdog import INTERVAL_S, Watchdog, engine_is_back, engine_is_silent, robot_is_back
from tui.terminal.pacing import Inbox, Pacer
from tui.words import strings
from tui.words.hints import hint_line

if TYPE_CHECKING:
    from engine.handle import EngineHandle, PartState, PartStatus
    from engine.robot.floor_map import FloorMap
    from tui.kept.tour import Tour
    from tui.shown.turn import Turn
    from tui.stage import Stage

IN_PANES: Final[tuple[str, ...]] = ("interrupt", "wake", "end_task", "type", "help", "leave")
IN_LINE: Final[tuple[str, ...]] = ("interrupt", "wake", "help", "pane_next", "palette", "leave_now")
IN_TEXT: Final[tuple[str, ...]] = ("interrupt", "send", "back", "help", "earlier", "palette", "leave_now")
IN_SEARCH: Final[tuple[str, ...]] = ("interrupt", "back", "leave_now")
ON_PAGE: Final[tuple[str, ...]] = ("interrupt", "wake", "end_task", "type", "help", "back")
"""The keys in the status line, by where the keyboard is."""
LOG_FRAMES: Final = 4
"""The log scrolls as a whole, which is much to send: it is redrawn once in so many frames."""
HINT_FRAMES: Final = 4
"""While all that happens is that something moves, the keys that act are asked for once in so many frames."""
PARTS_INTERVAL_S: Final = 0.25
"""How often the parts are asked how they are while some are still loading."""
AGES_S: Final = 10.0
"""How often things that were seen are shown as old as they are while nothing else happens."""
CALM_S: Final = 1.0
"""How often what moves by itself is redrawn where that disturbs somebody."""
_MOTION: Final = (ListenLevel, RobotStateView, ActionProgress)
"""What is told again and again while something moves, and changes nothing about what can be asked."""


class _Ended(NamedTuple):
    """What the engine ended by the key that stops: so many requests that had not begun, a question, or what ran."""

    waiting: int
    asks: bool
    ran: bool


class Drawing:
    """Holds what the console knows, and brings the screen up to date. In the UI thread."""

    def __init__(
        self,
        stage: Stage,
        sending: Sending,
        viewing: Viewing,
        leaving: Leaving,
        notice: Callable[[View], str],
        fps: float,
    ) -> None:
        """``notice`` is what must be read in the status line; ``fps``: so many frames a second at most."""
        self.model = ConsoleModel()
        self.view = View(self.model)
        """What is on the screen."""
        self.calm = False
        """What moves by itself does so seldom."""
        self.browsed: str | None = None
        """The turn that somebody looks at; None: the newest."""
        self.on_event: Callable[[Body], None] = lambda body: None
        """Told of everything that happens, as it is drawn."""
        self.standstill: Callable[[View], str] = lambda view: ""
        """Why nothing moves the robot, and the key that changes that; empty where it can be moved."""
        self._counted = 0  # turns that there were when the user began to look at older ones
        self._looked_at: Turn | None = None  # the same turn as it was drawn last: it is kept for as long as that
        self.tour: Tour | None = None
        """What whoever sits here for the first time is told."""
        self.stop_asked = False
        """The key that stops was pressed, and the engine has not yet told what it stopped."""
        self._stop_dealt = True  # it has been dealt out
        self._ended_by_stop: _Ended | None = None  # as far as the engine has told
        self._unsent = 0  # requests that it took before they were sent
        self._stage = stage
        self._sending = sending
        self._viewing = viewing
        self._leaving = leaving
        self._notice = notice
        self._session = ""
        self._interval = 1 / fps
        self._arrived: list[tuple[Event, float]] = []  # taken from the inbox, not drawn yet
        self._inbox: Inbox[tuple[Event, float]] = Inbox(lambda: stage.post_message(Woken()))
        self._unhinted = HINT_FRAMES  # frames since the keys that act were asked for
        self._hinted_at: tuple[object, object] = (None, None)  # where the keyboard was then
        self._lag = float("inf")  # smallest seen difference between our clock and event time
        self._logged = self.model.log  # what the log has been asked to show
        self.parts: tuple[PartStatus, ...] = ()
        """How the engine's parts are, as far as is known."""
        self._floor_map: FloorMap | None = None
        self._watchdog = Watchdog(stage.clock())
        self._noticing = Noticing(stage)
        self.alerting = Alerting(stage)
        self.ending = Ending(stage)
        self.puts_back = False
        """What stands in the line is a request that was taken back: sent, it waits in its place again."""

    def begin(self) -> None:
        """Timers run from now on."""
        stage = self._stage
        self._frames = Pacer(stage, self._interval, self._draw)
        self._logs = Pacer(stage, LOG_FRAMES * self._interval, self._draw_log)
        self._parts_timer = stage.set_interval(PARTS_INTERVAL_S, self._ask_parts, pause=True)
        stage.set_interval(AGES_S, self._frames.ask)
        self._seldom = stage.set_interval(CALM_S, self._frames.ask, pause=True)
        stage.set_interval(INTERVAL_S, self._feel_pulse)

    def follow(self, handle: EngineHandle) -> Callable[[], None]:
        """The engine is there; gives what ends this again."""
        clock = self._stage.clock
        unsubscribe = handle.subscribe(lambda event: self._inbox.put((event, clock())))
        self._ask_parts()
        self._parts_timer.resume()
        return unsubscribe

    def ask(self) -> None:
        """Something has changed: draw as soon as the pace allows."""
        self._unhinted = HINT_FRAMES
        self._frames.ask()

    def woken(self) -> None:
        """Events have come in."""
        if not self.calm:
            self._frames.ask()
            return
        self._arrived += self._inbox.take()
        if all(isinstance(event.body, _MOTION) for event, _ in self._arrived):
            self._seldom.resume()
        else:
            self._frames.ask()

    def stop_read(self, *, sent: bool) -> None:
        """The key that stops was read, and ``sent`` to the engine. In the thread that reads."""
        self._stop_dealt, self._ended_by_stop, self.stop_asked = False, None, sent

    def stop_dealt(self, unsent: int) -> None:
        """The key that stops has been dealt out, and took so many requests that had not been sent."""
        if self._stop_dealt and not unsent:
            return
        self._stop_dealt = True
        self._unsent = unsent
        if not self.stop_asked and self._ended_by_stop is None:  # it was not sent
            self._ended_by_stop = _Ended(0, asks=False, ran=False)
        self._tell_stopped()

    def _tell_stopped(self) -> None:
        """Say what the key that stops ended, or that there was nothing, once all of it is known. Of what ran, the
        conversation tells."""
        if (found := self._ended_by_stop) is None or not self._stop_dealt:
            return
        waiting = found.waiting + self._unsent
        self._ended_by_stop, self._unsent = None, 0
        if found.ran and not waiting:
            return
        ended = [strings.WITHDRAWN] if found.asks else []
        ended += [strings.WAITING_DROPPED[waiting == 1].format(waiting)] if waiting else []
        if ended:
            if not self._stage.main.is_one_line:  # which tells each of them in the place of a notice
                self._stage.remark(" · ".join(ended))
        else:
            self.nothing_to_stop()

    def nothing_to_stop(self) -> None:
        """The key that stops was pressed while all was still: say so, and which key goes back."""
        self._stage.remark(hint_line(strings.NOTHING_TO_STOP, self._stage.acting), here=True)

    def log(self, level: Literal["info", "warning", "error"], text: str) -> None:
        """A line in the log that the console itself has to tell."""
        self.model = self.model.with_log(level, "console", text, t=self.time)
        self.ask()

    def pace(self, fps: float | None = None) -> None:
        """So many frames a second from now on, and fewer on a line that bears fewer."""
        self._interval = 1 / fps if fps is not None else self._interval
        interval = self._sending.slower * self._interval
        self._frames.pace(interval)
        self._logs.pace(LOG_FRAMES * interval)

    def taken_back(self, request: str) -> None:
        """The waiting request of this id is dropped only to stand in the line."""
        self.model = replace(self.model, taken_back=request)

    def left_out(self, text: str, note: str) -> None:
        """A request comes to nothing that the engine does not know of: it has a row with this note."""
        text = printable(text)
        self.model = self.model.with_end(text, note=note).with_line(Line("lost", text, note))
        self.ask()

    def browse(self, step: int) -> None:
        """Look at another turn; beyond the newest one, at whichever is the newest."""
        self.browse_to(self._beside(step))

    def can_browse(self, step: int) -> bool:
        """There is another turn to look at in this direction."""
        return self._beside(step) != self.browsed

    def _beside(self, step: int) -> str | None:
        """The turn so many after the one that is looked at; None: the newest."""
        ids = [turn.id for turn in self.model.turns.kept]
        here = ids.index(self.browsed) if self.browsed in ids else len(ids) - 1 if self.browsed is None else -1
        there = max(0, here + step)
        return ids[there] if there < len(ids) - 1 else None

    def browse_to(self, turn: str | None) -> None:
        """Look at the turn of this id; None: at the newest from now on."""
        if self.browsed is None or turn is None:  # what is new is new until somebody looks at it
            self._counted = self.model.turns.count
        self.browsed = turn
        self.ask()

    def now(self) -> bool:
        """Draw at once. True while something moves by itself."""
        self._unhinted = HINT_FRAMES
        return self._draw()

    @property
    def ticking(self) -> bool:
        """Something is drawn again and again."""
        return self._frames.ticking or self._logs.ticking

    @property
    def due(self) -> bool:
        """A frame has been asked for and is not drawn yet."""
        return self._frames.asked

    def _draw(self) -> bool:
        """Fold what has come in and show it."""
        stage = self._stage
        if not stage.screen_stack:  # the console is being left
            return False
        arrived, self._arrived = [*self._arrived, *self._inbox.take()], []
        for event, when in arrived:
            before, self.model = self.model, self.model.after(event)  # those who hear of it may add to the log
            self._session = event.session
            self._lag = min(self._lag, when - event.t)
            self.on_event(event.body)
            if isinstance(event.body, Log):
                self._noticing.hear(event.body)
            if isinstance(event.body, InterruptRaised) and self.stop_asked:
                self.stop_asked = False
                moved = self.view.robot is not None and self.view.robot.moving
                if event.body.scope == "interrupt" and event.body.state in REST and not moved:
                    begun = event.turn is not None  # it waits for the robot
                    self._ended_by_stop = _Ended(len(before.waiting) + begun, asks=before.asks, ran=False)
                else:
                    self._ended_by_stop = _Ended(0, asks=False, ran=True)
                self._tell_stopped()
        if any(isinstance(event.body, Log | ErrorRaised) for event, _ in arrived):
            self._parts_timer.resume()  # a part may have changed
        model = self.model
        if not model.unfinished:
            self._leaving.asked = False
        if self.tour is not None and self.tour.due and any(line.who == "you" for line in model.conversation):
            self.tour.end()
        self.alerting.look(model)
        if model.problem is not None and model.problem.fatal:
            self._leaving.failed(ExitCode.MISSING if model.problem.code == "robot_lost" else ExitCode.FAILED)
        if self.model.log is not self._logged:
            self._logged = self.model.log
            self._logs.ask()
        only_moves = self.view.moving and model.moving and all(isinstance(event.body, _MOTION) for event, _ in arrived)
        at = (stage.screen, stage.focused)
        hint = not only_moves or self.calm or self._unhinted >= HINT_FRAMES or at != self._hinted_at
        self._unhinted, self._hinted_at = 1 if hint else self._unhinted + 1, at
        view = self._view(hint)
        if stage.main.is_one_line:
            view = self._with_ends(view)
        self.view = view
        if stage.screen is stage.main:  # a screen that changes under another one has that one drawn as a whole
            stage.main.show(view, hint=hint)
        elif isinstance(stage.screen, Following):
            stage.screen.show(view)
        if self.calm:
            self._seldom.resume() if view.moving else self._seldom.pause()
            return False
        if view.moving:
            self._viewing.hurry()
        return view.moving

    @property
    def failed(self) -> bool:
        """The engine did not start, and will not."""
        problem = self.model.problem
        return self._stage.handle is None and problem is not None and problem.fatal

    @property
    def time(self) -> float:
        """What the clock of the events says now; before there is any, the time of the newest."""
        return max(self.model.t, self._stage.clock() - self._lag)

    def _view(self, hint: bool) -> View:
        """What is to be seen now; without ``hint`` with the keys of the last time."""
        model, handle = self.model, self._stage.handle
        bare = self._sending.fare == "bare"
        view = View(
            model=model,
            now=self.time,
            started=handle is not None,
            failed=self.failed,
            newest=self._newest() if hint else self.view.newest,
            session=self._session,
            hints=self._hints() if hint else self.view.hints,
            parts=self.parts,
            floor_map=self._floor_map,
            turn=(turn := self._turn_looked_at()),
            fresh=model.turns.count - self._counted if turn is not None else 0,
            bare=bare,
            link=self._sending.figures(),
            touring=self.tour is not None and self.tour.due,
        )
        if handle is not None:
            view = replace(
                view,
                robot=handle.robot_state(),
                places=handle.places(),
                world=handle.world(),
                scan=None if bare else handle.scan(),
            )
        view = replace(view, notice=self._notice(view))
        if words := self.standstill(view):
            release = strings.ESTOP_RELEASE.format(release=self._stage.reaching(RELEASE))
            view = replace(view, notice=words, notice_does=RELEASE, remark=view.notice, release=release)
        return view

    def _with_ends(self, view: View) -> View:
        """With how requests ended, unless something more urgent is to be read."""
        pressed = view.robot is not None and view.robot.estop
        hidden = bool((view.notice and not view.standstill) or view.model.partial)
        cut = self._stage.main.has_one_row and view.model.asking
        self.ending.look(view.model, pressed=pressed, hidden=hidden, cut=cut)
        return replace(view, ends=self.ending.told, outdated=self.ending.outdated)

    def _turn_looked_at(self) -> Turn | None:
        """The turn that somebody looks at, also when it is so old that it is not kept any more."""
        if self.browsed is None:
            self._looked_at = None
        else:
            kept = self.model.turns.kept
            self._looked_at = next((turn for turn in kept if turn.id == self.browsed), self._looked_at)
        return self._looked_at

    def _newest(self) -> str:
        return self._stage.acting("newest") or "" if self._stage.main.reads_conversation else ""

    def _hints(self) -> tuple[Hint, ...]:
        """The keys that do something now, where the keyboard is; the one that stops is always among them."""
        stage, line = self._stage, self._stage.main.line
        on_main = stage.screen is stage.main
        if stage.typing:
            there = IN_SEARCH if not (on_main and line.has_focus) else IN_TEXT if line.value else IN_LINE
        else:
            there = IN_PANES if on_main else ON_PAGE
        return tuple(hint for name in there if (hint := self._hint(name)) is not None)

    def _hint(self, action: str) -> Hint | None:
        stage, model = self._stage, self.model
        word = strings.KEY_WORDS[action]
        if action == "interrupt":
            return Hint(action, stage.shown_keys[action], word, model.busy or model.moving)
        if action == "send" and self.puts_back:
            word = strings.PUTS_BACK
        key = stage.acting(action)
        return Hint(action, key, word, True) if key is not None else None

    def _draw_log(self) -> bool:
        self._stage.main.show_log(self.model)
        return False

    def _ask_parts(self) -> None:
        """Ask the engine how its parts are; stop asking once none is loading."""
        handle = self._stage.handle
        assert handle is not None
        parts = handle.status()
        self._noticing.look(parts)
        if _robot_state(parts) == "ready" and _robot_state(self.parts) == "loading":
            self.model = robot_is_back(self.model)
        if self._floor_map is None:
            self._floor_map = handle.floor_map()
        if not any(part.state == "loading" for part in parts):
            self._parts_timer.pause()
        if parts != self.parts:
            self.parts = parts
            self.ask()

    def _feel_pulse(self) -> None:
        stage = self._stage
        if self._sending.feel():
            self.pace()
            self._viewing.spare(self._sending.fare)
            self.ask()
        if stage.handle is None:
            return
        match self._watchdog.look(stage.clock(), stage.handle.pulse()):
            case "silent":
                keys = stage.shown_keys
                self.model = engine_is_silent(self.model, stop=keys["interrupt"], leave=keys["leave_now"], t=self.time)
            case "back":
                self.model = engine_is_back(self.model)
            case None:
                return
        self.ask()


def _robot_state(parts: Sequence[PartStatus]) -> PartState | None:
    return next((part.state for part in parts if part.name == "robot"), None)
