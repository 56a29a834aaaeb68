"""A ROS graph that a test holds in its hand, and a session that is a part of it; in virtual time."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

from config import load
from engine import events
from engine.graph.goals import Goals
from engine.handle import PartStatus
from engine.parts.graph import GraphPart, Uses
from engine.parts.part import Part
from engine.planner.build import build_registry
from engine.ros.door import End, Graph, Message, Outcome, Reply, Take, Then, Work
from tests.session.conversation import Conversation, converse

STRING = "std_msgs/msg/String"


@dataclass
class Client:
    """A peer that has sent a goal."""

    goal: Message
    told: list[Message] = field(default_factory=list)
    ended: list[tuple[End, Message]] = field(default_factory=list)
    news: asyncio.Event = field(default_factory=asyncio.Event)
    on_feedback: Callable[[Message], object] = lambda message: None

    def feedback(self, message: Message) -> None:
        self.told.append(message)
        self.on_feedback(message)
        self.news.set()

    def end(self, how: End, result: Message) -> None:
        self.ended.append((how, result))
        self.news.set()

    async def result(self) -> tuple[End, Message]:
        while not self.ended:
            self.news.clear()
            await self.news.wait()
        return self.ended[0]


class Hand:
    """A door, and the graph behind it. ``echoes``: what we publish comes back where we listen, as in most graphs."""

    def __init__(self, *, echoes: bool = True) -> None:
        self.trouble = ""
        self.echoes = echoes
        self.published: list[tuple[str, Any]] = []
        self.takes: dict[str, tuple[str, Take]] = {}
        self.answers: dict[str, Callable[[Message, Reply], object]] = {}
        self.works: dict[str, Work] = {}
        self.closed = False
        self.news = asyncio.Event()

    # As a door

    def mismatches(self) -> Mapping[str, str]:
        return {}

    def advertise(self, topic: str, type: str) -> None:
        """Nobody is there who would listen earlier."""

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        assert type == STRING
        assert every, "each of them counts"
        message["data"].encode()
        self.published.append((topic, message["data"]))
        self.news.set()
        if self.echoes and topic in self.takes:
            asyncio.get_running_loop().call_soon(self.takes[topic][1], dict(message))

    def subscribe(
        self,
        topic: str,
        type: str,
        take: Take,
        *,
        every_s: float = 0.0,
        latched: bool = False,
        every: bool = False,
    ) -> None:
        self.takes[topic] = (type, take)

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        assert type == "sayso_interfaces/srv/GetPlan"
        self.answers[service] = answer

    def serve_action(self, action: str, type: str, work: Work) -> None:
        assert type == "sayso_interfaces/action/ExecutePlan"
        self.works[action] = work

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = 5.0) -> None:
        then(Outcome("no_server"))

    def send_goal(self, *args: Any, **kwargs: Any) -> Any:
        raise NotImplementedError

    def graph(self, then: Callable[[Graph], object]) -> None:
        then(Graph())

    def close(self) -> None:
        self.closed = True

    # As a peer

    def send(self, topic: str, message: Message) -> None:
        self.takes[topic][1](message)

    def say(self, text: Any, topic: str = "/speech_to_text/command") -> None:
        self.send(topic, {"data": text})

    def write(self, topic: str, found: object) -> None:
        self.say(json.dumps(found), topic)

    def execute(self, plan: Any) -> Client:
        client = Client({"plan": plan})
        assert self.works["/execute_plan"].begin(client)
        return client

    async def plan(self, command: Any, language: Any = "") -> Message:
        replied: asyncio.Future[Message] = asyncio.get_running_loop().create_future()
        self.answers["/get_plan"]({"command": command, "language": language}, replied.set_result)
        return await replied

    def on(self, topic: str) -> list[Any]:
        """What has been published there."""
        return [data for name, data in self.published if name == topic]

    async def until(self, topic: str, having: Callable[[Any], bool] = lambda data: True) -> Any:
        """The first text on a topic that fits, now or later; read, where it is JSON."""
        while True:
            for data in map(_read, self.on(topic)):
                if having(data):
                    return data
            self.news.clear()
            await self.news.wait()

    async def turn(self, number: int = 1) -> Any:
        """What became of the ``number``-th request."""
        while True:
            turns = [one for one in map(json.loads, self.on("/outcome")) if one["kind"] == "turn"]
            if len(turns) >= number:
                return turns[number - 1]
            self.news.clear()
            await self.news.wait()


def _read(data: str) -> Any:
    return json.loads(data) if data[:1] in ("{", "[") else data


@dataclass
class Joined:
    """A session that is a part of a graph."""

    talk: Conversation
    hand: Hand
    statuses: list[PartStatus]
    heard: list[bytes]

    @property
    def logs(self) -> list[str]:
        return [body.message for body in self.talk.bodies(events.Log) if body.source == "ros"]

    @property
    def moved(self) -> bool:
        return bool(self.talk.bodies(events.ActionStarted))

    async def moving(self) -> None:
        await self.talk.until(events.ActionStarted)
        await self.talk.pass_time(0.5)


@asynccontextmanager
async def joined(
    talk: Conversation, monkeypatch: pytest.MonkeyPatch, overrides: tuple[str, ...], hand: Hand
) -> AsyncIterator[Joined]:
    settings = load(overrides=("ros.door=ws://peer:9090", *overrides), environ={})
    monkeypatch.setattr("engine.parts.graph.open_door", lambda address: hand)
    needs, bus = talk.session._needs, talk.session._bus
    heard: list[bytes] = []

    def hear(pcm: bytes) -> bool:
        heard.append(pcm)
        return True

    uses = Uses(
        ask=talk.session.request,
        state=lambda: talk.session.state,
        subscribe=bus.subscribe,
        emit=lambda body: bus.publish(body),
        hear=hear,
        planner=needs.planner,
        registry=build_registry(settings),
        wording=needs.wording,
        place_names={symbol: place.name for symbol, place in settings.places.items()},
    )
    statuses: list[PartStatus] = []
    graph = GraphPart(settings, uses, asyncio.get_running_loop().time)
    keeping = asyncio.create_task(graph.keep(Part("ros", statuses.append)))
    try:
        while not any(status.state == "ready" for status in statuses) and not hand.trouble:
            await talk.pass_time(0.01)
        yield Joined(talk, hand, statuses, heard)
    finally:
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)
        assert hand.closed


def in_graph(
    test: Callable[[Joined], Awaitable[None]],
    monkeypatch: pytest.MonkeyPatch,
    *overrides: str,
    hand: Callable[[], Hand] = Hand,
) -> None:
    """Run ``test`` in a session that has joined the graph of a hand."""

    async def within(talk: Conversation) -> None:
        async with joined(talk, monkeypatch, overrides, hand()) as both:
            await test(both)

    converse(within, *overrides)


_CHECKED: type[Work] = Goals
