"""A turn's calls of large models are on record in the turn that made them, also when it was over before they were."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field

from engine import events
from engine.cancellation import GRACE_S
from engine.clock import LoopClock
from engine.commands import Interrupt, Say
from engine.errors import ExitCode
from engine.llm.chain import Chain
from engine.llm.chat import Ask, Chat, Hear, Message, Reply, _deaf
from engine.plan import Plan
from engine.planner.request import NoPlan, PlanRequest
from tests.session.conversation import Conversation, converse

ASK = Ask((Message("user", "What now?"),))


@dataclass
class Thinks:
    """A model that thinks for so long, s; a stubborn one goes on for as long again when it is cancelled."""

    seconds: float
    stubborn: bool = False
    name = "test"
    model = "test-1b"
    held = False
    sees = False

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        try:
            await asyncio.sleep(self.seconds)
        except asyncio.CancelledError:
            if not self.stubborn:
                raise
            await asyncio.sleep(self.seconds)
        return Reply("Nothing.")

    async def close(self) -> None:
        pass


@dataclass
class Asks:
    """A planner that asks its model, and has nothing to be done."""

    chat: Chat
    answered: list[str] = field(default_factory=list)
    understood = "Say anything."

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        request.enter("PLANNING")
        chain = Chain([self.chat], self.answered.append, LoopClock(asyncio.get_running_loop()))
        reply = await chain.answer(lambda chat: ASK, tell=lambda call: request.record(call.as_event("execution", 1)))
        return Plan(request.text, (), reply.text, "openai")


def calls(talk: Conversation) -> list[events.Event]:
    return [event for event in talk.seen if isinstance(event.body, events.ModelAsked)]


def turn_of(talk: Conversation) -> tuple[str | None, int]:
    """The turn that was asked for, and the epoch that it began in."""
    (said,) = [event for event in talk.seen if isinstance(event.body, events.TranscriptFinal)]
    return said.turn, said.epoch


def test_a_call_is_on_record_in_its_turn_before_the_plan_that_came_of_it() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("what now"))
        await talk.result()
        (call,) = calls(talk)
        assert isinstance(call.body, events.ModelAsked)
        assert (call.turn, call.epoch) == turn_of(talk)
        assert (call.body.duration_s, call.body.reply, call.body.cancelled) == (2.0, "Nothing.", False)
        (plan,) = [event for event in talk.seen if isinstance(event.body, events.PlanMade)]
        assert call.seq < plan.seq

    converse(test, plans=Asks(Thinks(2.0)))


def test_a_call_that_an_interruption_cuts_is_on_record_in_the_epoch_that_it_belongs_to() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("what now"))
        await talk.until_state("PLANNING")
        talk.send(Interrupt())
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED
        (call,) = calls(talk)
        assert isinstance(call.body, events.ModelAsked)
        assert call.body.cancelled
        assert (call.turn, call.epoch) == turn_of(talk)
        assert call.epoch < talk.epoch.current

    converse(test, plans=Asks(Thinks(60.0)))


def test_a_call_that_is_answered_long_after_its_turn_is_on_record_there_and_nothing_comes_of_it() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("what now"))
        await talk.until_state("PLANNING")
        talk.send(Interrupt())
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED
        assert calls(talk) == []
        await talk.pass_time(20 * GRACE_S)
        (call,) = calls(talk)
        assert isinstance(call.body, events.ModelAsked)
        assert (call.turn, call.epoch) == turn_of(talk)
        assert (call.body.reply, call.body.cancelled) == ("Nothing.", False)
        assert talk.bodies(events.PlanMade) == []
        assert [body.code for body in talk.bodies(events.PlanRejected)] == ["late"]
        assert len(talk.results) == 1

    converse(test, plans=Asks(Thinks(3.0, stubborn=True)))
