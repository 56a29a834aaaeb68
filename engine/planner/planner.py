"""From words to a validated plan, or to the reason why there is none.

The planner asks the phrase templates first; later stages (large models) follow where they have no match. Whatever
proposes actions, only the skill registry turns them into a plan: one wrong action and nothing of it runs.
"""

from __future__ import annotations

from dataclasses import dataclass

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

    async def plan(self, text: str) -> Plan | NoPlan:
        """Plan what ``text`` asks for."""
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
