"""Calls of large models on record: each is told once, however it ends, without what is secret and without end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest

from engine.clock import LoopClock, SystemClock
from engine.events import ModelAsked
from engine.llm.call import MAX_TEXT, Call, reply_of
from engine.llm.chain import Chain
from engine.llm.chat import Ask, ChatError, Hear, Message, Reply, Unreachable, _deaf
from engine.llm.openai import OpenAIChat
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import PlanRequest, Said
from engine.planner.stages.models import Models
from tests import virtual_time
from tests.history import planned, ran
from tests.model_service import SECRET, STREAM, Answer, Service, Unfinished, chunk, reply, serving, streamed
from tests.unit.test_two_stage import GOOD, ODD, SETTINGS, Model, planner_with


def calls_of(model: Model, text: str = ODD, decision: Model | None = None, **more: Any) -> list[ModelAsked]:
    """What was told while a request was planned."""
    told: list[ModelAsked] = []
    request = replace(PlanRequest(text, record=told.append), **more)
    asyncio.run(planner_with(model, decision).plan(request))
    return told


def test_a_question_and_its_answer_are_told_with_who_was_asked() -> None:
    (call,) = calls_of(Model([GOOD]))
    assert (call.layer, call.platform, call.model, call.round) == ("execution", "test", "test-1b", 1)
    assert call.reply == GOOD
    assert (call.error, call.error_code, call.cancelled, call.cut_off) == ("", None, False, False)
    assert [message.role for message in call.messages] == ["user"]
    assert ODD in call.messages[0].text


def test_a_plain_command_tells_of_no_call() -> None:
    told: list[ModelAsked] = []
    planner = build_planner(SETTINGS, models=Models(Chain([Model([GOOD])], lambda words: None)))
    asyncio.run(planner.plan(PlanRequest("go to the kitchen", record=told.append)))
    assert told == []


def test_what_every_question_begins_with_is_told_by_a_digest_that_changes_with_it() -> None:
    model = Model([GOOD])
    first, second = *calls_of(model), *calls_of(model, "could the blue cup perhaps live on the desk from now on")
    assert (first.head, first.head_length) == (second.head, second.head_length)
    head = model.asked[0].messages[: model.asked[0].shared]
    assert first.head_length == sum(len(message.text) for message in head) > 3000
    assert len(first.head) == 16
    (small,) = calls_of(Model([GOOD], local=True))
    assert small.head != first.head


def test_both_layers_tell_and_before_what_came_of_them() -> None:
    told: list[object] = []
    decision, execution = Model(['{"steps": ["take the red box", "put it on the sofa"]}']), Model([GOOD])
    request = PlanRequest(ODD, record=told.append, decide=lambda steps, source: told.append(steps))
    asyncio.run(planner_with(execution, decision).plan(request))
    first, steps, second = told
    assert isinstance(first, ModelAsked)
    assert isinstance(second, ModelAsked)
    assert (first.layer, second.layer) == ("decision", "execution")
    assert steps == ("take the red box", "put it on the sofa")
    assert first.head != second.head


def test_an_answer_that_was_given_back_makes_a_second_round_with_what_was_wrong() -> None:
    first, second = calls_of(Model(["nonsense", GOOD]))
    assert (first.round, first.reply, second.round, second.reply) == (1, "nonsense", 2, GOOD)
    assert [message.role for message in second.messages] == ["user", "assistant", "user"]
    assert second.messages[1].text == "nonsense"
    assert "Answer again" in second.messages[2].text


def test_a_model_that_refuses_has_answered() -> None:
    answer = '{"refuse": "I will not: the cat could get hurt."}'
    (call,) = calls_of(Model([answer]), "well well, my old friend of the mountains")
    assert (call.reply, call.error_code) == (answer, None)


def test_one_that_fails_is_told_with_its_error_and_so_is_the_one_that_is_asked_instead() -> None:
    told: list[ModelAsked] = []
    gone, there = Model([Unreachable("The platform cannot be reached.", hint="Check the network.")]), Model([GOOD])
    chain = Chain([gone, there], lambda words: None)
    planner = build_planner(SETTINGS, models=Models(chain), reader=False)
    found = asyncio.run(planner.plan(PlanRequest(ODD, record=told.append)))
    assert isinstance(found, Plan)
    failed, answered = told
    assert (failed.error_code, failed.reply, failed.cancelled) == ("model_unreachable", "", False)
    assert failed.error == "The platform cannot be reached. Check the network."
    assert (answered.round, answered.error_code, answered.reply) == (1, None, GOOD)


@pytest.mark.parametrize("size", [(160, 120), (480, 360)])
def test_a_picture_is_told_by_its_size(size: tuple[int, int]) -> None:
    done, file = cv2.imencode(".png", np.zeros((size[1], size[0], 3), np.uint8))
    assert done
    happened = (Said(ODD), planned("seewhat()"), ran("seewhat()"))
    (call,) = calls_of(Model([GOOD]), "", happened=happened, picture=file.tobytes())
    assert call.messages[-1].text.endswith(f"\n[picture {size[0]}×{size[1]}]")
    assert len(msgspec.json.encode(call)) < 2000
    (call,) = calls_of(Model([GOOD]), "", happened=happened, picture=b"\xff\xd8\xff")
    assert call.messages[-1].text.endswith("\n[picture]")


def told_of(ask: Ask, answer: str) -> ModelAsked:
    call = Call("test", "", ask, 0.1, answer, Reply(answer))
    return call.as_event("execution", 1)


def test_what_is_too_long_is_cut_and_says_how_much_is_missing_the_newest_message_last() -> None:
    long = Ask((Message("user", "a" * 30_000), Message("assistant", "b" * 15_000), Message("user", "c" * 12_000)))
    call = told_of(long, "d" * (MAX_TEXT + 7))
    oldest, middle, newest = (message.text for message in call.messages)
    assert newest == "c" * 12_000
    assert middle == "b" * 8_000 + "… [7000 characters more]"
    assert oldest == "… [30000 characters more]"
    assert call.reply == "d" * MAX_TEXT + "… [7 characters more]"
    assert told_of(Ask((Message("user", "x" * MAX_TEXT),)), "ok").messages[0].text == "x" * MAX_TEXT


async def asked(service: Service, tell: Callable[[Call], None], hear: Hear = _deaf) -> None:
    """Ask the service once."""
    chat = OpenAIChat("cloud", service.platform())
    try:
        await reply_of(chat, Ask((Message("user", "Where is the cup?"),)), hear, tell, SystemClock())
    finally:
        await chat.close()


def told_when(*answers: Answer) -> ModelAsked:
    """What is told of a call that is answered so."""
    told: list[Call] = []

    async def test() -> None:
        async with serving(*answers) as service:
            with suppress(ChatError):
                await asked(service, told.append)

    asyncio.run(test())
    (call,) = told
    return call.as_event("execution", 1)


def test_the_tokens_that_a_service_counts_are_told() -> None:
    usage = {"prompt_tokens": 812, "completion_tokens": 64, "total_tokens": 876}
    call = told_when(streamed("There", ".", usage=usage))
    assert (call.platform, call.model, call.reply) == ("cloud", "one-that-sees", "There.")
    assert (call.prompt_tokens, call.reply_tokens) == (812, 64)
    assert call.duration_s > 0


def test_of_an_answer_that_breaks_off_it_is_told_what_had_come() -> None:
    call = told_when(streamed("On the ", "table", end=None))
    assert call.reply.startswith("On the")
    assert call.error_code is not None
    assert not call.cancelled


@pytest.mark.parametrize(
    "answers",
    [
        (streamed(f"Your key is {SECRET[:9]}", f"{SECRET[9:]}."),),
        (reply(401, {"error": {"message": f"{SECRET} is wrong at http://me:{SECRET}@localhost/v1"}}),),
        (reply(302, {}, Location=f"http://{SECRET}@localhost/"),),
    ],
)
def test_the_key_is_not_told_even_where_the_service_says_it(answers: tuple[Answer, ...]) -> None:
    line = msgspec.json.encode(told_when(*answers)).decode()
    assert SECRET not in line
    assert "bearer" not in line.casefold()
    assert "127.0.0.1" not in line


def test_one_that_is_cancelled_is_told_with_what_had_come_by_then() -> None:
    async def test() -> None:
        told: list[Call] = []
        begun = asyncio.Event()
        async with serving(Unfinished(STREAM + chunk({"content": "On the "}))) as service:
            asking = asyncio.create_task(asked(service, told.append, lambda piece: begun.set()))
            await begun.wait()
            asking.cancel()
            with pytest.raises(asyncio.CancelledError):
                await asking
        (call,) = told
        event = call.as_event("execution", 1)
        assert (event.cancelled, event.reply, event.error_code, event.error) == (True, "On the ", None, "")

    asyncio.run(test())


def test_one_that_fails_because_it_was_cut_off_was_cancelled_and_did_not_fail() -> None:
    async def test() -> None:
        told: list[Call] = []
        asking = asyncio.create_task(
            reply_of(CutOff(), Ask((Message("user", "?"),)), _deaf, told.append, LoopClock(asyncio.get_running_loop()))
        )
        await asyncio.sleep(1.5)
        asking.cancel()
        await asyncio.wait([asking])
        asking.exception()
        (call,) = told
        assert (call.cancelled, call.error, call.duration_s) == (True, None, 1.5)

    virtual_time.run(test())


def test_one_that_answers_although_it_was_cancelled_is_told_with_its_answer() -> None:
    async def test() -> None:
        told: list[Call] = []
        asking = asyncio.create_task(
            reply_of(
                Stubborn(), Ask((Message("user", "?"),)), _deaf, told.append, LoopClock(asyncio.get_running_loop())
            )
        )
        await asyncio.sleep(1.5)
        asking.cancel()
        await asyncio.wait([asking])
        (call,) = told
        assert (call.cancelled, call.came) == (False, "There.")

    virtual_time.run(test())


class CutOff(Model):
    """Hangs until it is cancelled, and then calls that a failure."""

    def __init__(self) -> None:
        super().__init__([GOOD])

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            raise Unreachable("The connection broke.") from None
        raise AssertionError


class Stubborn(CutOff):
    """Answers when it is cancelled."""

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        with suppress(Unreachable):
            await super().reply(ask, hear)
        return Reply("There.")
