"""An engine without a screen, and somebody who waits for its results: what ``ask``, ``hear`` and ``engine`` share."""

from __future__ import annotations

import queue
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from types import FrameType
from typing import TYPE_CHECKING

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
        """Send ``command`` and wait for the result of its turn; after ``timeout_s`` stop the robot and say so."""
        self._awaited = key = str(ULID())
        self._engine.send(replace(command, id=key))
        try:
            while True:
                answered, result = self._results.get(timeout=timeout_s)
                if answered in (key, None):
                    return result
        except queue.Empty:
            assert timeout_s is not None, "only a wait with a limit ends empty"
            self._engine.send(Interrupt())
            return TurnResult(ExitCode.TIMEOUT, "timeout", f"No result within {timeout_s:g} s; the robot was stopped.")

    def finish(self) -> None:
        """End the engine and print what is left."""
        self._engine.send(Quit())
        self._engine.join()
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
