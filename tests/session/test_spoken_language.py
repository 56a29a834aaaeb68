"""The robot answers in the language that it is spoken to in; what it did stays on record in English."""

from __future__ import annotations

import pytest

from engine import events
from engine.commands import EndTask, Interrupt, Say, Wake
from engine.plan import Plan
from engine.planner.request import NoPlan, PlanRequest
from tests.session.conversation import Conversation, converse


def spoken(talk: Conversation) -> list[str]:
    return [body.text for body in talk.bodies(events.SpeechStarted)]


def test_what_was_done_is_told_in_chinese_and_recorded_in_english() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("去厨房，然后左转九十度"))
        result = await talk.result()
        assert result.message == "我到厨房了。我向左转了90度。"
        assert spoken(talk) == ["去厨房，然后左转90度。", result.message]
        recorded = [body.message for body in talk.bodies(events.ActionFinished)]
        assert recorded == ["I am at the kitchen.", "Turned 90° left."]

    converse(test)


def test_each_request_is_answered_in_its_own_language() -> None:
    async def test(talk: Conversation) -> None:
        for number, (text, answer) in enumerate(
            [("点头", "我点过头了。"), ("nod", "Nodded."), ("把它放下", "我手里没有可以放下的东西。")], 1
        ):
            talk.send(Say(text))
            assert (await talk.result(number)).message == answer

    converse(test)


def test_a_plan_that_is_not_allowed_is_explained_in_chinese() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("前进一千米"))
        result = await talk.result()
        [refused] = talk.bodies(events.RefusalMade)
        assert spoken(talk) == [result.message] == [refused.reason]
        assert result.message.startswith("前进的距离不能是1000米，只能是")

    converse(test)


def test_words_that_it_is_to_say_are_never_translated() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("说 I am at the kitchen"))
        await talk.result()
        assert spoken(talk)[0] == "I am at the kitchen"

    converse(test)


def test_what_it_can_do_is_said_once_in_the_language_of_the_question() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("what can you do"))
        assert (await talk.result()).message == "I can drive."
        assert spoken(talk) == ["I can drive."]

    converse(test)


@pytest.mark.parametrize(("text", "answer"), [("停", "停下了。"), ("stop", "Stopped.")])
def test_a_stop_is_confirmed_in_its_language(text: str, answer: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(text))
        await talk.result()
        assert spoken(talk) == [answer]

    converse(test)


def test_an_end_without_words_is_told_in_the_language_of_the_conversation() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("去厨房"))
        await talk.until_state("ACTING")
        talk.send(Interrupt())
        assert (await talk.result()).message == "被打断了。"
        talk.send(EndTask())
        assert (await talk.result(2)).message == "任务结束了。"

    converse(test)


def test_nothing_heard_is_told_in_the_language_of_the_conversation() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("点头"))
        await talk.result()
        talk.send(Wake())
        await talk.until_state("LISTENING")
        await talk.pass_time(0.1)
        assert talk.hearing.speak("")
        assert (await talk.result(2)).message == "没有听懂：没有听出话来。"

    converse(test)


def test_what_a_model_says_stays_as_it_is() -> None:
    class Model:
        understood = ""

        async def plan(self, request: PlanRequest) -> Plan | NoPlan:
            return NoPlan(request.text, "impossible", "I am a robot, not a cook.")

    async def test(talk: Conversation) -> None:
        talk.send(Say("做一顿饭"))
        assert (await talk.result()).message == "I am a robot, not a cook."

    converse(test, plans=Model())
