"""The small facts that the console shows: a line, a plan, an action, a level. Frozen, and clean of what would disturb
a terminal: :func:`printable` is what every text from outside goes through on its way in."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping
from typing import Final, Literal

from msgspec import Struct

from engine.events import ActionQueued, ActionStarted, Value

MAX_TEXT: Final = 2000
"""Characters of one text that are shown."""

Speaker = Literal["you", "robot", "unheard", "mark", "lost", "done", "problem"]
"""``lost`` is a request that came to nothing."""
Phase = Literal["queued", "running", "ok", "failed", "interrupted", "uncertain"]
Stage = Literal["thinking", "made", "rejected", "refused", "question"]
Path = tuple[tuple[float, float], ...]


class Line(Struct, frozen=True):
    """One line of the conversation; ``note`` is a remark beside it."""

    who: Speaker
    text: str
    note: str = ""


class Ended(Struct, frozen=True):
    """How a request ended, in the robot's words or in ours."""

    number: int  # 1 is the first of the session
    text: str
    message: str = ""  # what the robot says
    note: str = ""  # a remark of the console
    by: str = ""  # what interrupted it
    halted: bool = False  # the robot could not be moved, as ``message`` says
    done: bool = False

    def is_like(self, other: Ended) -> bool:
        """They ended in the same way."""
        return (self.message, self.note, self.by, self.done) == (other.message, other.note, other.by, other.done)


class Plan(Struct, frozen=True):
    """What the planner made of the last request."""

    stage: Stage
    goal: str = ""
    steps: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    source: str = ""
    message: str = ""  # why not, or what is asked
    suggestions: tuple[str, ...] = ()
    open: bool = True  # what is asked about waits for an answer


class Row(Struct, frozen=True):
    """One action of the queue."""

    action: str
    turn: str | None
    index: int
    call: str  # what is to be done, in words: ``Go to the kitchen``
    phase: Phase
    started: float | None = None  # s, event time…
    began: float | None = None  # …and robot time, by which its duration is measured; None: nobody has told
    duration_s: float | None = None
    fraction: float | None = None  # 0…1
    message: str = ""
    path: Path = ()  # the way that is left, map frame, m

    def elapsed(self, now: float, robot_now: float | None = None) -> float | None:
        """Seconds so far at event time ``now``, or in all; None before the start. They are the robot's own where its
        clock is known, which may go faster than ours."""
        if self.duration_s is not None or self.started is None:
            return self.duration_s
        if self.began is not None and robot_now is not None:
            return max(0.0, robot_now - self.began)
        return max(0.0, now - self.started)


class Waiting(Struct, frozen=True):
    """A request that waits until what runs has ended."""

    id: str  # by which it is dropped and moved; empty where nobody has told it
    text: str


class LogLine(Struct, frozen=True):
    """One line of the log."""

    t: float  # s since the session began
    level: Literal["debug", "info", "warning", "error"]
    source: str
    message: str
    turn: str | None = None  # in which it was told, by its id


class Level(Struct, frozen=True):
    """Loudness and voice activity at one moment."""

    rms_db: float
    speech_probability: float
    in_speech: bool


class Problem(Struct, frozen=True):
    """Something that failed and wants to be read."""

    message: str
    hint: str = ""
    title: str = ""  # none: that something failed
    fatal: bool = False
    code: str = ""  # for programs, as in the event ``error``


def printable(text: str) -> str:
    """Text that cannot disturb a terminal: controls, escapes and direction overrides become spaces; cut when long."""
    if len(text) > MAX_TEXT:
        text = text[: MAX_TEXT - 1] + "…"
    if text.isascii() and text.isprintable():
        return text
    return "".join(" " if unicodedata.category(char) in ("Cc", "Cf", "Zl", "Zp", "Cs") else char for char in text)


def printable_lines(text: str) -> str:
    """Text of several lines, each of them printable; what is longer than one may be goes on in the next."""
    cut = (line[at : at + MAX_TEXT] for line in text.splitlines() for at in range(0, len(line) or 1, MAX_TEXT))
    return "\n".join(map(printable, cut))


def call(name: str, args: Mapping[str, Value]) -> str:
    """An action as it is written: ``navigate_to(A)``, with names once there is more than one argument."""
    values = [figure(value) if isinstance(value, float) else str(value) for value in args.values()]
    if len(values) > 1:
        values = [f"{key}={value}" for key, value in zip(args, values, strict=True)]
    return printable(f"{name}({', '.join(values)})")


def figure(value: float) -> str:
    """A number for people: two decimals at most, without an exponent and without the minus of −0."""
    return f"{round(value, 2) + 0.0:.2f}".rstrip("0").rstrip(".") if math.isfinite(value) else str(value)


def in_words(body: ActionQueued | ActionStarted) -> str:
    """What is to be done, for people; as it is written where the engine has no words for it."""
    return printable(body.told) or call(body.name, body.args)
