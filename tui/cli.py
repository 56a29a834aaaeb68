"""The command line: what can be asked of ``sayso``, and how it ends.

stdout is data and nothing else; stderr is for people; exit codes are those of ``engine.errors.ExitCode``. Commands
are imported only when they are run, so that ``sayso --help`` is instant and only the console ever imports textual.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from engine import __version__
from engine.errors import ExitCode, SaysoError
from tui.commands.output import data, say, silence_stdout

DESCRIPTION = """\
Say it, and a robot does it. Without a command: the console, with a robot in a simulated flat.
"""
EPILOG = """\
exit codes: 0 done · 1 the robot could not do it · 2 usage or configuration · 3 a device or model is missing
            4 timed out · 5 needs clarification · 6 refused · 130 interrupted
"""
COMPLETE_FILE = {
    "bash": "_shtab_compgen_files",
    "zsh": "_files",
    "tcsh": "f",
    "fish": "(__fish_complete_path (commandline -ct))",
}
"""What shtab calls ``FILE``: complete the names of files."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. The entry point of ``sayso``."""
    arguments = build_parser().parse_args(argv)
    module, _, function = arguments.run.partition(":")
    from config import ConfigError

    try:
        code = int(getattr(importlib.import_module(module), function)(arguments))
        sys.stdout.flush()
        return code
    except (SaysoError, ConfigError) as error:
        say(f"sayso: {error}")
        return int(error.exit_code)
    except KeyboardInterrupt:
        say("sayso: interrupted.")
        return int(ExitCode.INTERRUPTED)
    except BrokenPipeError:
        silence_stdout()
        return int(ExitCode.INTERRUPTED)


def entry() -> None:
    """The console script."""
    sys.exit(main())


def build_parser() -> argparse.ArgumentParser:
    """The whole command line; also what shell completion is made from."""
    parser = _Parser(
        prog="sayso", description=DESCRIPTION, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--version", action="version", version=f"sayso {__version__}")
    parser.add_argument(
        "--print-completion",
        action=_PrintCompletion,
        choices=["bash", "zsh", "tcsh", "fish"],
        help="print a completion script for a shell and exit",
    )
    parser.add_argument("--demo", action="store_true", help="play demo speech through a simulated microphone")
    settings = _settings_options()
    _add_settings(parser)
    parser.set_defaults(run="tui.commands.console:run", json=False)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")

    def command(name: str, run: str, summary: str, *, json: bool = True) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=summary, description=summary, parents=[settings])
        sub.set_defaults(run=run)
        if json:
            sub.add_argument("--json", action="store_true", help="print JSON lines")
        return sub

    engine = command("engine", "tui.commands.engine:run", "run without a screen: JSON lines out, commands in")
    engine.add_argument(
        "--source",
        choices=["auto", "mic", "demo", "none"],
        default="auto",
        help="where sound comes from; auto: the microphone if there is one (default)",
    )

    ask = command("ask", "tui.commands.ask:run", "do what TEXT says and report; '-' reads one request a line")
    ask.add_argument("text", help="a request, or - for stdin")
    _add_timeout(ask)

    hear = command("hear", "tui.commands.hear:run", "do what a recording says and report")
    _file(hear, "file", "a WAV file, or - for raw PCM on stdin (16 kHz, 16-bit, mono)")
    hear.add_argument("--pace", choices=["fast", "real"], default="fast", help="how fast the file is heard")
    _add_timeout(hear)

    plan = command("plan", "tui.commands.plan:run", "print the plan for TEXT; nothing moves; '-' reads stdin")
    plan.add_argument("text", help="a request, or - for stdin")

    transcribe = command("transcribe", "tui.commands.transcribe:run", "print what is said in recordings")
    _file(transcribe, "files", "WAV files", nargs="+")

    command("skills", "tui.commands.skills:run", "list what the robot can do")
    command("doctor", "tui.commands.doctor:run", "look for what is missing, and say how to get it")

    models = command("models", "tui.commands.models:run", "list, download and verify models")
    models.add_argument("action", choices=["list", "pull", "verify", "path"])
    models.add_argument("names", nargs="*", metavar="MODEL", help="default: the models that sayso needs")

    scene = command("scene", "tui.commands.scene:run", "list scenes, and show one from above")
    scene.add_argument("action", choices=["list", "show"])
    scene.add_argument("name", nargs="?", metavar="NAME", help="default: the scene of the settings")
    png = scene.add_argument("--png", metavar="FILE", type=Path, help="write the picture to FILE")
    png.complete = COMPLETE_FILE  # type: ignore[attr-defined]

    config = command("config", "tui.commands.config:run", "show and check the configuration")
    config.add_argument("action", choices=["show", "path", "check"])

    bench = command("bench", "tui.commands.bench:run", "run a benchmark (in a checkout)")
    bench.add_argument("name", nargs="?", help="which one; without a name they are listed")
    bench.add_argument("options", nargs=argparse.REMAINDER, help="options of the benchmark")
    return parser


class _PrintCompletion(argparse.Action):
    """Prints the completion script that shtab makes of the parser; shtab is imported for nothing else."""

    def __call__(self, parser: argparse.ArgumentParser, *values: Any) -> None:
        import shtab

        data(shtab.complete(parser, shell=values[1]))
        parser.exit()


class _Parser(argparse.ArgumentParser):
    """Errors go the way of all errors of sayso: one line for people and exit code 2."""

    def error(self, message: str) -> NoReturn:
        say(f"{self.prog}: {message}. Try: {self.prog} --help")
        raise SystemExit(int(ExitCode.USAGE))


def _settings_options() -> _Parser:
    parent = _Parser(add_help=False)
    _add_settings(parent, default=argparse.SUPPRESS)
    return parent


def _add_settings(parser: argparse.ArgumentParser, default: object = None) -> None:
    group = parser.add_argument_group("settings")
    file = group.add_argument(
        "--config", metavar="FILE", type=Path, action="append", default=default, help="read settings from FILE too"
    )
    file.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    group.add_argument(
        "--set", metavar="KEY=VALUE", action="append", default=default, help="e.g. --set endpoint.silence_s=0.8"
    )
    group.add_argument("--scene", default=default, help="the robot's scene: a name or a YAML file")
    group.add_argument("--speed", choices=["real", "max"], default=default, help="how fast simulated time passes")
    group.add_argument("--model", default=default, help="the recogniser's model: a name or a folder")


def _add_timeout(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--timeout", type=float, metavar="S", default=None, help="give up after S seconds (exit code 4)"
    )


def _file(parser: argparse.ArgumentParser, name: str, text: str, nargs: str | None = None) -> None:
    argument = parser.add_argument(name, metavar="FILE", help=text, nargs=nargs)
    argument.complete = COMPLETE_FILE  # type: ignore[attr-defined]
