"""A session with a person at it: real planner, dispatcher and skills, a kinematic robot, virtual time.

What the real parts would take time for (hearing, thinking, speaking) takes as long as a test says, may fail, and may
refuse to be cancelled.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeVar

import numpy as np

from config import load
from config.schema import Settings
from engine import events
from engine.audio.endpoint import Utterance
from engine.bus import Bus, Emit
from engine.clock import LoopClock
from engine.commands import Command, Halted, Quit, Wake
from engine.epoch import Epoch
from engine.errors import ModelError, SaysoError
from engine.events import Body, Event, State, TurnResult
from engine.hearing.afterwards import More
from engine.hearing.hearing import NothingHeard
from engine.parts.part import Part
from engine.perception.eyes import Eyes
from engine.perception.memory import WorldMemory
from engine.plan import Plan
from engine.planner.build import build_planner, build_registry
from engine.planner.planner import NoPlan, PlanRequest, Plans
from engine.robot.geometry import Pose
from engine.session.dispatch import Dispatcher
from engine.session.hesitation import Hesitation
from engine.session.holds import Holds
from engine.session.recall import Recall
from engine.session.session import Session
from engine.session.turn import Needs
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry
from engine.tts.voice import SilentVoice, Voice
from engine.wording import build_wording
from tests.session.kinematic import KinematicRobot
from tests.virtual_time import run

T = TypeVar("T")
B = TypeVar("B", bound=Body)

NEVER = 1e6
"""s; nothing waits for this long."""


class SlowVoice:
    """Speaks fifteen characters a second, word by word."""

    audible = True

    async def say(self, text: str, heard: Callable[[str], None]) -> None:
        end = 0
        for word in text.split():
            await asyncio.sleep(len(word) / 15)
            end = text.index(word, end) + len(word)
            heard(text[:end])


class ScriptedHearing:
    """Ears into which a test speaks. What is said while nobody listens is lost."""

    warnings: tuple[str, ...] = ()

    def __init__(self) -> None:
        self.decode_s = 0.3
        self.overhearing = False
        self.suspected: list[str] = []
        """What it was asked to listen for."""
        self.grow_likelier: Callable[[], None] = lambda: None
        """What was suspected was rather said than not, and that is not known yet."""
        self._settled: Callable[[], None] = lambda: None
        self._said = ""
        self._ear: asyncio.Future[str | None] | None = None
        self._on_more: More | None = None

    def go_on(self, text: str, *, adds: bool) -> bool:
        """Say more after what was understood last, to be done after it or in its place; whether anybody was told."""
        if self._on_more is None:
            return False
        self._on_more(_final(text), adds)
        return True

    def speak(self, text: str | None) -> bool:
        """Say something, or (None) nothing for too long; whether somebody listened."""
        if self._ear is None or self._ear.done():
            return False
        self._ear.set_result(text)
        return True

    async def listen(self, emit: Emit, *, restarted: bool = False) -> Utterance | NothingHeard:
        emit(events.ListenStarted("test", restarted))
        ended = events.ListenEnded("cancelled", 0.0, 0.0)
        self._on_more = None
        self._ear = asyncio.get_running_loop().create_future()
        try:
            text = await self._ear
            ended = events.ListenEnded("no_speech" if text is None else "silence", 1.0, 1.0)
        finally:
            emit(ended)
        if text is None:
            return NothingHeard("no_speech", "Nobody spoke.")
        self._said = text
        return Utterance(np.zeros(16000, np.int16), 0.0, 1.0, 1.0)

    async def transcribe(
        self, utterance: Utterance, emit: Emit, on_more: More | None = None
    ) -> events.TranscriptFinal | events.TranscriptRejected:
        del utterance
        text = self._said
        await asyncio.sleep(self.decode_s)
        result: events.TranscriptFinal | events.TranscriptRejected
        if text:
            result, self._on_more = _final(text, self.decode_s), on_more
        else:
            result = events.TranscriptRejected("empty", "No words were recognised.")
        emit(result)
        return result

    def overhear(self, on: bool) -> None:
        self.overhearing = on
        if not on:
            self.settle()

    @property
    def overhears(self) -> bool:
        return self.overhearing

    def suspect(self, phrase: str, settled: Callable[[], None], likelier: Callable[[], None], *, sure: bool) -> None:
        del sure
        self.suspected.append(phrase)
        self._settled, self.grow_likelier = settled, likelier

    def settle(self) -> None:
        """It is known whether what was suspected was said."""
        settled, self._settled, self.grow_likelier = self._settled, lambda: None, lambda: None
        settled()


def _final(text: str, decode_s: float = 0.3) -> events.TranscriptFinal:
    return events.TranscriptFinal(text, "speech", "en", 0.9, -0.1, 0.02, 1.0, decode_s)


@dataclass
class SlowPlanner:
    """The real planner, behind a model that thinks for as long as a test says, and does what models do."""

    real: Plans
    decide_s: float = 0.0  # s; with any, there is a stage of deciding
    plan_s: float = 0.0
    stubborn: bool = False  # it does not let itself be cancelled, and answers late
    fault: SaysoError | None = None
    asked: list[PlanRequest] = field(default_factory=list)
    answered: int = 0

    @property
    def abilities(self) -> str:
        return self.real.abilities

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        self.asked.append(request)
        if self.decide_s:
            request.enter("DECIDING")
            await self._think(self.decide_s)
        if self.plan_s:
            request.enter("PLANNING")
            await self._think(self.plan_s)
        self.answered += 1
        if self.fault is not None:
            raise self.fault
        return await self.real.plan(request)

    async def _think(self, seconds: float) -> None:
        loop = asyncio.get_running_loop()
        end = loop.time() + seconds
        while (left := end - loop.time()) > 0:
            try:
                await asyncio.sleep(left)
            except asyncio.CancelledError:
                if not self.stubborn:
                    raise


MODEL_FAULT = ModelError("The model wrote nonsense.", hint="Try again.")


@dataclass
class Conversation:
    """Everything a test says, sees and asks."""

    session: Session
    robot: KinematicRobot
    epoch: Epoch
    hearing: ScriptedHearing
    planner: SlowPlanner
    holds: Holds
    hesitation: Hesitation
    ducked: list[bool] = field(default_factory=list)
    """Whether speech was told to be quieter, or as usual again."""
    volumes: list[float] = field(default_factory=list)
    """How loud the robot was told to be."""
    seen: list[Event] = field(default_factory=list)
    on_event: Callable[[Event], None] = lambda event: None
    _news: asyncio.Event = field(default_factory=asyncio.Event)

    def see(self, event: Event) -> None:
        self.seen.append(event)
        self.on_event(event)
        self._news.set()

    def send(self, command: Command) -> None:
        self.session.request(command)

    async def wake_and_say(self, text: str) -> None:
        """Wake it with the key, for the first time here, and say this once it listens."""
        self.send(Wake("key"))
        await self.until(events.ListenStarted)
        await self.pass_time(0.1)
        self.hearing.speak(text)

    def bodies(self, kind: type[B]) -> list[B]:
        return [event.body for event in self.seen if isinstance(event.body, kind)]

    async def until(self, kind: type[B], having: Callable[[B], bool] = lambda body: True) -> B:
        """The first event of this kind that fits, among those of the past or in the future."""
        looked = 0
        while True:
            for event in self.seen[looked:]:
                if isinstance(event.body, kind) and having(event.body):
                    return event.body
            looked = len(self.seen)
            self._news.clear()
            await self._news.wait()

    async def until_state(self, state: State) -> None:
        """Return when the session is in ``state``."""
        while self.session.state != state:
            self._news.clear()
            await self._news.wait()

    async def result(self, number: int = 1) -> TurnResult:
        """The result of the ``number``-th turn that ended."""
        while True:
            results = self.results
            if len(results) >= number:
                return results[number - 1]
            self._news.clear()
            await self._news.wait()

    @property
    def results(self) -> list[TurnResult]:
        """The results of all turns that have ended."""
        return [body.result for body in self.bodies(events.StateChanged) if body.result is not None]

    async def pass_time(self, seconds: float) -> None:
        """Let virtual time pass."""
        await asyncio.sleep(seconds)


def as_shipped(registry: SkillRegistry) -> SkillRegistry:
    return registry


def converse(
    test: Callable[[Conversation], Awaitable[T]],
    *overrides: str,
    voice: Voice | None = None,
    skills: Callable[[SkillRegistry], SkillRegistry] = as_shipped,
    plans: Plans | None = None,
) -> T:
    """Run ``test`` in a session under virtual time; afterwards nothing of it may be left. ``plans`` plan instead of the
    planner of the settings."""
    settings, reader = _prepared(overrides)
    if skills is not as_shipped:
        reader = None
    reader = plans or reader
    return run(_converse(test, settings, voice or SilentVoice(), skills, reader))


@cache
def _prepared(overrides: tuple[str, ...]) -> tuple[Settings, Plans | None]:
    """Settings, and a planner for them: it knows no session, and takes a while to build."""
    settings = load(overrides=overrides, environ={})
    return settings, build_planner(settings)


async def _converse(
    test: Callable[[Conversation], Awaitable[T]],
    settings: Settings,
    voice: Voice,
    skills: Callable[[SkillRegistry], SkillRegistry],
    reader: Plans | None,
) -> T:
    conversation = await begin(settings, voice, skills, reader)
    running = asyncio.get_running_loop().create_task(conversation.session.run())
    try:
        return await test(conversation)
    finally:
        conversation.send(Quit())
        await running
        others = asyncio.all_tasks() - {asyncio.current_task()}
        assert not others, f"left over: {others}"


async def begin(
    settings: Settings,
    voice: Voice,
    skills: Callable[[SkillRegistry], SkillRegistry] = as_shipped,
    reader: Plans | None = None,
) -> Conversation:
    """A session that is ready to run, in the running loop. ``reader``: what plans, once the model has thought."""
    loop = asyncio.get_running_loop()
    bus = Bus(LoopClock(loop))
    robot = KinematicRobot()
    epoch = Epoch(robot.stop)
    places = Places(settings.places)
    places.remember(Pose(0.0, 0.0, 0.0))
    registry = skills(build_registry(settings, places))
    holds = Holds()
    planner = SlowPlanner(reader or build_planner(settings, registry))
    hearing = ScriptedHearing()
    in_words = build_planner(settings, registry, reader=False)
    volumes: list[float] = []
    needs = Needs(
        robot=await _ready("robot", robot),
        planner=await _ready("planner", planner),
        dispatcher=lambda up: Dispatcher(
            registry, up, places, epoch, holds, lambda: "I can drive.", Eyes(robot, WorldMemory())
        ),
        hearing=await _ready("recogniser", hearing),
        voice=voice,
        recall=lambda up: Recall(up, WorldMemory()),
        ask=lambda command: session.request(command),
        press=robot.press,
        set_volume=volumes.append,
        wording=build_wording(settings),
        rounds=settings.planner.rounds,
        steps=settings.planner.steps,
        told=in_words.in_words,
        release_key="ctrl+o",
    )
    session = Session(settings.session, bus, epoch, needs)
    ducked: list[bool] = []
    hesitation = Hesitation(
        robot, epoch, bus, LoopClock(loop), state=lambda: session.state, ears=lambda: hearing, duck=ducked.append
    )
    robot.on_halt = lambda reason, number: session.request(Halted(reason, number))
    conversation = Conversation(session, robot, epoch, hearing, planner, holds, hesitation, ducked, volumes)
    bus.subscribe(conversation.see)
    return conversation


async def _ready(name: Any, value: T) -> Part[T]:
    async def loaded() -> T:
        return value

    part: Part[T] = Part(name, lambda status: None)
    await part.load(loaded)
    return part
