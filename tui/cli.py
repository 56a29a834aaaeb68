"""The command line: what can be asked of ``sayso``, and how it ends.

stdout is data and nothing else; stderr is for people; exit codes are those of ``engine.errors.ExitCode``. Commands
are imported only when they are run, so that ``sayso --help`` is instant and only the console ever imports textual.
"""

from __future__ import annotations

import argparse
import importlib
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from engine import __version__
from engine.errors import ExitCode, SaysoError
from tui.output import ENDING, data, say, silence_stdout

DESCRIPTION = """\
Say it, and a robot does it. Without a command: the console, with a robot in a simulated flat.
"""
EPILOG = """\
exit codes: 0 done · 1 the robot could not do it · 2 usage or configuration · 3 a device or model is missing
            4 timed out · 5 needs clarification · 6 refused · 130 interrupted
"""
OTHERS = "train with this recording of speech or noise without the phrase as well (a WAV file)"
VOICES = "train with the voices in this folder as well: piper's (.onnx), Kokoro's styles (.bin, .npz)"
ROBOT_NAME = "a model (default: that of the settings); to probe: ros2; to calibrate: wheels, steering, servos or camera"
ROBOT_ACTIONS = ("list", "show", "check", "probe", "calibrate", "drive", "estop", "release", "emulate")

PULL = "to emulate: it turns by so much a metre without being told to"
THICKNESS = "of what the board is glued to, when it lies on the floor (0)"
URI = "where to listen: tcp://HOST:PORT (default: tcp://127.0.0.1:10300, for programs on this machine only)"
WEB = "serve the console to a browser on this machine, one tab at a time"
WEB_HOST = "the address to listen at (default: 127.0.0.1); beyond this machine nothing is encrypted, the token neither"
COMPLETE_FILE = {
    "bash": "_shtab_compgen_files",
    "zsh": "_files",
    "tcsh": "f",
    "fish": "(__fish_complete_path (commandline -ct))",
}
"""What shtab calls ``FILE``: complete the names of files."""
ENDLESS = frozenset(f"tui.commands.{name}" for name in ("engine", "web", "wyoming"))
"""Commands that run until they are told to end: to be told so is no failure."""
LATER = "later_"
"""How the options that stand for settings are named after the command, until they are joined to those before it."""


class EndedEarly(KeyboardInterrupt):
    """The process was asked to end before the command had said what that means for it."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. The entry point of ``sayso``."""
    endless = False
    try:
        arguments = build_parser().parse_args(argv)
        endless = arguments.run.partition(":")[0] in ENDLESS
        return _performed(arguments)
    except EndedEarly:
        return int(ExitCode.DONE if endless else ExitCode.INTERRUPTED)


def _performed(arguments: argparse.Namespace) -> int:
    module, _, function = arguments.run.partition(":")
    from config import ConfigError

    try:
        code = int(getattr(importlib.import_module(module), function)(arguments))
        sys.stdout.flush()
        return code
    except (SaysoError, ConfigError) as error:
        say(f"sayso: {error}")
        return int(error.exit_code)
    except EndedEarly:
        raise
    except KeyboardInterrupt:
        say("sayso: interrupted.")
        return int(ExitCode.INTERRUPTED)
    except BrokenPipeError:
        silence_stdout()
        return int(ExitCode.INTERRUPTED)


def entry() -> None:
    """The console script."""
    open_missing_streams()
    for number in ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:  # and not ignored, as nohup leaves it
            signal.signal(number, _end_early)
    sys.excepthook = lambda kind, error, trace: _show(error)
    threading.excepthook = lambda fault: _show(fault.exc_value)
    sys.exit(main())


def _end_early(number: int, frame: FrameType | None) -> NoReturn:
    for other in ENDING:
        signal.signal(other, signal.SIG_IGN)  # the end is under way
    raise EndedEarly


def _show(fault: BaseException | None) -> None:
    """A fault of sayso itself, without anybody's secrets."""
    from config.secrets import show_fault

    show_fault(fault)


def open_missing_streams() -> None:
    """Open /dev/null for what whoever started us has closed (``2>&-``): else the next file that is opened would stand
    there, and be written into by all that write to stderr."""
    for fd, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(fd)
        except OSError:
            nothing = os.open(os.devnull, os.O_RDWR)
            os.dup2(nothing, fd)
            if nothing == fd:
                os.set_inheritable(fd, True)
            else:
                os.close(nothing)
            setattr(sys, name, open(fd, mode, encoding="utf-8", closefd=False))  # noqa: SIM115 - for good


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
    parser.add_argument(
        "--line", action="store_true", help="the console on one line, for a small pane beside other work"
    )
    parser.add_argument("--theme", metavar="NAME", help="how the console looks: sayso-light, sayso-contrast, nord, …")
    parser.add_argument("--tab", action="store_true", help=argparse.SUPPRESS)  # how --web starts it
    parser.set_defaults(run="tui.commands.console:run", json=False)
    browser = parser.add_argument_group("the console in a browser")
    browser.add_argument("--web", action="store_const", dest="run", const="tui.commands.web:run", help=WEB)
    browser.add_argument("--web-host", metavar="HOST", default="127.0.0.1", help=WEB_HOST)
    browser.add_argument("--web-port", metavar="PORT", type=_port, default=8300, help="default: 8300; 0: a free one")
    settings = _settings_options()
    _add_settings(parser)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")

    def command(name: str, run: str, summary: str, *, json: str | None = "print JSON lines") -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=summary, description=summary, parents=[settings])
        sub.set_defaults(run=run)
        if json is not None:
            sub.add_argument("--json", action="store_true", help=json)
        return sub

    summary = "run without a screen: JSON lines out, commands in"
    engine = command("engine", "tui.commands.engine:run", summary, json="as it does anyway")
    engine.add_argument(
        "--source",
        choices=["auto", "mic", "demo", "none"],
        default="auto",
        help="where sound comes from; auto: the microphone if there is one (default); none: from commands, and then "
        "nothing is spoken unless voice.device or voice.when=always asks for it",
    )

    ask = command("ask", "tui.commands.ask:run", "do what TEXT says and report; '-' reads one request a line")
    ask.add_argument("text", help="a request, or - for stdin")
    _add_timeout(ask)

    hear = command("hear", "tui.commands.hear:run", "do what a recording says and report")
    _file(hear, "file", "a recording (WAV, FLAC, Ogg, MP3, …), or - for raw PCM on stdin (16 kHz, 16-bit, mono)")
    hear.add_argument("--pace", choices=["fast", "real"], default="fast", help="how fast the file is heard")
    _add_timeout(hear)

    plan = command("plan", "tui.commands.plan:run", "print the plan for TEXT; nothing moves; '-' reads stdin")
    plan.add_argument("text", help="a request, or - for stdin")
    world = plan.add_argument(
        "--world", metavar="FILE", type=Path, help="plan for the places, objects and people of FILE (YAML or JSON)"
    )
    world.complete = COMPLETE_FILE  # type: ignore[attr-defined]

    transcribe = command("transcribe", "tui.commands.transcribe:run", "print what is said in recordings")
    _file(transcribe, "files", "recordings: WAV, FLAC, Ogg, MP3, …", nargs="+")

    command("skills", "tui.commands.skills:run", "list what the robot can do")
    mic = command(
        "mic",
        "tui.commands.mic:run",
        "hand sound on stdin (raw PCM: 16 kHz, 16-bit, mono) over to the sayso that runs here",
        json=None,
    )
    mic.add_argument("--wyoming", metavar="URI", help="instead, a Wyoming satellite: tcp://HOST:10700")

    doctor = command("doctor", "tui.commands.doctor:run", "look for what is missing, and say how to get it")
    doctor.add_argument(
        "--mic", action="store_true", help="record three seconds instead; say whether it is too loud or too quiet"
    )

    doctor.add_argument(
        "--wheels-up", action="store_true", help="find out whether the motor board stops by itself: it turns the wheels"
    )
    doctor.add_argument("--yes", action="store_true", help="with --wheels-up: the robot is lifted, do not ask")

    models = command("models", "tui.commands.models:run", "list, download and verify models")
    models.add_argument("action", choices=["list", "pull", "verify", "path"])
    models.add_argument("names", nargs="*", metavar="MODEL", help="default: the models that sayso needs")

    wake = command("wake", "tui.commands.wake:run", "wake words: list, try and train them")
    wake.add_argument("action", choices=["list", "test", "train"])
    what = wake.add_argument("what", nargs="?", metavar="PHRASE|FILE", help="to train: a phrase; to test: a WAV file")
    what.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    wake.add_argument("--mine", metavar="DIR|record", help="train with recordings of the phrase by yourself as well")
    others = wake.add_argument("--others", metavar="FILE", type=Path, action="append", help=OTHERS)
    others.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    voices = wake.add_argument("--voices", metavar="DIR", type=Path, action="append", help=VOICES)
    voices.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    wake.add_argument("--quick", action="store_true", help="train with less of everything")
    wake.add_argument("--to", metavar="FILE", type=Path, help="where the head goes; default: your folder")
    wake.add_argument("--yes", action="store_true", help="keep it without asking")

    wyoming = command("wyoming", "tui.commands.wyoming:run", "lend recogniser and voice to programs that speak Wyoming")
    wyoming.add_argument("--uri", metavar="URI", default="tcp://127.0.0.1:10300", help=URI)
    wyoming.add_argument("--only", choices=["asr", "tts"], help="lend the recogniser alone, or the voice")

    scene = command("scene", "tui.commands.scene:run", "list scenes, and show one from above")
    scene.add_argument("action", choices=["list", "show"])
    scene.add_argument("name", nargs="?", metavar="NAME", help="default: the scene of the settings")
    png = scene.add_argument("--png", metavar="FILE", type=Path, help="write the picture to FILE")
    png.complete = COMPLETE_FILE  # type: ignore[attr-defined]

    robot = command("robot", "tui.commands.robot:run", "robots: list, check, drive and stop them")
    robot.add_argument("action", choices=ROBOT_ACTIONS)
    robot.add_argument("name", nargs="?", metavar="NAME", help=ROBOT_NAME)
    robot.add_argument("--as", dest="called", metavar="NAME", default="mine", help="to probe: what it is called then")
    robot.add_argument("--stops-after", metavar="S", type=_seconds, help="to emulate: it stands by itself after S s")
    robot.add_argument("--port", metavar="PATH", type=Path, help="to emulate: where the board is (default: ./board)")
    robot.add_argument("--lidar", metavar="PATH", type=Path, help="to emulate: a lidar too, and where it is")
    robot.add_argument("--pull", metavar="RAD_PER_M", type=_number(-0.5, 0.5), default=0.0, help=PULL)
    steering = robot.add_argument_group("to calibrate")
    steering.add_argument("--yes", action="store_true", help="do not ask before it moves, or before pictures are taken")
    steering.add_argument("--runs", metavar="N", type=_count(2, 50), default=5, help="of the steering (default: 5)")
    _add_chessboard(robot.add_argument_group("to calibrate a camera"))

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

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """As argparse's, with the command or choice that was probably meant."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            from config.nearest import did_you_mean

            near = did_you_mean(str(value), map(str, action.choices or ()))
            error.message = f"{error.message}. {near}".removesuffix(". ")
            raise

    def _options(self) -> Iterator[str]:
        """All options, also those of commands."""
        yield from self._option_string_actions
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for command in action.choices.values():
                    yield from command._option_string_actions

    def _meant(self, message: str) -> str:
        """The options that were probably meant by those that nobody knows."""
        from config.nearest import did_you_mean

        _, unknown, given = message.partition("unrecognized arguments: ")
        options = (word.partition("=")[0] for word in given.split() if unknown and word.startswith("--"))
        return "".join(f" {near}" for option in options if (near := did_you_mean(option, self._options())))

    def error(self, message: str) -> NoReturn:
        message += f".{meant}" if (meant := self._meant(message)) else ""
        say(f"{self.prog}: {message}{'' if message.endswith('?') else '.'} Try: {self.prog} --help")
        raise SystemExit(int(ExitCode.USAGE))

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """With the settings before the command joined to those after it."""
        arguments = super().parse_args(args, namespace)
        for later in [key for key in vars(arguments) if key.startswith(LATER)]:
            name, after = later.removeprefix(LATER), vars(arguments).pop(later)
            before = getattr(arguments, name)
            if after is not None:
                setattr(arguments, name, [*before, *after] if isinstance(before, list) else after)
        return arguments


def _settings_options() -> _Parser:
    parent = _Parser(add_help=False)
    _add_settings(parent, LATER)
    return parent


def _add_settings(parser: argparse.ArgumentParser, prefix: str = "") -> None:
    group = parser.add_argument_group("settings")

    def add(name: str, text: str, **more: Any) -> argparse.Action:
        return group.add_argument(f"--{name}", dest=prefix + name, help=text, **more)

    file = add("config", "read settings from FILE too", metavar="FILE", type=Path, action="append")
    file.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    add("set", "e.g. --set endpoint.silence_s=0.8", metavar="KEY=VALUE", action="append")
    add("scene", "the robot's scene: a name or a YAML file", metavar="SCENE")
    add("speed", "how fast simulated time passes", choices=["real", "max"])
    add("model", "the recogniser's model: a name or a folder", metavar="MODEL")


def _add_timeout(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--timeout", type=_seconds, metavar="S", default=None, help="give up after S seconds (exit code 4)"
    )


def _seconds(text: str) -> float:
    """A time that one can wait for, s."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no time; one is a number of seconds above 0")
    return seconds


def _number(low: float, high: float) -> Callable[[str], float]:
    """What reads a number within these limits."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not low <= number <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is no number from {low:g} to {high:g}")
        return number

    return read


def _count(low: int, high: int) -> Callable[[str], int]:
    """What reads a whole number within these limits."""

    def read(text: str) -> int:
        if not (text.isdecimal() and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {low} to {high}")
        return int(text)

    return read


def _add_chessboard(camera: argparse._ArgumentGroup) -> None:
    """The options of the board that is held before a camera; the defaults are those of the sheet."""
    sheet = camera.add_argument("--sheet", metavar="FILE.svg", type=Path, help="write the board to print, and end")
    sheet.complete = COMPLETE_FILE  # type: ignore[attr-defined]
    size = _number(5, 100)
    camera.add_argument("--columns", metavar="N", type=_count(4, 30), default=10, help="its squares in a row (10)")
    camera.add_argument("--rows", metavar="N", type=_count(4, 30), default=7, help="its squares in a column (7)")
    camera.add_argument("--square", metavar="MM", type=size, default=25.0, help="side of a square, as measured (25)")
    camera.add_argument("--thickness", metavar="MM", type=_number(0, 50), default=0.0, help=THICKNESS)
    camera.add_argument("--timeout", metavar="S", type=_seconds, default=180.0, help="give up after S s (180)")


def _port(text: str) -> int:
    """A number that a port can have."""
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is no port; one is 0 to 65535")
    return int(text)


def _file(parser: argparse.ArgumentParser, name: str, text: str, nargs: str | None = None) -> None:
    argument = parser.add_argument(name, metavar="FILE", help=text, nargs=nargs)
    argument.complete = COMPLETE_FILE  # type: ignore[attr-defined]
