"""What a running skill is given: the robot under the epoch it may move in, eyes and a memory of what they saw, the
places, a voice, and a way to say how far it is. A skill reaches nothing else."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

from engine.perception.memory import WorldMemory
from engine.perception.sighting import EVERYTHING, Part, Sight
from engine.robot.camera import Picture
from engine.robot.geometry import Pose, Twist
from engine.robot.robot import Robot, RobotState
from engine.skills.people import People
from engine.skills.places import Places


class Progress(Protocol):
    """Report how far the action is: a fraction 0…1 or None, words, and the planned way ahead when it changed."""

    def __call__(
        self, fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None: ...


class Say(Protocol):
    """Speak (or show) a sentence; returns when it has been said."""

    async def __call__(self, text: str) -> None: ...


class See(Protocol):
    """Take a picture and understand it; what it shows is in the memory when this returns. Asked for some ``parts``
    alone it is a glance, of which nothing is remembered. Raises ``CameraError``."""

    async def __call__(self, parts: Collection[Part] = EVERYTHING) -> Sight: ...


class AskAbout(Protocol):
    """Ask a model that sees a question about a picture: its answer, one printable line. Raises ``ChatError``, of which
    the user has been told then."""

    async def __call__(self, picture: Picture, question: str) -> str: ...


class Ask(Protocol):
    """Say a question, and give what is answered: what is heard or typed next, or what somebody of a simulation says.
    None where nobody has answered within ``limit_s`` of robot time."""

    async def __call__(self, question: str, limit_s: float = 10.0) -> str | None: ...


class Worded(Protocol):
    """A sentence of ours in a language: that of the request, unless another is named."""

    def __call__(self, text: str, language: Literal["en", "zh"] | None = None) -> str: ...


@dataclass(frozen=True, slots=True)
class SkillContext:
    """One invocation's view of the world."""

    robot: Robot
    epoch: int
    places: Places
    say: Say
    progress: Progress
    describe_skills: Callable[[], str]
    see: See
    world: WorldMemory
    ask_about: AskAbout | None = None  # where a model that sees is configured
    worded: Worded = lambda text, language=None: text
    people: People = field(default_factory=People)
    ask: Ask | None = None  # where answers can be heard

    def drive(self, twist: Twist) -> None:
        """Command a velocity in this invocation's epoch; it dies within the command lifetime unless repeated."""
        self.robot.drive(twist, self.epoch)

    def saying(self, words: str, part: float | None = None) -> SkillContext:
        """The same for a piece of the work: whatever it says of its progress, people read ``words`` and ``part``; only
        the way ahead is passed on."""

        def progress(
            fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
        ) -> None:
            del fraction, message
            self.progress(part, words, path=path)

        return replace(self, progress=progress)

    @property
    def pose(self) -> Pose:
        return self.robot.state().pose

    async def sleep(self, seconds: float) -> RobotState:
        """Wait in robot time."""
        state = self.robot.state()
        end = state.t + seconds - 1e-9
        while state.t < end:
            state = await self.robot.tick()
        return state
