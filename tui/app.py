"""The console: it holds an engine, shows what the engine says, and passes on what a person wants.

The screen is painted before the engine exists: whoever starts the console hands it a function that starts one, and that
function runs in a thread behind the first picture. From then on there are two directions and nothing else: events come
in and are drawn (``tui.rooms.drawing``), and keys become commands. What has a state of its own has a room of its own:
the line to the terminal (``tui.rooms.sending``), the camera (``tui.rooms.viewing``), what a person takes along
(``tui.rooms.keeping``), the palette (``tui.rooms.choosing``), the doctor (``tui.rooms.examining``), the settings
(``tui.rooms.dressing``, ``tui.rooms.changing``) and the end (``tui.rooms.leaving``).
"""

from __future__ import annotations

import gc
import math
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from msgspec.structs import replace
from rich.console import RenderableType
from textual import _time, events
from textual.actions import ActionParseResult
from textual.app import App
from textual.dom import DOMNode
from textual.driver import Driver
from textual.keys import _character_to_key
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Input

from config.errors import ConfigError
from engine import events as ev
from engine.commands import Drive, EndTask, Here, Interrupt, LimitSpeed, Quit, Say, Wake
from engine.errors import ExitCode, SaysoError
from tui.keys.bindings import BINDINGS
from tui.keys.keys import ALL_KEYS, EDITING
from tui.keys.speeds import LIMITS, limit_beside
from tui.looks.themes import CONTRAST, DARK, LIGHT
from tui.messages import (
    Answered,
    Dressed,
    Failed,
    HungUp,
    KeyDone,
    Measured,
    Recalled,
    Reported,
    Seen,
    Settled,
    Started,
    Told,
    Warned,
    Woken,
)
from tui.rooms.changing import Changing
from tui.rooms.choosing import Choosing
from tui.rooms.drawing import Drawing
from tui.rooms.dressing import Dressing, Rooms
from tui.rooms.early import Early
from tui.rooms.emergency import EmergencyStop
from tui.rooms.enabling import Enabling
from tui.rooms.examining import Examining
from tui.rooms.keeping import Keeping, while_still
from tui.rooms.leaving import Leaving
from tui.rooms.queueing import Queueing
from tui.rooms.sending import Sending
from tui.rooms.viewing import Viewing
from tui.screens.pages import Paged, Placed, Stepped
from tui.shown.facts import Problem, printable
from tui.shown.offers import FollowUp, offered, why_not
from tui.shown.readiness import deaf, no_robot
from tui.shown.view import View
from tui.stage import Stage
from tui.terminal.bursts import Burst
from tui.terminal.driver import listening_driver
from tui.widgets.ask import Ask
from tui.widgets.by_hand import ByHand
from tui.widgets.figures import Figures, link_words
from tui.widgets.floor_view import FloorView
from tui.widgets.log import LogView
from tui.widgets.queue import ActionQueue
from tui.widgets.status import StatusLine
from tui.widgets.text_line import TextLine, is_text
from tui.widgets.timeline import Timeline
from tui.words import strings
from tui.words.hints import hint_line
from tui.words.language import Language, of_environment, speak

if TYPE_CHECKING:
    from rich.text import Text
    from textual.filter import LineFilter
    from textual.widget import Widget

    from engine.handle import EngineHandle
    from tui.palette.form import Form
    from tui.palette.palette import Palette
    from tui.screens.panes import PaneName


class SaysoApp(Stage):
    """The application. ``start_engine`` runs in a thread and returns the engine, or raises ``SaysoError``."""

    TITLE = strings.NAME
    CSS_PATH = "screens/console.tcss"  # here, because Textual does not read the style sheet of a default screen
    BINDINGS = BINDINGS
    ENABLE_COMMAND_PALETTE = False

    def __init__(
        self,
        start_engine: Callable[[], EngineHandle],
        *,
        theme: str = DARK.name,
        fps: float = 8.0,
        keymap: Mapping[str, str] | None = None,
        language: Language = "en",
        clock: Callable[[], float] = time.monotonic,
        passing: Callable[[str], str] = lambda data: data,
        one_line: bool = False,
    ) -> None:
        """``keymap`` replaces keys by action id (see ``tui.keys.keys``); ``clock`` is monotonic seconds; ``passing``
        says what is written of what is to be written to the terminal; ``one_line``: all of it stands on one line."""
        keys = {key.id: key.key for key in ALL_KEYS} | {
            action: ",".join(_character_to_key(key) if len(key) == 1 else key for key in chosen.split(","))
            for action, chosen in (keymap or {}).items()
        }
        speak(language)
        self._passing = passing
        super().__init__(keys, clock, one_line=one_line)
        for one in (DARK, LIGHT, CONTRAST):
            self.register_theme(one)
        self._begin_dark()
        self.theme = theme
        self.set_keymap(keys)
        self.sending = Sending(self)
        self.viewing = Viewing(self, self.sending)
        self.leaving = Leaving(self)
        self.drawing = Drawing(self, self.sending, self.viewing, self.leaving, self.notice, fps)
        self.keeping = Keeping(self)
        self.emergency = EmergencyStop(self, self.drawing, self.keeping)
        self.drawing.standstill = self.emergency.standstill
        self.enabling = Enabling(self, self.drawing, self.leaving, self.emergency, one_line=one_line)
        self.early = Early(self, self.drawing)
        self.queueing = Queueing(self, self.drawing, self.keeping, self.early)
        self.examining = Examining(self, self.keeping)
        self.dressing = Dressing(self, Rooms(self.drawing, self.viewing, self.examining, self.leaving, self.early))
        self.drawing.on_event = self._heard
        self.dress, self.speak = self.dressing.dress, self.dressing.speak
        self.changing = Changing(self, self.dressing)
        self.leaving.at_the_end(self.dressing.close)
        self.leaving.at_the_end(self.changing.close)
        self._choosing = Choosing(self, self.changing, self.keeping)
        self._start_engine = start_engine
        self._is_ready = False
        self._stopped_at = -math.inf  # when a key that stops was read last, in the time of Textual's messages…
        self._stopped_by: Literal["interrupt", "estop"] = "interrupt"  # which of them
        self._dealt_stop = -math.inf  # …of the last of them that has been dealt out…
        self._acted_at = -math.inf  # …of the last other key that has been dealt out, when it was read…
        self._sent_at = -math.inf  # …and when a request was sent last
        self._unsent = 0  # requests that a key took which stops, and which has not been dealt out yet
        self._keys: deque[events.Key | Burst] = deque()  # that wait to be dealt out
        self._taker: Widget | None = None  # what the last one was dealt out to, and which is not done with it

    def _heard(self, body: ev.Body) -> None:
        """As it is drawn."""
        self.keeping.hear(body)
        self.queueing.hear(body)
        self.dressing.hear(body)

    def _begin_dark(self) -> None:
        """Have the usual theme. Setting it would read every style sheet twice before the first picture."""
        self.set_reactive(App.theme, DARK.name)
        self.add_class(f"-theme-{DARK.name}", update=False)  # as Textual does
        self.stylesheet.set_variables(self.get_css_variables())

    @property
    def shown(self) -> View:
        """What is on the screen."""
        return self.drawing.view

    def redraw(self) -> None:
        self.drawing.ask()

    def draw(self) -> None:
        self.drawing.now()

    def note(self, level: Literal["info", "warning", "error"], text: str) -> None:
        self.drawing.log(level, text)

    def remark(self, text: str, *, here: bool = False) -> None:
        self.keeping.remark(text, holds=while_still, here=here)

    def notice(self, view: View) -> str:
        """What must be read in the status line now."""
        told, ended = self.keeping.notice(view), self.drawing.model.ended
        if ended is None and not self.leaving.asked:
            return told
        leave = self.acting("leave") or self.acting("leave_now")
        if ended is not None:
            return strings.SESSION_ENDED.format(reason=strings.REASONS.get(ended, ended), leave=leave)
        question = strings.QUIT_QUESTION if self.drawing.model.busy else strings.QUIT_QUESTION_OPEN
        return question.format(leave=leave, interrupt=self.shown_keys["interrupt"])

    # Starting

    def get_default_screen(self) -> Screen[None]:
        return self.main

    def get_driver_class(self) -> type[Driver]:
        return listening_driver(
            super().get_driver_class(),
            self._key_arrived,
            lambda: self.leaving.hang_up(),
            lambda: self.post_message(Reported(self.clock())),
            lambda answer: self.post_message(Answered(answer)),
            self._passing,
        )

    def on_mount(self) -> None:
        self.drawing.begin()
        if not self.is_headless and threading.current_thread() is threading.main_thread():
            self.leaving.watch()

    def on_ready(self) -> None:
        """All panes are there: draw them, and begin what takes long only after that."""
        if self.main.focused is None:
            self.main.type()  # before the screen was there, it could not have the keyboard
        self._is_ready = True
        self.call_later(self._deal)
        self.redraw()
        self.call_after_refresh(self._start)

    def _start(self) -> None:
        gc.freeze()  # what is there by now stays for good; whoever started us may have put off collecting
        gc.enable()
        threading.Thread(target=self._start_in_thread, name="engine-start", daemon=True).start()

    def _start_in_thread(self) -> None:
        try:
            handle = self._start_engine()
        except Exception as error:  # noqa: BLE001 - whatever it was, a person must read it
            self.post_message(Failed(error, strings.ENGINE_FAILED, fatal=True))
            return
        if not self.post_message(Started(handle, handle.offer())):  # the console was left in the meantime
            handle.send(Quit())

    def on_started(self, message: Started) -> None:
        self.handle = message.handle
        self.offer = message.offer
        self.main.line.know(message.offer.words)
        self.leaving.unsubscribe = self.drawing.follow(message.handle)
        self.emergency.begin()
        self.viewing.begin()
        for command in self.early.take():
            self._send_or_leave(command)

    def on_failed(self, message: Failed) -> None:
        error = message.error
        if isinstance(error, SaysoError | ConfigError):
            problem, code = Problem(error.message, error.hint, message.title, message.fatal), ExitCode(error.exit_code)
        else:
            words = self.leaving.noted(error)
            problem, code = Problem(words, strings.CRASH_HINT, message.title, message.fatal), ExitCode.FAILED
        problem = replace(problem, message=printable(problem.message), hint=printable(problem.hint))
        if message.fatal:
            self.leaving.failed(code)
            self.early.leave(strings.NO_ENGINE)
        model = self.drawing.model.with_log("error", "engine", problem.message, t=self.drawing.time)
        self.drawing.model = replace(model, problem=problem)
        self.redraw()

    # Settings, which are read behind the first picture

    def on_dressed(self, message: Dressed) -> None:
        self.dressing.dressed(message)

    def on_recalled(self, message: Recalled) -> None:
        self.dressing.recalled(message.keys, message.history)

    def on_measured(self, message: Measured) -> None:
        self.dressing.measured(message.shares, message.file)

    def on_settled(self, message: Settled) -> None:
        self.changing.settled(message)

    # From other threads

    def on_woken(self, message: Woken) -> None:
        self.drawing.woken()

    def on_warned(self, message: Warned) -> None:
        self.note("warning", message.text)

    def on_told(self, message: Told) -> None:
        self.keeping.tell(message.text, message.level, message.file)

    def on_seen(self, message: Seen) -> None:
        self.viewing.seen(message.found)

    def on_reported(self, message: Reported) -> None:
        self.sending.reported(message.t)

    def on_answered(self, message: Answered) -> None:
        self.viewing.answered(message.answer)

    def on_app_focus(self) -> None:
        self.drawing.alerting.looked_at = True

    def on_app_blur(self) -> None:
        self.drawing.alerting.looked_at = False

    def on_hung_up(self, message: HungUp) -> None:
        self.leaving.leave()

    # From keys to the engine

    def _key_arrived(self, key: str) -> None:
        """In the thread that reads the keyboard, before the key is queued: stopping waits for nothing."""
        stops, presses = key in self.dressing.stop_keys, key in self.dressing.estop_keys
        if stops or presses:
            self._stopped_by = "interrupt" if stops else "estop"
            self._stopped_at = _time.get_time()
        if stops:
            self.drawing.stop_read(sent=self.handle is not None)
            self.send(Interrupt())
        if presses:
            self.emergency.press()

    def action_interrupt(self) -> None:
        """The robot has stopped by now. What waits for an answer is answered by that; nothing else changes. A request
        that was sent since, by a key before this one, is stopped, too."""
        if self.is_headless:  # there is no keyboard to read, and no thread that has already done it
            self._key_arrived(next(iter(self.dressing.stop_keys)))
        if overtaken := self._sent_at > self._stopped_at > self._dealt_stop:
            self.send(Interrupt())
        self.drawing.stop_dealt(self._stop_dealt("interrupt") + overtaken)
        self.leaving.asked = False
        self.main.floor.ask_no_more()
        self.redraw()

    def action_estop(self) -> None:
        if self.is_headless:  # as above
            self._key_arrived(next(iter(self.dressing.estop_keys)))
        if self.handle is None:
            self.emergency.press()
        if unsent := self._stop_dealt("estop"):
            self.remark(strings.WAITING_DROPPED[unsent == 1].format(unsent))
        self.emergency.tell_pressed()

    def _stop_dealt(self, by: Literal["interrupt", "estop"]) -> int:
        """A key that stops is dealt out: how many requests it took that had not been sent."""
        self._dealt_stop = self._stopped_at
        unsent, self._unsent = self._unsent, 0
        self.queueing.stopped()
        return unsent + self.early.leave(strings.LOST_BY.format(reason=strings.REASONS[by]))

    def action_release(self) -> None:
        self.emergency.release()

    async def action_back(self) -> None:
        """One step, and never a stop."""
        if self.leaving.asked:
            self.leaving.asked = False
        elif self.screen is not self.main:
            if not (isinstance(self.screen, Stepped) and self.screen.step_back()):
                self.step_back()
        elif not await self.main.back():
            self.remark(hint_line(strings.NOTHING_BACK, self.acting), here=True)
        self.redraw_later()

    def action_by_hand(self) -> None:
        self.come_back()
        if self.main.driving_by_hand:
            self.main.rest()
        elif self.shown.standstill:
            self.keeping.tell(
                strings.NOT_WHILE_PRESSED.format(release=self.reaching("release")), holds=lambda view: view.pressed
            )
        elif self.handle is None or self.handle.robot_state() is None:
            why = no_robot(self.shown)
            self.keeping.tell(why, holds=lambda view: view.robot is None and no_robot(view) == why)
        else:
            self.main.drive_by_hand()

    def action_speed(self, step: int) -> None:
        """Another speed limit; the robot that drives already heeds it at once."""
        if self.screen is self.main and self.handle is not None and (robot := self.handle.robot_state()) is not None:
            limit = limit_beside(robot.speed_limit, step)
            self.send(LimitSpeed(limit))
            if not self.main.figures_in_sight:
                self.keeping.remark(strings.SPEED_LIMIT_IS.format(strings.SPEED_LIMITS[LIMITS.index(limit)]))
            self.redraw()

    def on_figures_limited(self, message: Figures.Limited) -> None:
        self.action_speed(message.step)

    def on_by_hand_driven(self, message: ByHand.Driven) -> None:
        self.send(Drive(message.vx, message.vy, message.wz))

    def action_wake(self) -> None:
        """Where nobody can be heard, that is said, and nothing stops for it."""
        parts = self.handle.status() if self.handle is not None else ()
        if (missing := deaf(parts)) is not None:
            self.keeping.remark(strings.DEAF[missing], holds=lambda view: deaf(view.parts) == missing)
            return
        self._follow()
        self.send(Wake("key"))

    def action_end_task(self) -> None:
        self.send(EndTask())

    def on_ask_asked(self, message: Ask.Asked) -> None:
        self.dressing.typed(message.text)
        self._ask(self.queueing.asked(*message.requests, waits=message.waits, here=message.here))

    def on_action_queue_dropped(self, message: ActionQueue.Dropped) -> None:
        self.queueing.drop(message.request)

    def on_action_queue_moved(self, message: ActionQueue.Moved) -> None:
        self.queueing.move(message.request, message.before)

    def on_action_queue_taken_back(self, message: ActionQueue.TakenBack) -> None:
        self.queueing.take_back(message.request)

    def action_resume(self) -> None:
        self._follow_up("resume")

    def action_undo(self) -> None:
        self._follow_up("undo")

    def action_again(self) -> None:
        self._follow_up("again")

    def _follow_up(self, kind: FollowUp) -> None:
        """Ask for what is offered, in its word; or say why it is not offered."""
        self.drawing.now()
        model = self.drawing.model
        if kind in offered(model):
            self._ask(Say(strings.FOLLOW_UPS[kind]))
        else:
            words, holds = why_not(kind, model, self.shown_keys | {"release": self.reaching("release")})
            self.keeping.tell(words, holds=holds)

    def on_floor_view_touched(self) -> None:
        self.redraw()

    def on_floor_view_chosen(self, message: FloorView.Chosen) -> None:
        self._ask(Say(message.request))

    def on_floor_view_put(self, message: FloorView.Put) -> None:
        self.send(Here(message.x, message.y, message.yaw))

    def _ask(self, command: Say) -> None:
        """Ask for this; once the engine is there, where that takes its time."""
        self._follow()
        if self.handle is not None or self._is_stopped:
            self._send_or_leave(command)
            return
        if self.drawing.failed:
            self._leave(command, strings.NO_ENGINE)
            return
        if self.early.add(command, self.queueing.place_of(command)) == "estop":
            self.emergency.press()
            self.emergency.tell_pressed()

    @property
    def _is_stopped(self) -> bool:
        """What is asked for now was asked for before a key that stops, which has acted when it was read and has not
        been dealt out yet."""
        return self._stopped_at > self._dealt_stop and self._stopped_at >= self._acted_at

    def _send_or_leave(self, command: Say) -> None:
        """Keys count in the order in which they were pressed: what was asked for before a stop does not run after
        it."""
        if self._is_stopped:
            self._leave_unsent(command, self._stopped_by)
            return
        self.send(command)
        self._sent_at = _time.get_time()  # a stop that was read before this moment may have overtaken it

    def _leave_unsent(self, command: Say, by: Literal["interrupt", "estop"]) -> None:
        """A stop has come before it was sent."""
        self._unsent += 1 + len(command.then)
        self._leave(command, strings.LOST_BY.format(reason=strings.REASONS[by]))

    def _leave(self, command: Say, note: str) -> None:
        """It comes to nothing, and has a row that says why."""
        for request in (command.text, *command.then):
            self.drawing.left_out(request, note)

    def _follow(self) -> None:
        """The user asks for something: the end of the conversation is in sight again, and the turn that is looked at
        is the newest, unless it is on a page."""
        self.main.follow("conversation")
        if self.screen is self.main:
            self.drawing.browse_to(None)

    # Keys that only change what is shown

    async def _check_bindings(self, key: str, priority: bool = False) -> bool:
        """As Textual's; while somebody types, what is text and what edits goes to the line first, and what answers the
        map goes there."""
        if priority and ((self.typing and (key in EDITING or is_text(key))) or self.enabling.answers(key)):
            return False
        return await super()._check_bindings(key, priority)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether it would do something now: see ``tui.rooms.enabling``."""
        return self.enabling.check(action, parameters)

    def possible(self, action: str) -> bool:
        return self.enabling.possible(action)

    async def run_action(
        self,
        action: str | ActionParseResult,
        default_namespace: DOMNode | None = None,
        namespaces: Mapping[str, DOMNode] | None = None,
    ) -> bool:
        """As Textual's; an action that does nothing now (``check_action`` says None) keeps its key and may say why. It
        is False alone that leaves the key to whoever comes next."""
        target, name, parameters = self._parse_action(action, default_namespace or self, namespaces)
        if target.check_action(name, parameters) is False:
            return False
        return await self._dispatch_action(target, name, parameters)

    async def _dispatch_action(self, namespace: DOMNode, action_name: str, params: Any) -> bool:
        """As Textual's; where all stands on one line, what needs panes or pages says so."""
        if namespace is self and action_name in self.enabling.without_room:
            self.keeping.remark(strings.NO_ROOM_IN_LINE)
            return True
        return await super()._dispatch_action(namespace, action_name, params)

    async def on_event(self, event: events.Event) -> None:
        """As Textual's, but for keys, which are dealt out one after the other."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            self._keys.append(event)
            await self._deal()
        else:
            await super().on_event(event)

    async def _deal(self) -> None:
        """Deal keys out, each when the one before has done what it does, which may give the keyboard to something else.
        Over a slow line to the terminal many arrive at once. The first ones wait until the line has the keyboard."""
        while self._is_ready and self._keys and (self._taker is None or not self._taker.is_attached):
            key, self._taker = self._keys.popleft(), None
            last = key.keys[-1] if isinstance(key, Burst) else key
            if last.key not in self.dressing.stop_keys | self.dressing.estop_keys:
                self._acted_at = last.time
            if isinstance(key, Burst):
                self._take(key)
                continue
            await super().on_event(key)
            taker = self.focused or self.screen
            if key.is_forwarded and taker.post_message(KeyDone()):  # which comes back behind the key
                self._taker = taker
            else:
                self.redraw()  # other keys may act now

    async def on_burst(self, message: Burst) -> None:
        self._keys.append(message)
        await self._deal()

    def _take(self, burst: Burst) -> None:
        """In the line, several requests that come at once are one submission, each of which is done; the engine sees to
        it that a stop among them waits for none. Elsewhere they are keys."""
        if self.main.line.has_focus:
            self.main.line.take(burst.text)
        else:
            self._keys.extendleft(reversed(burst.keys))

    async def on_key_done(self, message: KeyDone) -> None:
        if not message.told:  # a request that the key sent may stand behind this, and comes before the next key
            self.post_message(KeyDone(told=True))
            return
        self._taker = None
        self.redraw()  # other keys may act now
        await self._deal()

    def on_paste(self, event: events.Paste) -> None:
        """Of what is pasted outside the line, nothing is lost and nothing is a key."""
        self.action_type()
        self.main.line.paste(event.text)

    def moved(self) -> None:
        self.keeping.moved()
        self.redraw()  # the keys that matter have changed

    def on_descendant_focus(self) -> None:
        self.moved()

    def on_descendant_blur(self) -> None:
        self.moved()

    def on_input_changed(self, event: Input.Changed) -> None:
        if event.input is self.main.line:
            self.queueing.written(event.value)

    async def on_text_line_commanded(self, message: TextLine.Commanded) -> None:
        await self.run_action(message.action)

    def on_text_line_turned(self) -> None:
        self.redraw()  # some keys act in an empty line only

    def on_resize(self) -> None:
        self.call_later(self.redraw_later)  # how much is told depends on the room there is

    def action_type(self) -> None:
        """Acts before the keys behind it are dealt out: what was typed ahead goes into the line."""
        self.come_back()
        self.main.type()

    def action_add(self) -> None:
        """Ask for what is in the line, after what runs."""
        if self.screen is self.main and self.main.line.has_focus and self.main.line.value:
            self.main.line.submit(waits=True)
        else:
            self.keeping.remark(strings.NOTHING_TO_ADD)

    def action_help(self) -> None:
        from tui.screens.help import HelpScreen  # pages are read when somebody wants them

        if isinstance(self.screen, HelpScreen):
            self.step_back()
        else:
            commands = self.command_in_line
            self.open_page(HelpScreen(self, commands, self._place, self.enabling.idle_borders()))

    @property
    def _place(self) -> str:
        """Where the keyboard is, as the help page calls it."""
        if self.screen is not self.main:
            return self.screen.place if isinstance(self.screen, Placed) else ""
        if self.main.line.has_focus:
            return "line"
        return "hand" if self.main.driving_by_hand else self.main.pane or ""

    def action_doctor(self) -> None:
        self.examining.toggle()

    def action_settings(self) -> None:
        self.changing.open()

    def open_page(self, page: Screen[None]) -> None:
        self.leaving.asked = False  # on a page, other keys leave and quit
        super().open_page(page)

    async def action_palette(self) -> None:
        self.leaving.asked = False
        await self._choosing.open()

    async def action_recall(self) -> None:
        await self._choosing.recall()

    async def on_status_line_chosen(self, message: StatusLine.Chosen) -> None:
        await self._choosing.act(message.action)

    async def on_palette_chosen(self, message: Palette.Chosen) -> None:
        await self._choosing.chosen(message.choice)

    async def on_form_composed(self, message: Form.Composed) -> None:
        await self._choosing.composed(message.text)

    def action_log(self) -> None:
        self.come_back()
        self.main.toggle_log()

    def action_link(self) -> None:
        """In the frame of the robot's pane, until the next press; for a while where that is not in sight."""
        self.come_back()
        if self.main.figures_in_sight:
            self.sending.meter()
            self.redraw()
        else:
            self.keeping.remark(link_words(self.sending.measured(), self.size.width))

    def action_map(self) -> None:
        if self.screen is self.main:
            self.main.point()

    def action_camera(self) -> None:
        there = self.screen is self.main and self.main.camera_in_sight
        self.come_back()
        self.viewing.show(not there)

    def action_copy(self) -> None:
        self.keeping.copy()

    def action_save(self) -> None:
        self.keeping.save()

    def action_pane(self, name: PaneName) -> None:
        """Go to the pane of this name."""
        if self.main.has_class("-tiny"):
            return
        self.come_back()
        if name == "camera" and not self.main.camera_shown:
            self.viewing.show(True)
        self.main.go_to(name)
        self.redraw_later()

    def action_next_pane(self, step: int) -> None:
        """Give the keyboard to the next pane or the one before, and after the last one to the line."""
        self.screen.focus_next() if step > 0 else self.screen.focus_previous()
        self.redraw()

    def action_zoom(self) -> None:
        if self.screen is self.main and not self.main.has_class("-tiny"):
            self.main.zoom()
            self.redraw_later()

    def action_border(self, steps: int) -> None:
        """Move the border between panes to the right."""
        if self.screen is not self.main:
            return
        if (shares := self.main.shift(steps)) is None:
            self.keeping.remark(strings.NO_BORDER)
            return
        if self.dressing.sizes is not None:
            self.dressing.sizes.keep(shares)
        self.redraw_later()

    def action_scroll_line(self, lines: int) -> None:
        if self.screen is self.main:
            self.main.scroll_lines(lines)

    def action_older(self) -> None:
        self._scroll_page(-1)

    def action_newer(self) -> None:
        self._scroll_page(1)

    def action_newest(self, name: PaneName | None = None) -> None:
        """To the end of this pane, or of the one that is meant."""
        if self.screen is not self.main:
            return
        if (name or self.main.pane) == "turns":
            self.drawing.browse_to(None)
        self.main.follow(name)

    def _scroll_page(self, step: int) -> None:
        page = self.screen if isinstance(self.screen, Paged) else self.main
        page.scroll_page(step)

    def action_timeline(self) -> None:
        self.come_back()
        self.main.toggle_timeline()
        self.redraw_later()

    def action_turn_back(self) -> None:
        self._browse(-1)

    def action_turn_on(self) -> None:
        self._browse(1)

    def _browse(self, step: int) -> None:
        self.drawing.browse(step)
        if self.screen is self.main:
            self.main.toggle_timeline(on=True)

    def on_timeline_chosen(self, message: Timeline.Chosen) -> None:
        older = self.drawing.model.turns.kept[:-1]  # the newest one is followed, as without a click
        self.drawing.browse_to(next((turn.id for turn in older if turn.number == message.number), None))
        self.drawing.now()
        self.action_turn()

    def on_log_view_opened(self, message: LogView.Opened) -> None:
        kept = [turn.id for turn in self.drawing.model.turns.kept]
        if message.turn not in kept:
            self.keeping.tell(strings.LINE_OF_NO_TURN)
            return
        self.drawing.browse_to(message.turn if message.turn != kept[-1] else None)
        self.drawing.now()
        self.action_turn()

    async def on_log_view_wanted(self, message: LogView.Wanted) -> None:
        await self._choosing.search_log()

    def action_turn(self) -> None:
        from tui.screens.turn import TurnScreen

        if isinstance(self.screen, TurnScreen):
            self.step_back()
        else:
            self.come_back()
            self.open_page(TurnScreen(self.acting, self.shown))

    # Leaving

    def action_leave(self) -> None:
        """Leave the page that is shown; on the main screen, quit, while something is open only when asked twice. A task
        that has ended is none, drawn or not."""
        if self.screen is not self.main:
            self.step_back()
            return
        self.drawing.now()
        if self.drawing.model.unfinished and not self.leaving.asked and not self.engine_hangs:
            self.leaving.asked = True
            self.redraw()
            return
        self.leaving.leave()

    def action_leave_now(self) -> None:
        self.leaving.leave()

    def _fatal_error(self) -> None:
        """As Textual's, but without the values of local variables and other secrets."""
        assert self._exception is not None
        told: Text = self.leaving.traceback(self._exception)
        self._exit_renderables.append(told)
        self._close_messages_no_wait()

    def _handle_exception(self, error: Exception) -> None:
        """As Textual's; the robot stops, and what happened is written down at the end."""
        self.leaving.fault(error)
        super()._handle_exception(error)

    # Drawing

    def get_line_filters(self) -> Sequence[LineFilter]:
        """As Textual's; a theme of high contrast is one in every pane."""
        filters = super().get_line_filters()
        if self.theme != CONTRAST.name:
            return filters
        from tui.looks.contrast import Lift  # which other themes do without

        return [*filters, Lift()]

    def _display(self, screen: Screen[Any], renderable: RenderableType | None) -> None:
        """As Textual's, with less to send, and only when the terminal has drawn what was sent before."""
        ready = self.sending.screened(renderable)
        super()._display(screen, ready)
        if ready is not None:
            self.viewing.send(screen, ready)
            self.sending.sent()


def run_console(
    start_engine: Callable[[Callable[..., None]], EngineHandle],
    passing: Callable[[str], str] = lambda data: data,
    *,
    one_line: bool = False,
) -> int:
    """Run the console until somebody leaves it, and return the exit code of the process.

    ``start_engine`` runs in a thread behind the first picture and returns the engine. It is given
    :meth:`SaysoApp.dress`, to tell theme, keys and the like once it has read the settings. ``passing`` is as in
    :meth:`SaysoApp.__init__`.
    """
    app = SaysoApp(
        lambda: start_engine(app.dress), language=of_environment(os.environ), passing=passing, one_line=one_line
    )
    return app.leaving.run()
