"""The console: it holds an engine, shows what the engine says, and passes on what a person wants.

The screen is painted before the engine exists: whoever starts the console hands it a function that starts one, and
that function runs in a thread behind the first picture. From then on there are two directions and nothing else:
events come in through an inbox and are folded into a :class:`~tui.model.ConsoleModel` that the screen draws, and keys
become commands. What moves (pose, level, running durations) is sampled at a fixed pace, and only while it moves.
"""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import FrameType
from typing import TYPE_CHECKING, Final

from textual.app import App
from textual.driver import Driver
from textual.keys import _character_to_key
from textual.message import Message
from textual.screen import Screen

from config.errors import ConfigError
from engine.commands import Command, EndTask, Interrupt, Quit, Say, Wake
from engine.errors import ExitCode, SaysoError
from engine.events import ErrorRaised, Event, Log
from engine.scheduling import prefer, raise_priority
from tui import strings
from tui.driver import listening_driver
from tui.facts import Problem, printable
from tui.keys import BINDINGS, KEYS, shown
from tui.model import ConsoleModel
from tui.pacing import Inbox, Pacer
from tui.screens.console import ConsoleScreen, View
from tui.screens.help import HelpScreen
from tui.themes import DARK, LIGHT
from tui.watchdog import INTERVAL_S, SILENT_S, Watchdog, engine_is_back, engine_is_silent, robot_is_back
from tui.widgets.ask import Ask
from tui.widgets.status import Hint

if TYPE_CHECKING:
    from engine.handle import EngineHandle, PartState, PartStatus
    from engine.robot.robot import FloorMap

LOG_FRAMES: Final = 4
"""The log scrolls as a whole, which is much to send: it is redrawn once in so many frames."""
PARTS_INTERVAL_S: Final = 0.25
"""How often the parts are asked how they are while some are still loading."""
LEAVE_LIMIT_S: Final = 3.0
"""How long an orderly end may take when the terminal is gone or the process is to end."""
ALL_KEYS_COLUMNS: Final = 76
"""Columns from which the status line has room for all keys."""


class SaysoApp(App[None]):
    """The application. ``start_engine`` runs in a thread and returns the engine, or raises ``SaysoError``."""

    TITLE = strings.NAME
    CSS_PATH = "screens/console.tcss"  # here, because Textual does not read the style sheet of a default screen
    BINDINGS = BINDINGS
    ENABLE_COMMAND_PALETTE = False

    class Woken(Message):
        """Events lie in the inbox."""

    class Started(Message):
        """The engine is there."""

        def __init__(self, handle: EngineHandle) -> None:
            super().__init__()
            self.handle = handle

    class HungUp(Message):
        """The terminal is gone, or somebody ends the process."""

    class Dressed(Message):
        """The settings are read: how the console is to look."""

        def __init__(self, theme: str, fps: float) -> None:
            super().__init__()
            self.theme = theme
            self.fps = fps

    class Failed(Message):
        """The engine did not start, or did not take a command."""

        def __init__(self, error: Exception, title: str, *, fatal: bool) -> None:
            super().__init__()
            self.error = error
            self.title = title
            self.fatal = fatal

    def __init__(
        self,
        start_engine: Callable[[], EngineHandle],
        *,
        theme: str = DARK.name,
        fps: float = 8.0,
        keymap: Mapping[str, str] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """``keymap`` replaces keys by action id (see ``tui.keys``); ``clock`` is monotonic seconds."""
        super().__init__()
        self.register_theme(DARK)
        self.register_theme(LIGHT)
        self.theme = theme
        keys = {key.id: key.key for key in KEYS} | {
            action: ",".join(_character_to_key(key) if len(key) == 1 else key for key in chosen.split(","))
            for action, chosen in (keymap or {}).items()
        }
        self.set_keymap(keys)
        self._stop_keys = frozenset(keys["interrupt"].split(","))
        self._shown_keys = {action: "/".join(map(shown, key.split(","))) for action, key in keys.items()}
        self._start_engine = start_engine
        self._handle: EngineHandle | None = None
        self._unsubscribe: Callable[[], None] | None = None
        self._inbox: Inbox[tuple[Event, float]] = Inbox(lambda: self.post_message(self.Woken()))
        self._clock = clock
        self._lag = float("inf")  # smallest seen difference between our clock and event time
        self._interval = 1 / fps
        self._model = ConsoleModel()
        self._shown = View(self._model)
        self._logged = self._model.log  # what the log has been asked to show
        self._parts: tuple[PartStatus, ...] = ()
        self._floor_map: FloorMap | None = None
        self._asked_early: list[Say] = []  # typed before the engine was there
        self._quit_asked = False
        self._watchdog = Watchdog(clock())
        self._left = threading.Event()
        self._exit_code = ExitCode.DONE
        self._main = ConsoleScreen(self._shown_keys)

    @property
    def shown(self) -> View:
        """What is on the screen."""
        return self._shown

    # Starting

    def get_default_screen(self) -> Screen[None]:
        return self._main

    def get_driver_class(self) -> type[Driver]:
        return listening_driver(super().get_driver_class(), self._key_arrived, self._hang_up)

    def on_mount(self) -> None:
        self._frames = Pacer(self, self._interval, self._draw)
        self._logs = Pacer(self, LOG_FRAMES * self._interval, self._draw_log)
        self._parts_timer = self.set_interval(PARTS_INTERVAL_S, self._ask_parts, pause=True)
        self.set_interval(INTERVAL_S, self._feel_pulse)
        if not self.is_headless and threading.current_thread() is threading.main_thread():
            for number in (signal.SIGHUP, signal.SIGTERM):
                signal.signal(number, self._signalled)

    def on_ready(self) -> None:
        """All panes are there: draw them, and begin what takes long only after that."""
        self._frames.ask()
        self.call_after_refresh(self._start)

    def _start(self) -> None:
        gc.freeze()  # what is there by now stays for good; whoever started us may have put off collecting
        gc.enable()
        threading.Thread(target=self._start_in_thread, name="engine-start", daemon=True).start()

    def _start_in_thread(self) -> None:
        try:
            handle = self._start_engine()
        except Exception as error:  # noqa: BLE001 - whatever it was, a person must read it
            self.post_message(self.Failed(error, strings.ENGINE_FAILED, fatal=True))
            return
        if not self.post_message(self.Started(handle)):  # the console was left in the meantime
            handle.send(Quit())

    def dress(self, theme: str, fps: float, *, prompt: bool = False) -> None:
        """Look as the settings say. Thread-safe: settings are read behind the first picture.

        ``prompt``: the thread that reads the keyboard goes before others, where the system allows it.
        """
        if prompt and (reader := getattr(self._driver, "reader", None)) is not None:
            raise_priority(reader)
            prefer(threading.main_thread().native_id or 0)
        self.post_message(self.Dressed(theme, fps))

    def on_sayso_app_dressed(self, message: Dressed) -> None:
        if message.theme in self.available_themes:
            self.theme = message.theme
        else:
            self._model = self._model.with_log("warning", "console", strings.UNKNOWN_THEME.format(message.theme))
        self._frames.pace(1 / message.fps)
        self._logs.pace(LOG_FRAMES / message.fps)
        self._frames.ask()

    def on_sayso_app_started(self, message: Started) -> None:
        self._handle = message.handle
        self._unsubscribe = message.handle.subscribe(lambda event: self._inbox.put((event, self._clock())))
        self._ask_parts()
        self._parts_timer.resume()
        for command in self._asked_early:
            self._send(command)
        self._asked_early = []

    def on_sayso_app_failed(self, message: Failed) -> None:
        error = message.error
        if isinstance(error, SaysoError | ConfigError):
            problem, code = Problem(error.message, error.hint, message.title, message.fatal), ExitCode(error.exit_code)
        else:
            problem, code = Problem(repr(error), strings.CRASH_HINT, message.title, message.fatal), ExitCode.FAILED
        problem = replace(problem, message=printable(problem.message), hint=printable(problem.hint))
        if message.fatal:
            self._exit_code = code
        self._model = replace(self._model.with_log("error", "engine", problem.message), problem=problem)
        self._frames.ask()

    # From the engine to the screen

    def on_sayso_app_woken(self) -> None:
        self._frames.ask()

    def _draw(self) -> bool:
        """Fold what has come in and show it. True while something moves by itself."""
        arrived = self._inbox.take()
        model = self._model
        for event, when in arrived:
            model = model.after(event)
            self._lag = min(self._lag, when - event.t)
        if any(isinstance(event.body, Log | ErrorRaised) for event, _ in arrived):
            self._parts_timer.resume()  # a part may have changed
        if not model.busy:
            self._quit_asked = False
        if model.problem is not None and model.problem.fatal and self._exit_code is ExitCode.DONE:
            self._exit_code = ExitCode.MISSING if model.problem.code == "robot_lost" else ExitCode.FAILED
        self._model = model
        if model.log is not self._logged:
            self._logged = model.log
            self._logs.ask()
        robot = self._handle.robot_state() if self._handle is not None else None
        self._shown = View(
            model=model,
            now=max(model.t, self._clock() - self._lag),
            started=self._handle is not None,
            notice=self._notice(),
            hints=self._hints(),
            parts=self._parts,
            robot=robot,
            floor_map=self._floor_map,
            places=self._handle.places() if self._handle is not None else {},
            world=self._handle.world() if self._handle is not None else None,
        )
        self._main.show(self._shown)
        return model.moving or (robot is not None and robot.moving)

    def _draw_log(self) -> bool:
        self._main.show_log(self._model)
        return False

    def _ask_parts(self) -> None:
        """Ask the engine how its parts are; stop asking once none is loading."""
        assert self._handle is not None
        parts = self._handle.status()
        if _robot_state(parts) == "ready" and _robot_state(self._parts) == "loading":
            self._model = robot_is_back(self._model)
        if self._floor_map is None:
            self._floor_map = self._handle.floor_map()
        if not any(part.state == "loading" for part in parts):
            self._parts_timer.pause()
        if parts != self._parts:
            self._parts = parts
            self._frames.ask()

    def _feel_pulse(self) -> None:
        if self._handle is None:
            return
        match self._watchdog.look(self._clock(), self._handle.pulse()):
            case "silent":
                self._model = engine_is_silent(self._model, self._shown_keys)
            case "back":
                self._model = engine_is_back(self._model)
            case None:
                return
        self._frames.ask()

    @property
    def engine_hangs(self) -> bool:
        """The engine is there and does not answer; whoever waits for it waits for ever."""
        return self._handle is not None and self._handle.pulse() > SILENT_S

    def _notice(self) -> str:
        """What must be read in the status line now."""
        leave = self._shown_keys["leave"]
        if self._model.ended is not None:
            return strings.SESSION_ENDED.format(reason=self._model.ended, key=leave)
        return strings.QUIT_QUESTION.format(key=leave) if self._quit_asked else ""

    def _hints(self) -> tuple[Hint, ...]:
        model, here = self._model, self._handle is not None
        matters = {
            "interrupt": model.busy or model.moving,
            "wake": here and not self._main.typing,
            "end_task": here and not self._main.typing,
            "type": here and not self._main.typing,
            "help": not self._main.typing,
            "leave": not self._main.typing,
        }
        few = () if self.size.width >= ALL_KEYS_COLUMNS else ("help", "leave")
        return tuple(
            Hint(self._shown_keys[key.id], key.word, matters[key.id], urgent=key.id == "interrupt")
            for key in KEYS
            if key.word and key.id not in few
        )

    # From keys to the engine

    def _key_arrived(self, key: str) -> None:
        """In the thread that reads the keyboard, before the key is queued: stopping waits for nothing."""
        if key in self._stop_keys:
            self._send(Interrupt())

    def _send(self, command: Command) -> None:
        """Thread-safe. An interrupting command has stopped the robot when this returns."""
        if self._handle is None:
            return
        try:
            self._handle.send(command)
        except SaysoError as error:
            self.post_message(self.Failed(error, strings.SOMETHING_FAILED, fatal=False))

    def action_interrupt(self) -> None:
        if self.is_headless:  # there is no keyboard to read, and no thread that has already done it
            self._send(Interrupt())
        self._asked_early = []
        self._quit_asked = False
        if self.screen is not self._main:
            self.pop_screen()
        self._main.set_focus(None)
        self._frames.ask()

    def action_wake(self) -> None:
        self._send(Wake("key"))

    def action_end_task(self) -> None:
        self._send(EndTask())

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """A slash that is being typed is a slash."""
        return False if action == "type" and self._main.typing else super().check_action(action, parameters)

    def action_type(self) -> None:
        """Acts before the keys behind it are dealt out: what was typed ahead goes into the line."""
        if self.screen is not self._main:
            self.pop_screen()
        self._main.type()

    def action_help(self) -> None:
        if self.screen is self._main:
            self.push_screen(HelpScreen(self._shown_keys))
        else:
            self.pop_screen()

    def action_log(self) -> None:
        self._main.toggle_log()

    def action_older(self) -> None:
        self._main.scroll_conversation(-5)

    def action_newer(self) -> None:
        self._main.scroll_conversation(5)

    def action_leave(self) -> None:
        """Quit; while a task is running, only when asked twice."""
        if self._model.busy and not self._quit_asked and not self.engine_hangs:
            self._quit_asked = True
            self._frames.ask()
            return
        self.action_leave_now()

    def action_leave_now(self) -> None:
        """Quit: the robot has stopped when the console goes."""
        self._send(Quit())
        unsubscribe, self._unsubscribe = self._unsubscribe, None
        if self.engine_hangs:
            self._exit_code = self._exit_code or ExitCode.FAILED
        elif unsubscribe is not None:
            unsubscribe()
        self.exit(return_code=int(self._exit_code))

    def on_ask_asked(self, message: Ask.Asked) -> None:
        command = Say(message.text)
        if self._handle is not None:
            self._send(command)
            return
        self._asked_early.append(command)
        self._model = self._model.with_log("info", "console", strings.ASKED_EARLY.format(printable(message.text)))
        self._frames.ask()

    def on_descendant_focus(self) -> None:
        self._frames.ask()  # the keys that matter have changed

    def on_descendant_blur(self) -> None:
        self._frames.ask()

    def _fatal_error(self) -> None:
        """As Textual's, but without the values of local variables, which may be anybody's secrets."""
        from rich.traceback import Traceback  # 40 ms that the first paint does not wait for

        self._exit_renderables.append(Traceback(show_locals=False, width=None))
        self._close_messages_no_wait()

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        """In a thread of its own: the one that was interrupted by the signal may hold what stopping needs."""
        threading.Thread(target=self._hang_up, name="hang-up", daemon=True).start()

    def _hang_up(self) -> None:
        """The terminal is gone, or somebody ended us (SIGHUP, SIGTERM). In any thread: the robot stops first."""
        self._exit_code = ExitCode.INTERRUPTED
        self._send(Quit())
        self.post_message(self.HungUp())
        threading.Thread(target=self._leave_for_sure, name="leave", daemon=True).start()

    def _leave_for_sure(self) -> None:
        """The interface may wait for a terminal that takes nothing any more."""
        if not self._left.wait(LEAVE_LIMIT_S):
            os._exit(self._exit_code)

    def on_sayso_app_hung_up(self) -> None:
        self.action_leave_now()

    def run_to_the_end(self) -> int:
        """Run until somebody leaves and the engine has ended, too; returns the exit code of the process."""
        self.run()
        self._left.set()
        code, limit = self.return_code or 0, time.monotonic() + LEAVE_LIMIT_S
        while self._handle is not None and not self._handle.join(0.1):
            if self.engine_hangs or time.monotonic() > limit:
                os._exit(code)  # the interpreter would wait for threads that hang
        return code


def _robot_state(parts: Sequence[PartStatus]) -> PartState | None:
    return next((part.state for part in parts if part.name == "robot"), None)


def run_console(start_engine: Callable[[Callable[..., None]], EngineHandle]) -> int:
    """Run the console until somebody leaves it, and return the exit code of the process.

    ``start_engine`` runs in a thread behind the first picture and returns the engine. It is given
    :meth:`SaysoApp.dress`, to tell theme and frames per second once it has read the settings.
    """
    app = SaysoApp(lambda: start_engine(app.dress))
    return app.run_to_the_end()
