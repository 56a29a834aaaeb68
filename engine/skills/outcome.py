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
    "door_closed",  # the only way leads through a door that is shut
    "object_not_found",  # nothing like it was seen
    "out_of_reach",  # the arm cannot get there from anywhere the base can stand
    "grasp_failed",  # the fingers closed on nothing, or it slipped out
    "dropped",  # it was held, and is not any more
    "nothing_held",
    "hand_full",  # something else is held
    "no_room",  # there is no free place to put it down
    "target_lost",  # what was followed is out of sight
    "camera_lost",
    "needs_answer",  # a question to the user; the message is the question
    "no_progress",  # commanded to move, but it does not
    "robot_lost",  # the robot does not answer; what it did is uncertain
    "robot_halted",  # the robot stopped itself: watchdog, envelope
    "battery_low",  # too low for something that goes on and on
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
