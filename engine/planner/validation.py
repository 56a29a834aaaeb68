"""From actions that a reader has named to a validated plan, or to the reason why there is none.

Only the skill registry makes a plan of them: one wrong action and nothing of it runs. Where several things are called
the same, the one that has been seen is meant; else it is asked which one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from engine.errors import ExitCode, PlanError
from engine.plan import Action, ActionCall, Argument, Plan, Quantity
from engine.planner.request import Language, NoPlan, PlanRequest
from engine.planner.sentences import SAID
from engine.robot.robot import Capability
from engine.skills.registry import Skill, SkillRegistry, any_of, is_said
from engine.skills.vocabulary import Vocabulary

_TAKES: Final = frozenset({"pick_object", "carry"})
"""Skills for which it matters which one of several things is meant."""


def which_of(text: str, names: Sequence[str], language: Language) -> NoPlan:
    """The question which of several things is meant."""
    told = SAID[language]
    listed = told["or"].join((", the ".join(names[:-1]), names[-1]))
    return NoPlan(text, "ambiguous", told["which_of"].format(names=listed), ExitCode.CLARIFY, options=tuple(names))


class Validation:
    """What the skills and the words of one house allow."""

    def __init__(self, registry: SkillRegistry, vocabulary: Vocabulary, max_actions: int) -> None:
        self._registry = registry
        self._vocabulary = vocabulary
        self._max_actions = max_actions

    def occupied(self, skill: str) -> frozenset[Capability]:
        """What a skill occupies while it runs."""
        return self._registry[skill].occupies

    def offers(self, skill: str) -> bool:
        """Whether there is a skill of this name."""
        return any(skill == one.name for one in self._registry)

    def calls(self, plan: Plan) -> tuple[ActionCall, ...]:
        """The actions of a plan as they are written."""
        return tuple(as_call(self._registry[action.name], action) for action in plan.actions)

    def of(self, text: str, calls: Sequence[ActionCall], steps: tuple[str, ...], response: str) -> Plan | NoPlan:
        """The plan of ``calls``, told as ``steps`` and ``response``."""
        try:
            if len(calls) > self._max_actions:
                raise PlanError(f"That is {len(calls)} actions; a plan has {self._max_actions} at most.")
            actions = tuple(self._registry.resolve(call, text) for call in calls)
        except PlanError as error:
            return NoPlan(text, error.code, str(error), ExitCode(error.exit_code))
        return Plan(goal=text, actions=actions, response=response, source="phrases", steps=steps)

    def one_of(
        self, found: Plan | NoPlan, request: PlanRequest, language: Language, located: Mapping[str, str] | None = None
    ) -> Plan | NoPlan:
        """With the one thing that can be meant, where several are called so and only one of them has been seen; the
        question which one it is, where that is open. Of those that are ``located``, each with the name of its place,
        the one that is there is meant."""
        located = located or {}
        if isinstance(found, NoPlan):
            return found
        actions: list[Action] = []
        for action in found.actions:
            words = str(action.args.get("object", ""))
            several = self._vocabulary.fitting(words) if action.name in _TAKES else ()
            called = [name for name in several if is_said(name, request.text)]
            if len(called) == 1 and words == self._vocabulary.object(called[0]):
                several = ()  # another thing looks like it, and is called otherwise
            apposed = _apposed(several, request.text)
            if len(several) > 1 and words in located and apposed is None:
                there = [name for name in several if _was_seen_at(name, located[words], request.seen)]
                if len(there) > 1 and not any_of(words, request.text):
                    return which_of(found.goal, there, language)
                if there:
                    action = replace(action, args={**action.args, "object": self._vocabulary.object(there[0])})
            elif len(several) > 1 and not any_of(words, request.text):
                seen = [name for name in several if any(name in told for told in request.seen)]
                if apposed is not None:
                    seen = [apposed]
                elif len(called) == 1:  # "the yellow box …; the box …"
                    seen = called
                if len(seen) != 1:
                    return which_of(found.goal, several, language)
                action = replace(action, args={**action.args, "object": self._vocabulary.object(seen[0])})
            actions.append(action)
        return replace(found, actions=tuple(actions))


def _was_seen_at(name: str, place: str, seen: Sequence[str]) -> bool:
    return any(name in told and f"the {place}" in told.casefold() for told in seen)


def _apposed(several: Sequence[str], text: str) -> str | None:
    """The one of these that the text tells more of: "pick up the cup, the white one"."""
    plain = text.casefold()
    told = [
        name for name in several if re.search(rf"(?<!not )(?<!but )\bthe {re.escape(name.split()[0])} one\b", plain)
    ]
    return told[0] if len(told) == 1 else None


def as_call(skill: Skill, action: Action) -> ActionCall:
    """An action as it is written, without the arguments at the end that are the skill's own."""
    arguments: list[Argument] = []
    kept = 0
    for parameter in skill.parameters:
        value = action.args[parameter.name]
        arguments.append(Quantity(value, parameter.unit) if isinstance(value, float) else str(value))
        if value != parameter.default:
            kept = len(arguments)
    return ActionCall(action.name, tuple(arguments[:kept]), alongside=action.alongside)
