"""Two stages of large models: one decides on the steps in words, the other turns them into actions.

The decision layer is asked once, when a task begins; everything later in the task goes to the execution layer. Where a
profile names no decision layer, the execution model does both in one breath. Whatever a model answers is only a
proposal: every action goes through the skill registry, and everything in it has to come from what was said, known or
seen. An answer that is no good is given back once with the reason; the second one that is no good is reported.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isclose
from typing import Final, Protocol

from engine.errors import ExitCode, PlanError
from engine.events import PlanSource
from engine.llm.chain import Chain
from engine.llm.chat import Ask, Chat, ChatError, Message, Reply
from engine.plan import Action, ActionCall, Plan, Quantity
from engine.planner.grounding.deeds import asked_for
from engine.planner.grounding.doubt import Doubt
from engine.planner.grounding.questions import question_about
from engine.planner.grounding.statement import Statement
from engine.planner.grounding.vagueness import vague
from engine.planner.happened import in_words, last_said
from engine.planner.phrases.phrases import Told
from engine.planner.phrases.said import Calls
from engine.planner.reply import SCHEMA, STEPS_SCHEMA, Proposal, UnreadableReply, read_reply, read_steps
from engine.planner.request import Language, NoPlan, Noted, PlanRequest, Ran, Said, Withdrawn
from engine.planner.stages.brief import full
from engine.planner.stages.prompts import Now, Prompts
from engine.skills.registry import NOT_SAID, SkillRegistry, UnknownSkill

LOOKS: Final = frozenset({"seewhat", "locate", "scan_room", "get_dist"})
"""Actions that find something out."""
_GOES: Final = frozenset({"navigation", "navigate_to_object", "get_current_pose", "wait"})
MAX_TOKENS: Final = 400

_GAVE_UP: Final = {
    "en": "I tried that twice and it did not work.",
    "zh": "我试了两次，都没有成功。",
}
_UNREADABLE: Final = {
    "en": "The model's answer was no plan, twice; nothing was done. Try other words.",
    "zh": "模型两次都没有给出可用的计划，我什么也没做。请换个说法。",
}
_UNSURE: Final = {
    "en": "I am not sure what you mean. What shall I do?",
    "zh": "我不太明白您的意思。您要我做什么？",
}
_CHALLENGED: Final = {
    "impossible": "One of the actions can do it, or something was not said: write ? for that.",
    "refused_by_model": "Nobody spoke of harm. If it is safe, write the actions; else refuse again.",
}
"""What a small model is told that gives up, or refuses, what the rules let pass."""
_NO_ANSWERS: Final = frozenset({"understood", "ok", "okay", "sure", "yes", "done", "明白", "好的", "好"})
"""What a small model says when it knows nothing to say."""
_HARM: Final = re.compile(
    r"\b(?:hurt\w*|harm\w*|injur\w*|broken?|breaks?|damag\w*|danger\w*|unsafe|not safe|safety|forbidden|not allowed|"
    r"steal\w*|theft|privacy|scar(?:e|ed|ing)|poison\w*|fire|burn\w*|illegal)\b"
    r"|伤|弄坏|打碎|会碎|危险|不安全|不允许|禁止|隐私|偷",
    re.IGNORECASE,
)
"""What a reason speaks of for which something must not be done."""
_CANNOT: Final = re.compile(
    r"(?:sorry,? |but )*(?:I cannot|I can't|I can not|I am not able|I'm not able)\b|我不能|我不会|我无法", re.IGNORECASE
)


class _Unsaid(PlanError):
    """A number that is out of range, and that only the model has thought of."""


class Doubts(Protocol):
    """Finds in a plan what comes from nowhere."""

    def __call__(
        self,
        actions: Sequence[Action],
        said: Sequence[str],
        seen: Sequence[str],
        known: Sequence[str],
        language: Language,
    ) -> Doubt | None: ...


class TwoStage:
    """Plans by large models. ``prompts`` gives those of a language for a model; ``covers`` says whether a request is
    about what the robot could do, so that mere words are no answer to it. What a small model answers is set right by
    ``mend``, and it is asked once more about what ``left_out`` finds."""

    def __init__(
        self,
        execution: Chain,
        decision: Chain | None,
        prompts: Callable[[Language, Chat], Prompts],
        registry: SkillRegistry,
        covers: Callable[[str], bool],
        mend: Callable[[Calls, str], Calls],
        left_out: Callable[[Sequence[Action], str], str],
        doubts: Doubts,
        tell: Callable[[Sequence[Action], Language], Told],
        *,
        max_actions: int,
    ) -> None:
        self._execution = execution
        self._decision = decision
        self._prompts = prompts
        self._registry = registry
        self._covers = covers
        self._mend = mend
        self._left_out = left_out
        self._doubts = doubts
        self._tell = tell
        self._max_actions = max_actions

    @property
    def is_small(self) -> bool:
        """The model that acts is one that has to be held to a grammar."""
        return self._execution.held

    def told(self, actions: Sequence[Action], language: Language) -> Told:
        """How a plan is told."""
        return self._tell(actions, language)

    def beginnings(self, language: Language, chat: Chat) -> tuple[tuple[Message, ...], ...]:
        """What every question to ``chat`` begins with in a language: one beginning for each layer."""
        prompts = self._prompts(language, chat)
        return (prompts.head, *((prompts.decision("", ())[:1],) if self._decision is not None else ()))

    async def plan(
        self, request: PlanRequest, language: Language, *, known: Sequence[str] = (), looks_first: bool = False
    ) -> Plan | NoPlan:
        """Plan ``request``, or what comes after feedback. ``known`` are facts that may help; ``looks_first``: it
        depends on something, and only what finds that out may be done. Raises :class:`~engine.llm.chat.ChatError`."""
        steps: tuple[str, ...] = ()
        if self._decision is not None and request.text and not request.happened:
            request.enter("DECIDING")
            steps = await self._decide(request, language, known)
        request.enter("PLANNING")
        now = Now(request.text, steps, tuple(known), request.holding, request.seen, looks_first)
        wrong: list[tuple[str, str]] = []
        while True:
            reply = await self._ask(request, language, now, wrong)
            try:
                found = self._judged(read_reply(reply.text), reply, request, language, steps, known, looks_first)
                if not wrong and not looks_first:
                    self._check_whole(found, request, language)
                return found
            except PlanError as error:
                if wrong:
                    return self._given_up(request, error, language)
                wrong.append((reply.text, str(error)))

    def _check_whole(self, found: Plan | NoPlan, request: PlanRequest, language: Language) -> None:
        """Raises :class:`PlanError` where a small model has forgotten something, or gives up what it could do."""
        if not request.text:
            return
        if isinstance(found, NoPlan):
            if self.is_small and found.code in _CHALLENGED and self._covers(request.text):
                raise PlanError(_CHALLENGED[found.code])
            return
        missing = self._left_out(found.actions, request.text) if found.actions else ""
        if missing and found.source == "local":
            raise PlanError(f"You left out: “{missing}”.")

    async def _decide(self, request: PlanRequest, language: Language, known: Sequence[str]) -> tuple[str, ...]:
        assert self._decision is not None

        def ask(chat: Chat) -> Ask:
            messages = self._prompts(language, chat).decision(request.text, known)
            conversation = f"{request.cycle}/decision"
            return Ask(messages, STEPS_SCHEMA, max_tokens=MAX_TOKENS, shared=1, conversation=conversation)

        try:
            reply = await self._decision.answer(ask, tell=lambda call: request.record(call.as_event("decision", 1)))
            steps = read_steps(reply.text)
        except (ChatError, UnreadableReply) as error:  # the execution layer has the request itself
            request.warn(f"There are no decided steps; the execution layer goes on alone. {error}")
            return ()
        request.decide(steps, reply.kind)
        return steps

    async def _ask(self, request: PlanRequest, language: Language, now: Now, wrong: Sequence[tuple[str, str]]) -> Reply:
        def ask(chat: Chat) -> Ask:
            prompts = self._prompts(language, chat)
            messages: tuple[Message, ...] = prompts.execution(request.happened, now)
            if chat.sees and request.picture is not None:
                messages = (*messages[:-1], replace(messages[-1], picture=request.picture))
            for answer, why in wrong:
                messages += prompts.wrong(answer, why)
            talks = not request.text or not self._covers(request.text)  # after feedback nothing may be left to be done
            grammar = prompts.grammar(talks=talks) if chat.held else None
            conversation = f"{request.cycle}/execution"
            return Ask(messages, SCHEMA, grammar, MAX_TOKENS, shared=len(prompts.head), conversation=conversation)

        round = len(wrong) + 1
        reply = await self._execution.answer(ask, tell=lambda call: request.record(call.as_event("execution", round)))
        return replace(reply, text=full(reply.text)) if reply.kind == "local" else reply

    def _judged(
        self,
        proposal: Proposal,
        reply: Reply,
        request: PlanRequest,
        language: Language,
        steps: tuple[str, ...],
        known: Sequence[str],
        looks_first: bool,
    ) -> Plan | NoPlan:
        """The plan that a proposal amounts to. Raises :class:`PlanError` when another one is wanted."""
        goal = request.text or last_said(request.happened)
        if why := proposal.refuse or proposal.impossible or _cannot(proposal):
            if _HARM.search(why):  # small models confuse what they must not with what they cannot do
                return NoPlan(goal, "refused_by_model", why, ExitCode.REFUSED)
            if reply.kind == "local" and vague(request.text):
                return NoPlan(goal, "unclear", _UNSURE[language], ExitCode.CLARIFY)
            return NoPlan(goal, "impossible", why)
        if proposal.clarification:
            return NoPlan(goal, "unclear", proposal.clarification, ExitCode.CLARIFY)
        if request.text and not proposal.calls and proposal.response.casefold().strip(" .!。！") in _NO_ANSWERS:
            return NoPlan(goal, "unclear", _UNSURE[language], ExitCode.CLARIFY)
        if len(proposal.calls) > self._max_actions:
            raise PlanError(f"That is {len(proposal.calls)} actions; a plan has {self._max_actions} at most.")
        said = (*(entry.text for entry in request.happened if isinstance(entry, Said)), request.text)
        actions: tuple[Action, ...] = ()
        calls = self._mend(proposal.calls, request.text) if reply.kind == "local" and request.text else proposal.calls
        for call in calls:
            call, question = self._completed(call, language)
            if question:
                return NoPlan(goal, "unclear", question, ExitCode.CLARIFY)
            try:
                actions += (self._registry.resolve(call, request.text),)
            except PlanError as error:
                if _is_form(error) or (error.exit_code == ExitCode.FAILED and not _said(call, said)):
                    raise
                if error.exit_code == ExitCode.REFUSED and not _measured(call, said):
                    raise _Unsaid(f"{error.message} Nobody said that number.") from error
                return NoPlan(goal, error.code, str(error), error.exit_code)
        if reply.kind == "local" and actions and not (actions := asked_for(actions, said)):
            return NoPlan(goal, "ungrounded", _UNSURE[language], ExitCode.CLARIFY)
        if looks_first and (acting := next((i for i, a in enumerate(actions) if not _finds_out(a)), None)) is not None:
            actions = actions[:acting]
            if not any(action.name in LOOKS for action in actions):
                raise PlanError("It depends on something: go there and look first, and do nothing else yet.")
        if any(str(action) in request.spent for action in actions):
            return NoPlan(goal, "gave_up", proposal.response or _GAVE_UP[language])
        feedback = (in_words(entry) for entry in request.happened if isinstance(entry, Ran | Noted | Withdrawn))
        seen = (*request.seen, *feedback, *((f"The {request.holding} is in the hand.",) if request.holding else ()))
        if request.holding:  # it need not be picked up again
            actions = tuple(a for a in actions if a.name != "pick_object" or a.args["object"] != request.holding)
        while (doubt := self._doubts(actions, said, seen, known, language)) is not None:
            mended = self._without(actions, doubt)
            if mended is None:
                repeats = reply.kind == "local" and not doubt.parameter  # a model that has lost its way
                question = _UNSURE[language] if repeats else doubt.question
                return NoPlan(goal, "ungrounded", question, ExitCode.CLARIFY)
            actions = mended
        told = self._tell(actions, language)
        source: PlanSource = reply.kind
        # A small model does not say reliably when it is done: its plan is all there is, unless it had to look first.
        finished = not looks_first and (proposal.finishes or reply.kind == "local")
        return Plan(
            goal=goal,
            actions=actions,
            response=proposal.response or told.response,
            source=source,
            steps=steps or told.steps,
            finished=finished or not actions,
            written=reply.text,
        )

    def _completed(self, call: ActionCall, language: Language) -> tuple[ActionCall, str]:
        """The call without the arguments that were not said, and the question where one of them is needed."""
        try:
            skill = self._registry[call.name]
        except KeyError:
            return call, ""
        given = {**dict(zip((p.name for p in skill.parameters), call.positional, strict=False)), **call.named}
        if NOT_SAID not in given.values():
            return call, ""
        for parameter in skill.parameters:
            if given.get(parameter.name) == NOT_SAID and parameter.default is None:
                return call, question_about(skill, parameter, language)
        return replace(call, positional=(), named={k: v for k, v in given.items() if v != NOT_SAID}), ""

    def _without(self, actions: tuple[Action, ...], doubt: Doubt) -> tuple[Action, ...] | None:
        """The actions with the skill's own value for what nobody said, where it has one."""
        action = actions[doubt.action_index]
        for parameter in self._registry[action.name].parameters:
            if parameter.name == doubt.parameter and parameter.default is not None:
                mended = replace(action, args={**action.args, parameter.name: parameter.default})
                return (*actions[: doubt.action_index], mended, *actions[doubt.action_index + 1 :])
        return None

    def _given_up(self, request: PlanRequest, error: PlanError, language: Language) -> NoPlan:
        goal = request.text or last_said(request.happened)
        if isinstance(error, _Unsaid):
            return NoPlan(goal, "ungrounded", _UNSURE[language], ExitCode.CLARIFY)
        if isinstance(error, UnreadableReply | UnknownSkill):
            return NoPlan(goal, error.code, f"{_UNREADABLE[language]} ({error.message})")
        return NoPlan(goal, error.code, str(error), error.exit_code)


def _cannot(proposal: Proposal) -> str:
    """Why not, where an answer in words says that it is not possible."""
    return proposal.response if not proposal.calls and _CANNOT.match(proposal.response) else ""


def _is_form(error: PlanError) -> bool:
    """Whether the call itself is wrong, and not a word or a number in it."""
    return isinstance(error, UnknownSkill) or error.code == PlanError.code


def _finds_out(action: Action) -> bool:
    return action.name in LOOKS or action.name in _GOES


def _said(call: ActionCall, said: Sequence[str]) -> bool:
    """Whether a wrong word of a call is the user's own: then asking the model again does not help."""
    words = [word.casefold() for word in _words(call)]
    heard = " ".join(said).casefold()
    return any(word in heard for word in words)


def _measured(call: ActionCall, said: Sequence[str]) -> bool:
    """Whether a number of a call is the user's own: then it is refused, and not only the model's fault."""
    statements = [Statement(text) for text in said]
    figures = [abs(n) for s in statements for n in (*s.numbers, *(value for value, _ in s.quantities))]
    numbers = [abs(value.value) for value in (*call.positional, *call.named.values()) if isinstance(value, Quantity)]
    return any(isclose(number, figure, rel_tol=0.02) for number in numbers for figure in figures)


def _words(call: ActionCall) -> list[str]:
    arguments = (*call.positional, *call.named.values())
    return [argument for argument in arguments if isinstance(argument, str) and argument]
