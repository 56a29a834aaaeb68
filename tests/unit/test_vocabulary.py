"""The words of a house: each becomes the word that skills use, or an error that names what is known."""

from __future__ import annotations

import pytest

from config import load
from config.schema import Place, Position
from engine.errors import ExitCode, PlanError
from engine.parts.loading import vocabulary as expected_nouns
from engine.perception.naming import UnknownObject
from engine.plan import parse_call
from engine.planner.worlds.house import build_vocabulary
from engine.robot.floor_map import Furniture, Room
from engine.skills.context import SkillContext
from engine.skills.library.searching import ObjectName
from engine.skills.outcome import Result, ok
from engine.skills.places import Places, UnknownPlace
from engine.skills.registry import SkillRegistry, skill
from engine.skills.vocabulary import Ambiguous, House, UnknownColour, Vocabulary


def piece(name: str, kind: str = "low_table") -> Furniture:
    return Furniture(name, 0, 0, 1, 1, 0.14, kind)


HOUSE = House(
    furniture=(piece("coffee table"), piece("bedside table"), piece("oak desk", "desk"), piece("palm", "plant"),
               piece("bin", "bin"), piece("bench"), piece("tray 1"), piece("tray 2")),
    rooms=(Room("kitchen", 0, 0, 4, 4), Room("living room", 4, 0, 8, 4)),
    things={"red box": "red box", "teddy": "black thing", "block 2": "block 2"},
)  # fmt: skip
SPOT = Position(x=1, y=1)
PLACES = Places(
    {
        "A": Place(name="kitchen", aliases=("galley",), position=SPOT),
        "B": Place(name="bench", aliases=("low bench",), position=SPOT),
        "C": Place(name="bin", aliases=("trash can",), position=SPOT),
        "D": Place(name="front door", position=SPOT),
    }
)
WORDS = Vocabulary(PLACES, HOUSE)


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("red box", "red box"), ("the Red Box", "red box"), ("a gray mug", "grey cup"), ("bottles", "bottle"),
        ("tag 3", "block 3"), ("block 2", "block 2"), ("the teddy", "black thing"), ("anything red", None),
        ("unicorn", None), ("pink box", None), ("", None),
    ],
)  # fmt: skip
def test_a_thing_is_what_perception_knows_or_what_has_a_name_here(said: str, meant: str | None) -> None:
    if meant is not None:
        assert WORDS.object(said) == meant
        return
    with pytest.raises(UnknownObject):
        WORDS.object(said)


def test_an_unknown_thing_is_told_what_is_known() -> None:
    with pytest.raises(UnknownObject) as unknown:
        WORDS.object("the unicorn")
    assert {"bottle", "red"} <= set(unknown.value.hint.replace(",", "").replace(".", "").split())
    assert "teddy" in unknown.value.hint


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("coffee table", "coffee table"), ("the Coffee Table", "coffee table"), ("desk", "oak desk"),
        ("bench", "bench"), ("low bench", "bench"), ("bin", "bin"), ("trash can", "bin"), ("the floor", "floor"),
        ("ground", "floor"), ("kitchen", "kitchen"), ("galley", "kitchen"), ("living room", "living room"),
        ("D", "front door"), ("front door", "front door"),
    ],
)  # fmt: skip
def test_a_surface_is_furniture_the_floor_the_bin_or_a_place(said: str, meant: str) -> None:
    assert WORDS.surface(said) == meant


@pytest.mark.parametrize(
    ("said", "which"), [("the table", "coffee table or bedside table"), ("tray", "tray 1 or tray 2")]
)
def test_a_word_for_several_pieces_is_asked_about(said: str, which: str) -> None:
    assert said.removeprefix("the ") in WORDS.surfaces()
    with pytest.raises(Ambiguous, match=which) as doubt:
        WORDS.surface(said)
    assert doubt.value.exit_code == ExitCode.CLARIFY


def test_a_number_alone_is_no_surface() -> None:
    assert not any(word.isdigit() for word in WORDS.surfaces())


@pytest.mark.parametrize("said", ["moon", "palm", "zero"])
def test_nothing_is_put_on_what_is_no_surface(said: str) -> None:
    with pytest.raises(UnknownPlace, match=r"coffee table.*floor"):
        WORDS.surface(said)


def test_a_room_has_the_names_of_its_place_too() -> None:
    assert WORDS.room("the kitchen") == WORDS.room("galley") == WORDS.room("A") == "kitchen"
    with pytest.raises(UnknownPlace, match="kitchen, living room"):
        WORDS.room("bench")


def test_colours_of_things_are_those_that_are_told_apart() -> None:
    assert WORDS.colour("Grey") == WORDS.colour("gray") == "grey"
    with pytest.raises(UnknownColour, match=r"pink.*red, orange"):
        WORDS.colour("pink")


@skill()
async def fetch(context: SkillContext, object: ObjectName = "") -> Result:
    """Fetch something."""
    del context
    return ok(object)


def test_the_registry_checks_a_word_by_its_kind_but_not_the_default() -> None:
    registry = SkillRegistry([fetch], capabilities=frozenset(), vocabulary=WORDS.resolvers())
    assert registry.resolve(parse_call("fetch(the red mug)")).args == {"object": "red cup"}
    assert registry.resolve(parse_call("fetch(block 2)")).args == {"object": "block 2"}
    assert registry.resolve(parse_call('fetch("")')).args == registry.resolve(parse_call("fetch()")).args
    with pytest.raises(PlanError, match="unicorn"):
        registry.resolve(parse_call("fetch(unicorn)"))


def test_the_words_of_the_configured_house_come_from_its_scene() -> None:
    words = build_vocabulary(load(environ={}))
    assert words.surface("coffee table") == "coffee table"
    assert words.room("lounge") == "living room"
    assert {"box", "cup", "bottle"} <= set(words.thing_words())


def test_places_are_known_by_their_chinese_names_in_either_spelling() -> None:
    settings = load(environ={})
    places, words = Places(settings.places), build_vocabulary(settings)
    assert places.symbols("厨房、客厅和書房") == ("A", "B", "D")
    assert words.surface("那張桌子") == words.surface("餐桌") == "dining table"
    assert words.surface("扶手椅") == "armchair"
    assert words.surface("地上") == "floor"
    assert words.room("客厅") == "living room"
    with pytest.raises(Ambiguous, match="north chair"):
        words.surface("椅子")


def test_the_recogniser_expects_names_and_nouns_but_no_commands() -> None:
    nouns = expected_nouns(load(environ={}))
    assert {"kitchen", "red", "box", "bottle"} <= set(nouns)
    assert not {"go", "pick", "bring", "stop"} & {word for noun in nouns for word in noun.split()}
    assert len(nouns) == len(set(nouns)) <= 60
    assert "厨房" not in nouns
    assert "厨房" in expected_nouns(load(environ={}, overrides=["asr.language=zh"]))


def test_things_are_called_together_by_their_category() -> None:
    things = {"coke": "red bottle", "juice": "orange bottle", "apple": "red ball"}
    kinds = {"coke": "drinks", "juice": "drinks", "apple": "fruits"}
    words = Vocabulary(Places({}), House(things=things, categories=kinds))
    assert words.object("a fruit") == "red ball", "the only one"
    with pytest.raises(Ambiguous, match="Which drinks: coke or juice"):
        words.object("the drinks")
    assert words.of_category("snacks") == ()
