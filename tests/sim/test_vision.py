"""What a picture shows: perception's own words first, then those of a model that sees, where one is configured."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest

from config import load
from engine.epoch import Epoch
from engine.events import ActionFinished, Log, ModelAsked
from engine.llm.openai import OpenAIChat
from engine.parts.loading import make_vision
from engine.perception.asking import LONGEST, Onlooker
from engine.perception.eyes import Eyes
from engine.perception.memory import WorldMemory
from engine.plan import Plan, parse_call
from engine.planner.build import build_registry
from engine.robot.geometry import Pose
from engine.session.dispatch import Dispatcher, Ran, Run
from engine.session.holds import Holds
from engine.skills.places import Places
from tests.model_service import HANGS_UP, SECRET, SILENCE, Answer, Service, answer, reply, serving
from tests.sim.inhand import PLACES, HandRobot

SETTINGS = load(environ={})
REGISTRY = build_registry(SETTINGS)


@dataclass
class Looker:
    """A robot in the kitchen that looks at what stands on the floor there, and everything that is told of it."""

    robot: HandRobot = field(default_factory=HandRobot)
    told: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.robot.stand_at(Pose(0.0, 0.0, np.pi))
        self.robot.put("red box", -0.55, 0.0, 0.02)

    async def look(self, ask_about: Onlooker | None) -> ActionFinished:
        """Do ``seewhat()``, as a session would."""

        async def say(text: str) -> None: ...

        def record(ran: Ran) -> None: ...

        eyes = Eyes(self.robot, WorldMemory())
        epoch = Epoch(self.robot.stop)
        dispatcher = Dispatcher(REGISTRY, self.robot, Places(PLACES), epoch, Holds(), str, eyes, ask_about)
        plan = Plan("look", (REGISTRY.resolve(parse_call("seewhat()")),), "", "phrases")
        await dispatcher.run(Run(plan, epoch.current, self.told.append, say, record))
        return self.finished

    @property
    def finished(self) -> ActionFinished:
        [finished] = [body for body in self.told if isinstance(body, ActionFinished)]
        return finished

    @property
    def calls(self) -> list[ModelAsked]:
        return [body for body in self.told if isinstance(body, ModelAsked)]

    @property
    def warnings(self) -> list[str]:
        return [body.message for body in self.told if isinstance(body, Log)]


def with_service(test: Callable[[Service, Looker], Awaitable[None]], *answers: Answer) -> None:
    async def run() -> None:
        looker = Looker()  # it takes time to build, which is none of the service's
        async with serving(*answers) as service:
            try:
                await test(service, looker)
            finally:
                while opened:
                    await opened.pop().close()

    asyncio.run(run())


opened: list[Onlooker] = []
"""Those that have to be closed when their test has ended."""


def onlooker(service: Service, **changes: Any) -> Onlooker:
    opened.append(Onlooker(OpenAIChat("cloud", service.platform(**changes))))
    return opened[-1]


def test_the_model_gets_the_picture_and_its_answer_follows_what_perception_says() -> None:
    async def test(service: Service, looker: Looker) -> None:
        alone = await looker.look(None)
        assert "red box" in alone.message
        looker.told.clear()

        together = await looker.look(onlooker(service))
        assert together.message == f"{alone.message} The picture shows: A red box on a floor."
        assert together.data == alone.data
        assert looker.warnings == []

        [request] = service.asked
        text, picture = request.body["messages"][0]["content"]
        assert "recognised myself: " in text["text"]
        assert "red box" in text["text"]
        file = base64.b64decode(picture["image_url"]["url"].partition(",")[2])
        sent = cv2.cvtColor(cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        taken = (await looker.robot.look()).rgb
        assert sent.shape == (360, 480, 3)
        small = cv2.resize(sent, (160, 120), interpolation=cv2.INTER_AREA)
        assert np.abs(small.astype(int) - taken).mean() < 3
        assert np.abs(small[..., ::-1].astype(int) - taken).mean() > 3  # colours that are swapped would show

        [call] = looker.calls
        assert (call.layer, call.platform, call.reply) == ("vision", "cloud", "A red box\non a floor.")
        assert call.messages[0].text == f"{text['text']}\n[picture 480×360]"

    with_service(test, answer("A red box\non a floor."))


def test_an_answer_is_one_printable_line_that_is_not_too_long() -> None:
    async def test(service: Service, looker: Looker) -> None:
        message = (await looker.look(onlooker(service))).message
        _, _, shown = message.partition(" The picture shows: ")
        assert shown.startswith("A red [31mbox 红")
        assert len(shown) == LONGEST
        assert shown.isprintable()

    with_service(test, answer("A red \x1b[31mbox\r\n\u202e红" + " and a cup" * 100))


@pytest.mark.parametrize(
    "answers",
    [
        (reply(401, {"error": {"message": f"{SECRET} is wrong"}}),),
        (reply(500, {}),),
        (HANGS_UP,),
        (reply(200, b"nonsense"),),
        (SILENCE,),
    ],
)
def test_a_model_that_fails_costs_the_description_nothing_and_is_told_once(answers: tuple[Answer, ...]) -> None:
    async def test(service: Service, looker: Looker) -> None:
        alone = await looker.look(None)
        looker.told.clear()
        finished = await looker.look(onlooker(service, timeout_s=0.2 if answers == (SILENCE,) else 5))
        assert (finished.outcome, finished.message) == ("ok", alone.message)
        [warning] = looker.warnings
        assert "cloud" in warning
        assert "platforms.cloud" in warning or "later" in warning
        [call] = looker.calls
        assert call.error == warning
        assert SECRET.encode() not in msgspec.json.encode(looker.told)

    with_service(test, *answers)


def test_an_interruption_closes_the_connection_and_is_the_one_end_of_the_action() -> None:
    async def test(service: Service, looker: Looker) -> None:
        there = asyncio.Event()
        service.on_request = there.set
        looking = asyncio.create_task(looker.look(onlooker(service)))
        await there.wait()
        looking.cancel()
        with pytest.raises(asyncio.CancelledError):
            await looking
        await service.left.wait()
        assert looker.finished.outcome == "interrupted"
        assert [call.cancelled for call in looker.calls] == [True]
        assert looker.warnings == []

    with_service(test, SILENCE)


def test_the_platform_that_the_settings_name_is_the_one_that_is_asked() -> None:
    async def test(service: Service, looker: Looker) -> None:
        settings = load(
            environ={"CLOUD_KEY": SECRET},
            overrides=[
                "profiles.phrases.vision=cloud",
                "platforms.cloud.kind=openai",
                "platforms.cloud.model=one-that-sees",
                "platforms.cloud.api_key=${CLOUD_KEY}",
                f"platforms.cloud.base_url=http://127.0.0.1:{service.port}/v1/",
            ],
        )
        vision = make_vision(settings)
        assert isinstance(vision, Onlooker)
        opened.append(vision)
        assert (await looker.look(vision)).message.endswith(" The picture shows: A red box.")
        [request] = service.asked
        assert request.line.startswith("POST /v1/chat/completions ")
        assert request.headers["authorization"] == f"Bearer {SECRET}"
        assert request.body["model"] == "one-that-sees"
        assert SECRET.encode() not in msgspec.json.encode(looker.told)

    with_service(test, answer("A red box."))


def test_as_shipped_nobody_is_asked() -> None:
    assert make_vision(SETTINGS) is None
