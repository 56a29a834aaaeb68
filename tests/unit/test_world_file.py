"""A world file replaces the words of the scene for planning; whoever wrote it, however it is shaped."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from config import load
from config.schema import Profile, Settings
from engine.errors import ExitCode, PlanError
from engine.events import from_json
from engine.perception.naming import UnknownObject
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.request import NoPlan, PlanRequest
from engine.planner.worlds.world import World, WorldVocabulary
from engine.planner.worlds.world_file import WorldError, load_world, read_world
from engine.skills.places import UnknownPlace
from engine.skills.vocabulary import Ambiguous
from tests.eval.commands import world_file
from tui.cli import main

FAMILY = load_world(world_file("family"))


def words(raw: Any) -> WorldVocabulary:
    return read_world(raw, "it").vocabulary()


def settings() -> Settings:
    """With phrases only."""
    found = load(environ={})
    planner = found.planner.model_copy(update={"profile": "none"})
    return found.model_copy(update={"planner": planner, "profiles": {"none": Profile()}})


def planned(world: World, text: str) -> Plan | NoPlan:
    return asyncio.run(build_planner(settings(), world=world).plan(PlanRequest(text)))


def actions(world: World, text: str) -> list[str]:
    found = planned(world, text)
    assert isinstance(found, Plan), found
    return [
        f"{action.name}({', '.join(str(value) for value in action.args.values() if value)})" for action in found.actions
    ]


@pytest.mark.parametrize(
    "places",
    [
        ["kitchen", "living_room"],
        [{"name": "kitchen"}, {"name": "living_room", "aliases": ["lounge"], "kind": "room"}],
        {"kitchen": None, "living_room": ["lounge"]},
        {"kitchen": {}, "living_room": {"aliases": "lounge"}},
        ["kitchen", {"living_room": ["lounge"]}],
        [{"id": "kitchen"}, {"id": "living_room", "name": "living room", "position": [1, 2]}],
    ],
)
def test_places_may_have_any_common_shape(places: Any) -> None:
    found = words({"places": places})
    assert found.place("the living room") == found.place("living_room") == "living_room"
    assert found.surface("Kitchen") == "kitchen"
    assert found.room("kitchen") == "kitchen"
    if "lounge" in json.dumps(places):
        assert found.place("lounge") == "living_room"


@pytest.mark.parametrize(
    "objects",
    [
        {"fruit": ["apple", "banana"]},
        {"apple": {"category": "fruit"}, "banana": {"category": "fruit"}},
        [{"name": "apple", "category": "fruit"}, {"name": "banana", "kind": "fruit"}],
        {"fruit": {"apple": {}, "banana": {"aliases": ["plantain"]}}},
        {"fruit": [{"name": "apple"}, {"name": "banana", "aliases": ["plantain"]}]},
    ],
)
def test_objects_may_have_any_common_shape(objects: Any) -> None:
    found = words({"places": ["kitchen"], "objects": objects})
    assert found.object("the apple") == "apple"
    assert found.object("bananas") == "banana"
    assert found.object("a fruit") in ("apple", "banana")
    with pytest.raises(Ambiguous, match="apple or banana"):
        found.object("the fruit")


def test_things_of_one_name_are_told_apart_by_their_colours() -> None:
    boxes = [{"name": "box", "color": "red"}, {"name": "box", "color": "blue"}]
    found = words({"places": ["kitchen"], "objects": boxes})
    assert found.object("the blue box") == "blue box"
    with pytest.raises(Ambiguous):
        found.object("the box")
    with pytest.raises(WorldError, match="there twice"):
        words({"places": ["kitchen"], "objects": ["box", "box"]})


def test_lists_under_names_are_other_names_where_some_are_empty() -> None:
    found = words({"places": ["kitchen"], "objects": {"cup": ["beaker"], "book": []}})
    assert found.object("beaker") == "cup"
    assert found.object("the book") == "book"


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("red box", "red_box"), ("the red_box", "red_box"), ("mug", "cup"), ("blue mug", "cup"), ("bear", "teddy"),
        ("toy car", "toy_car"), ("car", "toy_car"), ("any toy", "teddy"), ("remote control", "remote"),
    ],
)  # fmt: skip
def test_a_thing_is_found_by_its_names_and_with_or_without_a_colour(said: str, meant: str) -> None:
    assert FAMILY.vocabulary().object(said) == meant


@pytest.mark.parametrize("said", ["box", "the toy", "dish", "thing"])
def test_a_word_for_several_things_is_asked_about(said: str) -> None:
    with pytest.raises(Ambiguous) as doubt:
        FAMILY.vocabulary().object(said)
    assert doubt.value.exit_code == ExitCode.CLARIFY


@pytest.mark.parametrize("said", ["violin", "green box", "", "apple pie"])
def test_an_unknown_thing_is_told_what_there_is(said: str) -> None:
    with pytest.raises(UnknownObject) as unknown:
        FAMILY.vocabulary().object(said)
    assert "teddy" in str(unknown.value)


def test_people_and_the_speaker_are_places() -> None:
    found = FAMILY.vocabulary()
    assert found.place("granny") == found.surface("Grandma") == "Grandma"
    assert found.place("me") == found.place("here") == found.place("zero") == "user"
    assert found.surface("the bin") == "trash_bin"
    with pytest.raises(UnknownPlace, match=r"attic.*nursery.*Anna"):
        found.place("attic")
    assert words({"places": ["kitchen"]}).place("zero") == "zero"


def test_a_person_who_is_a_place_too_is_one() -> None:
    world = read_world({"places": ["kitchen", "user"], "people": ["user", "Anna"]}, "it")
    assert list(world.places) == ["kitchen", "user", "Anna"]


def test_two_places_of_a_name_are_asked_about() -> None:
    found = words({"places": ["coffee table", "kitchen table"]})
    assert found.place("coffee table") == "coffee table"
    with pytest.raises(Ambiguous, match="coffee table or kitchen table"):
        found.surface("the table")


def test_what_is_not_known_is_left_aside_with_a_warning() -> None:
    warnings: list[str] = []
    read_world({"places": [{"name": "kitchen", "smell": "fine"}], "weather": "good"}, "it", warnings.append)
    assert len(warnings) == 2
    assert "weather" in warnings[0]
    assert "smell" in warnings[1]


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (None, "mapping with places"), (["kitchen"], "mapping with places"), ({}, "nowhere to go"),
        ({"places": "kitchen"}, "must be a list or a mapping"), ({"places": [["kitchen"]]}, "no name"),
        ({"places": [{"aliases": ["x"], "kind": "room"}]}, "has no name"), ({"places": ["a", "A"]}, "there twice"),
        ({"places": {"kitchen": 3.5}}, "neither a list of other names"), ({"places": ["zero"]}, "remembers"),
        ({"places": {"kitchen": [1, 2]}}, "list of texts"), ({"places": ["x"], "objects": 5}, "must be a list"),
        ({"places": [f"p{i}" for i in range(501)]}, "at most"),
    ],
)  # fmt: skip
def test_nonsense_is_an_error_that_says_what_is_wrong(raw: Any, says: str) -> None:
    with pytest.raises(WorldError, match=says) as wrong:
        read_world(raw, "it")
    assert wrong.value.exit_code == ExitCode.USAGE


def test_a_file_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="Cannot read"):
        load_world(tmp_path / "absent.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("places: [kitchen")
    with pytest.raises(WorldError, match="neither YAML nor JSON"):
        load_world(broken)


def test_plans_are_made_in_the_names_of_the_file() -> None:
    assert actions(FAMILY, "bring the teddy to Anna") == ["carry(teddy, Anna)"]
    assert actions(FAMILY, "go to the lounge and beep") == ["navigation(living_room)", "beep(0.2)"]
    assert actions(FAMILY, "bring the book to me") == ["carry(book, user)"]
    assert actions(FAMILY, "put the mug on the kitchen table") == ["carry(cup, kitchen_table)"]
    assert actions(FAMILY, "throw the red box in the bin")[0] == "pick_object(red_box)"


def test_any_of_several_will_do_where_one_is_asked_for() -> None:
    world = load_world(world_file("shop"))
    assert actions(world, "bring a drink to the till") == ["carry(water bottle, checkout)"]
    doubt = planned(world, "bring the drink to the till")
    assert isinstance(doubt, NoPlan)
    assert "lemonade" in doubt.answer


def test_what_the_world_does_not_have_is_told_and_what_is_ambiguous_asked() -> None:
    doubt = planned(FAMILY, "put the box on the sofa")
    assert isinstance(doubt, NoPlan)
    assert doubt.exit_code == ExitCode.CLARIFY
    absent = planned(FAMILY, "go to the attic")
    assert isinstance(absent, NoPlan)
    assert absent.exit_code == ExitCode.FAILED


def test_the_places_of_the_scene_are_not_there(tmp_path: Path) -> None:
    file = tmp_path / "world.json"
    file.write_text(json.dumps({"places": ["cellar"], "objects": ["lamp"]}))
    world = load_world(file)
    assert actions(world, "go to the cellar") == ["navigation(cellar)"]
    assert isinstance(planned(world, "go to the bedroom"), NoPlan)


def test_the_command_answers_every_line_of_stdin(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "lines.txt"
    file.write_text("go to the kitchen\ngo to the attic\nbring the box to Ben\n")
    with file.open() as stdin:
        monkeypatch.setattr("sys.stdin", stdin)
        code = main(["plan", "--world", str(world_file("family")), "--json", "-"])
    printed = capsys.readouterr().out.splitlines()
    kinds = [kind for line in printed if (kind := from_json(line).body.kind) != "meaning.read"]
    assert kinds == ["plan.made", "plan.rejected", "clarification.asked"]
    assert code == ExitCode.FAILED


def test_words_of_the_world_are_all_that_templates_get() -> None:
    found = FAMILY.vocabulary()
    assert {"toy chest", "toy box", "floor"} <= set(found.surfaces())
    assert {"teddy bear", "toy"} <= set(found.things())
    assert found.words_for("Grandma")[0] == "Grandma"
    assert "nana" in found.words_for("Grandma")
    with pytest.raises(PlanError):
        found.room("user")
