"""Loose things in real pictures: what they are, what colour, and where, on the floor and on low tables."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.perception.depth import distance_at, thing_in_box
from engine.perception.describe import describe
from engine.perception.looking import LOOK_POSES, look_at
from engine.perception.memory import WorldMemory
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight, Sighting
from engine.robot.geometry import Pose
from engine.skills.search import LOOK
from tests.sim.arranged import COLOURS, Arranged, Put, loose, one_of_each

HALL = Pose(0.5, 0.0, 0.0)
TABLE = Pose(-2.35, 1.9, math.pi)
"""Before the coffee table, whose top is 14 cm high."""
TOP = 0.141
KINDS = ("box", "ball", "cup", "bottle")
ROOMS = (
    (0.0, 0.0), (3.0, 0.2), (-2.3, -0.4), (-3.7, -0.8), (-3.8, 0.8), (0.3, 2.2), (1.0, 2.3), (3.2, 1.8), (0.2, -2.2),
    (2.0, -1.7),
)  # fmt: skip


@pytest.fixture(scope="module")
def stage() -> Arranged:
    return Arranged(one_of_each() | {"red box 2": loose("box", "red"), "small red box": loose("box", "red", scale=0.7)})


def seen(stage: Arranged, things: list[Put], pose: Pose = HALL, look: str = "AHEAD") -> Sight:
    return perceive(stage.look(things, pose, LOOK_POSES[look].joints), stage.map)  # type: ignore[index]


def only(sight: Sight) -> Sighting:
    assert len(sight.objects) == 1, [thing.name for thing in sight.objects]
    return sight.objects[0]


def assert_is(stage: Arranged, thing: Put, found: Sighting) -> None:
    """Right kind, colour, place, surface and height."""
    truth = stage.objects[thing.name]
    middle = np.array(stage.middle(thing))
    assert found.kind == truth.kind
    assert found.colour == truth.colour
    assert math.dist(found.position[:2], middle[:2]) < 3 * found.sigma < 0.06
    assert found.surface == pytest.approx(thing.z, abs=0.01)
    assert found.size[1] == pytest.approx(truth.tall, rel=0.3)


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_and_colour_is_recognised_on_the_floor(stage: Arranged, kind: str, colour: str) -> None:
    for away in (0.35, 0.8, 1.4):
        thing = Put(f"{colour} {kind}", HALL.x + away, 0.07, yaw=0.4)
        picture = stage.look([thing], HALL, look_at(away).joints)
        assert_is(stage, thing, only(perceive(picture, stage.map)))


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_recognised_on_a_low_table(stage: Arranged, kind: str) -> None:
    for colour in ("red", "blue", "white", "grey", "orange"):
        thing = Put(f"{colour} {kind}", -3.0, 1.95, TOP, yaw=0.7)
        assert_is(stage, thing, only(seen(stage, [thing], TABLE)))


def test_a_tag_makes_a_block_of_what_carries_it(stage: Arranged) -> None:
    thing = Put("block 2", HALL.x + 0.35, 0.0, yaw=0.3)
    found = only(seen(stage, [thing], look="DOWN"))
    assert (found.kind, found.tag) == ("block", 2)
    assert found.name == "block 2"


def test_the_turn_of_a_box_shows(stage: Arranged) -> None:
    for degrees in (0, 20, 45, 70):
        found = only(seen(stage, [Put("green box", HALL.x + 0.5, 0.0, yaw=math.radians(degrees))]))
        assert found.yaw is not None
        off = (found.yaw - math.radians(degrees) + math.pi / 4) % (math.pi / 2) - math.pi / 4
        assert abs(off) < math.radians(6)


def test_a_block_whose_tag_is_too_far_to_read_is_still_no_plain_box(stage: Arranged) -> None:
    found = only(seen(stage, [Put("block 2", HALL.x + 0.8, 0.0, yaw=0.3)]))
    assert (found.kind, found.tag) == ("block", None)
    assert only(seen(stage, [Put("grey box", HALL.x + 0.8, 0.0, yaw=0.3)])).name == "grey box"


def test_a_thing_in_the_distance_is_less_certain(stage: Arranged) -> None:
    near = only(seen(stage, [Put("red cup", HALL.x + 0.6, 0.0)]))
    far = only(seen(stage, [Put("red cup", HALL.x + 1.9, 0.0)], look="FAR"))
    assert far.sigma > 1.5 * near.sigma


def test_nothing_is_seen_in_empty_rooms_even_where_the_robot_errs_about_its_place(stage: Arranged) -> None:
    looks = list(LOOK_POSES.values())
    seen_there = []
    for number, (x, y) in enumerate(ROOMS):
        for heading in range(12):
            pose = Pose(x, y, math.radians(30 * heading))
            side = 1 if heading % 2 else -1
            believed = Pose(x + 0.035 * side, y - 0.035, pose.yaw + math.radians(3) * side)
            picture = stage.look((), pose, looks[(number + heading) % 3].joints, believed)
            sight = perceive(picture, stage.map)
            seen_there += [(x, y, heading, thing) for thing in sight.objects if thing.kind != "person"]
    assert not seen_there


def test_the_belief_that_is_off_shifts_what_is_seen_and_loses_nothing(stage: Arranged) -> None:
    thing = Put("blue cup", -3.0, 1.95, TOP)
    believed = Pose(TABLE.x + 0.05, TABLE.y, TABLE.yaw + math.radians(3))
    picture = stage.look([thing], TABLE, LOOK_POSES["AHEAD"].joints, believed)
    found = only(perceive(picture, stage.map))
    assert found.name == "blue cup"
    true = picture.from_map(np.array([found.position]))[0]
    assert true[0] == pytest.approx(0.65, abs=0.01)
    assert true[1] == pytest.approx(-0.05, abs=0.01)


def test_touching_things_of_two_colours_are_two(stage: Arranged) -> None:
    pair = [Put("red box", HALL.x + 0.6, 0.02), Put("blue box", HALL.x + 0.6, -0.02)]
    assert {thing.name for thing in seen(stage, pair).objects} == {"red box", "blue box"}


def test_things_of_one_colour_one_behind_the_other_are_two(stage: Arranged) -> None:
    pair = [Put("red box", HALL.x + 0.5, 0.0), Put("red cup", HALL.x + 0.7, 0.01)]
    assert {thing.name for thing in seen(stage, pair).objects} == {"red box", "red cup"}


def test_a_box_on_a_box_stands_on_it(stage: Arranged) -> None:
    pair = [Put("green box", HALL.x + 0.6, 0.0), Put("yellow box", HALL.x + 0.6, 0.0, 0.04)]
    surfaces = {thing.name: thing.surface for thing in seen(stage, pair).objects}
    assert surfaces == {"green box": pytest.approx(0, abs=0.01), "yellow box": pytest.approx(0.04, abs=0.01)}


def test_what_a_finger_hides_in_part_is_not_told_to_be_something_else(stage: Arranged) -> None:
    behind = [(0.3, -0.04), (0.3, 0.0), (0.3, 0.04), (0.36, 0.1), (0.393, -0.135), (0.42, 0.12)]
    for colour in ("blue", "red"):
        for away, side in behind:
            picture = stage.look([Put(f"{colour} bottle", HALL.x + away, side)], HALL, LOOK)
            sure = {thing.name for thing in perceive(picture, stage.map).objects if thing.complete}
            assert sure <= {f"{colour} bottle"}, (away, side)


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (1, 2)])
def test_a_look_past_a_finger_neither_undoes_a_better_one_nor_stands_against_it(
    stage: Arranged, order: tuple[int, ...]
) -> None:
    thing = Put("blue bottle", HALL.x + 0.3, 0.0)
    free, behind_fingers, afar = HALL.x - 0.15, HALL.x, HALL.x - 0.4
    memory = WorldMemory()
    for x in ((free, behind_fingers, afar)[look] for look in order):
        memory.update(perceive(stage.look([thing], Pose(x, 0.0, 0.0), LOOK), stage.map))
    assert [remembered.name for remembered in memory.things] == ["blue bottle"]


def test_what_the_edge_cuts_off_is_not_complete(stage: Arranged) -> None:
    cut = only(seen(stage, [Put("red bottle", HALL.x + 0.6, 0.41)]))
    assert not cut.complete
    assert only(seen(stage, [Put("red bottle", HALL.x + 0.6, 0.2)])).complete


def test_white_on_white_tiles_and_grey_by_a_wall_are_seen_by_depth(stage: Arranged) -> None:
    kitchen = Pose(0.3, 2.2, 0.0)
    assert only(seen(stage, [Put("white box", 0.9, 2.2)], kitchen)).name == "white box"
    assert only(seen(stage, [Put("grey cup", 1.66, 2.2)], Pose(0.9, 2.2, 0.0))).name == "grey cup"


def test_a_box_in_the_picture_means_the_thing_in_it(stage: Arranged) -> None:
    sight = seen(stage, [Put("red box", HALL.x + 0.6, 0.12), Put("blue ball", HALL.x + 0.6, -0.12)])
    ball = next(thing for thing in sight.objects if thing.kind == "ball")
    left, top, right, bottom = ball.box
    assert thing_in_box(sight, right + 2, bottom + 2, left - 2, top - 2) is ball
    assert thing_in_box(sight, 0, 0, 160, 120) is None
    assert thing_in_box(sight, 0, 0, 5, 5) is None


def test_the_distance_at_a_pixel_is_that_of_what_it_shows(stage: Arranged) -> None:
    sight = seen(stage, [Put("red box", HALL.x + 0.6, 0.0)])
    left, top, right, bottom = only(sight).box
    told = distance_at(sight.picture, (left + right) / 2, (top + bottom) / 2)
    assert told == pytest.approx(only(sight).range, abs=0.03)
    assert distance_at(sight.picture, -1, 5) is None


def test_what_is_seen_is_told_in_words(stage: Arranged) -> None:
    assert describe(seen(stage, []), stage.map) == "I see nothing but the room."
    hall = [Put("red box", HALL.x + 0.5, 0.0), Put("blue cup", HALL.x + 0.6, 0.16), Put("block 3", HALL.x + 0.4, -0.1)]
    assert describe(seen(stage, hall, look="DOWN"), stage.map) == (
        "I see tag block 3 0.4 m to the right on the floor, a red box 0.5 m ahead on the floor, and a blue cup 0.6 m to"
        " the left on the floor."
    )
    table = [Put("red box", -3.0, 1.87, TOP), Put("red box 2", -3.0, 1.93, TOP)]
    assert describe(seen(stage, table, TABLE), stage.map) == "I see two red boxes 0.7 m ahead on the coffee table."
