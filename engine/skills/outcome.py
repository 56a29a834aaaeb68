"""How an action ended, as a type. Skills return one of these; nobody parses prose to learn what happened."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from engine.events import Outcome, Value

ErrorCode = Literal[
    "path_blocked",  # something is in the way
    "unreachable",  # there is no way to that place
    "unknown_place",
    "no_progress",  # commanded to move, but it does not
    "robot_lost",  # the robot does not answer; what it did is uncertain
    "robot_halted",  # the robot stopped itself: watchdog, envelope
    "cancelled",  # cut by an interruption
    "time_limit",
    "not_supported",
    "crashed",  # a fault in the skill itself
]


@dataclass(frozen=True, slots=True)
class Result:
    """What a skill reports: the outcome, a stable code unless it is ok, a sentence for people, and findings."""

    outcome: Outcome
    error_code: ErrorCode | None
    message: str
    data: Mapping[str, Value] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        return self.outcome == "ok"


def ok(message: str = "", **data: Value) -> Result:
    """Done, as asked."""
    return Result("ok", None, message, data)


def fail(code: ErrorCode, message: str, **data: Value) -> Result:
    """Not done; ``message`` says how far it got and why."""
    return Result("failed", code, message, data)
