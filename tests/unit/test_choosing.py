"""Which one of several things is meant: words for it, and the choice among what was seen."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace
from typing import cast

import pytest

from engine.perception.memory import Thing
from engine.perception.naming import UnknownObject, wanted
from engine.perception.sighting import Colour, Kind
from engine.robot.geometry import Pose
from engine.skills.choosing import best_of
from engine.skills.context import SkillContext
from engine.skills.library import manipulation
from engine.skills.places import Places
from engine.skills.vocabulary import House, Vocabulary

HERE = Pose(0.0, 0.0, 0.0)
"""Looking east: north is left."""


def thing(kind: Kind, colour: Colour, x: float, y: float, size: tuple[float, float] = (0.05, 0.05)) -> Thing:
    number = round(1000 * (x + 2) + 7 * (y + 2) * 1000)
    return Thing(number, kind, colour, None, (x, y, 0.03), 0.01, size, 0.0, None, 0.0)


CUP = thing("cup", "red", 1.0, 0.2, (0.08, 0.1))
BALL = thing("ball", "blue", 1.0, 0.0, (0.04, 0.04))
BOX = thing("box", "green", 0.8, -0.2, (0.1, 0.07))
FAR = thing("box", "white", 1.4, 0.0, (0.05, 0.2))
ON_IT = replace(thing("ball", "yellow", 0.82, -0.18), position=(0.82, -0.18, 0.1))


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("the left most thing", CUP),
        ("rightmost object", BOX),
        ("the nearest thing", BOX),
        ("the farthest box", FAR),
        ("biggest object", BOX),
        ("the heaviest thing", BOX),
        ("the smallest thing", BALL),
        ("the lightest object", BALL),
        ("the tallest box", FAR),
        ("the thing left of the blue ball", CUP),
        ("the box at the right of the blue ball", BOX),
        ("the thing behind the ball", FAR),
        ("最大的东西", BOX),
        ("蓝色的球左边的东西", CUP),
    ],
)
def test_the_one_that_is_meant_comes_first(words: str, meant: Thing) -> None:
    assert best_of((CUP, BALL, BOX, FAR), wanted(words), HERE)[0] is meant


def test_left_is_as_the_robot_sees_it() -> None:
    behind = Pose(2.0, 0.0, math.pi)
    assert best_of((CUP, BALL, BOX), wanted("leftmost thing"), behind)[0] is BOX


def test_nothing_on_that_side_is_nothing() -> None:
    assert best_of((BALL, BOX), wanted("thing left of ball"), HERE) == ()


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("the thing on top of the green box", ON_IT),
        ("the object that is underneath the yellow ball", BOX),
        ("绿盒子上面的球", ON_IT),
        ("黄球下面的东西", BOX),
    ],
)
def test_what_lies_on_another_thing_is_told_from_what_stands_beside_it(words: str, meant: Thing) -> None:
    assert best_of((CUP, BALL, BOX, FAR, ON_IT), wanted(words), HERE) == (meant,)


@pytest.mark.parametrize(
    "words", ["leftmost thing", "biggest of red ball or green box", "red ball or cup", "cup next to green box"]
)
def test_what_skills_are_given_is_read_as_it_was_meant(words: str) -> None:
    assert str(wanted(words)) == words
    assert wanted(str(wanted(words))) == wanted(words)


def test_a_kind_of_this_house_is_any_of_its_things() -> None:
    house = House(
        things={"apple": "red ball", "crisps": "green box"}, categories={"apple": "snacks", "crisps": "snacks"}
    )
    words = Vocabulary(Places({}), house)
    assert words.object("the largest snack") == "biggest of red ball or green box"
    assert words.object("the biggest apple") == "biggest red ball"
    assert words.object("the box next to the apple") == "box next to red ball"
    with pytest.raises(UnknownObject):
        words.object("the largest wombat")


def test_what_lies_under_another_thing_is_not_gripped_through_that(monkeypatch: pytest.MonkeyPatch) -> None:
    async def find(*_: object, **__: object) -> Thing:
        return BOX

    monkeypatch.setattr(manipulation, "find", find)
    result = asyncio.run(manipulation.fetch(cast(SkillContext, None), wanted("thing under yellow ball")))
    assert result.error_code == "out_of_reach"
    assert result.message == "The green box lies under the yellow ball: I would have to take that away first."
