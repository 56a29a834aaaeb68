"""Those who are around the robot and hear what it says, where somebody plays them: the people of a simulation.

Real people hear the loudspeaker and are heard by the microphone; a robot with a body of its own has no company.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

Posture = Literal["standing", "sitting", "lying"]
Gesture = Literal[
    "waving", "raising the left arm", "raising the right arm", "pointing to the left", "pointing to the right"
]
"""What somebody does with their arms; left and right are theirs."""
Happening = Literal["hears", "says", "follows", "stays", "leads", "steps aside", "takes", "gives"]
"""What somebody does about what they have heard."""


@dataclass(frozen=True, slots=True)
class News:
    """What one of them has done."""

    t: float  # robot time, s
    who: str  # the name that the scene has for them
    does: Happening
    text: str = ""  # what they heard or say; the name of the thing that they take or give


class Company(Protocol):
    """People who hear the robot. Thread-safe."""

    def tell(self, text: str) -> None:
        """The robot says this now, aloud; whoever is near enough hears it."""
        ...

    def news(self) -> tuple[News, ...]:
        """What they have done since this was last asked, the oldest first."""
        ...
