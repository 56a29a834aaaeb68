"""``sayso``: the console. Everything but the first picture happens behind it."""

from __future__ import annotations

import gc
import os
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import TYPE_CHECKING

from engine.errors import UsageError
from tui.commands.settings import load_settings
from tui.terminal import why_not_usable

if TYPE_CHECKING:
    from engine.handle import EngineHandle


def run(arguments: Namespace) -> int:
    """Show the console until it is left. Exit code of the engine."""
    if reason := why_not_usable(os.environ, sys.stdin.isatty(), sys.stdout.isatty(), sys.stderr.isatty()):
        raise UsageError(reason)
    gc.disable()  # imports make no garbage worth looking for; the console enables it after the first picture
    os.environ.setdefault("ESCDELAY", "25")  # ms that Textual waits to tell the key from the start of a sequence
    from tui.app import run_console

    def start(dress: Callable[..., None]) -> EngineHandle:
        """Everything that takes long: behind the first picture."""
        settings = load_settings(arguments)
        dress(settings.console.theme, settings.console.fps, prompt=settings.robot.realtime_priority)
        from engine.engine import Engine
        from engine.loading import Sound

        engine = Engine(settings, mode="console", sound=Sound("demo" if arguments.demo else "mic"))
        engine.start()
        return engine

    return run_console(start)
