"""What noun phrases name in a house, whatever stands around the name."""

from __future__ import annotations

import pytest

from config import load
from config.schema import Place, Position
from engine.parts.loading import at_home
from engine.planner.entities import Entities
from engine.planner.worlds.house import build_vocabulary


@pytest.fixture(scope="module")
def flat() -> Entities:
    return Entities(build_vocabulary(at_home(load())))


@pytest.mark.parametrize(
    "words", ["the red box", "that shiny red box", "my red box please", "红色的盒子", "那个红盒子", "all the red boxes"]
)
def test_a_thing_is_found_behind_what_is_said_around_it(flat: Entities, words: str) -> None:
    if words.startswith("all"):
        assert flat.of(words).every
    else:
        assert flat.of(words).thing == "red box"


@pytest.mark.parametrize(
    ("words", "name"),
    [("the kitchen table's counter", "counter"), ("the old desk over there", "desk"), ("next to the bed", "bed"),
     ("in front of the sofa", "sofa"), ("沙发旁边", "sofa"), ("卧室的床上", "bed")],
)  # fmt: skip
def test_furniture_is_found_whatever_relation_is_said(flat: Entities, words: str, name: str) -> None:
    assert flat.of(words).surface == name


def test_a_piece_of_another_room_is_not_meant(flat: Entities) -> None:
    assert flat.of("the kitchen counter").surface == "counter"
    assert flat.of("the bedroom counter").surface is None


def test_a_room_is_a_place_and_a_room(flat: Entities) -> None:
    kitchen = flat.of("the kitchen")
    assert kitchen.room == "kitchen"
    assert kitchen.place is not None


def test_where_a_thing_is_said_to_be_is_an_entity_of_its_own(flat: Entities) -> None:
    cup = flat.of("the white cup that's lying on the coffee table")
    assert cup.thing == "white cup"
    assert cup.at is not None
    assert cup.at.surface == "coffee table"


@pytest.mark.parametrize("words", ["me", "here", "over here", "我", "这儿"])
def test_the_speaker_is_a_place(flat: Entities, words: str) -> None:
    assert flat.of(words).me


@pytest.mark.parametrize("words", ["it", "them", "there", "that one", "它", "那里"])
def test_a_pronoun_refers_to_what_was_named_before(flat: Entities, words: str) -> None:
    assert flat.of(words).refers


@pytest.mark.parametrize(
    ("words", "side"),
    [("to your left", "left"), ("behind you", "behind"), ("右边", "right"), ("straight ahead", "ahead")],
)
def test_a_side_of_the_robot_is_no_place(flat: Entities, words: str, side: str) -> None:
    found = flat.of(words)
    assert (found.side, found.place) == (side, None)


def test_an_unknown_name_is_nothing_and_can_be_asked_back(flat: Entities) -> None:
    assert not flat.of("the garage").known
    assert flat.near("to the garage, please") == "garage"


def test_words_that_fit_several_pieces_ask_which_one(flat: Entities) -> None:
    assert "Which" in flat.of("the chair").which


@pytest.mark.parametrize("words", ["tray 4", "the tray 4", "tray number 4", "platform 4", "4号托盘", "4号台"])
def test_a_number_behind_a_word_that_nobody_knows_is_no_block(flat: Entities, words: str) -> None:
    found = flat.of(words)
    assert (found.thing, found.place, found.surface) == (None, None, None)


@pytest.mark.parametrize("words", ["block 4", "number 4", "the tag 4", "4", "4号", "4号积木", "4号的红色积木"])
def test_a_block_is_found_by_its_number(flat: Entities, words: str) -> None:
    assert flat.of(words).thing == "block 4"


def test_a_place_that_was_named_with_a_word_before_it_is_found() -> None:
    kept = load()
    places = {**kept.places, "X": Place(name="my corner", position=Position(x=1, y=1))}
    named = Entities(build_vocabulary(at_home(kept.model_copy(update={"places": places}))))
    assert named.of("to my corner").place == "X"
    assert named.of("my kitchen").place == "A"
