"""The state machine of a session on one page: the states, the ways between them, and what each interruption does.

    IDLE ─▶ LISTENING ─▶ TRANSCRIBING ─▶ DECIDING ─▶ PLANNING ─▶ ACTING (∥ speaking) ─▶ FEEDBACK ─▶ WAITING
                                                        ├──────▶ SPEAKING ──────────────────────────▶
                                                        └──────▶ CLARIFYING ────────────────────────▶

An action may ask the user something: then CLARIFYING follows ACTING. A typed request enters at DECIDING or PLANNING.
FEEDBACK may lead back to them: the planner is told what was done and plans on, or gives up and says so. From every
state a turn can end, and then the session rests: in IDLE when its task cycle is empty, in WAITING when it has a
history. IDLE and WAITING are the only states without a running turn.

Nothing here acts. ``engine.session.session`` follows these tables, and a way that is not in them is a fault.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from engine.events import Scope, State

REST: Final[frozenset[State]] = frozenset({"IDLE", "WAITING"})
"""No turn is running."""

EXPRESSING: Final[frozenset[State]] = frozenset({"CLARIFYING", "SPEAKING", "ACTING", "FEEDBACK"})
"""The robot moves or speaks. Here "stop" is understood without a wake, and a wake sends the arm home."""


def _to(*states: State) -> frozenset[State]:
    return REST.union(states)


_STARTS: Final = _to("LISTENING", "DECIDING", "PLANNING", "SPEAKING")

NEXT: Final[Mapping[State, frozenset[State]]] = {
    "IDLE": _STARTS,
    "WAITING": _STARTS,
    "LISTENING": _to("TRANSCRIBING"),
    "TRANSCRIBING": _to("DECIDING", "PLANNING"),
    "DECIDING": _to("PLANNING", "CLARIFYING", "SPEAKING", "ACTING"),
    "PLANNING": _to("CLARIFYING", "SPEAKING", "ACTING"),
    "CLARIFYING": _to(),
    "SPEAKING": _to(),
    "ACTING": _to("FEEDBACK", "CLARIFYING"),
    "FEEDBACK": _to("DECIDING", "PLANNING", "SPEAKING"),
}
"""The states that may follow each state."""


@dataclass(frozen=True, slots=True)
class Effect:
    """What an interruption does. All of them stop the robot in the caller's thread, end the running turn with its
    outcomes on record, and drop what waits."""

    message: str
    """How the turn that it ended is reported."""
    arm_home_from: frozenset[State] = frozenset()
    """States from which the arm is sent slowly to its initial pose; it keeps what it holds."""


EFFECTS: Final[Mapping[Scope, Effect]] = {
    "stop": Effect("Stopped."),  # and the robot says so
    "estop": Effect("The emergency stop was pressed."),  # and nothing moves until it is released
    "release": Effect("The emergency stop was released."),  # and nothing of what was asked for before it moves anything
    "interrupt": Effect("Interrupted."),  # and nothing else happens
    "wake": Effect("Woken.", arm_home_from=EXPRESSING),  # and listening starts at once
    "replaced": Effect("A newer command replaced this one."),  # which is planned at once
    "by_hand": Effect("Somebody drives by hand."),
    "end_task": Effect("The task was ended."),  # the new cycle begins with the arm at home and without a history
    "halted": Effect("The robot stopped by itself."),  # as an interrupt, but the turn counts as failed
    "shutdown": Effect("The session ends."),
}
