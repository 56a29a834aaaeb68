"""Made-up houses are whole: everything that a command needs is there and can be reached."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.robot.sim.build import build
from engine.robot.sim.scene import Scene
from tests.eval.gpsr.goal import OPERATOR, Guest, Item, Needs
from tests.eval.gpsr.rooms import FURNITURE, NoHouse
from tests.eval.houses import LOOKS, house, unreachable

SEEDS = st.integers(0, 2**31)
NEEDS = Needs(
    (
        Guest("couch", "Linda", "female", posture="sitting"),
        Guest("bedroom", "John", "male", posture="lying"),
        Guest("entrance", "Mary", "female", leads_to="kitchen", strays=True, known=True),
        Guest("dining room", "James", "male", gesture="waving", is_child=True, posture="sitting"),
    ),
    (
        Item("coke", "coke", "desk"),
        Item("sprite", "sprite", "desk", beside=("right", "coke")),
        Item("cereal", "cereal", "desk", scale=0.8, beside=("left", "coke")),
        Item("apple", "apple", "desk", beside=("behind", "coke")),
        Item("noodles", "noodles", "side table"),
        Item("pringles", "pringles", "side table", beside=("on", "noodles")),
        Item("fork", "fork", "kitchen"),
    ),
    frozenset({"desk", "dining room"}),
    blocked="bookcase",
)


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_every_seed_makes_a_house_with_all_rooms_and_places_in_which_everything_can_be_reached(seed: int) -> None:
    scene = house(seed)
    assert set(scene.rooms) == {"corridor", *FURNITURE}
    assert {"entrance", "exit", "taxi", "bed", "desk", "sink", *scene.rooms} <= set(scene.places)
    assert unreachable(scene) == []
    assert 2 <= len([name for name in scene.people if name != OPERATOR]) <= 4


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_what_is_needed_is_there(seed: int) -> None:
    scene = house(seed, NEEDS)
    assert unreachable(scene, "bookcase") == []
    linda, john, mary, james = (scene.people[f"person {number}"] for number in (1, 2, 3, 4))
    assert _on(scene, "couch", linda.path[0])
    assert _on(scene, "bed", john.path[0])
    assert mary.leads[-1] == scene.places["kitchen"].at
    assert mary.strays
    assert mary.known
    assert scene.rooms["dining room"].contains(*james.path[0])
    assert james.height < 1.3
    assert any(piece.kind == "chair" and math.dist(piece.at, james.path[0]) < 0.1 for piece in scene.furniture.values())
    assert scene.objects["pringles"].stands_on == "noodles"
    assert scene.rooms["kitchen"].contains(*scene.objects["fork"].at)
    assert not scene.furniture["carton"].mapped


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_what_must_stand_beside_something_does_as_somebody_before_it_sees_it(seed: int) -> None:
    scene = house(seed, NEEDS)
    turn = math.radians(scene.furniture["desk"].turn)
    across = {name: _turned(scene.objects[name].at, -turn) for name in ("cereal", "coke", "sprite", "apple")}
    assert across["cereal"][0] < across["coke"][0] < across["sprite"][0]
    assert across["apple"][1] > across["coke"][1] + 0.1


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_nobody_and_nothing_else_is_where_a_command_counts(seed: int) -> None:
    scene = house(seed, NEEDS)
    assert {name for name, loose in scene.objects.items() if loose.stands_on == "desk"} == {
        "coke", "sprite", "cereal", "apple"
    }  # fmt: skip
    inside = [name for name, who in scene.people.items() if scene.rooms["dining room"].contains(*who.path[0])]
    assert inside == ["person 4"]


@pytest.mark.parametrize("seed", range(3))
def test_physics_can_be_made_of_it(seed: int) -> None:
    build(house(seed, NEEDS), pictures=False)


def test_things_look_different_and_the_same_seed_is_the_same_house() -> None:
    assert len(set(LOOKS.values())) == len(LOOKS)
    assert house(4, NEEDS) == house(4, NEEDS)


def test_a_command_about_the_corridor_begins_elsewhere() -> None:
    scene = house(1, Needs((Guest("corridor", "Linda", "female"),), clear=frozenset({"corridor"})))
    assert not scene.rooms["corridor"].contains(scene.start.x, scene.start.y)


def test_what_has_no_room_in_any_house_is_told() -> None:
    with pytest.raises(NoHouse):
        house(1, Needs(tuple(Guest("corridor", f"Linda {number}", "female") for number in range(60))))


def test_things_are_called_in_the_language_of_the_command() -> None:
    scene = house(2, language="zh")
    assert "厨房" in scene.rooms["kitchen"].aliases
    assert "水槽" in scene.places["sink"].aliases
    assert all(any("一" <= sign <= "鿿" for sign in name) for name in scene.objects)


def _on(scene: Scene, piece: str, at: tuple[float, float]) -> bool:
    x0, y0, x1, y1 = scene.furniture[piece].area
    return x0 <= at[0] <= x1 and y0 <= at[1] <= y1


def _turned(at: tuple[float, float], angle: float) -> tuple[float, float]:
    x, y = at
    return x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle)
