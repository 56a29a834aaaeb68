"""What a planner is asked, and what comes of it: the vocabulary of planning."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, Protocol

from engine.errors import ExitCode
from engine.events import (
    ClarificationAsked,
    MeaningRead,
    ModelAsked,
    Outcome,
    PlanRejected,
    PlanSource,
    RefusalMade,
    Scope,
)
from engine.plan import Action, ActionCall, Plan

Language = Literal["en", "zh"]


@dataclass(frozen=True, slots=True)
class NoPlan:
    """Nothing will move. ``answer`` is what the robot says; ``exit_code`` tells a failure from a question (5) and a
    refusal (6)."""

    text: str
    code: str
    answer: str
    exit_code: ExitCode = ExitCode.FAILED
    suggestions: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    """Names between which the user is to choose."""
    offer: tuple[ActionCall, ...] = ()
    """What is done if the user says yes."""
    lacks: str = ""
    """What the request does not say, as one of the questions for it: "where"; empty where that is not what is asked."""
    repeats: bool = False
    """It puts the last question once more: what was said instead of an answer was not understood."""

    @property
    def is_not_understood(self) -> bool:
        """Nobody has understood what was said, or the model that might have was not to be had."""
        return self.code == "not_understood" or self.code.startswith("model_")

    @property
    def nothing_new(self) -> bool:
        """It says nothing about what became of a plan."""
        return not self.answer or self.code.startswith("model_")

    @property
    def is_no_order(self) -> bool:
        """What was said forbids something, or is talk: it asks for nothing."""
        return self.code == "no_order"

    @property
    def leaves_open(self) -> bool:
        """An answer would complete the request; of what was no order nothing is open."""
        return self.exit_code is ExitCode.CLARIFY and not self.is_no_order

    def as_written(self) -> str:
        """The same as a model would write it."""
        key = {ExitCode.CLARIFY: "clarification", ExitCode.FAILED: "impossible"}.get(self.exit_code, "response")
        return json.dumps({key: self.answer}, ensure_ascii=False)

    def as_event(self) -> PlanRejected | RefusalMade | ClarificationAsked:
        if self.exit_code is ExitCode.REFUSED:
            return RefusalMade(self.answer, self.text)
        if self.exit_code is ExitCode.CLARIFY:
            return ClarificationAsked(self.answer, self.text, leaves_open=self.leaves_open)
        return PlanRejected(self.text, self.answer, self.code, self.suggestions)


@dataclass(frozen=True, slots=True)
class Said:
    """The user said it."""

    text: str


@dataclass(frozen=True, slots=True)
class Ran:
    """An action ran, and how it ended."""

    action: Action
    outcome: Outcome
    message: str = ""
    data: Mapping[str, object] = field(default_factory=dict)
    """What it has found, as its skill tells it: ``people`` is how many were counted."""

    def __str__(self) -> str:
        return f"{self.action} {self.outcome}. {self.message}".rstrip()


@dataclass(frozen=True, slots=True)
class Noted:
    """Something else that a model should know: an interruption, what could be heard of an answer, what never began."""

    text: str


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """Somebody interrupted while a question of the robot was open: no answer to it is to come."""


Happened = Said | Plan | NoPlan | Ran | Noted | Withdrawn
"""Something that happened earlier in a task; a plan or the reason why there is none is what the robot answered."""


@dataclass(frozen=True, slots=True)
class OnRecord:
    """What the session knows of the last plan of a task, for questions about the robot itself."""

    stopped: Scope | None = None
    """What interrupted it; None: nothing did."""
    failure: str = ""
    """Why an action of it failed, a sentence."""
    done: tuple[str, ...] = ()
    """What its actions came to, a sentence each."""
    left: tuple[Action, ...] = ()
    """What was cut, or never started; in the order of the plan."""
    cut: bool = False
    """Whether the first one that is left had begun."""
    back: tuple[ActionCall, ...] = ()
    """What undoes it."""
    no_way_back: str = ""
    """Why nothing does, a sentence."""
    charge: float | None = None
    """About how much the battery holds, 0…1; None: nobody measures it."""


NOTHING_ON_RECORD: Final = OnRecord()


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """What a planner is asked."""

    text: str
    """What the user said; empty when the planner is to go on after feedback."""
    happened: tuple[Happened, ...] = ()
    """What happened in this task until now, oldest first."""
    cycle: str = ""
    """Names the task: requests with the same one belong together."""
    language: Language | None = None
    """What the recogniser heard; None: to be seen from the text."""
    spoken: bool = False
    """Whether a microphone heard it: then it may have been said to somebody else, or be noise."""
    spent: frozenset[str] = frozenset()
    """Actions, as they are written, that have failed too often in this request to be tried again."""
    on_record: OnRecord = NOTHING_ON_RECORD
    """What came of the last plan."""
    holding: str = ""
    """The thing in the gripper."""
    people: Mapping[str, str] = field(default_factory=dict)
    """Of those who are known and were seen: where and when, a sentence by name."""
    seen: tuple[str, ...] = ()
    """Things that the robot has seen and where, a sentence each."""
    sees: Callable[[str], bool] | None = None
    """Whether such a thing (``red box``) has been seen since the request was made."""
    may_be_at: Callable[[str, str], bool] = lambda thing, place: True
    """Whether one of those that were seen may be there: on a piece of furniture or in a room, by its name."""
    picture: bytes | None = None
    """What the camera shows after a look, as a PNG file; only models that see get it."""
    enter: Callable[[Literal["DECIDING", "PLANNING"]], None] = lambda stage: None
    """To be called when a stage of planning begins that takes its time."""
    answers: Callable[[], object] = lambda: None
    """To be called when what was said is taken for the answer to the question that the robot asked last."""
    decide: Callable[[tuple[str, ...], PlanSource], None] = lambda steps, source: None
    """To be called with the decision layer's steps in words."""
    read: Callable[[MeaningRead], object] = lambda meaning: None
    """To be called with what a reader understood, when a plan or a question is made of it."""
    warn: Callable[[str], None] = lambda message: None
    """To be called with what the user should know of the planning itself."""
    record: Callable[[ModelAsked], object] = lambda call: None
    """To be called with each call of a large model when it is over, also when nobody waits for it any more."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A request, its text, or a part of that, and the language that it is answered in."""

    request: PlanRequest
    text: str
    language: Language


class Plans(Protocol):
    """Whatever makes plans for a session."""

    @property
    def abilities(self) -> str:
        """A sentence that tells what the robot can do."""
        ...

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """Plan it, or say why not. Every action of a plan has been through the skill registry. Raises ``SaysoError``
        where a model or a service fails. May be cancelled; a plan that comes after that is dropped."""
        ...
