"""What is made of a request whose meaning a reader has found: a plan, a question, or why there is none.

The meaning says what is wanted; the entities of this house say what its words name; ``doing.py`` turns both into
actions, and only the skill registry makes a plan of them. Words that take something back, forbid, report or ask, and
numbers, have to stand in the meaning: where they don't, the reader has missed something, and nothing is planned."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final, Protocol

from engine.errors import ExitCode
from engine.events import MeaningRead
from engine.plan import ActionCall, Plan
from engine.planner import about_itself, amounts
from engine.planner.accounted import accounted
from engine.planner.conversation import Conversation
from engine.planner.doing.acts import calls_of
from engine.planner.doing.conditions import of_itself, sought, with_antecedent
from engine.planner.doing.doing import MOST, Doing, NowhereKnown, Open, Unable, Which
from engine.planner.doing.looking import topic_of
from engine.planner.entities import Entities
from engine.planner.phrases.again import planned_last
from engine.planner.phrases.phrases import PhrasePlanner, UnknownPlace
from engine.planner.phrases.said import Calls
from engine.planner.readings.first_look import IF_POLITE
from engine.planner.request import Language, NoPlan, PlanRequest
from engine.planner.sentences import SAID
from engine.planner.unknown_places import unknown
from engine.planner.validation import Validation
from engine.skills.vocabulary import Vocabulary
from engine.understanding.meaning import About, Do, If, Meaning, Node, Not, Repeat, Retract, Role

SURE: Final = 0.4
"""How sure the reader has to be, 0 to 1, for something to move."""
MAYBE: Final = 0.25
"""How sure it has to be for a plan that moves nothing, and for the question whether something that moves is meant."""
NO_ORDER: Final = 0.6
"""How sure it has to be that something is no order, for another reader's plan to be held back."""
DOUBT: Final = 0.15
"""How much it may doubt that a request is an order for something of it to be done."""

_ASKED: Final = frozenset({"condition", "every", "until", "times", "role"})
"""What is asked about rather than turned down."""
_UNITS: Final = ("m", "deg", "s", "m/s")
_MOVING: Final = frozenset({"base"})
"""What a skill occupies that is asked about first: a wave of the arm harms nobody."""
_SOMEBODY: Final = re.compile(r"him|her|them|they|he|she|someone|somebody|他们?|她们?|谁|有人")
_NO_ORDERS: Final = frozenset({"talk", "fact"})
_OF_THE_SESSION: Final = frozenset({"answer", "yes", "no", "fragment", "again", "undo", "resume", "other"})
"""Acts that others than this reader answer: those of the conversation, and what no skill serves."""


class Reads(Protocol):
    """Finds the meaning of a request."""

    def readings(self, text: str) -> tuple[Meaning, ...]:
        """What the text may mean, the likeliest first."""
        ...


class Understood:
    """Plans from meanings, for one house."""

    def __init__(
        self,
        reader: Reads,
        phrases: Callable[[Language], PhrasePlanner],
        validation: Validation,
        vocabulary: Vocabulary,
    ) -> None:
        self._phrases = phrases
        self._validation = validation
        self._entities = Entities(vocabulary)
        self._names = frozenset(map(str.casefold, (*vocabulary.names(), *vocabulary.places())))
        self._reader = reader
        self._read = lru_cache(maxsize=64)(reader.readings)
        self._conversation = Conversation(self.meaning, lambda meaning: accounted(meaning, self._names), self._entities)

    def meaning(self, text: str) -> Meaning | None:
        """The likeliest meaning of ``text``."""
        return next(iter(self._meanings(text)), None)

    def agrees(self, text: str) -> bool:
        """Whether that is a yes, and nothing else."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= SURE and meaning.nodes == (Do("yes"),)

    def _meanings(self, text: str) -> tuple[Meaning, ...]:
        plain = IF_POLITE.sub(lambda found: " " * len(found[0]), text)
        if not plain.strip():
            return ()
        meanings = self._read(plain) or self._reader.readings(plain)  # what it reads with may have come since
        return meanings if plain == text else tuple(replace(meaning, text=text) for meaning in meanings)

    def no_order(self, request: PlanRequest, text: str, language: Language) -> NoPlan | None:
        """That nothing in ``text`` is an order, where the reader is sure of that; else None."""
        meanings = self._meanings(text)
        if not meanings:
            return None
        if meanings[0].doubt >= NO_ORDER:
            return NoPlan(text, "no_order", SAID[language]["no_order_doubt"], ExitCode.CLARIFY)
        held_back = [one for one in meanings if _is_no_order(one)]
        if sum(one.confidence for one in held_back) < NO_ORDER:
            return None
        meaning = held_back[0]
        request.read(_told(meaning))
        told = "forbidden" if meaning.has(Not) or meaning.has(Retract) else "told"
        return NoPlan(text, "no_order", SAID[language][f"no_order_{told}"], ExitCode.CLARIFY)

    def plan(self, request: PlanRequest, text: str, language: Language, named: str = "") -> Plan | NoPlan | None:
        """The plan of a request; None where this reader hands it on. ``named`` is the thing that was named last."""
        chosen = self._chosen(request, text, language, named)
        if chosen is None:
            return None
        meaning, found = chosen
        request.read(_told(meaning))
        if isinstance(found, NoPlan) or meaning.confidence >= SURE:
            return found
        if not found.finished:
            return None  # there is another reader of conditions
        if any(meaning.has(kind) for kind in (Not, Retract, About)) or self._moves(found):
            steps = SAID[language]["then"].join(step.rstrip(".。") for step in found.steps)
            question = SAID[language]["unsure"].format(steps=steps)
            return NoPlan(text, "unsure", question, ExitCode.CLARIFY, offer=self._validation.calls(found))
        return found

    def _chosen(
        self, request: PlanRequest, text: str, language: Language, named: str
    ) -> tuple[Meaning, Plan | NoPlan] | None:
        """The likeliest outcome, and the likeliest meaning that has it; None where it is likelier that others have the
        answer. Meanings that come to the same plan are as likely together as the sum of them."""
        answered = self._conversation.completed(request, text)
        outcomes: dict[object, tuple[Meaning, Plan | NoPlan]] = {}
        elsewhere = 0.0
        for meaning in (answered,) if answered is not None else self._meanings(text):
            if meaning is not answered and not accounted(meaning, self._names):
                continue  # words of the request have no place in it
            found = self._outcome(meaning, request, text, language, named)
            if found is None:
                elsewhere += meaning.confidence
                continue
            key = self._same(meaning, found, request, text, language)
            if key in outcomes:
                first, found = outcomes[key]
                meaning = replace(first, confidence=min(1.0, first.confidence + meaning.confidence))
            outcomes[key] = meaning, found
        chosen = max(outcomes.values(), key=lambda outcome: outcome[0].confidence, default=None)
        return chosen if chosen is not None and chosen[0].confidence >= max(MAYBE, elsewhere) else None

    def _same(
        self, meaning: Meaning, found: Plan | NoPlan, request: PlanRequest, text: str, language: Language
    ) -> object:
        """What two meanings have in common that come to the same."""
        branches: list[Plan | NoPlan | None] = [found]
        if isinstance(found, Plan) and not found.finished:
            branches += [self._after(meaning, request, text, language, holds) for holds in (True, False)]
        return tuple(
            (one.response, *map(str, one.actions)) if isinstance(one, Plan) else one and one.answer for one in branches
        )

    def _outcome(
        self, meaning: Meaning, request: PlanRequest, text: str, language: Language, named: str
    ) -> Plan | NoPlan | None:
        """What comes of one meaning; None where it is for others: small talk, answers, what no skill serves."""
        wanted = tuple(node for node in meaning.wanted() if _is_order(node))
        wanted = tuple(node for node in wanted if not _is_answer(node)) or wanted
        if not wanted:
            return None
        if len(wanted) == 1 and isinstance(act := wanted[0], Do):
            if act.act == "again" and (last := planned_last(request.happened)):
                count = amounts.times(act.words("times")) or 1
                return self._planned(text, last * min(count, MOST), language)
            if act.act in _OF_THE_SESSION:
                return None
            if act.act == "report":
                return self._reported(act, request, text, language)
        if meaning.doubt > DOUBT and not meaning.has(Retract) and not meaning.has(Not):
            return NoPlan(text, "no_order", SAID[language]["no_order_doubt"], ExitCode.CLARIFY)
        return self.of(wanted, request, text, language, named)

    def _moves(self, plan: Plan) -> bool:
        return any(self._validation.occupied(action.name) & _MOVING for action in plan.actions)

    def _reported(self, act: Do, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What the robot tells about itself: from what is on record, or with a skill."""
        kind = topic_of(f"{act.words('topic')} {text}")
        if kind in ("report_pose", "seewhat", "list_skills"):
            return self._planned(text, (ActionCall(kind),), language)
        answer = about_itself.of(kind, request.on_record, request.holding, language)
        return Plan(text, (), answer or SAID[language]["asked"], "reader")

    def of(
        self,
        acts: Sequence[Do | If | Repeat],
        request: PlanRequest,
        text: str,
        language: Language,
        named: str = "",
        place: str = "",
    ) -> Plan | NoPlan | None:
        """The plan of what is wanted; ``named`` is the thing that "it" is at first, ``place`` the symbol of "there"."""
        doing = Doing(self._entities, request.holding, named, place, greeting=SAID[language]["hello"])
        acts = tuple(self._completed(node) if isinstance(node, Do) else node for node in acts)
        phrases = self._phrases(language)
        try:
            index = next((index for index, node in enumerate(acts) if isinstance(node, If)), None)
            if index is not None:
                first = calls_of(acts[:index], doing)
                node = acts[index]
                assert isinstance(node, If)
                condition = with_antecedent(node, self._entities)
                if (holds := of_itself(doing, condition)) is not None:  # there is nothing to look at
                    branch = _only_wanted(node.then if holds else node.otherwise)
                    rest = (*acts[:index], *branch, *acts[index + 1 :])
                    nothing = Plan(text, (), SAID[language]["all_right"], "reader")
                    return self.of(rest, request, text, language, named) if rest else nothing
                found = self._planned(text, (*first, *sought(doing, condition).look), language)
                return replace(found, finished=False) if isinstance(found, Plan) else found
            calls = calls_of(acts, doing)
            if not calls:
                return None
            return self._validation.one_of(self._planned(text, calls, language), request, language)
        except Open as gap:
            return NoPlan(text, "incomplete", phrases.question(gap.question), ExitCode.CLARIFY)
        except Which as several:
            return NoPlan(text, "ambiguous", str(several), ExitCode.CLARIFY)
        except NowhereKnown as place:
            return unknown(text, UnknownPlace(place.words, phrases.places), language)
        except Unable as why:
            asks = why.what == "person" and _SOMEBODY.fullmatch(why.words.casefold())
            code = ExitCode.CLARIFY if asks or why.what in _ASKED else ExitCode.FAILED
            key = f"unable_{why.what}"
            return NoPlan(text, key, SAID[language][key].format(words=why.words), code)

    def decided(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What a condition decides after a look; None where there is no such condition."""
        if request.sees is None:
            return None
        chosen = self._chosen(request, text, language, "")
        return None if chosen is None else self._after(chosen[0], request, text, language, request.sees)

    def _after(
        self, meaning: Meaning, request: PlanRequest, text: str, language: Language, sees: Callable[[str], bool] | bool
    ) -> Plan | NoPlan | None:
        """What is to be done after the look of a condition; ``sees`` says what was seen, or whether it holds."""
        wanted = meaning.wanted()
        index = next((at for at, node in enumerate(wanted) if isinstance(node, If)), None)
        if index is None:
            return None
        node = wanted[index]
        assert isinstance(node, If)
        try:
            doing = Doing(self._entities, request.holding)
            looked_for = sought(doing, with_antecedent(node, self._entities))
        except (Open, Which, NowhereKnown, Unable):
            return None
        thing, holds = looked_for.thing, sees if isinstance(sees, bool) else looked_for.holds(sees)
        branch = node.then if holds else node.otherwise
        rest = (*_only_wanted(branch), *wanted[index + 1 :])
        if not rest:
            tells = ("present", "absent") if looked_for.count is None else ("so_many", "not_so_many")
            told = SAID[language][tells[holds != looked_for.there]].format(thing=thing)
            return Plan(text, (), told, "reader")
        found = self.of(rest, request, text, language, thing, doing.place)
        return found if found is not None else Plan(text, (), SAID[language]["all_right"], "reader")

    def _completed(self, act: Do) -> Do:
        """The act with what a correction leaves to what it corrects: a unit ("no, two"), a kind ("the blue one")."""
        return replace(act, roles=tuple(self._completed_role(role) for role in act.roles))

    def _completed_role(self, role: Role) -> Role:
        if not role.instead_of:
            return role
        if role.name == "thing":
            old = self._entities.near(role.instead_of)
            if (alike := self._entities.like(role.words, self._entities.of(role.instead_of).thing or old)) is not None:
                return replace(role, words=alike)
        if role.name in ("amount", "time") and (number := amounts.number(role.words)) is not None:
            unit = next((unit for unit in _UNITS if amounts.quantity(role.instead_of, unit) is not None), "")
            return replace(role, words=f"{number:g} {unit}")
        return role

    def _planned(self, text: str, calls: Calls, language: Language) -> Plan | NoPlan:
        told = self._phrases(language).told(calls)
        found = self._validation.of(text, calls, told.steps, told.response)
        return replace(found, source="reader") if isinstance(found, Plan) else found


def _told(meaning: Meaning) -> MeaningRead:
    told = meaning.describe()
    return MeaningRead(meaning.text, meaning.reader, told["confidence"], tuple(told["nodes"]))


def _is_no_order(meaning: Meaning) -> bool:
    """Nothing in it is to be done; small talk, which has answers of its own, apart."""
    talk = all(isinstance(node, Do) and node.act != "fact" for node in meaning.nodes)
    return not talk and not any(_is_order(node) for node in meaning.wanted())


def _is_order(node: Node) -> bool:
    return not (isinstance(node, Do) and node.act in _NO_ORDERS)


def _is_answer(node: Node) -> bool:
    """ "Fine, then …": what follows it is the order."""
    return isinstance(node, Do) and node.act in ("yes", "no")


def _only_wanted(nodes: Sequence[Node]) -> tuple[Do | If | Repeat, ...]:
    return tuple(node for node in nodes if isinstance(node, (Do, If, Repeat)))
