"""What the robot remembers of the things it saw: one thing stays one thing, what is gone is forgotten."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.perception.memory import Thing, WorldMemory
from engine.perception.naming import wanted
from engine.perception.sighting import Sight, Sighting
from engine.robot.camera import Lens, Mount, Picture
from engine.robot.geometry import Pose

LENS = Lens.of_view(160, 120, math.radians(48))
LOW = Mount(np.array([[0, 0, 1.0], [-1.0, 0, 0], [0, -1.0, 0]]), np.array([0.0, 0.0, 0.1]))
"""A camera 10 cm above the floor that looks straight ahead."""


def picture(t: float = 0.0, pose: Pose | None = None, depth: float = 3.0) -> Picture:
    """Nothing but a wall at this depth."""
    shape = (LENS.height, LENS.width)
    far = np.full(shape, depth, dtype=np.float32)
    return Picture(t, np.zeros((*shape, 3), dtype=np.uint8), far, LENS, LOW, pose or Pose(0, 0, 0))


def a(
    name: str, x: float, y: float = 0.0, *, sigma: float = 0.01, tag: int | None = None, complete: bool = True
) -> Sighting:
    colour, kind = name.split()
    return Sighting(
        kind,
        colour,
        (70, 50, 80, 60),
        (x, y, 0.1),
        sigma,
        (0.04, 0.04),
        x,
        0.0,
        None,
        tag,
        complete,  # type: ignore[arg-type]
    )


def saw(memory: WorldMemory, *things: Sighting, t: float = 0.0, depth: float = 3.0) -> tuple[Thing, ...]:
    return memory.update(Sight(picture(t, depth=depth), things, ()))


def test_a_thing_seen_twice_is_one_thing() -> None:
    memory = WorldMemory()
    (first,) = saw(memory, a("red box", 0.5))
    (second,) = saw(memory, a("red box", 0.53), t=1.0)
    assert first.number == second.number
    assert [thing.seen_at for thing in memory.things] == [1.0]


def test_two_alike_that_stand_apart_are_two_and_each_keeps_its_number() -> None:
    memory = WorldMemory()
    left, right = saw(memory, a("red box", 0.5, 0.08), a("red box", 0.5, -0.08))
    again = saw(memory, a("red box", 0.5, -0.07), a("red box", 0.5, 0.09), t=1.0)
    assert [thing.number for thing in again] == [right.number, left.number]


def test_things_of_other_colours_or_kinds_are_never_one() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.5))
    saw(memory, a("blue box", 0.5, 0.06), a("red cup", 0.5, -0.06), depth=0.2)
    assert {thing.name for thing in memory.things} == {"red box", "blue box", "red cup"}


def test_what_stands_on_the_same_spot_is_one_thing_and_the_closer_look_names_it() -> None:
    memory = WorldMemory()
    (far,) = saw(memory, a("grey box", 2.0, sigma=0.02))
    here = replace(a("white cup", 2.0, 0.01), range=0.5)
    (near,) = saw(memory, here, t=1.0)
    assert near.number == far.number
    assert [thing.name for thing in memory.things] == ["white cup"]


def test_a_block_is_the_same_wherever_its_tag_is_seen() -> None:
    memory = WorldMemory()
    (first,) = saw(memory, a("white block", 0.5, tag=3))
    (second,) = saw(memory, a("white block", 2.0, 1.0, tag=3), t=1.0)
    assert first.number == second.number
    assert second.position[:2] == (2.0, 1.0)


def test_a_block_keeps_its_number_while_its_tag_does_not_show() -> None:
    memory = WorldMemory()
    saw(memory, a("white block", 0.5, tag=3))
    (again,) = saw(memory, a("white box", 0.51), t=1.0)
    assert again.tag == 3
    assert memory.find(wanted("block 3")) == (again,)


def test_a_block_seen_for_the_first_time_is_no_box_that_stands_elsewhere() -> None:
    memory = WorldMemory()
    (box,) = saw(memory, a("red box", 0.5, 0.5))
    (block,) = saw(memory, a("white block", 1.5, -0.4, tag=3), t=1.0)
    assert block.number != box.number
    assert {(thing.name, thing.position[:2]) for thing in memory.things} == {
        ("red box", (0.5, 0.5)),
        ("block 3", (1.5, -0.4)),
    }


def test_a_block_is_never_beside_itself() -> None:
    """Something else looked like it, and the next look reads its number nearer to a neighbour than to where it was."""
    memory = WorldMemory()
    (block,) = saw(memory, a("white block", 0.6, 0.0, tag=3))
    (neighbour,) = saw(memory, a("white block", 0.6, 0.14), t=1.0, depth=0.3)
    assert neighbour.number != block.number
    (again,) = saw(memory, a("white block", 0.6, 0.10, tag=3), t=2.0, depth=0.3)
    assert again.number == block.number
    assert [thing.number for thing in memory.find(wanted("block 3"))] == [block.number]


def test_a_number_that_is_read_goes_before_what_stands_where_the_block_was() -> None:
    memory = WorldMemory()
    (block,) = saw(memory, a("white block", 0.6, 0.0, tag=3))
    other, again = saw(memory, a("white block", 0.6, 0.01), a("white block", 0.6, 0.08, tag=3), t=1.0)
    assert again.number == block.number != other.number
    assert [thing.position[:2] for thing in memory.find(wanted("block 3"))] == [(0.6, 0.08)]
    assert len(memory.things) == 2


def test_a_glance_from_afar_does_not_spoil_a_good_position() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.5, sigma=0.005))
    (again,) = saw(memory, a("red box", 0.54, sigma=0.04), t=1.0)
    assert again.position[0] == 0.5
    assert again.seen_at == 1.0


def test_a_thing_that_moved_is_where_it_was_last_seen() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.5, sigma=0.004))
    (again,) = saw(memory, a("red box", 0.6, sigma=0.01), t=1.0)
    assert again.position[0] == 0.6


def test_what_should_show_and_does_not_is_forgotten() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.6))
    saw(memory, t=1.0)
    assert memory.things == ()


def test_what_something_hides_is_not_forgotten() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.6))
    saw(memory, t=1.0, depth=0.4)
    assert [thing.name for thing in memory.things] == ["red box"]


@pytest.mark.parametrize(("x", "y"), [(0.6, 0.5), (-0.6, 0.0), (1.6, 0.0)], ids=["aside", "behind", "far"])
def test_what_is_out_of_sight_is_not_forgotten(x: float, y: float) -> None:
    memory = WorldMemory()
    saw(memory, a("red box", x, y))
    saw(memory, t=1.0)
    assert len(memory.things) == 1


def test_what_is_held_is_no_longer_where_it_stood_and_is_again_where_it_is_put() -> None:
    memory = WorldMemory()
    (box,) = saw(memory, a("red box", 0.5))
    memory.take(box)
    assert memory.held == box
    assert memory.find(wanted("the red box")) == ()
    memory.put((1.0, 1.0, 0.02), 5.0)
    assert memory.held is None
    (found,) = memory.find(wanted("the red box"))
    assert (found.number, found.position, found.seen_at) == (box.number, (1.0, 1.0, 0.02), 5.0)


def test_what_was_dropped_nobody_knows_where_is_nowhere() -> None:
    memory = WorldMemory()
    (box,) = saw(memory, a("red box", 0.5))
    memory.take(box)
    memory.put(None, 5.0)
    assert memory.held is None
    assert memory.things == ()


def test_the_nearest_comes_first_where_a_place_is_given() -> None:
    memory = WorldMemory()
    saw(memory, a("red box", 0.5, 0.0), a("red box", 2.5, 0.0))
    assert [thing.position[0] for thing in memory.find(wanted("a red box"), near=(2.4, 0.0))] == [2.5, 0.5]


def test_a_part_of_a_thing_does_not_change_what_it_is() -> None:
    memory = WorldMemory()
    saw(memory, a("red bottle", 0.5))
    (again,) = saw(memory, a("red thing", 0.5, complete=False), t=1.0)
    assert again.kind == "bottle"


def test_a_piece_of_a_larger_thing_at_the_pictures_edge_is_that_thing() -> None:
    memory = WorldMemory()
    (box,) = saw(memory, replace(a("red box", 0.6), size=(0.12, 0.12)))
    sliver = replace(a("red bottle", 0.63, 0.05, complete=False), size=(0.015, 0.03))
    (again,) = saw(memory, sliver, t=1.0)
    assert (again.number, again.name, again.size, again.position) == (box.number, "red box", box.size, box.position)


def test_what_has_only_been_seen_in_part_is_named_by_the_look_that_shows_more() -> None:
    memory = WorldMemory()
    (label,) = saw(memory, replace(a("white cup", 0.9, complete=False), size=(0.05, 0.07)))
    (bottle,) = saw(memory, replace(a("orange bottle", 0.91, complete=False), size=(0.05, 0.12)), t=1.0)
    assert (bottle.number, bottle.name) == (label.number, "orange bottle")


def test_pieces_of_what_is_seen_as_a_whole_are_forgotten() -> None:
    memory = WorldMemory()
    label, top = (
        replace(a("white cup", 0.8), position=(0.8, 0, 0.03)),
        replace(a("purple cup", 0.8), position=(0.8, 0, 0.11)),
    )
    saw(memory, label, top)
    whole = replace(a("purple bottle", 0.81), position=(0.81, 0, 0.07), size=(0.06, 0.144), range=1.0)
    saw(memory, whole, t=1.0)
    assert [thing.name for thing in memory.things] == ["purple bottle"]
