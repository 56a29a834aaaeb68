"""The emergency stop of a user: kept in a file, pressed by many, released by nothing but a release."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest

from engine.parts import estop as module
from engine.parts.estop import EmergencyStop, write


class Robot:
    """What was pressed."""

    def __init__(self, file: Path) -> None:
        self.pressed = False
        self.told: list[bool] = []
        self.warned: list[str] = []
        self.estop = EmergencyStop(file, self._act, self._tell, self.warned.append)
        self._more = asyncio.Event()

    def _act(self, pressed: bool) -> None:
        self.pressed = pressed

    def _tell(self, pressed: bool) -> None:
        self.told.append(pressed)
        self.estop.press(pressed)
        self._more.set()

    async def hears(self) -> None:
        """Until the next one is told."""
        await asyncio.wait_for(self._more.wait(), 30)
        self._more.clear()


def watched(file: Path, test: Callable[[Robot], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        robot = Robot(file)
        keeping = asyncio.create_task(robot.estop.keep())
        try:
            await test(robot)
        finally:
            keeping.cancel()

    asyncio.run(main())


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LOOK_S", 0.005)


def test_it_outlives_the_program_that_pressed_it(tmp_path: Path) -> None:
    file = tmp_path / "state" / "estop"
    Robot(file).estop.press(True)
    assert Robot(file).pressed
    Robot(file).estop.press(False)
    assert not Robot(file).pressed


def test_another_process_presses_and_releases_it(tmp_path: Path) -> None:
    file = tmp_path / "estop"

    async def test(robot: Robot) -> None:
        write(file, True)
        await robot.hears()
        assert robot.pressed
        write(file, False)
        await robot.hears()
        assert (robot.pressed, robot.told) == (False, [True, False])

    watched(file, test)


def test_one_that_is_pressed_before_it_is_looked_for_is_seen(tmp_path: Path) -> None:
    async def main() -> None:
        robot = Robot(tmp_path / "estop")
        write(tmp_path / "estop", True)
        keeping = asyncio.create_task(robot.estop.keep())
        await robot.hears()
        keeping.cancel()
        assert robot.pressed

    asyncio.run(main())


def test_a_folder_that_is_out_of_reach_releases_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    file = folder / "estop"

    async def test(robot: Robot) -> None:
        robot.estop.press(True)
        folder.rename(tmp_path / "elsewhere")
        assert robot.estop._is_there()
        (tmp_path / "elsewhere").rename(folder)
        write(file, False)
        await robot.hears()
        assert robot.told == [False]

    watched(file, test)


def test_one_that_cannot_be_kept_is_pressed_all_the_same_and_told(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("no folder")
    robot = Robot(tmp_path / "state" / "estop")
    robot.estop.press(True)
    assert robot.pressed
    assert "The emergency stop could not be saved in" in robot.warned[0]


def test_whoever_comes_last_counts_for_the_robot_and_for_the_file(tmp_path: Path) -> None:
    robot = Robot(tmp_path / "estop")
    for _ in range(200):
        ways = [threading.Thread(target=robot.estop.press, args=(pressed,)) for pressed in (True, False)]
        for way in ways:
            way.start()
        for way in ways:
            way.join()
        assert robot.pressed == robot.estop.pressed == (tmp_path / "estop").exists()
