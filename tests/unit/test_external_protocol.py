"""Any bytes of a program give messages within their limits, or nothing; declarations become skills."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import asdict
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config import load
from config.schema import ExternalParameter, ExternalSkill, Place, Position
from engine.errors import PlanError, UsageError
from engine.plan import parse_call
from engine.planner.build import build_registry
from engine.robot.camera import Lens, Mount, Picture
from engine.robot.floor_map import Doorway, FloorMap, Furniture, Landmark, Room, Wall
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.sim.dimensions import ARM
from engine.skills.external.facts import arm_of, map_facts, map_of, picture_facts, picture_of
from engine.skills.external.host import external_skill
from engine.skills.external.protocol import (
    MAX_WORDS,
    Arm,
    Beep,
    Drive,
    Finished,
    Gripper,
    Light,
    Look,
    NotUnderstood,
    Relocate,
    Report,
    ScanWish,
    Speech,
    Tick,
    read,
)
from engine.skills.places import Places, UnknownPlace
from engine.skills.registry import OutOfRange, SkillRegistry
from engine.skills.units import Unit

SPOT = Position(x=0, y=0)
PLACES = Places(
    {
        "A": Place(name="kitchen", position=SPOT),
        "B": Place(name="Bed and Breakfast Room", aliases=("guest room",), position=SPOT),
        "C": Place(name="study", position=SPOT),
    }
)


def test_each_message_is_read_and_several_keep_their_order() -> None:
    said = {
        "drive": [0.3, 0, -1],
        "arm": [1, 2, 3, 4, 5],
        "speed": 2,
        "gripper": 0.5,
        "light": [300, 0, -5],
        "beep": 60,
        "say": "hello\n\x1b[2J",
        "progress": {"fraction": 7, "message": "half", "path": [[1, 2], [3, 4]]},
        "scan": True,
        "look": True,
        "relocate": {"believed": [1, 2, 0], "true": [1, 2.5, 7]},
        "tick": True,
    }
    assert read(json.dumps(said)) == (
        Drive(Twist(0.3, 0.0, -1.0)),
        Arm((1.0, 2.0, 3.0, 4.0, 5.0), 2.0),
        Gripper(0.5),
        Light((255, 0, 0)),
        Beep(5.0),
        Speech("hello [2J"),
        Report(1.0, "half", ((1.0, 2.0), (3.0, 4.0))),
        ScanWish(),
        Look(),
        Relocate(Pose(1, 2, 0), Pose(1, 2.5, wrap(7))),
        Tick(),
    )


def test_a_picture_arrives_as_it_was_but_for_millimetres() -> None:
    rng = np.random.default_rng(1)
    lens = Lens.of_view(8, 6, 1.0)
    depth = rng.uniform(0.05, 12, (6, 8)).astype(np.float32)
    depth[0, 0] = np.inf
    rgb = rng.integers(0, 256, (6, 8, 3), dtype=np.uint8)
    mount = Mount(np.eye(3)[[2, 0, 1]], np.array([0.1, 0.2, 0.3]))
    taken = Picture(1.5, rgb, depth, lens, mount, Pose(1, 2, 3))
    told = picture_of(json.loads(json.dumps(picture_facts(taken))))
    assert (told.t, told.lens, told.pose) == (taken.t, taken.lens, taken.pose)
    assert np.array_equal(told.rgb, rgb)
    assert told.depth[0, 0] == np.inf
    assert np.allclose(told.depth.ravel()[1:], depth.ravel()[1:], atol=0.00051)
    assert np.array_equal(told.mount.rotation, mount.rotation)
    assert np.array_equal(told.mount.position, mount.position)


def test_the_map_and_the_arm_arrive_as_they_were() -> None:
    occupied = np.array([[True, False], [False, True]])
    house = FloorMap(
        0.05,
        (-1.0, 2.0),
        occupied,
        (Room("hall", 0, 0, 1, 1),),
        (Furniture("table", 0, 0, 1, 1, 0.14, "low_table"),),
        (Doorway(("hall", "study"), 1.0, 2.0, 0.8),),
        (Landmark(100, 1.0, 2.0, 0.4, -1.5, 0.1),),
        (Wall(0.0, -0.05, 1.0, 0.05),),
    )
    told = map_of(json.loads(json.dumps(map_facts(house))))
    assert np.array_equal(told.occupied, occupied)
    assert (told.rooms, told.furniture, told.doors, told.tags, told.walls) == (
        house.rooms,
        house.furniture,
        house.doors,
        house.tags,
        house.walls,
    )
    assert arm_of(json.loads(json.dumps(asdict(ARM)))) == ARM


@pytest.mark.parametrize(
    "line",
    [
        "",
        "nonsense",
        "[]",
        "{}",
        "null",
        '{"tick": 1}',
        '{"look": 1}',
        '{"relocate": {"believed": [1, 2, 3]}}',
        '{"relocate": {"believed": [1, 2, 3], "true": [1, 2]}}',
        '{"drive": [1, 2]}',
        '{"drive": [1, 2, "3"]}',
        '{"drive": [true, 0, 0]}',
        '{"drive": [NaN, 0, 0]}',
        '{"drive": [1e999, 0, 0]}',
        f'{{"drive": [1{"0" * 400}, 0, 0]}}',
        '{"drive": [0.1, 0, 0], "tock": true}',
        '{"speed": 1}',
        '{"arm": [0, 0, 0, 0, 0], "speed": null}',
        '{"say": 5}',
        '{"progress": "half"}',
        '{"progress": {"path": [[1]]}}',
        '{"progress": {"path": 3}}',
        "[" * 100_000,
    ],
)
def test_what_is_no_message_does_nothing_at_all(line: str) -> None:
    with pytest.raises(NotUnderstood):
        read(line)


@given(
    st.one_of(
        st.text(),
        st.dictionaries(
            st.sampled_from(["drive", "arm", "speed", "gripper", "light", "beep", "say", "progress", "result", "tick"]),
            st.recursive(
                st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
                lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
                max_leaves=8,
            ),
            max_size=3,
        ).map(json.dumps),
    )
)
def test_any_line_gives_messages_within_limits_or_is_not_understood(line: str) -> None:
    try:
        messages = read(line)
    except NotUnderstood:
        return
    for message in messages:
        match message:
            case Drive(twist):
                assert all(map(math.isfinite, (twist.vx, twist.vy, twist.wz)))
            case Speech(text) | Report(_, text, _):
                assert text == "" or text.isprintable()
                assert len(text) <= MAX_WORDS
            case Finished(result):
                assert result.ok == (result.error_code is None)


def test_a_declaration_becomes_a_skill_that_planners_read_and_the_registry_checks() -> None:
    declaration = ExternalSkill(
        does="Look around.",
        external=("look",),
        occupies=("camera",),
        parameters={
            "radius": ExternalParameter(unit="m", min=0, max=5, default=1),
            "places": ExternalParameter(kind="places"),
        },
    )
    skill = external_skill("look", declaration)
    assert skill.signature == "look(radius m = 1, places)"
    assert (skill.summary, skill.occupies) == ("Look around.", {"camera"})
    vocabulary = {"places": lambda words: ",".join(PLACES.symbols(words))}
    registry = SkillRegistry([skill], capabilities=frozenset({"camera"}), vocabulary=vocabulary)
    assert registry.resolve(parse_call("look(50 cm, 'kitchen and study')")).args == {"radius": 0.5, "places": "A,C"}
    assert registry.resolve(parse_call("look(places=kitchen)")).args == {"radius": 1, "places": "A"}
    with pytest.raises(OutOfRange):
        registry.resolve(parse_call("look(6, A)"))
    with pytest.raises(PlanError, match="places is missing"):
        registry.resolve(parse_call("look(1)"))
    with pytest.raises(UnknownPlace, match="garden"):
        registry.resolve(parse_call("look(1, 'kitchen and garden')"))


def test_a_program_ends_quietly_when_the_engine_has_nothing_to_say() -> None:
    command = [sys.executable, "-P", "-m", "engine.skills.external.patrol"]
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=True)
    assert (ended.stdout, ended.stderr) == (b"", b"")


def test_units_of_a_declaration_are_those_of_skills() -> None:
    field = ExternalParameter.model_fields["unit"]
    declared = next(option for option in get_args(field.annotation) if option is not type(None))
    assert set(get_args(declared)) == set(get_args(Unit))


def test_an_external_skill_cannot_take_the_name_of_a_built_in_one() -> None:
    settings = load(overrides=["skills.navigation={does: x, external: [x]}"], environ={})
    with pytest.raises(UsageError, match=r"skills\.navigation: there is a built-in skill of this name"):
        build_registry(settings)


@pytest.mark.parametrize(
    ("words", "symbols"),
    [
        ("", ()),
        ("A", ("A",)),
        ("kitchen, the study", ("A", "C")),
        ("the kitchen and the guest room", ("A", "B")),
        ("kitchen, bed and breakfast room, and study", ("A", "B", "C")),
        ("C,A,zero", ("C", "A", "zero")),
    ],
)
def test_a_list_of_places_is_read_with_names_that_hold_an_and(words: str, symbols: tuple[str, ...]) -> None:
    assert PLACES.symbols(words) == symbols


@pytest.mark.parametrize("name", ["", "A B", "A=B", "9A", "A-B", "A\n"])
def test_a_declaration_names_variables_of_the_environment_and_nothing_else(name: str) -> None:
    with pytest.raises(ValueError, match="no name of a variable"):
        ExternalSkill(does="Look.", external=("look",), environment=("ROS_DOMAIN_ID", name))
