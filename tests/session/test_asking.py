"""A skill asks somebody, and what is typed, heard or said by somebody of a simulation is the answer."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from engine import events
from engine.commands import Interrupt, Say
from engine.robot.robot import Capability
from engine.skills.context import SkillContext
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Skill, SkillRegistry
from tests.session.conversation import Conversation, converse

EVERY: frozenset[Capability] = frozenset({"base", "arm", "camera", "voice"})


async def poll(context: SkillContext) -> Result:
    """Ask for a colour."""
    assert context.ask is not None
    answer = await context.ask("Which colour do you like?")
    return ok(f"They like {answer}.") if answer else fail("no_progress", "Nobody answered.")


def with_poll(registry: SkillRegistry) -> SkillRegistry:
    return SkillRegistry([*registry, Skill("poll", "poll", (), frozenset({"base"}), poll)], capabilities=EVERY)


def asking(test: Callable[[Conversation], Awaitable[None]]) -> None:
    async def begun(talk: Conversation) -> None:
        talk.send(Say("poll()"))
        await talk.until(events.PersonAsked)
        await test(talk)

    converse(begun, skills=with_poll)


def answers(talk: Conversation) -> list[tuple[str, str]]:
    return [(body.answer, body.source) for body in talk.bodies(events.PersonAnswered)]


def test_what_is_typed_is_the_answer_and_interrupts_nothing() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("blue"))
        result = await talk.result()
        assert (result.outcome, result.message) == ("done", "They like blue.")
        assert answers(talk) == [("blue", "typed")]
        assert not talk.bodies(events.InterruptRaised)

    asking(test)


def test_a_stop_is_no_answer() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("stop"))
        result = await talk.result()
        assert result.outcome == "interrupted"
        assert answers(talk) == []

    asking(test)


def test_who_interrupts_ends_the_question() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Interrupt())
        assert (await talk.result()).outcome == "interrupted"
        assert answers(talk) == []

    asking(test)


def test_what_is_heard_is_the_answer_where_the_request_was_spoken() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("poll()")
        await talk.until(events.PersonAsked)
        while not talk.hearing.speak("green"):
            await talk.pass_time(0.05)
        result = await talk.result()
        assert result.message == "They like green."
        assert answers(talk) == [("green", "heard")]

    converse(test, skills=with_poll)


def test_nobody_answers_for_ever() -> None:
    async def test(talk: Conversation) -> None:
        result = await talk.result()
        assert (result.outcome, result.message) == ("failed", "Nobody answered.")
        assert answers(talk) == [("", "nobody")]

    asking(test)
