"""``sayso``: the console. Everything but the first picture happens behind it."""

from __future__ import annotations

import gc
import os
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import TYPE_CHECKING

from config.folders import paths
from engine.errors import UsageError
from tui.commands.settings import load_settings, make_state_folder, overrides
from tui.terminal.launch import LaunchPicture
from tui.terminal.terminal import why_not_usable

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.handle import EngineHandle
    from tui.doctor.examiner import Examiner


def run(arguments: Namespace) -> int:
    """Show the console until it is left. Exit code of the engine."""
    streams = (sys.stdin.isatty(), sys.stdout.isatty(), sys.stderr.isatty())
    if not arguments.tab and (reason := why_not_usable(os.environ, *streams)):
        raise UsageError(reason)
    for given in overrides(arguments):
        setting, _, name = given.partition("=")
        if setting == "console.theme":
            from tui.checking import check_theme

            check_theme(name)
    make_state_folder()
    launch = LaunchPicture(paths().launch, os.environ)
    if not (arguments.tab or arguments.line):
        launch.show()
    gc.disable()  # imports make no garbage worth looking for; the console enables it after the first picture
    os.environ.setdefault("ESCDELAY", "25")  # ms that Textual waits to tell the key from the start of a sequence

    def start(dress: Callable[..., None]) -> EngineHandle:
        """Everything that takes long: behind the first picture."""
        settings = load_settings(arguments)
        from config.changing import Layers
        from config.secrets import secrets_in
        from tui.kept.history import RequestHistory
        from tui.kept.sizes import SizeFile
        from tui.kept.tour import Tour
        from tui.keys.keymap import keymap
        from tui.keys.keys import first_shown
        from tui.rooms.dressing import camera_of, language_of, wording_of

        language, folders = language_of(settings), paths()
        dress(
            settings.console.theme,
            settings.console.fps,
            prompt=settings.robot.realtime_priority,
            camera=camera_of(settings),
            graphics=settings.console.camera_graphics,
            motion=settings.console.motion,
            notify=settings.console.notify,
            busy=settings.session.busy,
            keys=settings.console.keys,
            history=RequestHistory(folders.requests) if settings.console.history else None,
            sizes=SizeFile(folders.panes),
            tour=Tour(folders.toured, folders.requests),
            layers=Layers(tuple(arguments.config or ()), tuple(overrides(arguments))),
            secrets=tuple(secrets_in(settings)),
            language=language,
            wording=wording_of(settings) if language == "zh" else None,
            doctor=lambda: _doctor(settings),
        )
        if not arguments.line:
            launch.keep()
        from engine.engine import Engine
        from engine.parts.loading import Sound

        sound, release = (
            Sound("demo" if arguments.demo else "mic"),
            first_shown(keymap(settings.console.keys).keys)["release"],
        )
        engine = Engine(settings, mode="console", sound=sound, release_key=release)
        engine.start()
        return engine

    try:
        from tui.app import run_console

        return run_console(start, launch.passing, one_line=arguments.line)
    finally:
        launch.withdraw()


def _doctor(settings: Settings) -> Examiner:
    """What examines everything, which most sessions do without."""
    from tui.doctor.examiner import Examiner

    return Examiner(settings)
