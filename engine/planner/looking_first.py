"""What depends on what is there: first the plan of a look, and after it what the look decides.

A request is taken apart into what to look for, where, and what to do in either case (``conditions.py``); what could not
be taken apart is at least looked at (``first_look.py``). Nothing is decided about a thing that no look could tell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from engine.plan import ActionCall, Plan
from engine.planner.grounding.grounds import resolved
from engine.planner.happened import last_said
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner, UnknownPlace
from engine.planner.phrases.said import Calls
from engine.planner.readings.conditions import conditional
from engine.planner.request import Conditional, Language, NoPlan, PlanRequest
from engine.planner.sentences import SAID
from engine.planner.text.counts import counted
from engine.planner.unknown_places import unknown
from engine.planner.validation import Validation
from engine.skills.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True)
class GoesOn:
    """What is to be done after a look, as a request of its own."""

    text: str


class LookingFirst:
    """Knows what can be seen in one house."""

    def __init__(
        self,
        phrases: Callable[[Language], PhrasePlanner],
        heard: Callable[[str], Iterator[str]],
        validation: Validation,
        vocabulary: Vocabulary,
    ) -> None:
        """``heard`` gives what was said where it was written down otherwise."""
        self._phrases = phrases
        self._heard = heard
        self._validation = validation
        self._vocabulary = vocabulary

    def conditional(self, text: str) -> Conditional | None:
        """A request taken apart, also one that was misheard; None where it is no condition on what can be seen."""
        if (several := counted(text)) is not None and (found := conditional(several[0])) is not None:
            return replace(found, count=several[1])
        return conditional(text) or next(filter(None, map(conditional, self._heard(text))), None)

    def plan(self, text: str, condition: Conditional, language: Language) -> Plan | NoPlan | NoMatch:
        """Go where the condition can be seen, and look; no match where nobody knows how to get there."""
        if condition.count is not None and not self._countable(condition.thing):
            return NoPlan(text, "uncounted", SAID[language]["uncounted"].format(thing=condition.thing))
        phrases = self._phrases(language)
        going: tuple[ActionCall, ...] = ()
        for words in (condition.before, condition.where):
            if not words:
                continue
            go = phrases.plan(words)
            if not isinstance(go, Matched):
                go = phrases.plan(f"go to {words}" if language == "en" else f"去{words}")
            if isinstance(go, UnknownPlace):
                return unknown(text, go, language)
            if not isinstance(go, Matched) or go.kind != "plan":
                return NoMatch(words, phrases.understood)
            going += tuple(call for call in go.calls if call.name != "seewhat")
        return self.look(text, (*going, ActionCall("seewhat")), language)

    def look(self, text: str, look: Calls, language: Language) -> Plan | NoPlan:
        """The plan of a look, after which it goes on."""
        told = self._phrases(language).told(look)
        plan = self._validation.of(text, look, told.steps, told.response)
        return replace(plan, finished=False) if isinstance(plan, Plan) else plan

    def decided(self, request: PlanRequest, condition: Conditional, language: Language) -> GoesOn | Plan | NoPlan:
        """It was looked: what the condition says about what was seen."""
        assert request.sees is not None
        somebody = resolved(self._vocabulary.resolvers()["place"], condition.thing)  # a world may have people as places
        thing = condition.thing if somebody is None else "person"
        if not self._vocabulary.fitting(thing):  # then not having seen it means nothing
            answer = SAID[language]["unknown_thing"].format(thing=condition.thing)
            return NoPlan(last_said(request.happened), "unknown_object", answer)
        count = condition.count
        there = request.sees(thing) if count is None else count.holds(self._countable(thing), request.sees)
        words = condition.then if there != condition.negated else condition.otherwise
        if condition.thing == "thing" and len(request.seen) == 1 and request.seen[0] in self._vocabulary.inventory():
            words = words.replace("the thing", f"the {request.seen[0]}")
        if words:
            return GoesOn(words)
        tells = ("present", "absent") if count is None else ("so_many", "not_so_many")
        answer = SAID[language][tells[not there]].format(thing=condition.thing)
        return Plan(last_said(request.happened), (), answer, "phrases")

    def _countable(self, thing: str) -> tuple[str, ...]:
        """The names of all things that are meant; nothing where several of them may share one."""
        names = self._vocabulary.fitting(thing)
        return names if len(names) > 1 and set(names) <= set(self._vocabulary.inventory()) else ()
