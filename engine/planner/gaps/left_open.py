"""What a request leaves open in this house: which thing, where to, which way, or what to do at all.

A model fills such gaps with what is likely, so they are looked for in the words before one is asked: in the shape of
the request, and in what the house has several of.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from engine.planner.gaps.chinese import gap_zh
from engine.planner.gaps.english import (
    Gap,
    clauses_of,
    contradiction,
    gap_of_measure,
    gap_of_words,
    goes_nowhere,
    with_verb_first,
)
from engine.planner.gaps.kinds import NOTHING, Kinds, Known, is_wanted
from engine.planner.grounding.statement import Statement
from engine.planner.readings.corrections import QUOTES, bare
from engine.planner.readings.first_look import CONDITION
from engine.planner.request import Language
from engine.planner.text.language import any_of, load, without
from engine.skills.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True)
class Open:
    """What a request leaves open: the gap; or, of several things, their names; or the question itself."""

    gap: Gap | None = None
    names: tuple[str, ...] = ()
    question: str = ""


class LeftOpen:
    """Knows the words of one house. Thread-safe."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        sections = load("en")
        self._kinds = Kinds(vocabulary)
        self._polite = re.compile(any_of((*sections["fillers"], *sections["hesitations"])))
        self._closing = re.compile(rf"{any_of(sections['closing'])}$")

    def of(self, text: str, language: Language, before: Known = NOTHING, *, understood: bool = False) -> Open | None:
        """What ``text`` leaves open after what is known ``before``; None where it is nothing. ``understood``: something
        has been made of it, which may be wrong."""
        plain = bare(text).casefold().replace("’", "'")
        if not plain or QUOTES.search(text):
            return None
        said = Statement(plain)
        if language == "zh":
            gap: Gap | None = (
                None if understood else gap_zh(plain, self._kinds.names_thing(said), alone=before.is_nothing)
            )
        else:
            gap = self._gap(plain, said, alone=before.is_nothing, understood=understood)
        if gap is not None:
            return Open(gap)
        if understood or before.said or CONDITION.search(plain):
            return None
        if language == "en" and (names := self._kinds.either(plain) or self._kinds.one_of_several(plain, before)):
            return Open(names=names)
        question = self._kinds.one_of_furniture(said) if language == "zh" or is_wanted(plain) else ""
        return Open(question=question) if question else None

    def _gap(self, plain: str, said: Statement, *, alone: bool, understood: bool) -> Gap | None:
        clauses = [clause for part in clauses_of(plain) if (clause := self._bare(part))]
        thing, place = self._kinds.names_thing(said), self._kinds.names_place(said)
        if (gap := contradiction(plain)) is not None:
            return gap
        if alone and not place and not thing and goes_nowhere(clauses):
            return "where"
        if understood or (gap := gap_of_measure(plain, clauses, said)) is not None:
            return gap
        return gap_of_words(plain, clauses, thing=thing, place=place) if alone else None

    def _bare(self, clause: str) -> str:
        """A clause without politeness, beginning with its verb where it has one."""
        clause = without(self._closing, without(self._polite, clause.strip(" '\"")))
        return with_verb_first(clause)
