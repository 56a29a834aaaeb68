"""Reads one clause: tries the templates with and without the words of politeness and speed around them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from engine.plan import ActionCall, Argument, Quantity
from engine.planner.phrases.conventions import Manner
from engine.planner.phrases.errands import going_on, things_after
from engine.planner.phrases.freetext import FreeText
from engine.planner.phrases.meanings import TOPICS, calls_of
from engine.planner.phrases.said import NOTHING_NAMED, Calls, Incomplete, Said, Things
from engine.planner.phrases.templates import ASKED, BARE, NOTHING, Context, Match, Templates, render
from engine.planner.text.language import any_of, without
from engine.planner.text.words import Sentence, Token
from engine.skills.registry import Skill

MAX_LEADING = 4
"""How many phrases in front of an errand change nothing (你可以去给我 …)."""
_AS_SAID = {"whole", "tag"}
"""Slots that hold a bare number, not the index of a measure."""


class State(NamedTuple):
    """What earlier clauses were about."""

    context: Context = NOTHING
    things: Things = NOTHING_NAMED
    doing: bool = False  # they are asked for as in "would you mind going there"


@dataclass(frozen=True, slots=True)
class Clause:
    """One clause that was read: actions, or the name of a place that is not known, or a question."""

    words: tuple[Token, ...]
    calls: Calls = ()
    unknown: str = ""
    question: str = ""
    instead: bool = False  # of the clause before


class ClauseReader:
    """Reads the clauses of one language for one map."""

    def __init__(self, sections: Mapping[str, Any], templates: Templates, skills: Iterable[Skill]) -> None:
        self._templates = templates
        self._asked = {ASKED + skill.name: skill for skill in skills}
        self._free_text = FreeText(sections, templates)
        self._fillers = re.compile(any_of((*sections["fillers"], *sections["hesitations"])))
        self._hesitations = re.compile(any_of(sections["hesitations"]))
        self._closing = re.compile(rf"{any_of(sections['closing'])}$")
        self._doing: Mapping[str, str] = sections["doing"]
        self._minding = re.compile(rf"^{any_of(sections['minding'])} (?={any_of(self._doing)})")
        self._leading = re.compile(rf"^{any_of(sections['leading'])}")
        self._together = re.compile(any_of(sections["together"]))
        self._manners: dict[Manner, re.Pattern[str]] = {
            manner: re.compile(any_of(phrases)) for manner, phrases in sections["manners"].items()
        }

    def is_filler(self, words: Sequence[Token]) -> bool:
        """Whether the words are nothing but politeness ("okay", "please")."""
        return not without(self._closing, without(self._fillers, render(words)[0]))

    def read(
        self, sentence: Sentence, words: tuple[Token, ...], single: bool, lenient: bool, state: State
    ) -> tuple[Clause, State] | None:
        """The clause and the state after it, or None.

        ``single``: the words were not joined from several segments. ``lenient`` admits questions and unknown places.
        """
        text, measures = render(words)
        alone = without(self._together, text)
        text, together = without(self._closing, alone), alone != text
        bare, doing = self._bare(text, state.doing)
        state = state._replace(doing=doing)
        manner: Manner | None = None
        context = state.context
        match = self._templates.match(bare, context)
        for fuller in (text, without(self._hesitations, text)):  # "what can you do" is more than politeness
            if match is None and fuller != bare:
                match = self._templates.match(fuller, context)
        errand = bare
        for _ in range(MAX_LEADING):
            if match is not None or (shorter := without(self._leading, errand)) == errand:
                break
            errand = shorter
            match = self._templates.match(errand, context)
        if match is None and (speech := self._free_text.speech(sentence, words, single)):
            match, together = Match("Say", {"text": speech}), False  # every word of it is to be said
        if match is None:
            match, manner = self._match_manner(text, state)
        if match is None and lenient:
            if (match := self._templates.match(bare, context, "incomplete_intents")) is not None:
                return Clause(words, question=match.words["question"]), state
            place = self._free_text.unknown_place(sentence, words, context) if single else ""
            return (Clause(words, unknown=place), _after(state, "Somewhere", state.things)) if place else None
        if match is None:
            return None
        numbers = {
            name.removeprefix(BARE): float(n) if name in _AS_SAID or name.startswith(BARE) else measures[n]
            for name, n in match.numbers.items()
        }
        said = Said(match.intent, match.words, numbers, manner, state.things)
        more = going_on(said)
        try:
            skill = self._asked.get(said.intent)
            calls = calls_of(more or said) if skill is None else _as_asked(skill, said)
        except Incomplete as missing:
            return (Clause(words, question=missing.question), state) if lenient else None
        if calls is None or (together and len(calls) != 1):
            return None
        if together:
            calls = (replace(calls[0], alongside=True),)
        return Clause(words, calls, instead=more is not None), _after(state, match.intent, things_after(said, calls))

    def _bare(self, text: str, doing: bool) -> tuple[str, bool]:
        """What is asked for, without politeness and as a command, and whether it was put with a gerund."""
        bare = without(self._fillers, text)
        request = self._minding.sub("", bare)
        doing = doing or request != bare
        first = request.split(" ", 1)[0]
        return self._doing[first] + request.removeprefix(first) if doing and first in self._doing else request, doing

    def _match_manner(self, text: str, state: State) -> tuple[Match | None, Manner | None]:
        manners = [manner for manner, pattern in self._manners.items() if pattern.search(text)]
        if len(manners) != 1:
            return None, None
        bare, _ = self._bare(without(self._manners[manners[0]], text), state.doing)
        return self._templates.match(bare, state.context), manners[0]


def _after(state: State, intent: str, things: Things) -> State:
    """What the next clause may refer to: the last topic, and as "it" the arm or a thing once one was spoken of."""
    topic = TOPICS.get(intent, "")
    arm = "yes" if topic == "arm" else "" if things != state.things else state.context.arm
    light = "yes" if topic == "light" else state.context.light
    return State(Context(topic, arm, light), NOTHING_NAMED if topic == "arm" else things, state.doing)


def _as_asked(skill: Skill, said: Said) -> Calls:
    """The action of a skill that was asked for as its record says."""
    given: dict[str, Argument] = {**said.words}
    units = {parameter.name: parameter.unit for parameter in skill.parameters}
    given |= {name: Quantity(number, units[name]) for name, number in said.numbers.items()}
    return (ActionCall(skill.name, (), given),)
