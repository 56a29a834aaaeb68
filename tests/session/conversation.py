"""A session with a person at it: real planner, dispatcher and skills, a kinematic robot, virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import TypeVar

from config import load
from config.schema import Settings
from engine import events
from engine.bus import Bus
from engine.clock import LoopClock
from engine.commands import Command, Quit
from engine.dispatch import Dispatcher
from engine.epoch import Epoch
from engine.events import Body, Event, TurnResult
from engine.parts import Part
from engine.planner.build import build_planner, build_registry
from engine.robot.robot import Pose
from engine.session import Session
from engine.skills.places import Places
from engine.tts.voice import SilentVoice
from engine.turn import Needs
from tests.session.kinematic import KinematicRobot
from tests.virtual_time import run

T = TypeVar("T")
B = TypeVar("B", bound=Body)


class SlowVoice:
    """Speaks fifteen characters a second; what was heard of a cut sentence is what was said by then."""

    audible = True

    async def say(self, text: str) -> str:
        await asyncio.sleep(len(text) / 15)
        return text


@dataclass
class Conversation:
    """Everything a test says, sees and asks."""

    session: Session
    robot: KinematicRobot
    epoch: Epoch
    seen: list[Event] = field(default_factory=list)
    _news: asyncio.Event = field(default_factory=asyncio.Event)

    def see(self, event: Event) -> None:
        self.seen.append(event)
        self._news.set()

    def send(self, command: Command) -> None:
        self.session.request(command)

    def bodies(self, kind: type[B]) -> list[B]:
        return [event.body for event in self.seen if isinstance(event.body, kind)]

    async def until(self, kind: type[B], having: Callable[[B], bool] = lambda body: True) -> B:
        """The first event of this kind from now on (or among those not looked at yet) that fits."""
        looked = 0
        while True:
            for event in self.seen[looked:]:
                if isinstance(event.body, kind) and having(event.body):
                    return event.body
            looked = len(self.seen)
            self._news.clear()
            await self._news.wait()

    async def result(self, number: int = 1) -> TurnResult:
        """The result of the ``number``-th turn that ended."""
        while True:
            results = [body.result for body in self.bodies(events.StateChanged) if body.result is not None]
            if len(results) >= number:
                return results[number - 1]
            self._news.clear()
            await self._news.wait()

    async def pass_time(self, seconds: float) -> None:
        """Let virtual time pass."""
        await asyncio.sleep(seconds)


def converse(test: Callable[[Conversation], Awaitable[T]], *overrides: str, voice: object | None = None) -> T:
    """Run ``test`` in a session under virtual time; afterwards nothing of it may be left."""
    return run(_converse(test, load(overrides=overrides, environ={}), voice))


async def _converse(test: Callable[[Conversation], Awaitable[T]], settings: Settings, voice: object | None) -> T:
    loop = asyncio.get_running_loop()
    bus = Bus(LoopClock(loop))
    robot = KinematicRobot()
    epoch = Epoch(robot.stop)
    places = Places(settings.places)
    places.remember(Pose(0.0, 0.0, 0.0))
    registry = build_registry(settings, places)

    def report(status: object) -> None: ...

    async def ready(value: T) -> T:
        return value

    robot_part: Part[object] = Part("robot", report)
    planner_part: Part[object] = Part("planner", report)
    hearing_part: Part[object] = Part("recogniser", report)
    await robot_part.load(lambda: ready(robot))
    await planner_part.load(lambda: ready(build_planner(settings, registry)))
    needs = Needs(
        robot=robot_part,  # type: ignore[arg-type]
        planner=planner_part,  # type: ignore[arg-type]
        dispatcher=lambda up: Dispatcher(registry, up, places, epoch, lambda: "I can drive."),
        hearing=hearing_part,  # type: ignore[arg-type]
        voice=voice or SilentVoice(),  # type: ignore[arg-type]
    )
    session = Session(settings.session, bus, epoch, needs)
    conversation = Conversation(session, robot, epoch)
    bus.subscribe(conversation.see)
    running = loop.create_task(session.run())
    try:
        return await test(conversation)
    finally:
        conversation.send(Quit())
        await running
        others = asyncio.all_tasks() - {asyncio.current_task()}
        assert not others, f"left over: {others}"
