"""An engine without a screen, and somebody who waits for its results: what ``ask``, ``hear`` and ``engine`` share."""

from __future__ import annotations

import os
import queue
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Final

import msgspec
from ulid import ULID

from engine import events
from engine.commands import Interrupt, Quit, Say, Wake
from engine.errors import ExitCode
from engine.events import Event, TurnResult, to_json
from tui.commands.output import LineWriter, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.engine import Engine
    from engine.loading import Sound

SILENT_S: Final = 5.0
"""An engine that shows no sign of life for so long is given up by those who wait for a result."""
LOOK_S: Final = 0.5
"""How often somebody who waits feels the engine's pulse."""
END_S: Final = 10.0
"""How long an engine may take to end."""

_ENDED = TurnResult(ExitCode.INTERRUPTED, "interrupted", "The session ended before this was done.")


class Terminated(Exception):
    """The process was asked to end (SIGTERM, SIGHUP)."""


@contextmanager
def headless(settings: Settings, *, mode: str, json: bool, sound: Sound) -> Iterator[Headless]:
    """A running engine; however the block ends, the robot is stopped and the engine has ended after it."""
    from engine.engine import Engine

    engine = Engine(settings, mode=mode, sound=sound)
    running = Headless(engine, json=json)
    with signals_raise():
        engine.start()
        try:
            yield running
        except (KeyboardInterrupt, Terminated):
            engine.send(Interrupt())
            raise KeyboardInterrupt from None
        finally:
            running.finish()


@contextmanager
def signals_raise() -> Iterator[None]:
    """Within this, SIGTERM and SIGHUP raise :class:`Terminated` in the main thread, as SIGINT its KeyboardInterrupt."""

    def terminate(number: int, frame: FrameType | None) -> None:
        raise Terminated(signal.Signals(number).name)

    kept = {number: signal.signal(number, terminate) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


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
            say(f"sayso: the engine has not answered for {silence:.0f} s. The robot has stopped by itself.")
            os._exit(ExitCode.FAILED)  # the interpreter would wait for the thread that hangs
        return silence


def end(engine: Engine) -> None:
    """Wait for an engine that has been asked to end."""
    pulse, limit = Pulse(engine), time.monotonic() + END_S
    while not engine.join(LOOK_S) and time.monotonic() < limit:
        pulse.silence()


class Printer:
    """Prints an engine's events: JSON lines on stdout, or words for people on stderr."""

    def __init__(self, engine: Engine, *, json: bool) -> None:
        self._engine = engine
        self._writer = LineWriter(self._lost) if json else None
        engine.subscribe(self._see)

    @property
    def reader_gone(self) -> bool:
        """Nobody reads stdout any more."""
        return self._writer is not None and self._writer.closed

    def close(self) -> None:
        """Print what is left."""
        if self._writer is not None:
            self._writer.close()

    def _see(self, event: Event) -> None:
        if self._writer is None:
            _narrate(event.body)
        else:
            self._writer.write(to_json(event))

    def _lost(self) -> None:
        say("sayso: nobody reads the output any more; the robot was stopped.")
        self._engine.send(Quit())


class Headless:
    """Gives commands to an engine and waits for their results."""

    def __init__(self, engine: Engine, *, json: bool) -> None:
        self._engine = engine
        self._results: queue.SimpleQueue[tuple[str | None, TurnResult]] = queue.SimpleQueue()
        self._command_of: dict[str | None, str] = {}  # turn -> id of the command that started it
        self._awaited = ""
        self._printer = Printer(engine, json=json)
        engine.subscribe(self._see)

    @property
    def reader_gone(self) -> bool:
        return self._printer.reader_gone

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

    def finish(self) -> None:
        """End the engine and print what is left."""
        self._engine.send(Quit())
        end(self._engine)
        self._printer.close()

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


def _narrate(body: events.Body) -> None:
    """What people want to read while they wait."""
    match body:
        case events.TranscriptFinal(text=text, source="speech"):
            say(f"heard: {text}")
        case events.PlanMade(steps=steps):
            for number, step in enumerate(steps, 1):
                say(f"  {number}. {step}")
        case events.ActionStarted(index=index, total=total, name=name, args=args):
            values = ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in args.values())
            say(f"▸ {index}/{total} {name}({values})")
        case events.ActionFinished(name=name, outcome="ok", duration_s=seconds):
            say(f"✓ {name} {seconds:.1f} s")
        case events.ActionFinished(name=name, outcome=outcome, message=message):
            say(f"✗ {name} {outcome}: {message}")
        case events.ErrorRaised(message=message, hint=hint):
            say(f"error: {message} {hint}".rstrip())
        case events.Log(level="warning" | "error" as level, message=message):
            say(f"{level}: {message}")
