"""The phrase planner: plain commands become plans in less than a millisecond, without a language model.

A sentence is turned into words and measures, cut into clauses, and each clause must fit a template to its last word.
Whatever does not (a condition, a negation, a word too many) is no match: it is never guessed, and the answer says
which part was not understood. Sentences that only miss something ("go forward") get the question for it, and
journeys to places that the map does not have are told apart, because the answer to them is another.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise, zip_longest
from typing import Literal

from config.schema import Place
from engine.han import HAN
from engine.plan import ActionCall
from engine.planner.phrases.again import referred
from engine.planner.phrases.answers import Answers
from engine.planner.phrases.clauses import MAX_SEGMENTS, Phrase, Segment, interpret, split, without_frame
from engine.planner.phrases.errands import NEEDED
from engine.planner.phrases.reader import Clause, ClauseReader, State
from engine.planner.phrases.said import Calls, Question, Things
from engine.planner.phrases.small_talk import SmallTalk
from engine.planner.phrases.stopping import MAX_TEXT, is_end_task, is_only_stop, is_stop
from engine.planner.phrases.templates import Context, Templates, spoken
from engine.planner.text.language import alternatives, any_of, load
from engine.planner.text.measures import read_measures
from engine.planner.text.numbers_zh import NUMERALS
from engine.planner.text.words import Sentence, Token, words_of
from engine.skills.library import LIBRARY
from engine.skills.places import Places
from engine.skills.registry import Skill
from engine.skills.vocabulary import Vocabulary

__all__ = ["Matched", "NoMatch", "PhrasePlanner", "UnknownPlace", "is_end_task", "is_stop"]

_REPEATED = re.compile(
    rf"\b([^\W\d]+)(?:,? \1\b)+|(?P<han>(?:(?![{NUMERALS}]){HAN}){{1,4}}?)(?:[，、 ]?(?P=han))+", re.IGNORECASE
)
"""A word (never a number) said several times in a row."""
_HUMMED = re.compile(r"\b(?:uh+m*|um+|er+m?|hm+)\b[,.… ]*", re.IGNORECASE)

_OF_THINGS = frozenset({"pick_object", "carry", "locate", "navigate_to_object"})
"""Actions whose first argument is a thing."""

_PUTS = frozenset({"place_object", "place_in_bin", "carry"})
_LAST = {**dict.fromkeys((*_PUTS, "putdown"), "placed"), "navigation": "go", "scan_room": "look", "clean_room": "clean"}
"""What the context is called after an action of the plan before."""

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
class Told:
    """What a plan is told as."""

    steps: tuple[str, ...]  # one sentence for each action
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


@dataclass(frozen=True, slots=True)
class Before:
    """What a sentence may refer to: the actions that were planned last, and what the gripper holds."""

    calls: Calls = ()
    holding: str = ""
    seen: str = ""  # the only thing that was seen last

    @property
    def things(self) -> Things:
        """What "it" may be."""
        about = (
            str(call.positional[0]) for call in reversed(self.calls) if call.name in _OF_THINGS and call.positional
        )
        named = next(about, self.holding or self.seen)
        picked_up = bool(self.calls) and self.calls[-1].name == "pick_object"
        return Things(named, self.holding or (named if picked_up else ""))

    @property
    def context(self) -> Context:
        """What "it" or "down" may be about."""
        name = self.calls[-1].name if self.calls else ""
        arm = name in ("arm_up", "arm_down") and not self.holding
        last = _LAST.get(name, "") if not self.holding or name not in _PUTS else ""
        return Context(last, "yes" if arm else "", "yes" if name == "light" else "")


NOTHING_BEFORE = Before()


class PhrasePlanner:
    """Plans for one language and one house, and stops in every language. Thread-safe; loads in about 0.3 s, mostly the
    template library.

    ``vocabulary`` has the words of the house beyond the places. Phrases for other skills than ``skills`` are left out;
    None: those of the library, and phrases for all.
    """

    def __init__(
        self,
        places: Mapping[str, Place],
        language: str = "en",
        *,
        vocabulary: Vocabulary | None = None,
        skills: Iterable[Skill] | None = None,
    ) -> None:
        sections = load(language)
        vocabulary = vocabulary or Vocabulary(Places(places))
        offered = {skill.name: skill for skill in (LIBRARY if skills is None else skills)}
        missing = [intent for intent, needed in NEEDED.items() if skills is not None and not needed <= offered.keys()]
        self._answers = Answers(sections, places, vocabulary, offered)
        self._known = self._answers.places
        self._joints = _phrases(sections["joints"])
        self._openings = _phrases(sections["openings"])
        self._run_on = _phrases(sections["run_on"])
        self._not_last = _phrases(sections["not_last"])
        self._frames = [(tuple(first.split()), tuple(last.split())) for first, last in sections["frames"]]
        is_stop("")  # its words are compiled at their first use: now, not in the first command
        self._names = [
            *_phrases(sections["no_joints"]),
            *_names_to_keep((*_words_of_places(places), *vocabulary.names()), self._joints),
        ]
        self._templates = Templates(sections, places, vocabulary, offered.values(), missing)
        self._reader = ClauseReader(sections, self._templates, offered.values())
        self._talk = SmallTalk(sections, self._templates)
        nouns = (noun for words in (sections["things"]["one"], sections["things"]["many"]) for noun in words)
        house = {*_words_of_places(places), *vocabulary.names(), *vocabulary.inventory(), *nouns}
        self._about_house = re.compile(
            any_of(spoken(name) for name in house) if language == "en" else alternatives(house)
        )

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        return self._answers.understood

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places on the map."""
        return self._known

    def question(self, missing: Question) -> str:
        """The question for what a command lacks."""
        return self._answers.question(missing)

    def told(self, calls: Sequence[ActionCall]) -> Told:
        """How actions that somebody else thought of are told; those without words for them, by their names."""
        try:
            return Told(self._answers.steps(calls), self._answers.response(calls))
        except (KeyError, IndexError, ValueError):
            return Told(tuple(call.name for call in calls), "")

    def warm_up(self) -> None:
        """Have the templates compiled that the usual commands meet; without it the first ones take some ms longer."""
        self._templates.warm_up()

    def plan(
        self, text: str, before: Before = NOTHING_BEFORE, *, run_on: bool = True
    ) -> Matched | UnknownPlace | NoMatch:
        """What ``text`` asks for, after the actions ``before``; ``run_on``: with or without joints between clauses.
        Never raises, whatever the text; bounded in time.

        People stammer and recognisers repeat a first word ("go go forward"), so a sentence without a match gets a
        second chance without its repeated words.
        """
        if len(text) > MAX_TEXT:
            return self._no_match(text)
        match = self._plan(text, before, run_on)
        if isinstance(match, NoMatch) and (fluent := _fluent(text)) != text:
            again = self._plan(fluent, before, run_on)
            return match if isinstance(again, NoMatch) and not again.question else again
        return match

    def talk(self, text: str) -> str:
        """The answer to small talk; empty where ``text`` is more than that."""
        return self._talk.answer(text) if len(text) <= MAX_TEXT else ""

    def aside(self, text: str) -> str:
        """The answer to what is about the robot or its speaker, and holds nothing of this house; else empty."""
        return self._talk.aside(text, self._about_house) if len(text) <= MAX_TEXT else ""

    def clauses(self, text: str) -> tuple[tuple[str, Matched | None], ...]:
        """The clauses of ``text``, with what those mean that are commands by themselves."""
        sentence = words_of(text)
        segments = split(read_measures(sentence.tokens), self._joints, self._names, self._openings)
        parts = (sentence.part(segment.words) for segment in segments if not self._reader.is_filler(segment.words))
        matches = ((part, self._plan(part, NOTHING_BEFORE, run_on=False)) for part in islice(parts, MAX_SEGMENTS))
        return tuple(
            (part, match if isinstance(match, Matched) and match.kind == "plan" else None) for part, match in matches
        )

    def _plan(self, text: str, before: Before, run_on: bool) -> Matched | UnknownPlace | NoMatch:
        if is_stop(text):
            key = "stop" if is_only_stop(text) else "stop_rest"
            return self._matched("stop", (ActionCall("stop"),), self._answers.phrase(key))
        if is_end_task(text):
            return self._matched("end_task", (ActionCall("finish_dialogue"),), self._answers.phrase("end_task"))
        sentence = words_of(text)
        tokens = read_measures(sentence.tokens)
        match = self._read(sentence, tokens, before)
        if run_on and isinstance(match, NoMatch) and not match.question and self._run_on:
            without_joints = self._read(sentence, tokens, before, self._run_on)
            match = without_joints if isinstance(without_joints, Matched) else match
        if isinstance(match, NoMatch) and (request := without_frame(tokens, self._frames)) != tokens:
            again = self._read(sentence, request, before)
            return match if isinstance(again, NoMatch) and not again.question else again
        return match

    def _read(
        self, sentence: Sentence, tokens: Sequence[Token], before: Before, run_on: Sequence[Phrase] = ()
    ) -> Matched | UnknownPlace | NoMatch:
        """``run_on``: words before which a clause may begin without a joint."""
        text = sentence.text
        words = tuple(token.text for token in tokens if token.kind != "mark")
        if any(words[-len(end) :] == end for end in self._not_last):
            return self._no_match(text)
        segments = tuple(
            segment
            for segment in split(tokens, self._joints, self._names, (*self._openings, *run_on))
            if not self._reader.is_filler(segment.words)
        )
        if not 0 < len(segments) <= MAX_SEGMENTS:
            return self._no_match(text)
        clauses = self._interpret(sentence, segments, State(before.context, before.things))
        if isinstance(clauses, Segment):
            return self._no_match(sentence.part(clauses.words))
        return self._judge(text, sentence, clauses, before)

    def _interpret(
        self, sentence: Sentence, segments: Sequence[Segment], before: State
    ) -> tuple[Clause, ...] | Segment:
        """Read the clauses as commands; only when that fails, admit what is incomplete or leads to unknown places."""
        for lenient in (False, True):

            def read(words: tuple[Token, ...], single: bool, state: State) -> tuple[Clause, State] | None:
                return self._reader.read(sentence, words, single, lenient, state)  # noqa: B023 - used at once

            outcome: tuple[Clause, ...] | Segment = interpret(segments, read, before)
            if not isinstance(outcome, Segment):
                break
        return outcome

    def _judge(
        self, text: str, sentence: Sentence, clauses: Sequence[Clause], before: Before
    ) -> Matched | UnknownPlace | NoMatch:
        """One result for all clauses: any that cannot be done decides."""
        for clause in clauses:
            if clause.unknown:
                return UnknownPlace(clause.unknown, self._known)
            if clause.question:
                return self._no_match(sentence.part(clause.words), self._answers.question(clause.question))
        done = [one for one, after in zip_longest(clauses, clauses[1:]) if after is None or not after.instead]
        calls = referred(tuple(call for clause in done for call in clause.calls), before.calls)
        if calls is None:  # there is nothing that it could refer to
            return self._no_match(text)
        calls = _without_repeated_errands(calls)
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


def _without_repeated_errands(calls: Calls) -> Calls:
    """ "Take both cups to the study, the white one and the blue one": what is there is not carried there again. "Look
    at it and say what is on it": one look tells."""
    kept = [call for at, call in enumerate(calls) if call.name != "carry" or call not in calls[:at]]
    kept = [call for call, after in zip_longest(kept, kept[1:]) if not _goes_further(call, after)]
    looked = (one.name in ("seewhat", "scan_room") and two.name == "seewhat" for one, two in pairwise(kept))
    return (*kept[:1], *(call for call, again in zip(kept[1:], looked, strict=True) if not again))


def _goes_further(call: ActionCall, after: ActionCall | None) -> bool:
    """ "Take the ball to the bedroom, put it on the bed": it is not put on the floor there first."""
    return (
        after is not None
        and (call.name, after.name) == ("carry", "pick_object")
        and call.positional[:1] == after.positional[:1]
    )


def _fluent(text: str) -> str:
    """``text`` without its repeated words, also those between which somebody hums."""
    return _REPEATED.sub(lambda found: found[1] or found["han"], _HUMMED.sub("", text))


def _phrases(phrases: Iterable[str]) -> list[tuple[str, ...]]:
    """The words of each, the longest first."""
    return sorted((tuple(phrase.split()) for phrase in phrases), key=len, reverse=True)


def _words_of_places(places: Mapping[str, Place]) -> Iterable[str]:
    return (name for place in places.values() for name in (place.name, *place.aliases))


def _names_to_keep(names: Iterable[str], joints: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Names of places and things that would be cut in two."""
    cut = (name for name in dict.fromkeys(names) if len(split(read_measures(words_of(name).tokens), joints)) > 1)
    return [tuple(spoken(name).split()) for name in cut]
