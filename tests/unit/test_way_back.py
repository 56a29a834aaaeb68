"""The way back from a thing that was moved, which only what was known of it before can tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.perception.memory import Thing, World
from engine.plan import Action, ActionCall
from engine.robot.arm import ARM_INITIAL
from engine.robot.floor_map import FloorMap, Furniture
from engine.robot.geometry import ZERO, Pose
from engine.robot.robot import RobotState
from engine.session.ran import Moment, Ran
from engine.session.way_back import WayBack, way_back
from engine.skills.library import LIBRARY
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import SkillRegistry

SKILLS = SkillRegistry(LIBRARY, capabilities=frozenset({"base", "arm", "camera", "voice"}))
TABLE = Furniture("coffee table", 1.0, 1.0, 2.0, 2.0, 0.2)
FLOOR = FloorMap(0.05, (-5.0, -4.0), np.zeros((160, 200), dtype=np.bool_), furniture=(TABLE,))
BOX = Thing(1, "box", "red", None, (1.5, 1.5, 0.23), 0.01, (0.05, 0.05), 0.2, 0.0, 1.0)
ON_FLOOR = replace(BOX, position=(0.5, 0.5, 0.03), surface=0.0)
HERE = Pose(0.0, 0.0, 0.0)
BALL = replace(ON_FLOOR, number=2, kind="ball", colour="blue")


def moment(t: float, *things: Thing, held: Thing | None = None, at: Pose = HERE) -> Moment:
    state = RobotState(
        t=t, epoch=1, pose=at, twist=ZERO, command=ZERO, joints=ARM_INITIAL, joint_targets=ARM_INITIAL, gripper=1.0,
        light=(0, 0, 0), blocked=None, halted=None,
    )  # fmt: skip
    return Moment(state, World(things, held))


def ran(name: str, before: Moment, result: Result | None = None, **args: str) -> Ran:
    return Ran(Action(name, args), result or ok("Done."), 1.0, before)


def back(*acted: Ran, now: Moment) -> WayBack:
    return way_back(acted, SKILLS, now, FLOOR, ARM_INITIAL)


ELSEWHERE = moment(9.0, ON_FLOOR, at=Pose(3.0, 0.0, 0.0))


def named(found: WayBack) -> list[tuple[str, str]]:
    return [
        (call.name, str(call.positional[0]) if call.name in ("pick_object", "place_object") else "")
        for call in found.calls
    ]


def test_a_thing_that_stood_on_a_table_goes_back_there_and_then_the_robot() -> None:
    found = back(ran("carry", moment(0, BOX), object="red box", place="A", source=""), now=ELSEWHERE)
    assert named(found) == [
        ("pick_object", "red box"), ("place_object", "coffee table"), ("return_to", "")
    ]  # fmt: skip


def test_a_thing_that_is_held_now_is_only_put_back() -> None:
    found = back(ran("pick_object", moment(0, BOX), object="red box"), now=moment(9, held=BOX))
    assert named(found)[0] == ("place_object", "coffee table")


def test_a_thing_that_was_held_and_put_down_is_taken_again() -> None:
    found = back(ran("place_object", moment(0, held=BOX), surface="coffee table"), now=moment(9, BOX))
    assert named(found)[0] == ("pick_object", "red box")


@pytest.mark.parametrize(
    ("acted", "now", "why"),
    [
        ([ran("carry", moment(0, ON_FLOOR), object="red box")], ELSEWHERE, "lay on the floor"),
        ([ran("carry", moment(0), object="red box")], ELSEWHERE, "did not know where the red box was"),
        ([ran("carry", moment(0, BOX, replace(BOX, number=2)), object="red box")], ELSEWHERE, "several things"),
        ([ran("carry", moment(0, BOX, BALL), object="thing")], ELSEWHERE, "several things that are called thing"),
        ([ran("carry", moment(0, BOX, BALL), object=name) for name in ("red box", "blue ball")], ELSEWHERE, "Several"),
        ([ran("carry", moment(0, BOX), fail("dropped", "It fell."), object="red box")], ELSEWHERE, "do not know where"),
        ([ran("clean_room", moment(0, BOX), room="")], ELSEWHERE, "cannot undo clean_room"),
        ([ran("light", moment(0, held=BOX), color="red")], ELSEWHERE, "do not hold the red box any more"),
        ([ran("arm_up", moment(0), Result("uncertain", "robot_lost", "It was lost."))], ELSEWHERE, "how far I got"),
        ([replace(ran("arm_up", moment(0)), before=None)], ELSEWHERE, "do not know how everything was before"),
    ],
)  # fmt: skip
def test_where_it_is_not_safe_and_simple_nothing_is_offered(acted: list[Ran], now: Moment, why: str) -> None:
    found = back(*acted, now=now)
    assert not found.calls
    assert why in found.why_not


def test_every_way_back_is_one_that_the_skills_allow() -> None:
    found = back(ran("carry", moment(0, BOX), object="red box"), now=ELSEWHERE)
    assert [SKILLS.resolve(call).name for call in found.calls] == [call.name for call in found.calls]
    assert all(isinstance(call, ActionCall) for call in found.calls)
