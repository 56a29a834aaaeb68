"""An engine without a screen, and somebody who waits for its results: what ``ask``, ``hear`` and ``engine`` share."""

from __future__ import annotations

import os
import queue
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any, Final

import msgspec
from ulid import ULID

from engine import events
from engine.commands import Interrupt, Quit, Say, Wake
from engine.errors import ExitCode, UsageError
from engine.events import Event, TurnResult, to_json
from tui.output import ENDING, LineWriter, data, said_in_background, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.engine import Engine
    from engine.parts.loading import Sound

SILENT_S: Final = 5.0
"""An engine that shows no sign of life for so long is given up by those who wait for a result."""
LOOK_S: Final = 0.5
"""How often somebody who waits feels the engine's pulse."""
END_S: Final = 10.0
"""How long an engine may take to end."""

_ENDED = TurnResult(ExitCode.INTERRUPTED, "interrupted", "The session ended before this was done.")


class Terminated(KeyboardInterrupt):
    """The process was asked to end (``ENDING``)."""


@contextmanager
def headless(settings: Settings, *, mode: str, json: bool, sound: Sound) -> Iterator[Headless]:
    """A running engine; however the block ends, the robot is stopped and the engine has ended after it."""
    from engine.engine import Engine

    engine = Engine(settings, mode=mode, sound=sound)
    with Signals() as signals, said_in_background(), Printer(engine, json=json) as printer:
        running = Headless(engine, printer)
        engine.start()
        try:
            with signals.raised():
                printer.started()
                yield running
        except KeyboardInterrupt:
            engine.send(Interrupt())
            raise
        finally:
            engine.send(Quit())
            end(engine)


class Signals:
    """Raises the first signal that asks the process to end, in the main thread and only where that is expected: one
    that comes during the start waits, and one that comes during the end, or as a second one, changes nothing."""

    def __init__(self) -> None:
        self._first: int | None = None
        self._raised = False
        self._expected = False
        self._kept: dict[int, Any] = {}

    def __enter__(self) -> Signals:
        for number in (*ENDING, signal.SIGINT):
            if (kept := signal.getsignal(number)) is not signal.SIG_IGN:  # as nohup and a shell's & leave it
                self._kept[number] = kept
                signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._kept.items():
            signal.signal(number, handler if self._first is None else signal.SIG_IGN)  # the process ends by it anyway

    @contextmanager
    def raised(self) -> Iterator[None]:
        """Within this a signal is raised: SIGINT as KeyboardInterrupt, the others as :class:`Terminated`."""
        self._expected = True
        try:
            self._raise()
            yield
        finally:
            self._expected = False

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._first = self._first or number
        if self._expected:
            self._raise()

    def _raise(self) -> None:
        if self._first is not None and not self._raised:
            self._raised = True
            raise KeyboardInterrupt if self._first == signal.SIGINT else Terminated


class Pulse:
    """Feels an engine's pulse for somebody who waits for it."""

    def __init__(self, engine: Engine, limit_s: float = SILENT_S) -> None:
        """After ``limit_s`` of silence the engine is given up."""
        self._engine = engine
        self._limit_s = limit_s
        self._felt = time.monotonic()

    def silence(self) -> float:
        """For how long the engine has shown no sign of life, s; ends the process when that is for good.

        To be asked every ``LOOK_S``: whoever was away himself (a paused process) cannot know yet, and gets 0.
        """
        now, felt = time.monotonic(), self._felt
        self._felt = now
        silence = self._engine.pulse() if now - felt < 4 * LOOK_S else 0.0
        if silence > self._limit_s:
            say(f"sayso: the engine has not answered for {silence:.0f} s. The robot has stopped by itself.", wait_s=1.0)
            os._exit(ExitCode.FAILED)  # the interpreter would wait for the thread that hangs
        return silence


def end(engine: Engine) -> None:
    """Wait for an engine that has been asked to end."""
    pulse, limit = Pulse(engine), time.monotonic() + END_S
    while not engine.join(LOOK_S) and time.monotonic() < limit:
        pulse.silence()


class Printer:
    """Prints an engine's events: JSON lines on stdout, or words for people on stderr. A context manager, which prints
    what is left at its end."""

    def __init__(self, engine: Engine, *, json: bool) -> None:
        self._engine = engine
        self._started = False
        self.told: set[str] = set()
        """What people have read of warnings and errors."""
        self._writer = LineWriter(1, self._lost) if json else None
        self._narrator = Narrator()
        engine.subscribe(self._see)

    def __enter__(self) -> Printer:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()

    @property
    def json(self) -> bool:
        return self._writer is not None

    @property
    def lost(self) -> ExitCode | None:
        """What the command is to exit with where nothing can be written any more: nobody reads stdout, or the disk is
        full."""
        if self._writer is None or not self._writer.closed:
            return None
        return ExitCode.MISSING if self._writer.trouble else ExitCode.INTERRUPTED

    def started(self) -> None:
        """The engine takes commands from now on: it ends when nobody reads, also if nobody ever did."""
        self._started = True
        if self.lost is not None:
            self._engine.send(Quit())

    def _see(self, event: Event) -> None:
        if self._writer is not None:
            self._writer.write(to_json(event))
        elif (words := _complaint(event.body)) is None:
            self._narrator.tell(event.body)
        elif words not in self.told:
            self.told.add(words)
            say(f"{'error' if isinstance(event.body, events.ErrorRaised) else 'warning'}: {words}")

    def _lost(self) -> None:
        """Runs in the writer's thread."""
        assert self._writer is not None
        trouble = self._writer.trouble
        why = f"the output cannot be written: {trouble}" if trouble else "nobody reads the output any more"
        say(f"sayso: {why}; the robot was stopped.")
        if self._started:
            self._engine.send(Quit())


class Headless:
    """Gives commands to an engine and waits for their results."""

    def __init__(self, engine: Engine, printer: Printer) -> None:
        self._engine = engine
        self._results: queue.SimpleQueue[tuple[str | None, TurnResult]] = queue.SimpleQueue()
        self._command_of: dict[str | None, str] = {}  # turn -> id of the command that started it
        self._awaited = ""
        self._printer = printer
        engine.subscribe(self._see)

    @property
    def lost(self) -> ExitCode | None:
        """As of its printer."""
        return self._printer.lost

    def report(self, result: TurnResult) -> None:
        """Tell a person how it ended, unless an error has said so; programs have read it in the events."""
        if self._printer.json or not result.message:
            return
        if result.exit_code == ExitCode.DONE:
            data(result.message)
        elif result.message not in self._printer.told:
            say(result.message)
        self._printer.told.clear()

    def refuse(self, error: UsageError) -> None:
        """Tell that something is no request, and is not asked of the engine: programs as of a bad command."""
        if self._printer.json:
            self._engine.reject(str(error), Say.do)
        else:
            say(f"sayso: {error}")

    def perform(self, command: Say | Wake, timeout_s: float | None) -> TurnResult:
        """Send ``command`` and wait for the result of its turn; after ``timeout_s`` stop the robot and say so.

        An engine that does not answer any more ends the process (see :class:`Pulse`).
        """
        self._awaited = key = str(ULID())
        self._engine.send(msgspec.structs.replace(command, id=key))
        limit = float("inf") if timeout_s is None else time.monotonic() + timeout_s
        pulse = Pulse(self._engine)
        while (left := limit - time.monotonic()) > 0:
            pulse.silence()
            try:
                answered, result = self._results.get(timeout=min(left, LOOK_S))
            except queue.Empty:
                continue
            if answered == key:
                return result
            if answered is None:
                return self._how_it_ended()
        self._engine.send(Interrupt())
        return TurnResult(ExitCode.TIMEOUT, "timeout", f"No result within {timeout_s:g} s; the robot was stopped.")

    def _how_it_ended(self) -> TurnResult:
        end(self._engine)
        if (fault := self._engine.failure) is None:
            return _ENDED
        return TurnResult(ExitCode.FAILED, "failed", f"The engine ended by a fault: {fault!r}.")

    def _see(self, event: Event) -> None:
        """Runs in the engine's thread."""
        match event.body:
            case events.Ack(id=str(key), ok=True) if event.turn is not None:
                self._command_of[event.turn] = key
            case events.Ack(id=str(key), ok=False, message=message):
                self._results.put((key, TurnResult(ExitCode.FAILED, "failed", message)))
            case events.StateChanged(result=TurnResult() as result):
                self._results.put((self._command_of.pop(event.turn, self._awaited), result))
            case events.SessionEnded():
                self._results.put((None, _ENDED))


class Narrator:
    """Tells what people want to read while they wait, in words."""

    def __init__(self) -> None:
        self._steps: tuple[str, ...] = ()  # of the plan, in the language of the request
        self._doing: dict[str, str] = {}  # the actions that have started, by their ids

    def tell(self, body: events.Body) -> None:
        """This has happened."""
        match body:
            case events.TranscriptFinal(text=text, source="speech"):
                say(f"heard: {text}")
            case events.PlanMade(steps=steps):
                self._steps = steps
                for number, step in enumerate(steps, 1):
                    say(f"  {number}. {step}")
            case events.ActionStarted(action=action, index=index, total=total):
                words = self._steps[index - 1] if len(self._steps) == total else body.told or body.name
                self._doing[action] = words = words.rstrip(".。")
                say(f"▸ {index}/{total} {words}")
            case events.ActionFinished(action=action, name=name, outcome="ok", duration_s=seconds):
                say(f"✓ {self._doing.pop(action, name)} {seconds:.1f} s")
            case events.ActionFinished(action=action, name=name, outcome=outcome, message=message):
                say(f"✗ {self._doing.pop(action, name)}: {message or outcome}")


def _complaint(body: events.Body) -> str | None:
    """What a warning or an error says, which is told once."""
    match body:
        case events.ErrorRaised(message=message, hint=hint):
            return f"{message} {hint}".rstrip()
        case events.Log(level="warning" | "error", message=message):
            return message
    return None
