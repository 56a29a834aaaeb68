"""What goes bad around the robot is told once, and once when it is well again."""

from __future__ import annotations

import shutil
from collections import namedtuple
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from engine.events import Body, Log
from engine.parts.health import Health
from engine.planner.about_itself import of
from engine.planner.request import OnRecord
from engine.robot.description import Battery, described
from engine.robot.robot import BatteryState

Usage = namedtuple("Usage", "total used free")
NOW = 1_790_000_000.0


class Looked:
    """A health with everything that it looks at in a test's hand."""

    def __init__(self, folder: Path) -> None:
        self.told: list[str] = []
        self.seen: list[float] = []
        self.battery: BatteryState | None = None
        self.now = NOW
        robot: Any = SimpleNamespace(value=SimpleNamespace(state=lambda: SimpleNamespace(battery=self.battery)))
        self.zone = folder / "thermal_zone0" / "temp"
        self.zone.parent.mkdir()
        self.zone.write_text("45000")
        self._health = Health(
            robot,
            folder,
            self._tell,  # type: ignore[arg-type]
            clock=lambda: self.now,
            thermal=folder,
            on_battery=lambda battery: self.seen.append(battery.volts),
        )

    def _tell(self, body: Body) -> None:
        assert isinstance(body, Log)
        self.told.append(f"{body.level}: {body.message}")

    def look(self) -> list[str]:
        self.told.clear()
        self._health.look(dict(self._health._machine()))
        return list(self.told)


@pytest.fixture
def looked(tmp_path: Path) -> Looked:
    return Looked(tmp_path)


def test_all_is_well(looked: Looked) -> None:
    assert looked.look() == []


def test_a_low_battery_is_told_once_and_when_it_is_charged(looked: Looked) -> None:
    looked.battery = BatteryState(10.1, 0.2, True)
    assert looked.look() == ["warning: The battery is low (10.1 V): charge it soon."]
    assert looked.look() == []
    looked.battery = BatteryState(12.4, 0.9, False)
    assert looked.look() == ["info: The battery is fine again."]


def test_heat_is_told(looked: Looked) -> None:
    looked.zone.write_text("86500")
    assert looked.look() == ["warning: The machine is 86 °C hot: it will become slow."]
    looked.zone.write_text("not a number")
    assert looked.look() == ["info: The machine has cooled down."]


def test_a_clock_that_was_never_set_is_told(looked: Looked) -> None:
    looked.now = 3600.0
    assert looked.look() == ["warning: The clock of the machine has not been set: times in logs are wrong."]


def test_a_disk_that_is_full_is_told(looked: Looked, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda path: Usage(1, 1, 5_000_000))
    assert looked.look() == ["warning: The disk has 5 MB left: logs may soon not be written."]


def test_a_battery_knows_how_full_it_is() -> None:
    battery = Battery()
    assert battery.charge(battery.full) == 1.0
    assert battery.charge(battery.empty - 1) == 0.0
    board = described("x3plus").board
    assert board is not None
    assert board.battery.empty < board.battery.low < board.battery.full


@pytest.mark.parametrize(("charge", "told"), [(0.62, "about 60 % full"), (None, "this robot does not tell me")])
def test_it_says_how_full_its_battery_is(charge: float | None, told: str) -> None:
    assert told in of("battery", OnRecord(charge=charge), "", "en")


def test_a_battery_that_is_low_only_while_the_robot_drives_stays_low_until_it_is_charged(looked: Looked) -> None:
    for volts, low in ((10.1, True), (10.3, False), (10.1, True), (10.4, False)):
        looked.battery = BatteryState(volts, 0.3, low)
        looked.look()
    assert looked.seen == [10.1, 10.3, 10.1, 10.4]
    assert looked.told == [], "the last look told nothing new"
    looked.battery = BatteryState(11.0, 0.5, False)
    assert looked.look() == ["info: The battery is fine again."]
    looked.battery = BatteryState(10.0, 0.2, True)
    assert looked.look() == ["warning: The battery is low (10 V): charge it soon."]
