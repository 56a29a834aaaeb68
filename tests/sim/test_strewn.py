"""Small things on the floor, which the lidar does not see: the hull never touches what the memory knows of."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from engine.perception.memory import Thing, WorldMemory
from engine.robot.geometry import Pose, Twist
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.scene import Scene
from engine.skills.context import SkillContext
from engine.skills.search import Survey, search
from engine.skills.strewn import heed
from engine.skills.travel import go_to
from tests.sim.inhand import HandRobot, context_of

ROOM: dict[str, Any] = {
    "name": "a bare room",
    "bounds": {"x": [-1.5, 1.5], "y": [-1.5, 1.5]},
    "start": {"x": 0, "y": 0, "yaw": 0},
    "rooms": {"room": {"x": [-1.5, 1.5], "y": [-1.5, 1.5]}},
}


def cup(x: float, y: float) -> Thing:
    return Thing(1, "cup", "red", None, (x, y, 0.04), 0.01, (0.06, 0.08), 0.0, None, 0.0, 0.5)


class Bare:
    """A robot in a bare room with one cup."""

    def __init__(self, x: float, y: float, *, known: bool = True) -> None:
        loose = {"kind": "cup", "at": [x, y], "size": 0.08, "colour": "red", "mass": 0.08}
        self.robot = HandRobot(Scene.model_validate({**ROOM, "objects": {"red cup": loose}}))
        self.memory = WorldMemory()
        self.context: SkillContext = context_of(self.robot, self.memory)
        self._before = self.robot.where("red cup")
        self.pushed = 0.0
        self.robot.each_tick = self._watch
        if known:
            self.memory.take(cup(x, y))
            self.memory.put((x, y, 0.04), 0.0)

    def _watch(self) -> None:
        self.pushed = max(self.pushed, math.dist(self.robot.where("red cup"), self._before))


def bare(test: Callable[[Bare], Coroutine[Any, Any, None]], x: float, y: float, *, known: bool = True) -> None:
    asyncio.run(test(Bare(x, y, known=known)))


def test_a_turn_that_would_sweep_a_corner_over_something_gives_way_to_going_sideways() -> None:
    here, beside = Pose(0, 0, 0), cup(0.1, 0.17)
    turn, sideways = Twist(wz=1.5), Twist(vx=-0.2)
    assert heed(here, [beside], FOOTPRINT, [turn, sideways]) == sideways
    assert heed(here, [], FOOTPRINT, [turn, sideways]) == turn
    assert heed(here, [beside, cup(-0.2, 0), cup(0, -0.16), cup(0.2, 0)], FOOTPRINT, [turn, sideways]) is None


def test_what_stands_beside_the_hull_is_not_swept_away_by_turning() -> None:
    async def test(room: Bare) -> None:
        result = await go_to(room.context, Pose(-0.2, 0.9, math.pi / 2), "the goal")
        assert result.ok, result
        assert room.pushed < 0.003

    bare(test, 0.1, 0.18)


def test_what_is_on_the_way_behind_the_robot_is_seen_after_the_turn() -> None:
    async def test(room: Bare) -> None:
        result = await go_to(room.context, Pose(-1.1, 0.0, math.pi), "the goal")
        assert result.ok, result
        assert room.memory.things, "it has looked"
        assert room.pushed < 0.003

    bare(test, -0.7, 0.03, known=False)


@pytest.mark.parametrize("x", [0.9, 0.8])
def test_a_goal_on_which_something_lies_is_not_driven_to(x: float) -> None:
    async def test(room: Bare) -> None:
        result = await go_to(room.context, Pose(0.9, 0.0, 0.0), "the goal")
        assert (result.outcome, result.error_code) == ("failed", "path_blocked")
        assert "the red cup lies in the way" in result.message
        assert room.pushed < 0.003

    bare(test, x, 0.0)


def test_nobody_looks_around_from_where_something_lies() -> None:
    async def test(room: Bare) -> None:
        floor = room.robot.floor_map
        survey = Survey(floor.rooms[0], floor, FOOTPRINT, room.context.pose)
        searched = await search(room.context, floor.rooms[0], survey=survey)
        assert searched.trouble is None
        assert searched.seen > 0.85
        assert room.pushed < 0.003

    bare(test, 0.5, 0.4, known=False)
