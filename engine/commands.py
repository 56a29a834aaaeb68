"""Commands in: what a person or a program can ask of a running session.

On the wire a command is one JSON object a line, ``{"do": "say", "text": "go to the kitchen"}``; every command may
carry an ``id`` of the sender's choice, which its acknowledgement (event ``ack``) repeats.
"""

from __future__ import annotations

import json
from base64 import b64decode
from typing import Annotated, Any, ClassVar

import msgspec

from engine.errors import UsageError
from engine.events import TranscriptFinal, WakeSource
from engine.strict_json import is_text

MAX_LINE = 4 * 1024 * 1024
"""Longest command line that is read, bytes: two minutes of base64 PCM."""
MAX_TEXT = 2000
"""Longest request that is read, characters: two minutes of fast speech."""


class Command(msgspec.Struct, frozen=True):
    """Base of all commands."""

    do: ClassVar[str]


class Say(Command, frozen=True):
    """A typed request, treated as if it had been spoken and understood. ``then``: requests that are done after it, one
    after the other. They wait whatever ``session.busy`` says, and each is acknowledged with the same id. ``wait``: it
    waits itself for what runs to end, whatever ``session.busy`` says. A stop among them waits for nothing: those before
    it never begin, and those behind it are asked for anew.

    What waits waits also for the answer to a question about the request before it: the next one that does not
    ``wait`` is that, and begins at once.

    ``requests``: the ids by which these requests are dropped and moved while they wait, and their ends told: the first
    is that of ``text``, the others those of ``then``. Where one is missing, empty or was given before, the session
    gives another."""

    do: ClassVar[str] = "say"
    text: str
    id: str | None = None
    then: tuple[str, ...] = ()
    wait: bool = False
    requests: tuple[str, ...] = ()


class Wake(Command, frozen=True):
    """Listen now; while speaking or acting this stops both first. ``angle_deg`` is where the speaker stands; the
    request began ``ago_s`` seconds ago, where that is known."""

    do: ClassVar[str] = "wake"
    source: WakeSource = "command"
    phrase: str = ""
    angle_deg: float | None = None
    ago_s: Annotated[float, msgspec.Meta(ge=0, le=1)] | None = None
    id: str | None = None


class Interrupt(Command, frozen=True):
    """Stop everything and keep the task cycle."""

    do: ClassVar[str] = "interrupt"
    id: str | None = None


class EndTask(Command, frozen=True):
    """Stop everything, reset arm and history, begin a new task cycle."""

    do: ClassVar[str] = "end_task"
    id: str | None = None


class EStop(Command, frozen=True):
    """The emergency stop: stop everything, and let nothing move the robot until it is released."""

    do: ClassVar[str] = "estop"
    id: str | None = None


class Release(Command, frozen=True):
    """Release the emergency stop. Nothing that was stopped goes on."""

    do: ClassVar[str] = "release"
    id: str | None = None


class Drive(Command, frozen=True):
    """Drive by hand: m/s forward and to the left, rad/s counter-clockwise. It holds for a fifth of a second, so it is
    repeated while the robot is to drive. The first one ends whatever the robot does."""

    do: ClassVar[str] = "drive"
    vx: Annotated[float, msgspec.Meta(ge=-10, le=10)] = 0.0
    vy: Annotated[float, msgspec.Meta(ge=-10, le=10)] = 0.0
    wz: Annotated[float, msgspec.Meta(ge=-10, le=10)] = 0.0
    id: str | None = None


class Here(Command, frozen=True):
    """Where the robot is, on the map, as a person sees it: m, and rad counter-clockwise from east; without ``yaw`` it
    looks where it believes to look. Nothing moves. Not while it does something."""

    do: ClassVar[str] = "here"
    x: float
    y: float
    yaw: float | None = None
    id: str | None = None


class LimitSpeed(Command, frozen=True):
    """Drive no faster than this share of what the safety envelope allows, until another limit is set. Nothing is
    interrupted: what drives already gets slower or faster."""

    do: ClassVar[str] = "limit_speed"
    share: Annotated[float, msgspec.Meta(gt=0, le=1)]
    id: str | None = None


class SetVolume(Command, frozen=True):
    """Speak and sound so loud from now on, as ``voice.volume`` says it: 0…1. What sounds already gets louder or
    quieter; nothing is interrupted."""

    do: ClassVar[str] = "set_volume"
    volume: Annotated[float, msgspec.Meta(ge=0, le=1)]
    id: str | None = None


class Audio(Command, frozen=True):
    """Sound for the recogniser, as if from the microphone: 16 kHz mono signed 16-bit little-endian."""

    do: ClassVar[str] = "audio"
    pcm: bytes
    id: str | None = None


class Snapshot(Command, frozen=True):
    """Answer with the state of session and robot in the acknowledgement."""

    do: ClassVar[str] = "snapshot"
    id: str | None = None


class Drop(Command, frozen=True):
    """Drop a request that waits: the one of this id, as ``requests.waiting`` tells it."""

    do: ClassVar[str] = "drop"
    request: str
    id: str | None = None


class Move(Command, frozen=True):
    """Have a request that waits begin before another one that waits, or (without ``before``) after all of them. Both
    are ids, as ``requests.waiting`` tells them."""

    do: ClassVar[str] = "move"
    request: str
    before: str | None = None
    id: str | None = None


class Quit(Command, frozen=True):
    """End the session: stop everything at once, or, with ``drain``, when what was asked for before is done."""

    do: ClassVar[str] = "quit"
    drain: bool = False
    id: str | None = None


# What the engine's own parts tell the session. It interrupts like a command, but nobody can send it from outside.


class Heard(Command, frozen=True):
    """Words overheard without a wake while the robot moves or speaks; only a stop among them is acted on."""

    do: ClassVar[str] = "heard"
    text: str


class Added(Command, frozen=True):
    """Somebody went on after a request that was complete, which ``turn`` took in ``epoch``. What was ``heard`` then is
    done after that (``adds``), or in its place; not if anybody has interrupted since, nor after what failed."""

    do: ClassVar[str] = "added"
    heard: TranscriptFinal
    adds: bool
    turn: str
    epoch: int


class Withdraw(Command, frozen=True):
    """The request with this ``id`` is not wanted any more, if it still waits for what runs to end."""

    do: ClassVar[str] = "withdraw"
    id: str


class Halted(Command, frozen=True):
    """The robot has stopped by itself in ``epoch``, or is ``lost``: what moves cannot go on. ``reason``: why, for
    people."""

    do: ClassVar[str] = "halted"
    reason: str
    epoch: int = 0
    lost: bool = False


COMMANDS: dict[str, type[Command]] = {
    cls.do: cls
    for cls in (
        Say,
        Wake,
        Interrupt,
        EndTask,
        EStop,
        Release,
        Drive,
        Here,
        LimitSpeed,
        SetVolume,
        Audio,
        Drop,
        Move,
        Snapshot,
        Quit,
    )
}


class BadCommand(UsageError):
    """A line is no command. ``do`` and ``id`` are those that it has nevertheless, for its acknowledgement."""

    def __init__(self, error: UsageError, do: str, id: str | None) -> None:
        super().__init__(error.message, hint=error.hint)
        self.do = do
        self.id = id


def parse_command(line: bytes | str) -> Command:
    """Read one command line. Raises :class:`BadCommand` that says what is wrong and what is allowed."""
    try:
        return _parsed(line)
    except UsageError as error:
        raise BadCommand(error, *_name_and_id(line)) from error


def _name_and_id(line: bytes | str) -> tuple[str, str | None]:
    """What can be read of ``do`` and ``id``, also where something else in the line is wrong."""
    try:
        raw = json.loads(line)
    except (ValueError, RecursionError):
        return "", None
    do, id = (raw.get("do"), raw.get("id")) if isinstance(raw, dict) else (None, None)
    if isinstance(id, int) and not isinstance(id, bool):
        id = str(id)
    return (do if isinstance(do, str) and is_text(do) else ""), (id if isinstance(id, str) and is_text(id) else None)


def _parsed(line: bytes | str) -> Command:
    if len(line) > MAX_LINE:
        raise UsageError(f"The command is {len(line)} bytes long; {MAX_LINE} are read at most.")
    try:
        raw: Any = msgspec.json.decode(line)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise UsageError(
            f"Not JSON: {error}.", hint='A command looks like {"do": "say", "text": "go home"}.'
        ) from error
    if not isinstance(raw, dict) or not isinstance(raw.get("do"), str):
        raise UsageError("A command is a JSON object with a text field 'do'.", hint=_allowed())
    do = raw.pop("do")
    if do not in COMMANDS:
        raise UsageError(f"Unknown command {do!r}.", hint=_allowed())
    if do == "audio" and isinstance(raw.get("pcm"), str):
        try:
            raw["pcm"] = b64decode(raw["pcm"], validate=True)
        except ValueError as error:  # binascii.Error is one, and so is what is not ASCII
            raise UsageError(f"audio: 'pcm' is not base64: {error}.") from error
        if len(raw["pcm"]) % 2:
            raise UsageError("audio: 'pcm' holds an odd number of bytes; samples have two.")
    known = COMMANDS[do].__struct_fields__
    if unknown := sorted(raw.keys() - set(known)):
        raise UsageError(f"{do}: unknown field {unknown[0]!r}.", hint=f"Allowed: {', '.join(known)}.")
    try:
        command = msgspec.convert(raw, type=COMMANDS[do])
    except msgspec.ValidationError as error:
        raise UsageError(f"{do}: {error}.") from error
    if isinstance(command, Say):
        for text in (command.text, *command.then):
            check_request(text)
    return command


def check_request(text: str) -> None:
    """Raises :class:`UsageError` where a request is empty, no text, or too long to be one."""
    if not is_text(text):
        raise UsageError("The request is no text: it is not UTF-8, or holds half a character.", hint="Write it anew.")
    if not text.strip():
        raise UsageError("The request is empty.", hint='Say what is to be done, for example "go to the kitchen".')
    if (why := too_long(text)) is not None:
        raise UsageError(why)


def too_long(text: str) -> str | None:
    """Why a request is not read, for people, where it is longer than any that somebody would say."""
    if len(text) <= MAX_TEXT:
        return None
    return (
        f"The request is {len(text)} characters long; {MAX_TEXT} are read at most. Ask for one thing after the other."
    )


def _allowed() -> str:
    return f"Commands: {', '.join(COMMANDS)}."
