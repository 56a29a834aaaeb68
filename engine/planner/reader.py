"""Reads one clause: tries the templates with and without the words of politeness and speed around them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from engine.planner.freetext import FreeText
from engine.planner.language import any_of, without
from engine.planner.meanings import TOPICS, Calls, Incomplete, Manner, Said, calls_of
from engine.planner.templates import Context, Match, Templates, render
from engine.planner.words import Sentence, Token


@dataclass(frozen=True, slots=True)
class Clause:
    """One clause that was read: actions, or the name of a place that is not known, or a question."""

    words: tuple[Token, ...]
    calls: Calls = ()
    unknown: str = ""
    question: str = ""


class ClauseReader:
    """Reads the clauses of one language for one map."""

    def __init__(self, sections: Mapping[str, Any], templates: Templates) -> None:
        self._templates = templates
        self._free_text = FreeText(sections, templates)
        self._fillers = re.compile(any_of(sections["fillers"]))
        self._together = re.compile(any_of(sections["together"]))
        self._manners: dict[Manner, re.Pattern[str]] = {
            manner: re.compile(any_of(phrases)) for manner, phrases in sections["manners"].items()
        }

    def is_filler(self, words: Sequence[Token]) -> bool:
        """Whether the words are nothing but politeness ("okay", "please")."""
        return not without(self._fillers, render(words)[0])

    def read(
        self, sentence: Sentence, words: tuple[Token, ...], single: bool, lenient: bool, state: Context
    ) -> tuple[Clause, Context] | None:
        """The clause and the state after it, or None.

        ``single``: the words were not joined from several segments. ``lenient`` admits questions and unknown places.
        """
        text, measures = render(words)
        alone = without(self._together, text)
        text, together = alone, alone != text
        bare = without(self._fillers, text)
        manner: Manner | None = None
        match = self._templates.match(bare, state)
        if match is None and bare != text:
            match = self._templates.match(text, state)  # "what can you do" is more than politeness
        if match is None and (speech := self._free_text.speech(sentence, words, single)):
            match, together = Match("Say", {"text": speech}), False  # every word of it is to be said
        if match is None:
            match, manner = self._match_manner(bare, state)
        if match is None and lenient:
            if (match := self._templates.match(bare, state, "incomplete_intents")) is not None:
                return Clause(words, question=match.words["question"]), state
            place = self._free_text.unknown_place(sentence, words, state) if single else ""
            return (Clause(words, unknown=place), _after(state, "Somewhere")) if place else None
        if match is None:
            return None
        numbers = {name: float(n) if name == "whole" else measures[n] for name, n in match.numbers.items()}
        try:
            calls = calls_of(Said(match.intent, match.words, numbers, manner))
        except Incomplete as missing:
            return (Clause(words, question=missing.question), state) if lenient else None
        if calls is None or (together and len(calls) != 1):
            return None
        if together:
            calls = (replace(calls[0], alongside=True),)
        return Clause(words, calls), _after(state, match.intent)

    def _match_manner(self, text: str, state: Context) -> tuple[Match | None, Manner | None]:
        manners = [manner for manner, pattern in self._manners.items() if pattern.search(text)]
        if len(manners) != 1:
            return None, None
        return self._templates.match(without(self._manners[manners[0]], text), state), manners[0]


def _after(state: Context, intent: str) -> Context:
    """What the next clause may refer to: the last topic, and the arm once it was spoken of."""
    topic = TOPICS.get(intent, "")
    return Context(topic, "yes" if topic == "arm" else state.arm)
