"""From words to a validated plan, or to the reason why there is none.

In this order: what must not be done is refused; an answer completes the command that lacked something; what the learned
reader holds to be no order is not done; where it is sure of a plan, that is the plan; else plain commands fit a phrase
template; where none fits, what the reader was unsure of is asked about; what depends on a condition begins with a look;
the rest goes to large models. Only the skill registry turns proposed actions into a plan: one wrong action and nothing
of it runs.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final

from engine.commands import MAX_TEXT, too_long
from engine.errors import ExitCode, PlanError
from engine.events import PlanSource
from engine.hearing.readings import Afterthought, Completeness
from engine.llm.chat import Chat, ChatError, Message
from engine.perception.naming import CHINESE, KINDS
from engine.plan import Action, Plan, parse_calls
from engine.planner import about_itself
from engine.planner.afterthoughts import afterthought
from engine.planner.answering import Answering
from engine.planner.asking import AskingBack, needs_held
from engine.planner.completeness import completeness
from engine.planner.happened import last_question, last_said, rounds
from engine.planner.looking_first import GoesOn, LookingFirst
from engine.planner.not_an_order import marks, skipped
from engine.planner.orders import Orders
from engine.planner.pending import agreed
from engine.planner.phrases.again import planned_last
from engine.planner.phrases.more import more
from engine.planner.phrases.phrases import Before, Matched, NoMatch, PhrasePlanner, Told, UnknownPlace
from engine.planner.phrases.piecewise import is_piecewise
from engine.planner.readings.corrections import is_taken_back
from engine.planner.readings.first_look import CONDITION, IF_POLITE, first_look
from engine.planner.readings.put_back import put_back
from engine.planner.readings.readings import Readings
from engine.planner.refusal import Refusal, impossible, refusal
from engine.planner.request import Conditional, Language, NoPlan, PlanRequest, Plans, Ran, Said
from engine.planner.sentences import SAID
from engine.planner.stages.knowledge import Knowledge
from engine.planner.stages.two_stage import TwoStage
from engine.planner.text.language import language_of
from engine.planner.understood import Reads, Understood
from engine.planner.unknown_places import room_instead, unknown, which_place
from engine.planner.validation import Validation
from engine.skills.registry import SkillRegistry
from engine.skills.vocabulary import Vocabulary

__all__ = ["Language", "NoPlan", "PlanRequest", "Planner", "Plans"]

MAX_FACTS: Final = 4
"""Facts of the user's knowledge that a model is told for one request."""
MAX_READINGS: Final = 40
"""Of a sentence, other than word by word."""
_CALL: Final = re.compile(r"\s*([a-z]\w*)\s*\(")
"""What an action begins with that is written as such."""
_ASKS_FIRST: Final = re.compile(
    r"\b(?:is|are) there\b.*\b(?:then|and)\b|\?\W*(?:if )?(?:yes|yeah|no|so|not)\b", re.IGNORECASE
)
"""A question, and what is to be done according to its answer."""

_WORDS_ONLY: Final = frozenset({"say", "finishtask", "report_pose", "list_skills"})
"""Actions that move nothing and change nothing."""


@dataclass(slots=True)
class _Heard:
    """A request, and what the phrases and the learned reader make of it."""

    request: PlanRequest
    text: str
    """What was said, with what it refers to written out."""
    language: Language
    before: Before
    match: Matched | UnknownPlace | NoMatch
    unsure: NoPlan | None = None
    """What the learned reader would ask or tell; the phrases may know better."""


class Planner:
    """Plans with phrases of each language, and with large models where there are any."""

    def __init__(
        self,
        phrases: Callable[[Language], PhrasePlanner],
        registry: SkillRegistry,
        vocabulary: Vocabulary,
        *,
        language: Language | None,
        models: TwoStage | None,
        knowledge: Knowledge,
        tell: Callable[[Sequence[Action], Language], Told],
        max_actions: int,
        reader: Reads | None = None,
    ) -> None:
        """``language`` is the one of all requests; None: that of each. ``tell`` tells actions in it."""
        self._tell = tell
        self._phrases = phrases
        self._vocabulary = vocabulary
        self._language = language
        self._models = models
        self._knowledge = knowledge
        self._readings = Readings(vocabulary)
        self._validation = Validation(registry, vocabulary, max_actions)
        self._answering = Answering(phrases, self._validation, language)
        self._looking_first = LookingFirst(phrases, self._readings.heard, self._validation, vocabulary)
        self._learned = None if reader is None else Understood(reader, phrases, self._validation, vocabulary)
        self._orders = Orders(phrases, self._looking_first.conditional)
        self._asking_back = AskingBack(phrases, vocabulary, knowledge)
        self._nouns = frozenset(
            name.casefold() for name in (*vocabulary.names(), *vocabulary.places(), *KINDS, *CHINESE)
        )

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        return self._phrases(self._language or "en").understood

    def warm_up(self) -> None:
        """Read the rules, and the phrases of the language that is likeliest to be spoken: the first command need not
        wait for them."""
        refusal("go")
        impossible("go")
        marks("go")
        self._phrases(self._language or "en").warm_up()
        if self._learned is not None:
            self._learned.meaning("go")

    def completeness(self, text: str) -> Completeness:
        """Whether somebody who said ``text`` has said all. In any thread."""
        return completeness(text, self._phrases(self._language or language_of(text)))

    def afterthought(self, first: str, whole: str) -> Afterthought | None:
        """What somebody said after the request ``first`` that belongs to it; ``whole`` is both. In any thread."""
        language = self._language or language_of(whole)
        return afterthought(first, whole, self._phrases(language), language)

    def beginnings(self, chat: Chat) -> tuple[tuple[Message, ...], ...]:
        """What questions to ``chat`` will begin with, in the language that is likeliest to be spoken."""
        return self._models.beginnings(self._language or "en", chat) if self._models is not None else ()

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """Plan what was asked for, or what comes after feedback; raises nothing."""
        if (why := too_long(request.text)) is not None:
            return NoPlan(request.text[:MAX_TEXT], "too_long", why)
        if (written := self._written(request)) is not None:
            return written
        text = put_back(request.text, request.holding, request.happened, self._vocabulary)
        text = text or last_said(request.happened)
        language = self._language or request.language or language_of(text)
        if not request.text:
            return await self._after_feedback(request, text, language)
        before = Before(planned_last(request.happened), request.holding, self._only_seen(request.seen))
        said = last_said(request.happened)
        match = await asyncio.to_thread(self._understood, text, language, before, said)
        if isinstance(match, Refusal):
            return NoPlan(text, f"refused_{match.kind}", match.reason, ExitCode.REFUSED)
        heard = _Heard(request, text, language, before, match)
        for step in (
            self._taken_back,
            self._agreed,
            self._about_itself,
            self._answered,
            self._held_back,
            self._read,
            self._phrased,
            self._read_unsurely,
            self._looked_first,
            self._withheld,
        ):
            if (found := await step(heard)) is not None:
                return found
        return await self._asked_back(heard)

    def _written(self, request: PlanRequest) -> Plan | NoPlan | None:
        """The plan of actions that are written as such: ``navigation(place="kitchen"); beep()``."""
        name = _CALL.match(request.text)
        if name is None or not self._validation.offers(name[1]):
            return None
        if (refused := refusal(request.text)) is not None:
            return NoPlan(request.text, f"refused_{refused.kind}", refused.reason, ExitCode.REFUSED)
        try:
            found = self._validation.of(request.text, parse_calls(request.text), (), "")
        except PlanError as error:
            return NoPlan(request.text, error.code, str(error), ExitCode(error.exit_code))
        if isinstance(found, NoPlan):
            return found
        told = self._tell(found.actions, self._language or request.language or "en")
        return replace(found, steps=told.steps, response=told.response)

    # The steps of planning: each answers, or leaves the request to the next one

    async def _taken_back(self, heard: _Heard) -> Plan | NoPlan | None:
        """What is left of a request, or of the one before, that was taken back."""
        nothing = Plan(heard.text, (), SAID[heard.language]["all_right"], "phrases")
        if (left := self._orders.left(heard.text, heard.language)) is not None:
            return await self.plan(replace(heard.request, text=left)) if left else nothing
        return nothing if is_taken_back(heard.text) else None

    async def _agreed(self, heard: _Heard) -> Plan | NoPlan | None:
        """What the robot has offered, and the user says yes to."""
        question = last_question(heard.request.happened)
        if question is None:
            return None
        offered = agreed(question, heard.text)
        if not offered and question.offer and self._learned is not None:
            offered = question.offer if await asyncio.to_thread(self._learned.agrees, heard.text) else ""
        if not offered:
            return None
        if isinstance(offered, str):
            return await self.plan(replace(heard.request, text=offered, happened=()))
        told = self._phrases(heard.language).told(offered)
        return self._validation.of(heard.text, offered, told.steps, told.response)

    async def _about_itself(self, heard: _Heard) -> Plan | NoPlan | None:
        """What is on record: what it holds, why it stopped, what is left to be done."""
        request, text = heard.request, heard.text
        if told := about_itself.answer(text, request.on_record, request.holding, heard.language):
            return Plan(text, (), told, "phrases")
        if about_itself.asks_to_continue(text) and (request.on_record.left or not isinstance(heard.match, Matched)):
            return self._continued(request, text, heard.language)
        return None

    async def _answered(self, heard: _Heard) -> Plan | NoPlan | None:
        """The command that lacked something, with this answer; the question what a thing is to be put down."""
        if (answered := self._answering.plan(heard.request, heard.text, heard.match)) is not None:
            return answered
        known = heard.before.things.held or heard.before.seen
        if isinstance(heard.match, Matched) and needs_held(heard.match) and not known:
            question = self._phrases(heard.language).question("which_thing")
            return NoPlan(heard.text, "incomplete", question, ExitCode.CLARIFY)
        return None

    async def _held_back(self, heard: _Heard) -> Plan | NoPlan | None:
        """That the learned reader is sure that it is no order."""
        if self._learned is None:
            return None
        return await asyncio.to_thread(self._learned.no_order, heard.request, heard.text, heard.language)

    async def _read(self, heard: _Heard) -> Plan | NoPlan | None:
        """The plan that the learned reader is sure of; none for what the robot cannot do, however it is put."""
        if self._learned is None or (impossible(heard.text) is not None and not marks(heard.text)):
            return None
        named = heard.before.things.named
        found = await asyncio.to_thread(self._learned.plan, heard.request, heard.text, heard.language, named)
        if isinstance(found, NoPlan):
            heard.unsure = found
            return None
        return found

    async def _phrased(self, heard: _Heard) -> Plan | NoPlan | None:
        """What fits a phrase template: a plan, or small talk."""
        request, text, language = heard.request, heard.text, heard.language
        matched = isinstance(heard.match, Matched)
        if matched and (question := self._asking_back.question(request, text, language, understood=True)):
            return question
        if isinstance(heard.match, Matched) and _ASKS_FIRST.search(text) is None:
            return self._validation.one_of(self._validation.plan(text, heard.match), request, language)
        talk = self._phrases(language).talk(text)
        return Plan(text, (), talk, "phrases") if talk else None

    async def _read_unsurely(self, heard: _Heard) -> Plan | NoPlan | None:
        """What the learned reader asks or tells about what fits no template."""
        request, text, language, match = heard.request, heard.text, heard.language, heard.match
        if self._learned is None:
            return None
        if isinstance(match, NoMatch) and not match.question and not marks(text) and (why := impossible(text)):
            return NoPlan(text, "impossible", why)
        if question := self._asking_back.question(request, text, language):
            return question
        plain = isinstance(match, UnknownPlace)  # all but a place that is not here was plain to the phrases
        return None if plain else heard.unsure

    async def _looked_first(self, heard: _Heard) -> Plan | NoPlan | None:
        """A look, for what depends on something that can be seen."""
        condition = self._looking_first.conditional(heard.text)
        if condition is None:
            return None
        look = self._looking_first.plan(heard.text, condition, heard.language)
        return await self._by_model(heard.request, heard.language, look) if isinstance(look, NoMatch) else look

    async def _asked_back(self, heard: _Heard) -> Plan | NoPlan:
        """Why there is no plan: something is open, unknown, impossible or unclear; else the answer of a large model."""
        request, text, language, match = heard.request, heard.text, heard.language, heard.match
        if isinstance(match, Matched):  # its plan was not taken
            match = NoMatch(text, self._phrases(language).understood)
        if question := self._asking_back.question(request, text, language):
            return question
        if isinstance(match, UnknownPlace):
            return await self._unknown_place(request, text, match, language)
        if match.question and (self._models is None or not request.happened):  # else it may follow from those
            return NoPlan(text, "incomplete", match.question, ExitCode.CLARIFY)
        if (why := impossible(text)) is not None:
            return NoPlan(text, "impossible", why)
        return await self._by_model(request, language, match)

    def _understood(
        self, text: str, language: Language, before: Before, said: str
    ) -> Refusal | Matched | UnknownPlace | NoMatch:
        """What rules and phrases make of a request. In a thread: the first one has rules to read, others have many
        readings, and the robot needs its heartbeat all the time."""
        if (refused := refusal(text)) is not None:
            return refused
        phrases = self._phrases(language)
        match = phrases.plan(text, before)
        if isinstance(match, Matched) and any(mark.kind == "told" for mark in marks(text)):
            match = NoMatch(text, phrases.understood)  # "let's say …" orders no speech
        if self._orders.left(text, language) is not None:
            return match  # other readings would be of what was taken back
        if not isinstance(match, Matched) and (calls := more(text, before.calls, said)) is not None:
            told = phrases.told(calls)
            open_unit = NoMatch(text, phrases.understood, phrases.question("which_unit"))
            return Matched("plan", calls, told.steps, told.response) if calls else open_unit
        proposed = islice(self._readings.of(text, language, understood=isinstance(match, Matched)), MAX_READINGS)
        readings = tuple(reading for reading in proposed if not skipped(text, reading))
        for run_on in (False, True):
            for reading in readings:
                meant = phrases.plan(reading, before, run_on=run_on)
                if isinstance(meant, Matched):
                    return refusal(reading) or meant  # other words may show what is asked for
        return match

    def _continued(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan:
        """What an interruption left of the last plan."""
        if why := about_itself.cannot_continue(request.on_record, language):
            return NoPlan(text, "nothing_to_continue", why, ExitCode.CLARIFY)
        left = (replace(request.on_record.left[0], alongside=False), *request.on_record.left[1:])
        told = self._tell(left, language)
        return Plan(text, left, told.response, "phrases", told.steps)

    async def _withheld(self, heard: _Heard) -> Plan | NoPlan | None:
        """What becomes of a request that is no order, where no reader has understood it as one: no model may overrule
        that. None where it may be one."""
        request, text, language = heard.request, heard.text, heard.language
        if order := self._orders.beside_what_is_denied(text, language):
            return await self.plan(replace(request, text=order))
        answers = bool(last_question(request.happened) or self._facts_for(request, text))
        why = self._orders.why_none(text, language, answers=answers)
        if why is None or (why.code == "no_order" and marks(text)):
            return why
        answer = await self._by_model(request, language, NoMatch(text, self._phrases(language).understood))
        acts = isinstance(answer, Plan) and any(action.name not in _WORDS_ONLY for action in answer.actions)
        understood = isinstance(answer, Plan) or "model" in answer.code
        return answer if understood and not acts else why  # what asks or tells is answered in words, or not at all

    async def _unknown_place(
        self, request: PlanRequest, text: str, place: UnknownPlace, language: Language
    ) -> Plan | NoPlan:
        """A journey to a place that the map does not have."""
        if language == "en" and (question := which_place(text, place, self._vocabulary)) is not None:
            return question
        if self._models is not None and any(name.casefold() in place.name.casefold() for name in place.known):
            return await self._by_model(request, language, NoMatch(place.name, self._phrases(language).understood))
        return room_instead(text, place, self._vocabulary, language) or unknown(text, place, language)

    def _only_seen(self, seen: Sequence[str]) -> str:
        """The one thing that was seen; empty where there are several, or none."""
        names = [name for name in self._vocabulary.inventory() if any(name in told for told in seen)]
        return names[0] if len(names) == 1 and len(seen) == 1 else ""

    # Large models

    async def _by_model(self, request: PlanRequest, language: Language, match: NoMatch) -> Plan | NoPlan:
        part = f": “{match.leftover}”" if match.leftover else ""
        answer = SAID[language]["not_understood"].format(part=part, understood=match.understood)
        if self._models is None:
            asked = bool(last_question(request.happened))  # then it is no answer, and no small talk either
            if not asked and (aside := self._phrases(language).aside(request.text)):
                return Plan(request.text, (), aside, "phrases")
            return NoPlan(request.text, "not_understood", answer)
        depends = CONDITION.search(IF_POLITE.sub("", request.text)) is not None
        if depends and self._models.is_small:
            if look := first_look(request.text, self._vocabulary):
                return self._looking_first.look(request.text, look, language)
            return NoPlan(request.text, "condition", SAID[language]["condition"], ExitCode.CLARIFY)
        pieces = self._phrases(language).clauses(request.text) if self._models.is_small and not depends else ()
        try:
            if is_piecewise(request.text, pieces, self._nouns):
                return await self._piece_by_piece(request, pieces, language)
            known = self._facts_for(request, request.text)
            found = await self._models.plan(request, language, known=known, looks_first=depends)
            return self._validation.one_of(found, request, language)
        except ChatError as error:
            told = SAID[language]["no_model"].format(answer=answer, error=str(error))
            return NoPlan(request.text, error.code, told, ExitCode(error.exit_code))

    async def _piece_by_piece(
        self, request: PlanRequest, pieces: Sequence[tuple[str, Matched | None]], language: Language
    ) -> Plan | NoPlan:
        """One clause after the other, each as if what came before had been done. Raises ``ChatError``."""
        assert self._models is not None
        happened, actions = request.happened, tuple[Action, ...]()
        source: PlanSource = "phrases"
        for piece, match in pieces:
            part = replace(request, text=piece, happened=happened)
            if match is None:
                found = await self._models.plan(part, language, known=self._facts_for(request, piece))
            else:
                again = self._phrases(language).plan(piece, Before(planned_last(happened), request.holding))
                found = self._validation.plan(piece, again if isinstance(again, Matched) else match)
            found = self._validation.one_of(found, part, language)
            if isinstance(found, NoPlan):
                return replace(found, text=request.text)
            actions += found.actions
            source = found.source if match is None else source
            happened += (Said(piece), found, *(Ran(action, "ok") for action in found.actions))
        if not actions and isinstance(found, Plan):  # all of it was only talk
            return replace(found, goal=request.text)
        told = self._models.told(actions, language)
        return Plan(goal=request.text, actions=actions, response=told.response, source=source, steps=told.steps)

    async def _after_feedback(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan:
        first = request.sees is not None and rounds(request.happened) == 1
        if (
            first
            and self._learned is not None
            and (decided := await asyncio.to_thread(self._learned.decided, request, text, language))
        ):
            return decided
        condition = self._looking_first.conditional(text) if first else None
        try:
            if condition is not None:
                return await self._decided(request, condition, language)
            if self._models is None:
                return NoPlan(text, "not_understood", "")
            return await self._models.plan(request, language, known=self._facts_for(request, text))
        except ChatError as error:
            return NoPlan(text, error.code, str(error), ExitCode(error.exit_code))

    async def _decided(self, request: PlanRequest, condition: Conditional, language: Language) -> Plan | NoPlan:
        """Go on with what was seen says. Raises ``ChatError``."""
        found = self._looking_first.decided(request, condition, language)
        if isinstance(found, GoesOn):
            return await self.plan(replace(request, text=found.text, happened=()))
        if isinstance(found, NoPlan) and self._models is not None and not self._models.is_small:
            return await self._models.plan(request, language)
        return found

    def _facts_for(self, request: PlanRequest, text: str) -> tuple[str, ...]:
        """What the user has written down that may help."""
        facts = self._knowledge.facts_for(text, MAX_FACTS)
        if (trouble := self._knowledge.trouble) is not None:
            request.warn(str(trouble))
        return facts
