"""How a screen or a command line holds an engine: the same few calls whether it runs in a thread of this process
or, later, somewhere else. Everything else that a holder learns comes as events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

from config.schema import Place
from engine.bus import Subscriber
from engine.commands import Command
from engine.errors import SaysoError
from engine.offer import Offer
from engine.perception.memory import World
from engine.perception.sighting import Sight
from engine.robot.floor_map import FloorMap
from engine.robot.robot import RobotState, Scan

PartName = Literal[
    "robot", "microphone", "recogniser", "planner", "voice", "camera", "model", "wake", "wake words", "ros"
]
PartState = Literal["loading", "ready", "missing", "failed"]


@dataclass(frozen=True, slots=True)
class PartStatus:
    """How one part of the engine is doing; ``detail`` says what it is, or what is wrong with it."""

    name: PartName
    state: PartState
    detail: str = ""


class EngineHandle(Protocol):
    """A running engine. All calls are thread-safe and, but for ``join``, return at once."""

    def send(self, command: Command) -> None:
        """Give a command. Interrupting ones stop the robot before this returns."""
        ...

    def join(self, timeout: float | None = None) -> bool:
        """Wait for an engine that has been asked to end; False if it has not by then."""
        ...

    def subscribe(self, subscriber: Subscriber) -> Callable[[], None]:
        """Get every event from now on, in the publishing thread; call the result to end it."""
        ...

    def status(self) -> tuple[PartStatus, ...]:
        """The engine's parts and how they are doing."""
        ...

    def pulse(self) -> float:
        """Seconds since the engine's loop last showed that it lives; it beats about twenty times a second."""
        ...

    def robot_state(self) -> RobotState | None:
        """Newest snapshot of the robot; None while it starts or is gone."""
        ...

    def scan(self) -> Scan | None:
        """Newest lidar scan; None while there is none."""
        ...

    def look(self, deliver: Callable[[Sight | SaysoError], object]) -> None:
        """Take one picture, and hand it over with what is recognised in it, or the error; in the engine's thread. For
        people who look on: the camera works for them only as long as they go on asking."""
        ...

    def floor_map(self) -> FloorMap | None:
        """The fixed map; None while the robot starts."""
        ...

    def places(self) -> Mapping[str, Place]:
        """Places by symbol."""
        ...

    def offer(self) -> Offer:
        """What the robot can be asked to do, and the words for it; empty while the engine starts."""
        ...

    def world(self) -> World:
        """What the robot remembers to have seen, and what it holds."""
        ...
