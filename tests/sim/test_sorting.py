"""Sorting blocks by their tags and taking away what stands too high, by pictures and real grasps in the workshop."""

from __future__ import annotations

import asyncio
from functools import cache
from typing import Any

import pytest

from engine.perception.memory import WorldMemory
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Pose
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.skills.library.sorting import apriltag_remove_higher, apriltag_sort, color_remove_higher, tray_of
from engine.skills.outcome import Result
from engine.skills.registry import Skill
from tests.sim.inhand import HandRobot, context_of

BEFORE_THE_BLOCKS = Pose(-2.9, 1.7, 1.57)
BEFORE_THE_STACK = Pose(1.0, 1.6, 0.0)
TABLE = 0.1
"""Height of the stack table, m."""


@cache
def workshop() -> Scene:
    return load_scene(scene_path("workshop"))


def do(skill: Skill, start: Pose, *args: Any, scene: Scene | None = None) -> tuple[Result, HandRobot]:
    """Run a skill with the robot at ``start``."""
    robot = HandRobot(scene or workshop())
    robot.stand_at(start)

    async def run() -> Result:
        await robot.tick()
        return await skill.run(context_of(robot, WorldMemory()), *args)

    return asyncio.run(run()), robot


def test_a_block_is_sorted_into_the_tray_of_its_number() -> None:
    result, robot = do(apriltag_sort, BEFORE_THE_BLOCKS, 3.0)
    assert result.ok, result
    assert result.message == "Block 3 is on the tray 3."
    tray = next(piece for piece in robot.floor_map.furniture if piece.name == "tray 3")
    x, y, z = robot.where("block 3")
    assert tray.holds(x, y)
    assert z == pytest.approx(tray.height, abs=0.01)
    assert robot.where("block 2")[:2] == pytest.approx((-2.75, 2.27), abs=0.01)  # nobody touched the others


def test_a_block_without_a_tray_is_put_beside_where_the_robot_stood() -> None:
    scene = workshop().model_copy(
        update={"furniture": {name: f for name, f in workshop().furniture.items() if not name.startswith("tray")}}
    )
    result, robot = do(apriltag_sort, BEFORE_THE_BLOCKS, 2.0, scene=scene)
    assert result.ok, result
    assert result.data["place"] == "floor"
    x, y, z = robot.where("block 2")
    assert z == pytest.approx(0, abs=0.005)
    assert BEFORE_THE_BLOCKS.distance_to(Pose(x, y, 0)) < 0.6


def test_only_the_upper_block_of_a_stack_is_higher_than_one_block() -> None:
    result, robot = do(apriltag_remove_higher, BEFORE_THE_STACK, 0.06)
    assert result.ok, result
    assert result.data["removed"] == 1
    assert "block 5" in result.message
    assert robot.where("block 5")[2] == pytest.approx(0, abs=0.005)  # on the floor now
    assert robot.where("block 4") == pytest.approx((1.58, 1.35, TABLE), abs=0.01)
    assert robot.where("block 6") == pytest.approx((1.58, 1.75, TABLE), abs=0.01)


def test_tall_things_of_a_colour_are_taken_away_and_others_stay() -> None:
    result, robot = do(color_remove_higher, Pose(1.0, 1.9, 0.0), "orange", 0.06)
    assert result.ok, result
    assert result.data["removed"] == 1
    assert robot.where("orange box")[2] == pytest.approx(0, abs=0.005)
    assert robot.where("block 5")[2] == pytest.approx(TABLE + 0.045, abs=0.01)


def test_a_tray_belongs_to_the_block_of_its_number() -> None:
    trays = tuple(Furniture(f"Tray {number}", 0, 0, 1, 1) for number in (1, 12))
    assert tray_of(trays, 12) == trays[1]
    assert tray_of(trays, 2) is None
