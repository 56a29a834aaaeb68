"""People in real pictures: where they are, how they hold themselves, what they do with their arms, what they wear."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from engine.perception.gestures import gesture_of
from engine.perception.memory import WorldMemory
from engine.perception.people import Looks, PeopleMemory
from engine.perception.perceive import perceive
from engine.perception.person import find_people
from engine.perception.sighting import Figure, Sighting
from engine.robot.arm import ARM_INITIAL
from engine.robot.geometry import Pose
from engine.robot.sim.dimensions import ARM
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene_parts import Person
from engine.skills.servo import gaze
from tests.sim.eye import Eye
from tests.sim.people_room import Case, Onlooker
from tests.sim.rig import flat
from tests.sim.test_marks import LEVEL

SIDES = (0, 90, 180, 270)


def seen(case: Case, away: float, side: float = 0.0, *, width: int = 160) -> Figure:
    figure = one(Onlooker(case, width=width), away, side).figure
    assert figure is not None
    return figure


def one(onlooker: Onlooker, away: float, side: float = 0.0, t: float = 0.0) -> Sighting:
    [person] = find_people(onlooker.look(away, side, t=t, error=(0.02, -0.02, 0.01)), onlooker.map)
    return person


@pytest.mark.parametrize("away", [1.5, 2.5, 4.0])
@pytest.mark.parametrize(
    "case",
    [Case(), Case(height=1.85), Case("sitting", "sofa"), Case("sitting", "armchair"), Case("sitting", "chair")],
    ids=lambda case: f"{case.posture} {case.on} {case.height}",
)
def test_the_posture_and_the_place_are_seen_from_all_sides(case: Case, away: float) -> None:
    onlooker = Onlooker(case)
    for side in SIDES:
        person = one(onlooker, away, side)
        assert person.figure is not None
        assert (person.figure.posture, person.figure.shirt) == (case.posture, "red"), side
        assert math.dist(person.position[:2], case.at) < 0.15


@pytest.mark.parametrize("shows_to", [1.0, 1.15, 1.3])
def test_whose_head_and_shoulders_something_hides_is_no_child(shows_to: float) -> None:
    onlooker = Onlooker(Case())
    picture = onlooker.look(2.5)
    above = np.isfinite(picture.depth) & (picture.depth > 0)
    above[above] = picture.points(above)[:, 2] > shows_to
    depth = np.where(above, np.float32(1.0), picture.depth)
    [person] = find_people(replace(picture, depth=depth), onlooker.map)
    assert person.figure is not None
    assert (person.figure.shirt, person.figure.trousers) == ("red", "blue")


@pytest.mark.parametrize("away", [1.5, 2.5, 4.0])
@pytest.mark.parametrize(("on", "sides"), [("bed", (90, 270)), ("sofa", (90,))])
def test_whoever_lies_is_seen_from_aside(on: str, sides: tuple[int, ...], away: float) -> None:
    case = Case("lying", on)
    onlooker = Onlooker(case)
    for side in sides:
        person = one(onlooker, away, side)
        assert person.figure == Figure("lying", None, "red", "blue")
        assert math.dist(person.position[:2], case.at) < 0.3
        assert person.surface == pytest.approx(0.42, abs=0.06)


@pytest.mark.parametrize("away", [2.0, 3.0])
def test_whoever_lies_on_the_floor_is_seen_from_aside(away: float) -> None:
    onlooker = Onlooker(Case("lying"))
    for side in (60, 90, 120, 240, 270, 300):
        [person] = find_people(onlooker.look(away, side), onlooker.map)
        assert person.figure is not None
        assert (person.figure.posture, person.figure.shirt, person.figure.trousers) == ("lying", "red", "blue"), side


@pytest.mark.parametrize("shirt", ["red", "white"])
def test_whoever_lies_on_the_floor_is_seen_from_their_head_and_their_feet(shirt: str) -> None:
    onlooker = Onlooker(Case("lying", shirt=shirt))
    for side in range(0, 360, 15):
        [person] = find_people(onlooker.look(2.5, side), onlooker.map)
        assert person.figure is not None
        assert (person.figure.posture, person.figure.shirt) in {("lying", shirt), ("lying", None)}, side


@pytest.mark.parametrize(("shirt", "trousers"), [("white", "black"), ("yellow", "purple"), ("grey", "orange"),
                                                 ("green", "red"), ("black", "white"), ("orange", "grey")])  # fmt: skip
def test_shirt_and_trousers_are_told_apart(shirt: str, trousers: str) -> None:
    for case in (Case(), Case("sitting", "chair"), Case("lying", "bed")):
        figure = seen(replace(case, shirt=shirt, trousers=trousers), 2.2, 90.0 if case.posture == "lying" else 20.0)
        assert (figure.shirt, figure.trousers) == (shirt, trousers), case.posture


@pytest.mark.parametrize("away", [1.5, 2.2, 3.5])
@pytest.mark.parametrize("case", [Case(), Case("sitting", "chair"), Case("sitting", "sofa")],
                         ids=lambda case: f"{case.posture} {case.on}")  # fmt: skip
def test_an_arm_is_seen_and_whose_left_it_is(case: Case, away: float) -> None:
    gestures = ("raising the left arm", "raising the right arm", "pointing to the left", "pointing to the right", None)
    for gesture in gestures:
        for side in (0.0, 25.0):
            figure = seen(replace(case, gesture=gesture), away, side)
            assert figure.gesture == gesture, side
            assert (figure.hand is None) == (gesture is None)


def test_from_behind_left_and_right_are_theirs_too() -> None:
    for gesture in ("raising the left arm", "raising the right arm", "pointing to the left", "pointing to the right"):
        assert seen(Case(gesture=gesture), 2.5, 180.0).gesture == gesture


@pytest.mark.parametrize("case", [Case(gesture="waving"), Case("sitting", "sofa", "waving")],
                         ids=lambda case: case.posture)  # fmt: skip
def test_waving_is_an_arm_that_is_up_and_moves(case: Case) -> None:
    onlooker = Onlooker(case)
    for away in (1.5, 2.5, 3.5):
        for start in (0.0, 0.1, 0.3):
            looks = [one(onlooker, away, 10.0, start + 0.35 * i) for i in range(3)]
            assert gesture_of(looks) == "waving", (away, start)
    still = Onlooker(replace(case, gesture="raising the right arm"))
    assert gesture_of([one(still, 2.5, 10.0, 0.35 * i) for i in range(3)]) == "raising the right arm"


@pytest.mark.parametrize("beside", [(0.6, 0.0), (0.75, 0.0), (0.3, -0.8), (0.5, -0.8)])
def test_two_who_are_close_together_are_two(beside: tuple[float, float]) -> None:
    other = Person(path=(beside,), facing=90, height=1.65, shirt="green", trousers="grey")
    onlooker = Onlooker(Case(), other)
    for away in (2.0, 3.0):
        found = find_people(onlooker.look(away), onlooker.map)
        assert {(p.figure.shirt, p.figure.posture) for p in found if p.figure} == {
            ("red", "standing"), ("green", "standing"),
        }, away  # fmt: skip


def test_two_on_a_sofa_are_two_and_one_of_them_raises_an_arm() -> None:
    other = Person(path=((0.65, 0.0),), facing=90, height=1.65, shirt="green", trousers="grey", posture="sitting",
                   seat=0.38, gesture="raising the left arm")  # fmt: skip
    onlooker = Onlooker(Case("sitting", "sofa"), other)
    for away, side in itertools.product((2.0, 3.0), (0, 30)):
        found = find_people(onlooker.look(away, side), onlooker.map)
        told = {
            person.figure.shirt: (person.figure.posture, person.figure.gesture) for person in found if person.figure
        }
        assert told == {"red": ("sitting", None), "green": ("sitting", "raising the left arm")}, (away, side)


def test_where_somebody_looks_is_seen_at_their_head_or_knees() -> None:
    for case in (Case(), Case("sitting", "armchair")):
        onlooker = Onlooker(case)
        for side in SIDES:
            figure = one(onlooker, 2.2, side).figure
            assert figure is not None
            assert figure.facing is not None
            assert abs(math.remainder(figure.facing - math.radians(case.facing), math.tau)) < math.radians(50), side


def test_what_the_picture_does_not_show_is_not_told() -> None:
    eye = Eye("family")
    x, y = eye.scene.people["William"].path[0]
    person, *_ = find_people(eye.look(Pose(x + 1.2, y, math.pi), ARM_INITIAL), floor_map(eye.scene))
    assert person.figure is not None
    assert (person.figure.shirt, person.figure.trousers, person.figure.gesture) == (None, "blue", None)
    assert not person.complete


@pytest.mark.parametrize("width", [160, 320, 640])
def test_larger_pictures_show_the_same(width: int) -> None:
    figure = seen(Case("sitting", "sofa", "raising the left arm"), 2.5, width=width)
    assert (figure.posture, figure.gesture, figure.shirt) == ("sitting", "raising the left arm", "red")


def test_a_family_is_known_by_what_they_wear() -> None:
    eye = Eye("family")
    known = {n: Looks(p.shirt, p.trousers) for n, p in eye.scene.people.items() if p.known}  # type: ignore[arg-type]
    memory, house = WorldMemory(PeopleMemory(known)), floor_map(eye.scene)
    for name, (away, side) in {
        "William": (1.4, 0),
        "Anna": (1.5, 200),
        "Elizabeth": (2.2, 20),
        "visitor": (1.8, 180),
    }.items():
        x, y = eye.scene.people[name].path[0]
        pose = Pose(
            x + away * math.cos(math.radians(side)), y + away * math.sin(math.radians(side)), math.radians(side + 180)
        )
        memory.update(perceive(eye.look(pose, gaze(ARM, (away, 0.0, 0.8))), house))
        nearest, *_ = memory.people.find(lambda person: True, near=(x, y))
        assert nearest.name == (None if name == "visitor" else name)
        assert nearest.distance_to(x, y) < 0.15
    assert {p.name: p.posture for p in memory.people.everybody} == {
        "William": "standing", "Anna": "standing", "Elizabeth": "sitting", None: "standing",
    }  # fmt: skip


def test_furniture_that_was_moved_and_cartons_and_plants_are_nobody() -> None:
    pieces = dict(flat().furniture)
    moved = {"palm": (-3.0, 0.2), "carton": (-3.0, 0.2), "west chair": (-3.0, 0.2), "stool": (-3.0, 0.2)}
    for name, at in moved.items():
        scene = flat().model_copy(
            update={"furniture": {**pieces, name: pieces[name].model_copy(update={"moved": at})}, "people": {}}
        )
        eye, house = Eye(scene), floor_map(scene)
        for away in (1.2, 1.8, 2.4):
            for joints in (ARM_INITIAL, LEVEL):
                assert find_people(eye.look(Pose(-3.0 + away, 0.1, math.pi), joints), house) == (), (name, away)


def test_seats_and_beds_that_nobody_is_on_are_nobody() -> None:
    for piece, (x, y), away in (("sofa", (-4.4, 1.9), 2.0), ("bed", (3.3, -3.0), 2.2), ("armchair", (-2.6, 3.4), 1.8)):
        eye = Eye(flat().model_copy(update={"people": {}}))
        assert piece in eye.scene.furniture
        side = {"sofa": 0.0, "bed": 180.0, "armchair": 270.0}[piece]
        pose = Pose(
            x + away * math.cos(math.radians(side)), y + away * math.sin(math.radians(side)), math.radians(side + 180)
        )
        believed = Pose(pose.x + 0.03, pose.y - 0.03, pose.yaw + 0.02)
        for joints in (ARM_INITIAL, LEVEL, gaze(ARM, (away, 0.0, 0.8))):
            assert find_people(eye.look(pose, joints, believed), floor_map(eye.scene)) == ()
