"""Which of the meanings that a reader finds is taken, and how sure one has to be of it.

Meanings that come to the same plan are as likely together as the sum of them. Words that take something back, forbid,
report or ask, and numbers, have to stand in the meaning: where they don't, the reader has missed something, and nothing
is planned of it without a question. Nor is anything of an act that is said in words which the reader has never seen."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final, Protocol

from config.nearest import nearest
from engine.errors import ExitCode
from engine.events import MeaningRead
from engine.plan import Action, Plan
from engine.planner.accounted import (
    accounted,
    is_cut_off,
    is_said,
    sides_stand,
    without_an_empty_branch,
    without_an_unsaid_act,
)
from engine.planner.conversation import Conversation
from engine.planner.doing.sense import in_its_sense, with_exclusions, with_listed_acts, with_quantifiers, with_sources
from engine.planner.entities import Entities
from engine.planner.happened import last_question
from engine.planner.not_an_order import marks
from engine.planner.outcomes import Outcomes, is_no_order
from engine.planner.phrases.follow_ups import follow_up
from engine.planner.phrases.phrases import Phrases, Told
from engine.planner.request import Heard, Language, NoPlan
from engine.planner.sentences import SAID
from engine.planner.text.conditions import without_empty_branches
from engine.planner.text.shortened import written_in_full
from engine.planner.validation import Validation
from engine.skills.vocabulary import Vocabulary
from engine.understanding.learned import UNDIRECTED
from engine.understanding.lexicon import lexicon, words_in
from engine.understanding.meaning import About, Do, Meaning, Not, Retract

SURE: Final = 0.4
"""How sure the reader has to be, 0 to 1, for something to move."""
AGREES: Final = 0.9
"""How sure a yes has to be that sets the robot going: "hmm" is none."""
MAYBE: Final = 0.25
"""How sure it has to be for a plan that moves nothing, and for the question whether something that moves is meant."""
LIKELY: Final = 0.5
"""How sure it has to be of what nobody has asked the robot yet: of who pauses, or goes on."""
CERTAIN: Final = 0.97
"""How sure it is where words that only sound like what the robot cannot do are no reason to doubt it."""
NO_ORDER: Final = 0.6
"""How sure it has to be that something is no order, for nothing of it to be done."""
LONG_ENOUGH: Final = 4
"""Letters of a word that may be one that is misspelt."""
NEAR: Final = 0.8
"""How alike the two are then, 0 to 1, as ``difflib`` counts it."""
_MOVING: Final = frozenset({"base"})
"""What a skill occupies that is asked about first: a wave of the arm harms nobody."""
_NO: Final = re.compile(
    r"\s*(?:no|nope|nah|不对?|不是)\s*[,，.。!！]\s*(?=(?:\w+[ ']){2}|[\u3400-\u9fff]{3})", re.IGNORECASE
)
"""A "no" in front of an order."""


class Reads(Protocol):
    """Finds the meaning of a request."""

    @property
    def here(self) -> bool:
        """Whether all that it reads with is on this machine."""
        ...

    def readings(self, text: str) -> tuple[Meaning, ...]:
        """What the text may mean, the likeliest first."""
        ...


class Understood:
    """Plans from what a reader reads, for one house. Thread-safe."""

    def __init__(
        self,
        reader: Reads,
        phrases: Callable[[Language], Phrases],
        validation: Validation,
        vocabulary: Vocabulary,
        tell: Callable[[Sequence[Action], Language], Told],
    ) -> None:
        """``tell`` tells actions in a language."""
        entities = Entities(vocabulary)
        self._reader = reader
        self._read = lru_cache(maxsize=64)(reader.readings)
        self._validation = validation
        self._names = frozenset(map(str.casefold, (*vocabulary.names(), *vocabulary.places())))
        self._known = frozenset(word for name in self._names for word in words_in(name))
        self._outcomes = Outcomes(phrases, validation, vocabulary, entities, tell)
        self._conversation = Conversation(self.meaning, lambda meaning: accounted(meaning, self._names), entities)

    @property
    def reads(self) -> bool:
        """Whether it can read."""
        return self._reader.here

    def meaning(self, text: str) -> Meaning | None:
        """The likeliest meaning of ``text``."""
        return next(iter(self._meanings(written_in_full(text))), None)

    def is_sure(self, text: str, enough: float) -> bool:
        """Whether the likeliest meaning is at least as likely as that."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= enough

    def overhears(self, heard: Heard) -> bool:
        """Whether it is not said to the robot: talk between others, or words in no order. What is typed always is."""
        if not heard.request.spoken:
            return False
        meaning = self.meaning(heard.text) or next(iter(self._read(heard.text)), None)
        return meaning is not None and meaning.directed < UNDIRECTED

    def agrees(self, text: str) -> bool:
        """Whether that is a yes, and nothing else."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= AGREES and meaning.nodes == (Do("yes"),)

    def no_order(self, heard: Heard) -> NoPlan | None:
        """That nothing in it is an order, where the reader is sure of that; else None."""
        meanings = self._meanings(heard.text)
        if not meanings:
            return None
        if meanings[0].doubt >= NO_ORDER:
            return _question(heard, "no_order", "no_order_doubt")
        held_back = [one for one in meanings if is_no_order(one)]
        if sum(one.confidence for one in held_back) < NO_ORDER:
            return None
        meaning = held_back[0]
        heard.request.read(_told(meaning))
        forbidden = meaning.has(Not) or meaning.has(Retract)
        return _question(heard, "no_order", "no_order_forbidden" if forbidden else "no_order_told")

    def plan(self, heard: Heard) -> Plan | NoPlan | None:
        """What becomes of a request: a plan, an answer, a question, or why there is none; None where this reader hands
        it on."""
        if is_cut_off(heard.text):
            return _question(heard, "incomplete", "unfinished")
        chosen = self._chosen(heard)
        if chosen is None:
            return self._but_for_some_words(heard) or self._outcomes.meant(heard) or self._spelt_right(heard)
        meaning, found, alike = chosen
        heard.request.read(_told(meaning))
        if isinstance(found, NoPlan) or meaning.confidence >= SURE:
            return found
        if not found.finished:  # what all of them look at first; the look decides how much they differ
            return found if alike >= SURE else None
        if found.actions and any(meaning.has(kind) for kind in (Not, Retract, About)):
            return self._asked_about(found, heard)
        return self._unless_asked(found, heard) if self._moves(found) else found

    def _unless_asked(self, found: Plan, heard: Heard) -> Plan | NoPlan:
        """The question whether that is meant; the plan itself where the answer to that question says the same anew."""
        question, before = self._asked_about(found, heard), last_question(heard.request.happened)
        said_anew = before is not None and before.code == question.code and before.offer == question.offer
        return found if said_anew else question

    def decided(self, heard: Heard) -> Plan | NoPlan | None:
        """What a condition decides after a look; None where there is no such condition."""
        sees = heard.request.sees
        if sees is None or self._chosen(heard) is None:
            return None
        afters = ((meaning, self._outcomes.after(meaning, heard, sees)) for meaning in self._considered(heard)[0])
        found = [(meaning, after) for meaning, after in afters if after is not None]
        likely = dict[object, float]()
        for meaning, after in found:
            likely[_words_of(after)] = likely.get(_words_of(after), 0.0) + meaning.confidence
        best = max(found, key=lambda one: likely[_words_of(one[1])], default=None)
        if best is None or not isinstance(best[1], Plan) or not best[1].finished or not self._moves(best[1]):
            return None if best is None else best[1]
        agreed = likely[_words_of(best[1])] >= SURE * sum(likely.values())
        return best[1] if agreed else self._asked_about(best[1], heard)

    def _meanings(self, text: str) -> tuple[Meaning, ...]:
        text = without_empty_branches(text)
        if (act := follow_up(text)) is not None:
            likeliest = next(iter(self._read(text)), None)
            directed = likeliest.directed if likeliest is not None else 1.0  # in a room, people say "go on" to others
            return (Meaning(text, (Do(act),), "certain", directed=directed),)
        found = self._read(text) or self._reader.readings(text)  # what it reads with may have come since
        answer = _NO.match(text)
        first = found[0].nodes[0] if answer is not None and found and found[0].nodes else None
        refuses = isinstance(first, Not) or (isinstance(first, Do) and first.act == "no")
        if answer is None or not refuses or marks(text):
            return self._believed(map(without_an_empty_branch, found))
        return self._believed(self._read(text[answer.end() :]))  # "no, raise your arm" forbids nothing

    def _believed(self, found: Iterable[Meaning]) -> tuple[Meaning, ...]:
        """Those of these meanings that are said in known words."""
        said = (meaning for meaning in found if is_said(meaning, self._known))
        return tuple(_as_said(meaning) for meaning in said)

    def _chosen(self, heard: Heard) -> tuple[Meaning, Plan | NoPlan, float] | None:
        """The likeliest outcome, the likeliest meaning that has it, and how likely all are that begin with the same;
        None where it is likelier that others have the answer."""
        considered, answers = self._considered(heard)
        outcomes: dict[object, tuple[Meaning, Plan | NoPlan]] = {}
        begin = dict[object, float]()
        elsewhere = 0.0
        for meaning in considered:
            found = self._outcomes.of(meaning, heard)
            if found is None:
                elsewhere += meaning.confidence
                continue
            begin[_words_of(found)] = begin.get(_words_of(found), 0.0) + meaning.confidence
            key = self._same(meaning, found, heard)
            if key in outcomes:
                first, found = outcomes[key]
                meaning = replace(first, confidence=min(1.0, first.confidence + meaning.confidence))
            outcomes[key] = meaning, found
        chosen = max(outcomes.values(), key=lambda outcome: outcome[0].confidence, default=None)
        if chosen is None:
            return None
        meaning, found = chosen
        alike = begin[_words_of(found)]
        looks = isinstance(found, Plan) and not found.finished
        if (alike if looks else meaning.confidence) < max(MAYBE, elsewhere):
            return None
        if answers and last_question(heard.request.happened) is not None:
            heard.request.answers()
        return meaning, found, alike

    def _considered(self, heard: Heard) -> tuple[Sequence[Meaning], bool]:
        """The meanings in which all words of the request have a place, and whether that is an answer, which has only
        one."""
        answered = self._conversation.completed(heard.request, heard.text)
        if answered is not None:
            return (answered,), True
        return [meaning for meaning in self._meanings(heard.text) if accounted(meaning, self._names)], False

    def _same(self, meaning: Meaning, found: Plan | NoPlan, heard: Heard) -> object:
        """What two meanings have in common that come to the same."""
        branches: list[Plan | NoPlan | None] = [found]
        if isinstance(found, Plan) and not found.finished:
            branches += [self._outcomes.after(meaning, heard, holds) for holds in (True, False)]
        return tuple(map(_words_of, branches))

    def _but_for_some_words(self, heard: Heard) -> NoPlan | None:
        """The question whether the likeliest meaning is meant, although words of the request have no place in it."""
        meaning = self.meaning(heard.text)
        if meaning is None or meaning.confidence < SURE or marks(heard.text) or not sides_stand(meaning):
            return None
        found = self._outcomes.of(meaning, heard)
        if isinstance(found, Plan) and found.finished and found.actions:
            heard.request.read(_told(meaning))
            return self._asked_about(found, heard)
        return found if isinstance(found, NoPlan) and found.exit_code is ExitCode.CLARIFY else None

    def _spelt_right(self, heard: Heard) -> NoPlan | None:
        """The question whether an act is meant whose word is misspelt ("beeep"); None where it is none."""
        words = list(words_in(heard.text))
        wrong = [word for word in words if word not in lexicon() and word not in self._known]
        text = heard.text
        for word in wrong if len(wrong) == 1 or 2 * len(wrong) <= len(words) else ():
            if len(word) >= LONG_ENOUGH and word.isascii():
                near = nearest(word, [other for other in lexicon() if other[0] == word[0]], NEAR)
                text = re.sub(rf"\b{re.escape(word)}\b", near or word, text, flags=re.IGNORECASE)
        chosen = self._chosen(replace(heard, text=text)) if text != heard.text else None
        found = chosen[1] if chosen is not None else None
        if not isinstance(found, Plan) or not found.finished or not found.actions:
            return None
        return self._asked_about(found, heard)

    def _asked_about(self, found: Plan, heard: Heard) -> NoPlan:
        """The question whether that is meant; a yes does it."""
        steps = SAID[heard.language]["then"].join(step.rstrip(".。") for step in found.steps)
        question = SAID[heard.language]["unsure"].format(steps=steps)
        return NoPlan(heard.text, "unsure", question, ExitCode.CLARIFY, offer=self._validation.calls(found))

    def _moves(self, plan: Plan) -> bool:
        return any(self._validation.occupied(action.name) & _MOVING for action in plan.actions)


def _as_said(meaning: Meaning) -> Meaning:
    """The meaning as closed classes of words have it, whatever a reader has made of them."""
    for step in (
        without_an_unsaid_act,
        in_its_sense,
        with_exclusions,
        with_listed_acts,
        with_quantifiers,
        with_sources,
    ):
        meaning = step(meaning)
    return meaning


def _words_of(found: Plan | NoPlan | None) -> object:
    """What two outcomes have in common that are the same."""
    return (found.response, *map(str, found.actions)) if isinstance(found, Plan) else found and found.answer


def _question(heard: Heard, code: str, key: str) -> NoPlan:
    return NoPlan(heard.text, code, SAID[heard.language][key], ExitCode.CLARIFY)


def _told(meaning: Meaning) -> MeaningRead:
    told = meaning.describe()
    return MeaningRead(meaning.text, meaning.reader, told["confidence"], tuple(told["nodes"]))
