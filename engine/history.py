"""What happened in a task cycle, in the order it happened: the memory that the planner is told, and the truth.

An entry is written when the thing has happened, never before, and never changed afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from engine.dispatch import Ran
from engine.events import Scope
from engine.plan import Action


@dataclass(frozen=True, slots=True)
class Said:
    """Somebody asked for something."""

    turn: str
    text: str


@dataclass(frozen=True, slots=True)
class Acted:
    """An action ran, and how it ended."""

    turn: str
    ran: Ran


@dataclass(frozen=True, slots=True)
class NeverStarted:
    """What was left of a plan when it ended."""

    turn: str
    actions: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class Answered:
    """The robot said ``text``; ``heard`` is what could be heard of it, up to the last word that was played."""

    turn: str
    text: str
    heard: str


@dataclass(frozen=True, slots=True)
class Interrupted:
    """The turn was interrupted."""

    turn: str
    scope: Scope


Entry = Said | Acted | NeverStarted | Answered | Interrupted


@dataclass(slots=True)
class TaskCycle:
    """One conversation, from the first request to the end of the task."""

    number: int
    entries: list[Entry] = field(default_factory=list)

    def as_json(self) -> list[dict[str, Any]]:
        """For snapshots."""
        return [_as_json(entry) for entry in self.entries]

    def as_text(self) -> str:
        """For a planner: what was said, what was done and how it ended, what was cut and where that left the robot,
        and what never started. One fact a line, oldest first."""
        return "\n".join(map(_as_line, self.entries))


def _as_json(entry: Entry) -> dict[str, Any]:
    match entry:
        case Said(turn, text):
            return {"turn": turn, "said": text}
        case Answered(turn, text, heard):
            return {"turn": turn, "answered": heard, "cut_off": heard != text}
        case Interrupted(turn, scope):
            return {"turn": turn, "interrupted": scope}
        case Acted(turn, ran):
            result = ran.result
            return {"turn": turn, "action": str(ran.action), "outcome": result.outcome, "message": result.message}
        case NeverStarted(turn, actions):
            return {"turn": turn, "never_started": [str(action) for action in actions]}


def _as_line(entry: Entry) -> str:
    match entry:
        case Said(_, text):
            return f"user: {text}"
        case Answered(_, text, heard) if heard == text:
            return f"robot said: {text}"
        case Answered(_, _, heard):
            return f"robot said, before it was cut off: {heard or '(nothing that could be heard)'}"
        case Interrupted(_, scope):
            return f"interruption: {_BY[scope]}"
        case Acted(_, ran):
            return f"robot feedback: {ran.action} {ran.result.outcome}. {ran.result.message}".rstrip()
        case NeverStarted(_, actions):
            return f"robot feedback: never started: {', '.join(map(str, actions))}"


_BY: dict[Scope, str] = {
    "stop": "the user said stop",
    "interrupt": "the user interrupted",
    "wake": "the user called the robot",
    "end_task": "the user ended the task",
    "replaced": "the user gave another command",
    "halted": "the robot stopped by itself",
    "shutdown": "the session ended",
}
