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
from engine.plan import Action, ActionCall, Plan
from engine.planner import about_itself, amounts
from engine.planner.accounted import accounted, is_cut_off, sides_stand
from engine.planner.conversation import Conversation
from engine.planner.doing.acts import calls_of
from engine.planner.doing.conditions import of_itself, sought, with_antecedent
from engine.planner.doing.doing import MOST, Doing, NowhereKnown, Open, Unable, Which
from engine.planner.doing.looking import topic_of
from engine.planner.entities import Entities
from engine.planner.happened import last_question, named_last, planned_last
from engine.planner.not_an_order import marks
from engine.planner.phrases.phrases import Phrases, Told
from engine.planner.phrases.said import Calls
from engine.planner.request import Language, NoPlan, PlanRequest
from engine.planner.sentences import SAID
from engine.planner.unknown_places import room_instead, unknown
from engine.planner.validation import Validation
from engine.skills.vocabulary import Vocabulary
from engine.understanding.meaning import About, Do, If, Meaning, Node, Not, Repeat, Retract, Role

SURE: Final = 0.4
"""How sure the reader has to be, 0 to 1, for something to move."""
MAYBE: Final = 0.25
"""How sure it has to be for a plan that moves nothing, and for the question whether something that moves is meant."""
LIKELY: Final = 0.5
CERTAIN: Final = 0.97
"""How sure it is where words that only sound like what the robot cannot do are no reason to doubt it."""
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
_OF_THE_SESSION: Final = frozenset({"answer", "report", "yes", "no", "fragment", "again", "undo", "resume", "other"})
"""Acts of the conversation, and what no skill serves."""


_NO: Final = re.compile(
    r"\s*(?:no|nope|nah|不对?|不是)\s*[,，.。!！]\s*(?=(?:\w+[ ']){2}|[\u3400-\u9fff]{3})", re.IGNORECASE
)


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
    """Plans from meanings, for one house."""

    def __init__(
        self,
        reader: Reads,
        phrases: Callable[[Language], Phrases],
        validation: Validation,
        vocabulary: Vocabulary,
        tell: Callable[[Sequence[Action], Language], Told],
    ) -> None:
        self._phrases = phrases
        self._tell = tell
        self._validation = validation
        self._vocabulary = vocabulary
        self._entities = Entities(vocabulary)
        self._inventory = vocabulary.inventory()
        self._names = frozenset(map(str.casefold, (*vocabulary.names(), *vocabulary.places())))
        self._reader = reader
        self._read = lru_cache(maxsize=64)(reader.readings)
        self._conversation = Conversation(self.meaning, lambda meaning: accounted(meaning, self._names), self._entities)

    @property
    def reads(self) -> bool:
        """Whether it can read."""
        return self._reader.here

    def meaning(self, text: str) -> Meaning | None:
        """The likeliest meaning of ``text``."""
        return next(iter(self._meanings(text)), None)

    def is_likely(self, text: str) -> bool:
        """Whether one meaning is likelier than all others together: who pauses or goes on is not asked."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= LIKELY

    def is_certain(self, text: str) -> bool:
        """Whether nothing else can hardly be meant."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= CERTAIN

    def agrees(self, text: str) -> bool:
        """Whether that is a yes, and nothing else."""
        meaning = self.meaning(text)
        return meaning is not None and meaning.confidence >= SURE and meaning.nodes == (Do("yes"),)

    def _meanings(self, text: str) -> tuple[Meaning, ...]:
        found = self._read(text) or self._reader.readings(text)  # what it reads with may have come since
        answer = _NO.match(text)
        first = found[0].nodes[0] if answer is not None and found and found[0].nodes else None
        refuses = isinstance(first, Not) or (isinstance(first, Do) and first.act == "no")
        if answer is None or not refuses or marks(text):
            return found
        return self._read(text[answer.end() :])  # "no, raise your arm" forbids nothing

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

    def plan(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What becomes of a request: a plan, an answer, a question, or why there is none; None where this reader hands
        it on."""
        if is_cut_off(text):
            return NoPlan(text, "incomplete", SAID[language]["unfinished"], ExitCode.CLARIFY)
        chosen = self._chosen(request, text, language)
        if chosen is None:
            return self._but_for_some_words(request, text, language)
        meaning, found = chosen
        request.read(_told(meaning))
        if isinstance(found, NoPlan) or meaning.confidence >= SURE:
            return found
        if not found.finished:
            return None
        if any(meaning.has(kind) for kind in (Not, Retract, About)) or self._moves(found):
            return self._asked_about(found, text, language)
        return found

    def _but_for_some_words(self, request: PlanRequest, text: str, language: Language) -> NoPlan | None:
        """The question whether the likeliest meaning is meant, although words of the request have no place in it."""
        meaning = self.meaning(text)
        if meaning is None or meaning.confidence < SURE or marks(text) or not sides_stand(meaning):
            return None
        found = self._outcome(meaning, request, text, language)
        if isinstance(found, Plan) and found.finished and found.actions:
            request.read(_told(meaning))
            return self._asked_about(found, text, language)
        return found if isinstance(found, NoPlan) and found.exit_code is ExitCode.CLARIFY else None

    def _asked_about(self, found: Plan, text: str, language: Language) -> NoPlan:
        """The question whether that is meant."""
        steps = SAID[language]["then"].join(step.rstrip(".。") for step in found.steps)
        question = SAID[language]["unsure"].format(steps=steps)
        return NoPlan(text, "unsure", question, ExitCode.CLARIFY, offer=self._validation.calls(found))

    def _chosen(self, request: PlanRequest, text: str, language: Language) -> tuple[Meaning, Plan | NoPlan] | None:
        """The likeliest outcome, and the likeliest meaning that has it; None where it is likelier that others have the
        answer. Meanings that come to the same plan are as likely together as the sum of them."""
        answered = self._conversation.completed(request, text)
        outcomes: dict[object, tuple[Meaning, Plan | NoPlan]] = {}
        elsewhere = 0.0
        for meaning in (answered,) if answered is not None else self._meanings(text):
            if meaning is not answered and not accounted(meaning, self._names):
                continue  # words of the request have no place in it
            found = self._outcome(meaning, request, text, language)
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

    def _outcome(self, meaning: Meaning, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What comes of one meaning; None where it is for others: what no skill serves."""
        wanted = tuple(node for node in meaning.wanted() if _is_order(node))
        wanted = tuple(node for node in wanted if not _is_answer(node)) or wanted
        if not wanted:
            return self._no_act(meaning, request, text, language)
        if len(wanted) == 1 and isinstance(act := wanted[0], Do) and act.act in _OF_THE_SESSION:
            return self._of_the_session(act, request, text, language)
        if meaning.doubt > DOUBT and not meaning.has(Retract) and not meaning.has(Not):
            return NoPlan(text, "no_order", SAID[language]["no_order_doubt"], ExitCode.CLARIFY)
        thing, place = self._told_of(meaning)
        thing = thing or named_last(request.happened, "object") or request.holding or self._only_seen(request.seen)
        return self.of(wanted, request, text, language, thing, place or named_last(request.happened, "place"))

    def _told_of(self, meaning: Meaning) -> tuple[str, str]:
        """The thing and the place of which something is told before the order: "that bottle's empty, bin it"."""
        facts = [node for node in meaning.nodes if isinstance(node, Do) and node.act == "fact"]
        things = [self._entities.of(words).thing for node in facts for words in node.all("thing")]
        places = [self._entities.of(words).place for node in facts for words in node.all("place")]
        return next(filter(None, things), ""), next(filter(None, places), "")

    def _no_act(self, meaning: Meaning, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """The answer to what asks for nothing: small talk, or that what was said before is taken back."""
        if _takes_all_back(meaning):
            return Plan(text, (), SAID[language]["all_right"], "reader")
        if meaning.nodes and all(isinstance(node, Do) and node.act == "talk" for node in meaning.nodes):
            return Plan(text, (), self._phrases(language).talk(text), "reader")
        return None

    def _of_the_session(self, act: Do, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What acts of the conversation come to."""
        match act.act:
            case "again" if last := planned_last(request.happened):
                count = amounts.times(act.words("times")) or 1
                return self._once_more(last * min(count, MOST), text, language)
            case "resume":
                return self._continued(request, text, language)
            case "report":
                return self._reported(act, request, text, language)
            case "answer":
                return Plan(text, (), self._phrases(language).talk(text, asks=True), "reader")
            case "yes" | "no" if last_question(request.happened) is None:
                return Plan(text, (), SAID[language]["all_right"], "reader")
            case "fragment" if not request.happened and (talk := self._phrases(language).only_talk(text)):
                return Plan(text, (), talk, "reader")
            case "fragment" if act.words("place") and len(act.roles) == 1:
                return self.of((replace(act, act="go"),), request, text, language)
            case "fragment" | "again" | "undo":
                return NoPlan(text, "incomplete", self._phrases(language).question("what_do"), ExitCode.CLARIFY)
        return None

    def _once_more(self, actions: tuple[Action, ...], text: str, language: Language) -> Plan | NoPlan:
        actions = (replace(actions[0], alongside=False), *actions[1:])
        told = self._tell(actions, language)
        calls = self._validation.calls(Plan(text, actions, "", "reader"))
        return self._sourced(self._validation.of(text, calls, told.steps, told.response))

    def _continued(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan:
        """What an interruption left of the last plan."""
        if why := about_itself.cannot_continue(request.on_record, language):
            return NoPlan(text, "nothing_to_continue", why, ExitCode.CLARIFY)
        left = (replace(request.on_record.left[0], alongside=False), *request.on_record.left[1:])
        told = self._tell(left, language)
        return Plan(text, left, told.response, "reader", told.steps)

    def _only_seen(self, seen: Sequence[str]) -> str:
        """The one thing that was seen; empty where there are several, or none."""
        names = [name for name in self._inventory if any(name in told for told in seen)]
        return names[0] if len(names) == 1 and len(seen) == 1 else ""

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
            return self._unknown(text, place.words, language)
        except Unable as why:
            asks = why.what == "person" and _SOMEBODY.fullmatch(why.words.casefold())
            code = ExitCode.CLARIFY if asks or why.what in _ASKED else ExitCode.FAILED
            key = f"unable_{why.what}"
            return NoPlan(text, key, SAID[language][key].format(words=why.words), code)

    def decided(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan | None:
        """What a condition decides after a look; None where there is no such condition."""
        if request.sees is None:
            return None
        chosen = self._chosen(request, text, language)
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
        return self._sourced(self._validation.of(text, calls, told.steps, told.response))

    def _sourced(self, found: Plan | NoPlan) -> Plan | NoPlan:
        return replace(found, source="reader") if isinstance(found, Plan) else found

    def _unknown(self, text: str, name: str, language: Language) -> NoPlan:
        """A journey to a place that the map does not have."""
        offered = room_instead(text, name, self._vocabulary, language)
        return offered or unknown(text, name, self._phrases(language).places, language)


def _told(meaning: Meaning) -> MeaningRead:
    told = meaning.describe()
    return MeaningRead(meaning.text, meaning.reader, told["confidence"], tuple(told["nodes"]))


def _is_no_order(meaning: Meaning) -> bool:
    """Nothing in it is to be done; small talk, and what takes all back, which have answers of their own, apart."""
    talk = all(isinstance(node, Do) and node.act != "fact" for node in meaning.nodes)
    return not talk and not _takes_all_back(meaning) and not any(_is_order(node) for node in meaning.wanted())


def _takes_all_back(meaning: Meaning) -> bool:
    return meaning.has(Retract) and not meaning.has(Not) and not meaning.has(About) and not meaning.wanted()


def _is_order(node: Node) -> bool:
    return not (isinstance(node, Do) and node.act in _NO_ORDERS)


def _is_answer(node: Node) -> bool:
    """ "Fine, then …": what follows it is the order."""
    return isinstance(node, Do) and node.act in ("yes", "no")


def _only_wanted(nodes: Sequence[Node]) -> tuple[Do | If | Repeat, ...]:
    return tuple(node for node in nodes if isinstance(node, (Do, If, Repeat)))
