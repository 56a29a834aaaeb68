"""What happened in a task cycle, in the order it happened: the memory that the planner is told, and the truth.

An entry is written when the thing has happened, never before, and never changed afterwards.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Final

from ulid import ULID

from engine.events import Scope
from engine.plan import Action, Plan
from engine.planner import request
from engine.planner.request import Happened, NoPlan, Noted, OnRecord
from engine.session.ran import Ran, rest_of

MAX_ENTRIES: Final = 500
"""Entries of one task cycle that are kept, the newest: somebody may never end a task."""


@dataclass(frozen=True, slots=True)
class Said:
    """Somebody asked for something."""

    turn: str
    text: str


@dataclass(frozen=True, slots=True)
class Planned:
    """The planner answered: a plan that was begun, a question or a reason."""

    turn: str
    answer: Plan | NoPlan


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


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """The question that the turn ended with is not open any more: somebody interrupted."""

    turn: str


Entry = Said | Planned | Acted | NeverStarted | Answered | Interrupted | Withdrawn


@dataclass(slots=True)
class TaskCycle:
    """One conversation, from the first request to the end of the task."""

    number: int
    name: str = field(default_factory=lambda: str(ULID()))
    """Unlike that of any other cycle of any session."""
    put_after: str = ""
    """The turn that was the last to do something when somebody put the robot elsewhere on the map."""
    entries: deque[Entry] = field(default_factory=lambda: deque(maxlen=MAX_ENTRIES))

    @property
    def last_said(self) -> str:
        """What somebody asked for last."""
        return next((entry.text for entry in reversed(self.entries) if isinstance(entry, Said)), "")

    def acted_last(self) -> tuple[str, tuple[Ran, ...]]:
        """The newest turn in which something was done, by its id, and what was done; both are empty where nothing
        was. A turn whose actions the robot refused to begin is only meant where there is no other."""
        acted = [entry for entry in self.entries if isinstance(entry, Acted)]
        turns = [entry.turn for entry in acted if entry.ran.began] or [entry.turn for entry in acted]
        turn = turns[-1] if turns else ""
        return turn, tuple(entry.ran for entry in acted if entry.turn == turn)

    def planned_last(self) -> str:
        """The turn of the newest plan with actions, by its id; empty where there was none."""
        plans = (entry for entry in reversed(self.entries) if isinstance(entry, Planned))
        return next((plan.turn for plan in plans if isinstance(plan.answer, Plan) and plan.answer.actions), "")

    def leaves_open(self, turn: str) -> bool:
        """Whether a turn that ended with a question wants to know what would complete its request. A skill always
        does."""
        plans = (entry.answer for entry in reversed(self.entries) if isinstance(entry, Planned) and entry.turn == turn)
        answer = next(plans, None)
        return answer.leaves_open if isinstance(answer, NoPlan) else True

    def on_record(self) -> OnRecord:
        """What came of the last plan that was begun, for questions about it."""
        turn, acted = self.acted_last()
        if not turn:
            return OnRecord()
        mine = [entry for entry in self.entries if entry.turn == turn]
        cut = [ran for ran in acted if ran.result.outcome == "interrupted"]
        rests = [rest_of(ran) for ran in cut]
        left = [rest or ran.action for ran, rest in zip(cut, rests, strict=True) if rest is None or _is_worth(rest)]
        never = [action for entry in mine if isinstance(entry, NeverStarted) for action in entry.actions]
        stopped = (entry.scope for entry in reversed(mine) if isinstance(entry, Interrupted))
        since = [entry.ran for entry in list(self.entries)[self.entries.index(mine[0]) :] if isinstance(entry, Acted)]
        return OnRecord(
            stopped=next(stopped, None),
            failure=next((ran.result.message for ran in reversed(since) if ran.result.outcome == "failed"), ""),
            done=tuple(ran.result.message for ran in acted if ran.result.message),
            left=(*left, *never),
            cut=bool(rests) and rests[0] is None,
        )

    def as_json(self) -> list[dict[str, Any]]:
        """For snapshots."""
        return [_as_json(entry) for entry in self.entries]

    def happened(self) -> tuple[Happened, ...]:
        """For a planner: what was said, what was planned, what was done and how it ended, what was cut and where that
        left the robot, and what never started; oldest first."""
        return tuple(filter(None, map(_happened, self.entries)))


def _is_worth(rest: Action) -> bool:
    """Whether anything is left of an action."""
    return all(value for name, value in rest.args.items() if name in ("distance", "angle", "seconds", "duration"))


def _as_json(entry: Entry) -> dict[str, Any]:
    match entry:
        case Said(turn, text):
            return {"turn": turn, "said": text}
        case Planned(turn, answer):
            return {"turn": turn, "planned": answer.as_written()}
        case Answered(turn, text, heard):
            return {"turn": turn, "answered": heard, "cut_off": heard != text}
        case Interrupted(turn, scope):
            return {"turn": turn, "interrupted": scope}
        case Withdrawn(turn):
            return {"turn": turn, "withdrawn": "question"}
        case Acted(turn, ran):
            result = ran.result
            return {"turn": turn, "action": str(ran.action), "outcome": result.outcome, "message": result.message}
        case NeverStarted(turn, actions):
            return {"turn": turn, "never_started": [str(action) for action in actions]}


def _happened(entry: Entry) -> Happened | None:
    match entry:
        case Said(_, text):
            return request.Said(text)
        case Planned(_, answer):
            return answer
        case Answered(_, text, heard) if heard == text:
            return None  # it is in the plan, or in the feedback
        case Answered(_, _, heard):
            heard = heard or "(nothing that could be heard)"
            return Noted(f"The robot said, before it was cut off: {heard}")
        case Withdrawn():
            return request.Withdrawn()
        case Interrupted(_, scope):
            return Noted(f"Interruption: {_BY[scope]}.")
        case Acted(_, ran):
            return request.Ran(ran.action, ran.result.outcome, ran.result.message, ran.result.data)
        case NeverStarted(_, actions):
            return Noted(f"Never started: {', '.join(map(str, actions))}.")


_BY: dict[Scope, str] = {
    "stop": "the user said stop",
    "estop": "the user pressed the emergency stop",
    "release": "the user released the emergency stop",
    "interrupt": "the user interrupted",
    "wake": "the user called the robot",
    "end_task": "the user ended the task",
    "replaced": "the user gave another command",
    "by_hand": "the user drove by hand",
    "halted": "the robot stopped by itself",
    "shutdown": "the session ended",
}
