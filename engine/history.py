"""What happened in a task cycle, in the order it happened: the memory that the planner is told, and the truth.

An entry is written when the thing has happened, never before, and never changed afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from engine.dispatch import Ran
from engine.plan import Action


@dataclass(frozen=True, slots=True)
class Said:
    """Somebody asked for something."""

    turn: str
    text: str


@dataclass(frozen=True, slots=True)
class Done:
    """Actions of one plan: those that ran with how they ended, and those that never started."""

    turn: str
    ran: tuple[Ran, ...]
    never_started: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class Answered:
    """The robot said something; ``heard`` is what could be heard of it."""

    turn: str
    heard: str


Entry = Said | Done | Answered


@dataclass(slots=True)
class TaskCycle:
    """One conversation, from the first request to the end of the task."""

    number: int
    entries: list[Entry] = field(default_factory=list)

    def as_json(self) -> list[dict[str, Any]]:
        """For snapshots."""
        return [_entry(entry) for entry in self.entries]


def _entry(entry: Entry) -> dict[str, Any]:
    match entry:
        case Said(turn, text):
            return {"turn": turn, "said": text}
        case Answered(turn, heard):
            return {"turn": turn, "answered": heard}
        case Done(turn, ran, never_started):
            return {
                "turn": turn,
                "ran": [
                    {"action": str(r.action), "outcome": r.result.outcome, "message": r.result.message} for r in ran
                ],
                "never_started": [str(action) for action in never_started],
            }
