"""Where one model does not answer, the next one is asked; whoever failed is left alone for a while."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field

import pytest

from engine.clock import LoopClock
from engine.llm.chain import LONGEST_REST_S, REST_S, Chain
from engine.llm.chat import (
    Ask,
    ChatError,
    Hear,
    KeyWanted,
    Message,
    Refused,
    Reply,
    TooSlow,
    Unreachable,
    Unreadable,
)
from engine.llm.dify import DifyChat
from engine.llm.openai import OpenAIChat
from tests import virtual_time
from tests.dify_service import dify
from tests.model_service import HANGS_UP, SILENCE, reply, serving, streamed

ASK = Ask((Message("user", "Where is the cup?"),))


@dataclass
class Model:
    """A model that fails as it is told to, and counts how often it was asked."""

    name: str
    error: ChatError | None = None
    asked: int = 0
    closed: bool = False
    model = "test-1b"

    async def reply(self, ask: Ask, hear: Hear = str) -> Reply:
        self.asked += 1
        if self.error is not None:
            raise self.error
        return Reply("There.", self.name)

    async def close(self) -> None:
        self.closed = True


@dataclass
class Chained:
    """A chain under virtual time, and what it told."""

    models: tuple[Model, ...]
    told: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.chain = Chain(self.models, self.told.append, LoopClock(asyncio.get_running_loop()))

    async def answers(self) -> str:
        """Who answers."""
        return (await self.chain.reply(ASK)).model

    @property
    def asked(self) -> list[int]:
        return [model.asked for model in self.models]


def gone() -> Unreachable:
    return Unreachable("The platform cloud cannot be reached.", hint="Check the network.")


@pytest.mark.parametrize(
    "error",
    [
        gone(),
        TooSlow("Too slow."),
        KeyWanted("It wants a key."),
        Unreadable("Nonsense."),
        *(Refused("No.", status) for status in (400, 401, 403, 404, 429, 500, 503)),
    ],
    ids=lambda error: f"{type(error).__name__} {getattr(error, 'status', '')}",
)
def test_where_one_fails_the_next_one_answers_and_it_is_told_once(error: ChatError) -> None:
    async def test() -> None:
        it = Chained((Model("cloud", error), Model("local")))
        assert await it.answers() == "local"
        assert it.told == [f"{error} The platform local is asked instead."]

    virtual_time.run(test())


def test_one_that_answers_is_the_only_one_asked() -> None:
    async def test() -> None:
        it = Chained((Model("cloud"), Model("local")))
        assert it.chain.name == "cloud"
        assert await it.answers() == "cloud"
        assert (it.asked, it.told) == ([1, 0], [])

    virtual_time.run(test())


def test_one_that_failed_rests_longer_each_time_and_takes_over_again_when_it_is_well() -> None:
    async def test() -> None:
        it = Chained((Model("cloud", gone()), Model("local")))
        rests = [min(REST_S * 2**n, LONGEST_REST_S) for n in range(7)]
        assert rests[-1] == LONGEST_REST_S
        for count, rest in enumerate(rests, 1):
            assert await it.answers() == "local"
            assert it.asked[0] == count
            await asyncio.sleep(rest - 0.1)
            assert await it.answers() == "local"
            assert it.asked[0] == count
            await asyncio.sleep(0.1)
        it.models[0].error = None
        it.told.clear()
        assert [await it.answers(), await it.answers()] == ["cloud", "cloud"]
        assert it.told == ["The platform cloud answers again."]
        it.models[0].error = gone()
        await it.answers()
        await asyncio.sleep(REST_S)
        await it.answers()
        assert it.asked[0] == len(rests) + 4

    virtual_time.run(test())


def test_a_question_that_one_cannot_take_does_not_keep_it_from_the_next() -> None:
    async def test() -> None:
        it = Chained((Model("cloud", Refused("No pictures.", 400)), Model("local")))
        await it.answers()
        it.models[0].error = None
        assert await it.answers() == "cloud"

    virtual_time.run(test())


def test_when_all_fail_the_first_error_says_what_the_others_said() -> None:
    async def test() -> None:
        it = Chained((Model("cloud", gone()), Model("local", TooSlow("The model is too slow."))))
        with pytest.raises(Unreachable) as caught:
            await it.answers()
        assert str(caught.value) == ("The platform cloud cannot be reached. The model is too slow. Check the network.")
        assert len(it.told) == 1
        it.models[0].error = None
        assert await it.answers() == "cloud"  # rather one that should rest than none

    virtual_time.run(test())


def test_cancelling_is_no_failure_of_the_one_that_was_asked() -> None:
    async def run() -> None:
        told: list[str] = []
        async with serving(SILENCE) as silent, serving(streamed("There.")) as other:
            there = asyncio.Event()
            silent.on_request = there.set
            chain = Chain([OpenAIChat("cloud", silent.platform()), OpenAIChat("home", other.platform())], told.append)
            asking = asyncio.create_task(chain.reply(ASK))
            await there.wait()
            asking.cancel()
            await asyncio.wait([asking])
            assert asking.cancelled()
            await silent.left.wait()
            assert (other.asked, told) == ([], [])
            silent.answers = [streamed("Here.")]
            assert (await chain.reply(ASK)).model == "cloud"
            await chain.close()

    asyncio.run(run())


def test_a_model_that_fails_because_it_was_cut_off_leaves_the_question_cancelled() -> None:
    class CutOff(Model):
        async def reply(self, ask: Ask, hear: Hear = str) -> Reply:
            try:
                await asyncio.sleep(3600)
            except asyncio.CancelledError:
                raise gone() from None
            raise AssertionError

    async def test() -> None:
        it = Chained((CutOff("cloud"), Model("local")))
        asking = asyncio.create_task(it.chain.reply(ASK))
        await asyncio.sleep(1)
        asking.cancel()
        await asyncio.wait([asking])
        assert asking.cancelled()
        assert (it.asked[1], it.told) == (0, [])

    virtual_time.run(test())


def test_closing_closes_all() -> None:
    async def test() -> None:
        it = Chained((Model("cloud"), Model("local")))
        await it.chain.close()
        assert all(model.closed for model in it.models)

    virtual_time.run(test())


@pytest.mark.parametrize("first", [HANGS_UP, reply(401, {}), reply(200, b"garbage"), streamed("Th", end=None), SILENCE])
def test_real_services_stand_in_for_each_other(first: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", 0)

    async def run() -> None:
        told: list[str] = []
        async with dify(first) as app, serving(first) as cloud, serving(streamed("There.")) as home:
            chats = [
                DifyChat("app", app.platform(timeout_s=0.3)),
                OpenAIChat("cloud", cloud.platform(timeout_s=0.3)),
                OpenAIChat("home", home.platform()),
            ]
            chain = Chain(chats, told.append)
            assert (await chain.reply(ASK)).model == "home"
            assert [told[0].endswith("cloud is asked instead."), told[1].endswith("home is asked instead.")] == [
                True
            ] * 2
            assert (len(told), len(home.asked)) == (2, 1)
            await chain.close()

    asyncio.run(run())
