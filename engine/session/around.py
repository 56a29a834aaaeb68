"""Those around the robot: they hear what it says, and what they do and answer is told.

In a simulation they are played (:mod:`engine.robot.company`); real people hear the loudspeaker, and nothing is here.
"""

from __future__ import annotations

from engine.bus import Emit
from engine.events import PersonActed
from engine.robot.company import Company
from engine.robot.robot import Robot


class Around:
    """Whoever is around one robot. In one thread."""

    def __init__(self, robot: Robot, emit: Emit) -> None:
        self._company: Company | None = robot.company
        self._emit = emit
        self._said: list[str] = []

    def tell(self, text: str) -> None:
        """The robot says this now."""
        if self._company is not None:
            self._company.tell(text)

    def forget(self) -> None:
        """What was said until now answers nothing that is asked from now on."""
        self.poll()
        self._said.clear()

    def answered(self) -> str:
        """What somebody has said since; empty where nobody has."""
        self.poll()
        return self._said.pop(0) if self._said else ""

    def poll(self) -> None:
        """Tell what they have done since this was last called."""
        if self._company is None:
            return
        for news in self._company.news():
            self._emit(PersonActed(news.who, news.does, news.text, round(news.t, 3)))
            if news.does == "says":
                self._said.append(news.text)
