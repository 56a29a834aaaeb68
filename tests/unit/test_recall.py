"""What a session recalls of the things around the robot, for a planner."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from engine.perception.memory import Thing, WorldMemory
from engine.perception.people import PeopleMemory
from engine.robot.floor_map import FloorMap, Furniture, Room
from engine.robot.robot import Robot
from engine.session.recall import Recall

HOUSE = FloorMap(
    0.05,
    (-5.0, -4.0),
    np.zeros((160, 200), dtype=np.bool_),
    (Room("hall", -5.0, -4.0, 0.0, 4.0), Room("study", 0.0, -4.0, 5.0, 4.0)),
    (Furniture("desk", 1.0, 1.0, 2.0, 2.0, 0.2), Furniture("shelf", 1.0, -2.0, 2.0, -1.0, 0.2)),
)


def box(x: float, y: float, surface: float, t: float = 5.0) -> Thing:
    return Thing(1, "box", "red", None, (x, y, surface + 0.03), 0.01, (0.05, 0.05), surface, 0.0, t)


@pytest.mark.parametrize(
    ("thing", "there"),
    [
        (box(1.5, 1.5, 0.2), {"desk", "study"}),
        (box(1.5, -1.5, 0.2), {"shelf", "study"}),
        (box(0.7, 1.5, 0.0), {"desk", "study"}),  # on the floor, right beside the desk
        (box(-3.0, 0.0, 0.0), {"hall"}),
    ],
)
def test_a_thing_that_was_seen_may_only_be_where_it_was_seen(thing: Thing, there: set[str]) -> None:
    memory = WorldMemory(PeopleMemory({}))
    memory._things[1] = thing
    may_be_at = Recall(cast(Robot, SimpleNamespace(floor_map=HOUSE)), memory).where_since(4.0)
    assert {place for place in ("desk", "shelf", "hall", "study") if may_be_at("red box", place)} == there
    assert {place for place in ("desk", "shelf", "hall", "study") if may_be_at("thing", place)} == there


def test_nothing_is_ruled_out_where_nothing_is_known() -> None:
    memory = WorldMemory(PeopleMemory({}))
    memory._things[1] = box(1.5, 1.5, 0.2)
    recall = Recall(cast(Robot, SimpleNamespace(floor_map=HOUSE)), memory)
    assert recall.where_since(4.0)("red box", "garage"), "the map has no such name"
    assert recall.where_since(4.0)("blue box", "shelf"), "none was seen"
    assert recall.where_since(6.0)("red box", "shelf"), "it was not seen since then"
    assert recall.where_since(4.0)("Anna", "shelf"), "people are no things"
