"""``sayso engine``: no screen. JSON lines out on stdout, JSON commands in on stdin, one a line.

The end of stdin means "no more commands": what was asked for is done, then the engine ends. SIGTERM, SIGHUP,
SIGQUIT and SIGINT stop the robot and end it at once, and so does a reader of stdout who goes away, or does not read any
more, and a full disk. All of them exit with 0 but SIGINT and the reader, which exit with 130, and the full disk with 3.
An engine that dies by a fault, or does not answer for ten seconds, exits with 1.
"""

from __future__ import annotations

import os
import select
import sys
import threading
from argparse import Namespace
from collections.abc import Iterator

from engine.commands import MAX_LINE, BadCommand, Quit, parse_command
from engine.engine import Engine
from engine.errors import ExitCode
from engine.parts.loading import Sound
from engine.scheduling import raise_priority
from tui.commands.headless import LOOK_S, Printer, Pulse, Signals, Terminated, end
from tui.commands.settings import load_settings, make_state_folder
from tui.output import said_in_background, say

READ_BYTES = 65536
WARN_S = 2.0
"""From so long without a sign of life, people are told that the engine does not answer, s."""
HUNG_S = 10.0
"""After so long it is given up, s."""


def run(arguments: Namespace) -> int:
    """Run until the commands end or a signal comes."""
    make_state_folder()
    settings = load_settings(arguments)
    engine = Engine(settings, mode="engine", sound=Sound(arguments.source))
    code = ExitCode.DONE
    with Signals() as signals, said_in_background(), Printer(engine, json=True) as printer:
        engine.start()
        try:
            with signals.raised():
                printer.started()
                reading = (engine, sys.stdin.fileno(), settings.robot.realtime_priority)
                threading.Thread(target=_read_commands, args=reading, name="stdin", daemon=True).start()
                watch(engine)
        except Terminated:
            pass
        except KeyboardInterrupt:
            code = ExitCode.INTERRUPTED
        finally:
            engine.send(Quit())
            end(engine)
    if engine.failure is not None:
        code = ExitCode.FAILED
    return int(code if printer.lost is None else printer.lost)


def watch(engine: Engine) -> None:
    """Wait for the engine to end; tell people when it does not answer, and when it does again."""
    pulse, silent = Pulse(engine, HUNG_S), False
    while not engine.join(LOOK_S):
        was, silent = silent, pulse.silence() > WARN_S
        if silent and not was:
            say("sayso: the engine does not answer; the robot has stopped by itself.")
        elif was and not silent:
            say("sayso: the engine answers again.")


def _read_commands(engine: Engine, fd: int, prompt: bool) -> None:
    """Read commands to the end of ``fd``; what is no command is acknowledged as such. ``prompt``: this thread goes
    before others, where the system allows it, because it may be told to stop the robot."""
    if prompt:
        raise_priority()
    try:
        for line in _lines(fd):
            if not line.strip():
                continue
            try:
                engine.send(parse_command(line))
            except BadCommand as error:
                engine.reject(str(error), error.do, error.id)
    except OSError as error:  # a terminal that has gone, a folder: nobody could stop the robot any more
        say(f"sayso: commands cannot be read from stdin: {error.strerror or error}; the robot was stopped.")
        engine.send(Quit())
    else:
        engine.send(Quit(drain=True))


def _lines(fd: int) -> Iterator[bytes]:
    """Lines of a file descriptor; one that is too long is cut, so that it is refused and costs no more memory.

    Not through ``sys.stdin``: a thread that waits inside a buffered reader holds its lock, and the interpreter aborts
    at exit over that.
    """
    rest, skipping = b"", False
    while chunk := _read(fd):
        *whole, rest = (rest + chunk).split(b"\n")
        for line in whole:
            if not skipping:
                yield line
            skipping = False
        if len(rest) > MAX_LINE:
            if not skipping:
                yield rest
            rest, skipping = b"", True
    if rest and not skipping:
        yield rest


def _read(fd: int) -> bytes:
    """What comes next, also where reading does not wait by itself; nothing at the end. Raises OSError."""
    while True:
        try:
            return os.read(fd, READ_BYTES)
        except BlockingIOError:  # whoever started us shares the description, and made it so
            select.select([fd], [], [])
