"""Things that people hold, take from the gripper and put into it, by real contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.robot.arm import Joints
from engine.robot.geometry import ZERO, Twist
from engine.robot.host.memory import STATE
from engine.robot.sim.dimensions import ARM
from engine.robot.sim.scene import Scene
from engine.robot.sim.world import World
from tests.sim.inhand import pressed_by
from tests.sim.rig import drive, settings
from tests.sim.test_people_hearing import HALL, company_of, said

OUT: Joints | None = ARM.reach((0.3, 0.0, 0.3), (math.pi / 2,))
"""The hand before the hull, 0.3 m above the floor, pointing ahead."""
CUP = {"kind": "cup", "at": [3.5, 2], "size": 0.08, "colour": "blue", "mass": 0.08}
BOX = {"kind": "box", "at": [3.0, 2], "size": 0.04, "colour": "red"}
BOTTLE = {"kind": "bottle", "at": [2.5, 2], "size": 0.15, "colour": "green", "mass": 0.15}


def with_things(**people: dict[str, Any]) -> Scene:
    objects = {"cup": CUP, "red box": BOX, "bottle": BOTTLE}
    return Scene.model_validate({**HALL, "objects": objects, "people": people})


def hall_with_things(**people: dict[str, Any]) -> World:
    """A robot with its hand out before it, open, and people who may hold things."""
    world = World(with_things(**people), settings())
    assert OUT is not None
    world.move_arm(OUT, 2.0)
    world.grip(1.0)
    drive(world, ZERO, 2.0)
    company_of(world).news()
    return world


def middle(world: World, thing: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    found: np.ndarray[Any, np.dtype[np.float64]] = world.data.body(thing).xpos.copy()
    return found


def grip_point(world: World) -> np.ndarray[Any, np.dtype[np.float64]]:
    found: np.ndarray[Any, np.dtype[np.float64]] = world.data.site("grip").xpos.copy()
    return found


def test_what_somebody_holds_stays_in_their_hand_wherever_they_walk() -> None:
    world = hall_with_things(eve={"path": [[1, -2], [1, 2]], "speed": 0.5, "holds": "cup"})
    for _ in range(20):
        drive(world, ZERO, 0.2)
        eve = world.data.body("eve").xpos
        assert math.dist(middle(world, "cup")[:2], eve[:2]) == pytest.approx(0.4, abs=0.15)
        assert middle(world, "cup")[2] == pytest.approx(0.85, abs=0.15)


@pytest.mark.parametrize("thing", ["cup", "red box", "bottle"])
@pytest.mark.parametrize("person", [{}, {"posture": "sitting", "seat": 0.42}], ids=["standing", "sitting"])
def test_who_is_asked_puts_the_thing_between_the_fingers_and_holds_it_until_they_close(
    thing: str, person: dict[str, Any]
) -> None:
    world = hall_with_things(eve={"path": [[1, 0]], "facing": 180, "holds": thing, **person})
    news = said(world, f"Please give me the {thing}.", 1.5)
    assert [(n.does, n.text) for n in news[1:]] == [("gives", thing)]
    assert math.dist(middle(world, thing)[:2], grip_point(world)[:2]) < 0.01
    assert middle(world, thing)[2] < grip_point(world)[2]
    world.grip(0.0)
    drive(world, ZERO, 1.0)
    assert pressed_by(world, thing) > 1.0
    before = grip_point(world) - middle(world, thing)
    drive(world, Twist(-0.3), 2.0)
    assert world.true_pose.x < -0.4
    assert grip_point(world) - middle(world, thing) == pytest.approx(before, abs=0.02), "the robot has it"
    assert company_of(world).news() == ()


def test_a_thing_is_given_when_the_gripper_comes_near_and_is_open() -> None:
    world = hall_with_things(eve={"path": [[1.8, 0]], "facing": 180, "holds": "cup"})
    world.grip(0.0)
    drive(world, ZERO, 1.0)
    assert [n.does for n in said(world, "Please give me the cup.", 2.0)] == ["hears"]
    drive(world, Twist(0.25), 3.0)
    assert company_of(world).news() == ()
    world.grip(1.0)
    drive(world, ZERO, 1.0)
    assert [n.does for n in company_of(world).news()] == ["gives"]


def test_a_thing_falls_when_the_fingers_never_close() -> None:
    world = hall_with_things(eve={"path": [[1, 0]], "holds": "red box"})
    said(world, "Please give me the box.", 5.0)
    assert middle(world, "red box")[2] > 0.2
    drive(world, ZERO, 2.0)
    assert middle(world, "red box")[2] < 0.01


def held_by_the_robot(thing: str, **people: dict[str, Any]) -> World:
    """It has just been given this, by somebody behind it who goes away."""
    world = hall_with_things(giver={"path": [[0.2, -0.7]], "holds": thing}, **people)
    said(world, f"giver, please give me the {thing}.", 1.5)
    world.grip(0.0)
    drive(world, ZERO, 1.0)
    assert pressed_by(world, thing) > 1.0
    company_of(world).news()
    return world


@pytest.mark.parametrize("person", [{}, {"posture": "sitting", "seat": 0.42}], ids=["standing", "sitting"])
def test_who_is_asked_takes_the_thing_as_soon_as_the_gripper_opens(person: dict[str, Any]) -> None:
    world = held_by_the_robot("cup", ann={"path": [[1, 0]], "facing": 180, **person})
    assert [n.does for n in said(world, "Ann, please take the cup.", 1.1)] == ["hears"]
    world.grip(1.0)
    drive(world, ZERO, 0.5)
    assert [(n.who, n.does, n.text) for n in company_of(world).news()] == [("ann", "takes", "cup")]
    drive(world, Twist(-0.3), 2.0)
    assert math.dist(middle(world, "cup")[:2], (1, 0)) < 0.6
    assert middle(world, "cup")[2] > 0.4


def test_who_is_asked_pulls_when_the_gripper_stays_closed() -> None:
    world = held_by_the_robot("bottle", ann={"path": [[1, 0]], "facing": 180})
    news = said(world, "Ann, please take the bottle.", 3.0)
    assert [n.does for n in news] == ["hears", "takes"]
    assert news[1].t - news[0].t == pytest.approx(1.8, abs=0.1)
    drive(world, ZERO, 1.0)
    assert pressed_by(world, "bottle") == 0.0
    assert middle(world, "bottle")[2] > 0.3


def test_who_has_taken_something_gives_it_back() -> None:
    world = held_by_the_robot("cup", ann={"path": [[1, 0]], "facing": 180})
    said(world, "Ann, please take the cup.", 3.0)
    world.grip(1.0)
    drive(world, ZERO, 1.0)
    assert said(world, "Ann, please give me the cup.", 1.5)[-1].does == "gives"


def test_who_lies_takes_and_gives_nothing() -> None:
    world = hall_with_things(eve={"path": [[0.9, 0]], "posture": "lying", "seat": 0.4, "holds": "cup"})
    assert [n.does for n in said(world, "Please give me the cup.", 2.0)] == ["hears"]
    assert [n.does for n in said(world, "Please take the cup.", 2.0)] == ["hears"]


def test_who_has_nothing_gives_nothing() -> None:
    world = hall_with_things(eve={"path": [[0.9, 0]]})
    assert [n.does for n in said(world, "Please give me the cup.", 2.0)] == ["hears"]


def test_what_is_in_somebodys_hand_is_still_there_after_the_host_was_replaced() -> None:
    people: dict[str, dict[str, Any]] = {
        "eve": {"path": [[0.9, 0]], "holds": "cup"},
        "ann": {"path": [[-1, 1]], "holds": "bottle"},
    }
    world = hall_with_things(**people)
    said(world, "Eve, please give me the cup.", 1.5)
    world.grip(0.0)
    drive(world, ZERO, 1.0)
    last = np.zeros((), STATE)
    world.fill(last)
    again = World(with_things(**people), settings(), last)
    drive(again, ZERO, 1.0)
    assert math.dist(middle(again, "bottle"), middle(world, "bottle")) < 0.01
    assert math.dist(middle(again, "cup"), middle(world, "cup")) < 0.02, "the robot has it"
