"""From words to a validated plan, or to the reason why there is none.

In this order: what must not be done is refused; words that stop, or end the task, do so; a yes does what was offered;
what a user's own skill is asked for by is that skill; the learned reader finds the meaning of all else, and what is
made of it is a plan, an answer or a question; what it hands on goes to large models, unless words in it show that it is
no order. Only the skill registry turns proposed actions into a plan: one wrong action and nothing of it runs.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from engine.commands import MAX_TEXT, too_long
from engine.errors import ExitCode, PlanError
from engine.hearing.readings import Afterthought, Completeness
from engine.llm.chat import Chat, ChatError, Message
from engine.plan import Action, ActionCall, InWords, Plan, parse_calls
from engine.planner.afterthoughts import afterthought
from engine.planner.completeness import completeness
from engine.planner.happened import is_open, last_question, last_said, rounds, to_repeat
from engine.planner.not_an_order import marks
from engine.planner.options import agreed
from engine.planner.phrases.asked import Asked
from engine.planner.phrases.phrases import Phrases, Told
from engine.planner.phrases.stopping import is_end_task, is_only_stop, is_stop
from engine.planner.refusal import impossible, refusal
from engine.planner.request import Heard, Language, NoPlan, PlanRequest, Plans, Said
from engine.planner.sentences import SAID
from engine.planner.stages.knowledge import Knowledge
from engine.planner.stages.two_stage import TwoStage
from engine.planner.text.conditions import CONDITION, IF_POLITE
from engine.planner.text.language import language_of
from engine.planner.text.shortened import written_in_full
from engine.planner.understood import CERTAIN, LIKELY, Reads, Understood
from engine.planner.validation import Validation
from engine.skills.registry import SkillRegistry
from engine.skills.vocabulary import Vocabulary

__all__ = ["Language", "NoPlan", "PlanRequest", "Planner", "Plans"]

MAX_FACTS: Final = 4
"""Facts of the user's knowledge that a model is told for one request."""
MAX_SHOWN: Final = 80
"""Longest part of a request that an answer quotes, characters."""
_CALL: Final = re.compile(r"\s*([a-z]\w*)\s*\(")
"""What an action begins with that is written as such."""
_WORDS_ONLY: Final = frozenset({"say", "finishtask", "report_pose", "list_skills"})
"""Actions that move nothing and change nothing."""


class Planner:
    """Plans with the learned reader, and with large models where there are any."""

    def __init__(
        self,
        phrases: Callable[[Language], Phrases],
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
        self._language = language
        self._models = models
        self._knowledge = knowledge
        self._asked = Asked(registry)
        self._validation = Validation(registry, vocabulary, max_actions)
        self._learned = None if reader is None else Understood(reader, phrases, self._validation, vocabulary, tell)

    def in_words(self, action: Action) -> InWords:
        """How people are told of an action, in English."""
        told = self._tell((replace(action, alongside=False),), "en")
        step = told.steps[0].removesuffix(".")
        return InWords(step, told.doing or step)

    @property
    def abilities(self) -> str:
        """A sentence that tells what the robot can do."""
        return self._phrases(self._language or "en").abilities

    def warm_up(self) -> None:
        """Read the rules, and load the reader: the first command need not wait for them."""
        refusal("go")
        impossible("go")
        marks("go")
        is_stop("go")
        if self._learned is not None:
            self._learned.meaning("go")

    def completeness(self, text: str) -> Completeness:
        """Whether somebody who said ``text`` has said all. In any thread."""
        return completeness(text, self._plain)

    def afterthought(self, first: str, whole: str) -> Afterthought | None:
        """What somebody said after the request ``first`` that belongs to it; ``whole`` is both. In any thread."""
        return afterthought(first, whole, self._plain)

    def beginnings(self, chat: Chat) -> tuple[tuple[Message, ...], ...]:
        """What questions to ``chat`` will begin with, in the language that is likeliest to be spoken."""
        return self._models.beginnings(self._language or "en", chat) if self._models is not None else ()

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """Plan what was asked for, or what comes after feedback; raises nothing."""
        if (why := too_long(request.text)) is not None:
            return NoPlan(request.text[:MAX_TEXT], "too_long", why)
        full = written_in_full(request.text)
        found = await self._plan(replace(request, text=full))
        if full == request.text:
            return found
        if isinstance(found, Plan):
            return replace(found, goal=request.text) if found.goal == full else found
        return replace(found, text=request.text) if found.text == full else found

    async def _plan(self, request: PlanRequest) -> Plan | NoPlan:
        """The same of what is written in full."""
        if (written := self._written(request)) is not None:
            return written
        text = request.text or written_in_full(last_said(request.happened))
        language = self._language or request.language or language_of(text)
        if not request.text:
            return await self._after_feedback(request, text, language)
        if (refused := await asyncio.to_thread(refusal, text)) is not None:
            return NoPlan(text, f"refused_{refused.kind}", refused.reason, ExitCode.REFUSED)
        answered = False

        def answers() -> None:
            nonlocal answered
            answered = True

        heard = Heard(replace(request, answers=answers), text, language)
        for step in (self._stopped, self._agreed, self._asked_for, self._read, self._withheld):
            if (found := await step(heard)) is not None:
                if answered and (again := self._once_more(found, heard)) is not None:
                    return again
                if answered or self._is_answer(found, heard):
                    request.answers()
                return found
        found = await self._by_model(heard)
        if not (isinstance(found, NoPlan) and found.is_not_understood):
            request.answers()  # which a model may have taken it for: it has read the question
        return found

    @staticmethod
    def _is_answer(found: Plan | NoPlan, heard: Heard) -> bool:
        """Whether what was said answers the robot's question by itself: a no, or one of the names that it has named."""
        if isinstance(found, NoPlan) and found.is_no_order:
            return True
        question = last_question(heard.request.happened)
        named = question.suggestions if question is not None and question.code == "did_you_mean" else ()
        return any(name.casefold() in heard.text.casefold() for name in named)

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

    async def _stopped(self, heard: Heard) -> Plan | NoPlan | None:
        """What stops the robot, or ends the task."""
        phrases = self._phrases(heard.language)
        if is_stop(heard.text):
            answer = phrases.phrase("stop" if is_only_stop(heard.text) else "stop_rest")
            return self._told(heard, (ActionCall("stop"),), answer)
        if is_end_task(heard.text):
            return self._told(heard, (ActionCall("finish_dialogue"),), phrases.phrase("end_task"))
        return None

    async def _agreed(self, heard: Heard) -> Plan | NoPlan | None:
        """What the robot has offered, and the user says yes to."""
        question = last_question(heard.request.happened)
        if question is None:
            return None
        offered = agreed(question, heard.text)
        if not offered and question.offer and self._learned is not None:
            offered = question.offer if await asyncio.to_thread(self._learned.agrees, heard.text) else ""
        if not offered:
            return None
        heard.request.answers()
        if isinstance(offered, str):
            return await self.plan(replace(heard.request, text=offered, happened=()))
        return self._told(heard, offered)

    async def _asked_for(self, heard: Heard) -> Plan | NoPlan | None:
        """What asks for a skill in the words of its record, by itself or among other things."""
        calls: tuple[ActionCall, ...] = ()
        if any(mark.kind in ("taken_back", "forbidden") for mark in marks(heard.text)):
            return None  # of a part of it nobody knows whether that is meant
        for part, own in self._asked.pieces(heard.text):
            if own:
                calls += own
                continue
            found = await self._read(replace(heard, text=_from_there(part, calls, heard.language)))
            if not isinstance(found, Plan) or not found.finished:
                return found
            calls += self._validation.calls(found)
        return self._told(heard, calls) if calls else None

    async def _read(self, heard: Heard) -> Plan | NoPlan | None:
        """What the learned reader makes of it."""
        return await asyncio.to_thread(self._from_meaning, heard)

    def _from_meaning(self, heard: Heard) -> Plan | NoPlan | None:
        """What comes of the meaning; nothing of what is not said to the robot, and no plan for what it has no body for,
        however it is put."""
        if self._learned is None or self._learned.overhears(heard):
            return None
        if held_back := self._learned.no_order(heard):
            return held_back
        found = self._learned.plan(heard)
        if isinstance(found, NoPlan) and found.code == "unknown_place":
            return found
        if isinstance(found, Plan) and self._learned.is_sure(heard.text, CERTAIN):
            return found
        why = None if marks(heard.text) else impossible(heard.text)
        return found if why is None else NoPlan(heard.text, "impossible", why)

    async def _withheld(self, heard: Heard) -> NoPlan | Plan | None:
        """What becomes of a request that may be no order, where the reader has not understood it as one: no model may
        overrule that. None where nothing shows that it is none."""
        found = marks(heard.text)
        overheard = self._learned is not None and await asyncio.to_thread(self._learned.overhears, heard)
        if not found and not overheard:
            return None
        first = next((mark for mark in found if mark.kind != "asked"), None)
        said = SAID[heard.language]
        if first is not None:
            told = said["told" if first.kind == "told" else "forbidden"].format(words=first.words)
            return NoPlan(heard.text, "no_order", told, ExitCode.CLARIFY)
        answer = await self._by_model(heard)  # what asks, or is overheard, is answered in words, or not at all
        acts = isinstance(answer, Plan) and any(action.name not in _WORDS_ONLY for action in answer.actions)
        if overheard and acts:
            return self._not_understood(heard)
        if overheard:
            return answer
        if acts or (isinstance(answer, NoPlan) and "model" not in answer.code):
            return NoPlan(heard.text, "asked", said["asked"], ExitCode.CLARIFY)
        return answer

    def _told(self, heard: Heard, calls: Sequence[ActionCall], response: str | None = None) -> Plan | NoPlan:
        """The plan of ``calls``, told in the language of the request: as what they are resolved to, not by the words
        that an offer has for a place."""
        found = self._validation.of(heard.text, calls, (), "")
        if isinstance(found, NoPlan):
            return found
        told = self._tell(found.actions, heard.language)
        return replace(found, steps=told.steps, response=told.response if response is None else response)

    def _plain(self, text: str, before: str = "") -> Plan | NoPlan | None:
        """What comes of ``text``, which somebody says, by itself or after the request ``before``; no large model is
        asked."""
        if not text.strip() or too_long(text) is not None or refusal(text) is not None:
            return None
        heard = Heard(PlanRequest(text, spoken=True), text, self._language or language_of(text))
        if is_stop(text) or is_end_task(text):
            return self._told(heard, (ActionCall("stop"),))
        if calls := self._asked.call(text):
            return self._told(heard, calls)
        if self._learned is None or not self._learned.is_sure(text, LIKELY):
            return None
        first = self._plain(before) if before else None
        if isinstance(first, Plan):
            last = first.actions[-1:]
            held = str(last[0].args["object"]) if last and last[0].name == "pick_object" else ""
            heard = replace(heard, request=replace(heard.request, happened=(Said(before), first), holding=held))
        return self._from_meaning(heard)

    # Large models

    async def _by_model(self, heard: Heard) -> Plan | NoPlan:
        request, language = heard.request, heard.language
        if self._models is None:
            if self._learned is not None and not self._learned.reads:
                return NoPlan(request.text, "no_reader", SAID[language]["no_reader"], ExitCode.MISSING)
            return self._not_understood(heard)
        depends = CONDITION.search(IF_POLITE.sub("", request.text)) is not None
        if depends and self._models.is_small:
            return NoPlan(request.text, "condition", SAID[language]["condition"], ExitCode.CLARIFY)
        try:
            known = self._facts_for(request, request.text)
            found = await self._models.plan(request, language, known=known, looks_first=depends)
            return self._validation.one_of(found, request, language)
        except ChatError as error:
            found = self._not_understood(heard)
            told = SAID[language]["no_model"].format(answer=found.answer, error=str(error))
            if found.repeats:
                return replace(found, answer=told)
            return NoPlan(request.text, error.code, told, ExitCode(error.exit_code))

    @staticmethod
    def _once_more(found: Plan | NoPlan, heard: Heard) -> NoPlan | None:
        """The open question once more, after an answer that names nothing here: what it is about is not given up."""
        if not isinstance(found, NoPlan) or found.exit_code is not ExitCode.FAILED or found.is_not_understood:
            return None
        if (question := to_repeat(heard.request.happened)) is None:
            return None
        return replace(question, code="not_understood", answer=f"{found.answer} {question.answer}", repeats=True)

    def _not_understood(self, heard: Heard) -> NoPlan:
        """That the request was not understood, and what would be; or the open question once more."""
        shown = " ".join("".join(c if c.isprintable() else " " for c in heard.text[: 2 * MAX_SHOWN]).split())
        shown = shown if len(shown) <= MAX_SHOWN else f"{shown[:MAX_SHOWN].rstrip()}…"
        if (question := to_repeat(heard.request.happened)) is not None:
            said = SAID[language_of(question.answer)]["not_understood"]
            again = said.format(part=f": “{shown}”", understood=question.answer)
            return NoPlan(question.text, "not_understood", again, ExitCode.CLARIFY, repeats=True)
        understood = self._phrases(heard.language).understood
        answer = SAID[heard.language]["not_understood"].format(part=f": “{shown}”", understood=understood)
        return NoPlan(heard.request.text, "not_understood", answer)

    async def _after_feedback(self, request: PlanRequest, text: str, language: Language) -> Plan | NoPlan:
        depends = rounds(request.happened) == 1 or is_open(request.happened)
        if (
            depends
            and request.sees is not None
            and self._learned is not None
            and (decided := await asyncio.to_thread(self._learned.decided, Heard(request, text, language)))
        ):
            return decided
        if self._models is None:
            return NoPlan(text, "not_understood", "")
        try:
            return await self._models.plan(request, language, known=self._facts_for(request, text))
        except ChatError as error:
            return NoPlan(text, error.code, str(error), ExitCode(error.exit_code))

    def _facts_for(self, request: PlanRequest, text: str) -> tuple[str, ...]:
        """What the user has written down that may help."""
        facts = self._knowledge.facts_for(text, MAX_FACTS)
        if (trouble := self._knowledge.trouble) is not None:
            request.warn(str(trouble))
        return facts


def _from_there(text: str, before: Sequence[ActionCall], language: Language) -> str:
    """The rest of a request that began with giving the place where the robot is a name, without that name: "remember
    this place as base, go to the sofa, and come back to base"."""
    if not before or before[0].name != "remember_place" or not before[0].named:
        return text
    name = str(next(iter(before[0].named.values())))
    started = {"en": "where you started", "zh": "出发点"}[language]
    pattern = rf"\b(?:the |my )?{re.escape(name)}\b" if name.isascii() else re.escape(name)
    return re.sub(pattern, started, text, flags=re.IGNORECASE)
