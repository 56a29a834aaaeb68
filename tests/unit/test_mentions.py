"""The things that a text names, in English and Chinese, each with its kind, its colour and its number."""

from __future__ import annotations

import pytest

from engine.planner.grounding.mentions import Mention, Thing
from engine.planner.grounding.statement import Statement


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("pick up the red box", [Mention("box", "red")]),
        ("the red and blue cups", [Mention("cup", "red"), Mention("cup", "blue")]),
        ("a small violet carton", [Mention("box", "purple")]),
        ("the red one", [Mention("thing", "red")]),
        ("one of the boxes", [Mention("box")]),
        ("block 3 and the ball", [Mention("block", "", "3"), Mention("ball")]),
        ("paint the red wall", [Mention("", "red")]),
        ("go to the kitchen", []),
        ("把红色的盒子拿起来", [Mention("box", "red")]),
        ("三号积木和蓝色的小球", [Mention("block", "", "3"), Mention("ball", "blue")]),
    ],
)
def test_things_are_named_by_kind_colour_and_number(text: str, named: list[Mention]) -> None:
    assert list(Statement(text).mentions) == named


def test_a_colour_may_come_after_its_thing() -> None:
    assert Mention("box", "red") in Statement("the box that is red").mentions
    assert Mention("cup", "grey") in Statement("the mugs which are gray").mentions


@pytest.mark.parametrize(
    ("value", "text", "fits"),
    [
        ("red box", "the red carton", True),
        ("red box", "the box", False),
        ("box", "the red box", True),
        ("red box", "something red", True),
        ("red box", "a red cup", False),
        ("box", "block 3", True),
        ("block 3", "block 4", False),
        ("red thing", "the red cup", True),
        ("red_mug", "the red cup", True),
    ],
)
def test_a_thing_of_a_plan_fits_what_is_true_of_it(value: str, text: str, fits: bool) -> None:
    assert any(Thing.of(value).fits(mention) for mention in Statement(text).mentions) is fits


def test_of_which_colour_a_thing_is_may_be_left_open() -> None:
    (mention,) = Statement("the box").mentions
    assert Thing.of("red box").fits(mention, any_colour=True)
    assert not Thing.of("red cup").fits(mention, any_colour=True)
