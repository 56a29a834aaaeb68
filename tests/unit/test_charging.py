"""A robot with a low battery goes to its dock by itself, once, when nobody wants anything."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from config.schema import Place, Position
from engine.commands import Command, Say
from engine.errors import RobotError
from engine.events import Body, Log
from engine.parts.charging import ID, LOOKS, Charging
from engine.robot.geometry import Pose
from engine.robot.robot import BatteryState
from engine.skills.places import Places

PLACES = {
    "A": Place(name="kitchen", position=Position(x=0.0, y=2.0)),
    "F": Place(name="charging dock", position=Position(x=4.2, y=-0.3)),
}
LOW, RESTED, FULL = BatteryState(10.1, 0.2, True), BatteryState(10.6, 0.4, False), BatteryState(12.4, 0.95, False)


class Looked:
    """A robot whose battery is looked at."""

    def __init__(self, dock: str | None = "charging dock") -> None:
        self.pose, self.estop, self.lost, self.free = Pose(0.0, 0.0, 0.0), False, False, True
        self.asked: list[Command] = []
        self.told: list[Body] = []
        robot: Any = SimpleNamespace(value=SimpleNamespace(state=self._state))
        asked, told = self.asked.append, self.told.append
        self._charging = Charging(robot, Places(PLACES), dock, lambda: self.free, asked, told)

    def _state(self) -> Any:
        if self.lost:
            raise RobotError("gone")
        return SimpleNamespace(pose=self.pose, estop=self.estop)

    def sees(self, *batteries: BatteryState) -> int:
        """How often it has gone by then."""
        for battery in batteries:
            self._charging.look(battery)
        return len(self.asked)


def test_it_goes_to_its_dock() -> None:
    looked = Looked()
    assert looked.sees(*[LOW] * (LOOKS - 1)) == 0, "a motor that starts takes some volts for a moment"
    assert looked.sees(LOW) == 1
    assert looked.asked == [Say("navigation(charging dock)", id=ID, wait=True)]
    assert looked.told == [Log("warning", "robot", "The battery is low (10.1 V): I am going to the charging dock.")]


def test_it_goes_once_until_it_has_been_charged() -> None:
    looked = Looked()
    assert looked.sees(*[LOW] * 10, *[RESTED] * 10, *[LOW] * 10) == 1, "a battery that rests is not charged"
    assert looked.sees(FULL, *[LOW] * 10) == 2


def test_it_waits_until_nobody_wants_anything() -> None:
    looked = Looked()
    looked.free = False
    assert looked.sees(*[LOW] * 10) == 0
    looked.free = True
    assert looked.sees(LOW) == 1


def test_it_goes_as_soon_as_the_emergency_stop_is_released() -> None:
    looked = Looked()
    looked.estop = True
    assert looked.sees(*[LOW] * 10) == 0
    looked.estop = False
    assert looked.sees(LOW) == 1


@pytest.mark.parametrize("why", ["no dock", "no such place", "there already", "lost"])
def test_it_stays_where_it_is(why: str) -> None:
    looked = Looked({"no dock": None, "no such place": "garage"}.get(why, "charging dock"))
    looked.pose = Pose(4.1, -0.3, 0.0) if why == "there already" else looked.pose
    looked.lost = why == "lost"
    assert looked.sees(*[LOW] * 10) == 0
    assert looked.told == []
