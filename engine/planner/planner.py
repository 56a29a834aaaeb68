"""From words to a validated plan, or to the reason why there is none.

The planner asks the phrase templates first; later stages (large models) follow where they have no match. Whatever
proposes actions, only the skill registry turns them into a plan: one wrong action and nothing of it runs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from engine.errors import ExitCode, PlanError
from engine.events import ClarificationAsked, PlanRejected, RefusalMade
from engine.plan import Plan
from engine.planner.phrases import Matched, PhrasePlanner, UnknownPlace
from engine.skills.registry import SkillRegistry


@dataclass(frozen=True, slots=True)
class NoPlan:
    """Nothing will move. ``answer`` is what the robot says; ``exit_code`` tells a failure from a question (5) and a
    refusal (6)."""

    text: str
    code: str
    answer: str
    exit_code: ExitCode = ExitCode.FAILED
    suggestions: tuple[str, ...] = ()

    def as_event(self) -> PlanRejected | RefusalMade | ClarificationAsked:
        if self.exit_code is ExitCode.REFUSED:
            return RefusalMade(self.answer, self.text)
        if self.exit_code is ExitCode.CLARIFY:
            return ClarificationAsked(self.answer, self.text)
        return PlanRejected(self.text, self.answer, self.code, self.suggestions)


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """What a planner is asked."""

    text: str
    so_far: str = ""
    """What happened in this task until now, one fact a line (``engine.history.TaskCycle.as_text``)."""
    enter: Callable[[Literal["DECIDING", "PLANNING"]], None] = lambda stage: None
    """To be called when a stage of planning begins."""


class Plans(Protocol):
    """Whatever makes plans for a session."""

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        ...

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """Plan it, or say why not. Every action of a plan has been through the skill registry. Raises ``SaysoError``
        where a model or a service fails. May be cancelled; a plan that comes after that is dropped."""
        ...


class Planner:
    """Plans in the order phrases, then (a later issue) large models."""

    def __init__(self, phrases: PhrasePlanner, registry: SkillRegistry, *, max_actions: int) -> None:
        self._phrases = phrases
        self._registry = registry
        self._max_actions = max_actions

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        return self._phrases.understood

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """Plan what was asked for; raises nothing."""
        request.enter("PLANNING")
        text = request.text
        match = self._phrases.plan(text)
        if isinstance(match, Matched):
            return self._validated(text, match)
        if isinstance(match, UnknownPlace):
            answer = f"I don't know a place called {match.name}. I know {', '.join(match.known)}."
            return NoPlan(text, "unknown_place", answer, suggestions=match.known)
        if match.question:
            return NoPlan(text, "incomplete", match.question, ExitCode.CLARIFY)
        part = f": “{match.leftover}”" if match.leftover else ""
        return NoPlan(text, "not_understood", f"I did not understand{part}. {match.understood}")

    def _validated(self, text: str, match: Matched) -> Plan | NoPlan:
        try:
            if len(match.calls) > self._max_actions:
                raise PlanError(f"That is {len(match.calls)} actions; a plan has {self._max_actions} at most.")
            actions = tuple(self._registry.resolve(call) for call in match.calls)
        except PlanError as error:
            return NoPlan(text, error.code, str(error), ExitCode(error.exit_code))
        return Plan(goal=text, actions=actions, response=match.response, source="phrases", steps=match.steps)
