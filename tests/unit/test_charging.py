"""A robot with a low battery goes to its dock by itself, once, and after what it does; far and long errands wait."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from config.schema import Place, Position
from engine.commands import Command, Say
from engine.errors import RobotError
from engine.events import Body, Log
from engine.parts.charging import Charging
from engine.robot.geometry import Pose
from engine.skills.places import Places

PLACES = {
    "A": Place(name="kitchen", position=Position(x=0.0, y=2.0)),
    "F": Place(name="charging dock", position=Position(x=4.2, y=-0.3)),
}


class Low:
    """A robot whose battery has just become low."""

    def __init__(self, dock: str | None = "charging dock") -> None:
        self.pose, self.estop, self.lost = Pose(0.0, 0.0, 0.0), False, False
        self.asked: list[Command] = []
        self.told: list[Body] = []
        robot: Any = SimpleNamespace(value=SimpleNamespace(state=self._state))
        self.charging = Charging(robot, Places(PLACES), dock, self.asked.append, self.told.append)

    def _state(self) -> Any:
        if self.lost:
            raise RobotError("gone")
        return SimpleNamespace(pose=self.pose, estop=self.estop)


def test_it_goes_to_its_dock_after_what_it_does() -> None:
    low = Low()
    low.charging.go(10.1)
    assert low.asked == [Say("navigation(charging dock)", wait=True)]
    assert low.told == [Log("warning", "robot", "The battery is low (10.1 V): I am going to the charging dock.")]


@pytest.mark.parametrize("why", ["no dock", "no such place", "there already", "emergency stop", "lost"])
def test_it_stays_where_it_is(why: str) -> None:
    low = Low({"no dock": None, "no such place": "garage"}.get(why, "charging dock"))
    low.pose = Pose(4.1, -0.3, 0.0) if why == "there already" else low.pose
    low.estop, low.lost = why == "emergency stop", why == "lost"
    low.charging.go(10.1)
    assert low.asked == []
    assert low.told == []
