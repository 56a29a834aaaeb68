"""The phrase planner: plain commands become plans in less than a millisecond, without a language model.

A sentence is turned into words and measures, cut into clauses, and each clause must fit a template to its last word.
Whatever does not (a condition, a negation, a word too many) is no match: it is never guessed, and the answer says
which part was not understood. Sentences that only miss something ("go forward") get the question for it, and
journeys to places that the map does not have are told apart, because the answer to them is another.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from config.schema import Place
from engine.plan import ActionCall
from engine.planner.answers import Answers
from engine.planner.clauses import MAX_SEGMENTS, Segment, interpret, split
from engine.planner.errands import NEEDED
from engine.planner.language import load
from engine.planner.meanings import Calls
from engine.planner.numbers import read_measures
from engine.planner.reader import Clause, ClauseReader, State
from engine.planner.stopping import MAX_TEXT, is_end_task, is_only_stop, is_stop
from engine.planner.templates import Templates, spoken
from engine.planner.words import Sentence, Token, words_of
from engine.skills.places import Places
from engine.skills.vocabulary import Vocabulary

__all__ = ["Matched", "NoMatch", "PhrasePlanner", "UnknownPlace", "is_end_task", "is_stop"]

_REPEATED = re.compile(r"\b([^\W\d]+)(?:,? \1\b)+", re.IGNORECASE)
"""A word (never a number) said several times in a row."""

MAX_SHOWN = 80
"""Longest part of a sentence that an answer quotes, characters."""


@dataclass(frozen=True, slots=True)
class Matched:
    """Understood. ``stop`` and ``end_task`` concern the session; their calls are for whoever shows plans."""

    kind: Literal["plan", "stop", "end_task"]
    calls: tuple[ActionCall, ...]
    steps: tuple[str, ...]  # one sentence for each call
    response: str  # what the robot answers; may be empty


@dataclass(frozen=True, slots=True)
class UnknownPlace:
    """A journey to a place that the map does not have; all else in the sentence was understood."""

    name: str
    known: tuple[str, ...]  # names of the places on the map


@dataclass(frozen=True, slots=True)
class NoMatch:
    """Not understood, and nothing of it may be done."""

    leftover: str  # the part that was not understood, as said
    understood: str  # a sentence with examples of what can be said
    question: str = ""  # what is missing, where only that is wrong ("How far? …")


class PhrasePlanner:
    """Plans for one language and one house, and stops in every language. Thread-safe; loads in about 0.3 s, mostly the
    template library.

    ``vocabulary`` has the words of the house beyond the places. Phrases for other skills than ``skills`` are left out.
    """

    def __init__(
        self,
        places: Mapping[str, Place],
        language: str = "en",
        *,
        vocabulary: Vocabulary | None = None,
        skills: Collection[str] | None = None,
    ) -> None:
        sections = load(language)
        vocabulary = vocabulary or Vocabulary(Places(places))
        missing = [] if skills is None else [intent for intent, needed in NEEDED.items() if not needed <= set(skills)]
        self._known = tuple(place.name for place in places.values())
        self._answers = Answers(sections, places)
        self._joints = sorted((tuple(joint.split()) for joint in sections["joints"]), key=len, reverse=True)
        is_stop("")  # its words are compiled at their first use: now, not in the first command
        self._names = _names_to_keep((*_words_of_places(places), *vocabulary.names()), self._joints)
        self._reader = ClauseReader(sections, Templates(sections, places, vocabulary, missing))

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        return self._answers.understood

    def plan(self, text: str) -> Matched | UnknownPlace | NoMatch:
        """What ``text`` asks for. Never raises, whatever the text, and is bounded in time.

        People stammer and recognisers repeat a first word ("go go forward"), so a sentence without a match gets a
        second chance without its repeated words.
        """
        if len(text) > MAX_TEXT:
            return self._no_match(text)
        match = self._plan(text)
        if isinstance(match, NoMatch) and (fluent := _REPEATED.sub(r"\1", text)) != text:
            again = self._plan(fluent)
            return match if isinstance(again, NoMatch) else again
        return match

    def _plan(self, text: str) -> Matched | UnknownPlace | NoMatch:
        if is_stop(text):
            key = "stop" if is_only_stop(text) else "stop_rest"
            return self._matched("stop", (ActionCall("stop"),), self._answers.phrase(key))
        if is_end_task(text):
            return self._matched("end_task", (ActionCall("finish_dialogue"),), self._answers.phrase("end_task"))
        sentence = words_of(text)
        segments = tuple(
            segment
            for segment in split(read_measures(sentence.tokens), self._joints, self._names)
            if not self._reader.is_filler(segment.words)
        )
        if not 0 < len(segments) <= MAX_SEGMENTS:
            return self._no_match(text)
        clauses = self._interpret(sentence, segments)
        if isinstance(clauses, Segment):
            return self._no_match(sentence.part(clauses.words))
        return self._judge(text, sentence, clauses)

    def _interpret(self, sentence: Sentence, segments: Sequence[Segment]) -> tuple[Clause, ...] | Segment:
        """Read the clauses as commands; only when that fails, admit what is incomplete or leads to unknown places."""
        for lenient in (False, True):

            def read(words: tuple[Token, ...], single: bool, state: State) -> tuple[Clause, State] | None:
                return self._reader.read(sentence, words, single, lenient, state)  # noqa: B023 - used at once

            outcome: tuple[Clause, ...] | Segment = interpret(segments, read, State())
            if not isinstance(outcome, Segment):
                break
        return outcome

    def _judge(self, text: str, sentence: Sentence, clauses: Sequence[Clause]) -> Matched | UnknownPlace | NoMatch:
        """One result for all clauses: any that cannot be done decides."""
        for clause in clauses:
            if clause.unknown:
                return UnknownPlace(clause.unknown, self._known)
            if clause.question:
                return self._no_match(sentence.part(clause.words), self._answers.question(clause.question))
        calls = tuple(call for clause in clauses for call in clause.calls)
        if not calls:  # "and stop", without anything before it
            return self._matched("stop", (ActionCall("stop"),), self._answers.phrase("stop"))
        calls = (replace(calls[0], alongside=False), *calls[1:])  # there is nothing before it
        if any(call.name == "finish_dialogue" for call in calls[:-1]):
            return self._no_match(text)
        return self._matched("plan", calls, self._answers.response(calls))

    def _matched(self, kind: Literal["plan", "stop", "end_task"], calls: Calls, response: str) -> Matched:
        return Matched(kind, calls, self._answers.steps(calls), response)

    def _no_match(self, leftover: str, question: str = "") -> NoMatch:
        # what is quoted back goes to terminals: no control characters
        leftover = " ".join("".join(c if c.isprintable() else " " for c in leftover[: 2 * MAX_SHOWN]).split())
        shown = leftover if len(leftover) <= MAX_SHOWN else f"{leftover[:MAX_SHOWN].rstrip()}…"
        return NoMatch(shown, self._answers.understood, question)


def _words_of_places(places: Mapping[str, Place]) -> Iterable[str]:
    return (name for place in places.values() for name in (place.name, *place.aliases))


def _names_to_keep(names: Iterable[str], joints: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Names of places and things that would be cut in two."""
    cut = (name for name in dict.fromkeys(names) if len(split(read_measures(words_of(name).tokens), joints)) > 1)
    return [tuple(spoken(name).split()) for name in cut]
