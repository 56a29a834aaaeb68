"""Searching and errands in a small house of two rooms: what is found, brought and cleared away is where the robot says,
by the truth of physics."""

from __future__ import annotations

import asyncio
import math
import random
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from engine.perception.memory import Thing, WorldMemory
from engine.perception.naming import wanted
from engine.robot.geometry import Pose
from engine.robot.sim.scene import Scene
from engine.skills.context import SkillContext
from engine.skills.grasp import pick
from engine.skills.library.household import ask_user, carry, clean_room, clear_rubbish, tidy
from engine.skills.library.manipulation import pick_object
from engine.skills.library.searching import locate, navigate_to_object, scan_room, seewhat
from engine.skills.outcome import Result
from engine.skills.search import Survey
from engine.skills.travel import go_to
from tests.sim.inhand import SQUEEZED_N, HandRobot, context_of, pressed_by

HOUSE: dict[str, Any] = {
    "name": "two rooms",
    "bounds": {"x": [-1.5, 3.5], "y": [-1.4, 1.4]},
    "start": {"x": -0.8, "y": -0.6, "yaw": 0},
    "rooms": {"den": {"x": [-1.5, 1.5], "y": [-1.4, 1.4]}, "shed": {"x": [1.5, 3.5], "y": [-1.4, 1.4]}},
    "doors": [{"between": ["den", "shed"], "at": 0.0, "width": 0.9}],
    "furniture": {
        "bin": {"kind": "bin", "at": [-1.2, 1.1], "size": [0.3, 0.3, 0.2]},
        "stool": {"kind": "low_table", "at": [0.6, 1.1], "size": [0.5, 0.4, 0.14]},
    },
    "objects": {
        "red box": {"kind": "box", "at": [0.5, 0.98], "stands_on": "stool", "size": 0.04, "colour": "red"},
        "blue box": {"kind": "box", "at": [0.4, -0.5], "size": 0.04, "colour": "blue"},
        "green cup": {"kind": "cup", "at": [2.6, 0.5], "size": 0.08, "colour": "green", "mass": 0.08},
    },
}


class House:
    """The robot at home, and what it remembers."""

    def __init__(self, *, closed: bool = False, **objects: dict[str, Any]) -> None:
        doors = [{**HOUSE["doors"][0], "closed": closed}]
        scene = Scene.model_validate({**HOUSE, "doors": doors, **({"objects": objects} if objects else {})})
        self.robot = HandRobot(scene)
        self.memory = WorldMemory()
        self.context: SkillContext = context_of(self.robot, self.memory)
        self.context.places.remember(Pose(-0.8, -0.6, 0.0))

    def in_bin(self, name: str) -> bool:
        x, y, z = self.robot.where(name)
        return abs(x + 1.2) < 0.15 and abs(y - 1.1) < 0.15 and z < 0.2

    def between_the_fingers(self) -> list[str]:
        """By the truth of physics, whatever the robot thinks; fingers around something do not hold it yet."""
        return [name for name in self.robot.scene.objects if pressed_by(self.robot.world, name) > SQUEEZED_N]


def at_home(test: Callable[[House], Awaitable[None]], *, closed: bool = False, **objects: dict[str, Any]) -> None:
    async def run() -> None:
        await test(House(closed=closed, **objects))

    asyncio.run(run())


def test_looking_through_a_room_finds_what_is_in_it_and_nothing_else() -> None:
    async def test(house: House) -> None:
        result = await scan_room.run(house.context, "den")
        assert result.ok, result
        assert result.data["things"] == 2
        assert result.data["seen"] > 0.85
        (box,) = house.memory.find(wanted("red box"))
        assert abs(box.position[0] - 0.5) < 0.02
        assert abs(box.position[1] - 0.98) < 0.02
        assert "a red box" in result.message
        assert "a blue box" in result.message

    at_home(test)


def test_a_thing_in_another_room_is_looked_for_there() -> None:
    async def test(house: House) -> None:
        result = await locate.run(house.context, "green cup")
        assert result.message == "The green cup is on the floor in the shed."
        assert abs(result.data["x"] - 2.6) < 0.03
        pictures = house.robot.pictures
        again = await locate.run(house.context, "green cup")
        assert again.message == result.message
        assert house.robot.pictures == pictures, "what was seen a moment ago is not looked for again"

    at_home(test)


def test_what_is_nowhere_is_not_found_and_the_rooms_are_named() -> None:
    async def test(house: House) -> None:
        result = await locate.run(house.context, "purple ball")
        assert (result.outcome, result.error_code) == ("failed", "object_not_found")
        assert result.message == "I looked in the den and the shed and saw no purple ball."

    at_home(test)


def test_going_to_a_thing_ends_before_it_and_facing_it() -> None:
    async def test(house: House) -> None:
        result = await navigate_to_object.run(house.context, "blue box")
        assert result.ok, result
        ahead = house.robot.world.true_pose
        away = ahead.distance_to(Pose(0.4, -0.5, 0.0))
        assert 0.2 < away < 0.5

    at_home(test)


def test_what_is_before_the_camera_is_described() -> None:
    async def test(house: House) -> None:
        house.robot.stand_at(Pose(-0.3, -0.5, 0.0))
        assert "blue box" in (await seewhat.run(house.context)).message

    at_home(test)


def test_a_thing_is_brought_from_one_room_to_where_the_robot_was() -> None:
    async def test(house: House) -> None:
        result = await carry.run(house.context, "green cup", "zero")
        assert result.ok, result
        x, y, z = house.robot.where("green cup")
        assert Pose(x, y, 0.0).distance_to(Pose(-0.8, -0.6, 0.0)) < 0.5
        assert z < 0.02
        assert house.memory.held is None

    at_home(test)


def test_a_room_is_clean_when_everything_in_it_is_in_the_bin() -> None:
    async def test(house: House) -> None:
        result = await clean_room.run(house.context, "den")
        assert result.ok, result
        assert result.data["moved"] == 2
        assert house.in_bin("red box")
        assert house.in_bin("blue box")
        assert not house.in_bin("green cup"), "it is in the other room"

    at_home(test)


def test_rubbish_is_looked_for_in_the_next_room_where_none_lies_about_here() -> None:
    async def test(house: House) -> None:
        result = await clear_rubbish.run(house.context)
        assert result.ok, result
        assert house.in_bin("green cup")

    at_home(test, **{"green cup": HOUSE["objects"]["green cup"]})


def test_only_things_of_the_colour_are_put_where_they_belong() -> None:
    async def test(house: House) -> None:
        result = await tidy.run(house.context, "blue", "stool")
        assert result.ok, result
        assert house.robot.where("blue box")[2] == pytest.approx(0.14, abs=0.01)
        assert house.robot.where("red box")[:2] == pytest.approx((0.5, 0.98), abs=0.02)

    at_home(test)


def test_what_cannot_be_gripped_is_left_and_named_and_the_rest_is_done() -> None:
    async def test(house: House) -> None:
        result = await clean_room.run(house.context, "den")
        assert result.outcome == "failed"
        assert "red box" in result.message.partition("leave")[2]
        assert result.data["moved"] == 1
        assert house.in_bin("blue box")

    heavy = {"kind": "box", "at": [0.3, 0.3], "size": 0.12, "colour": "red", "mass": 1.0}  # wider than the jaw
    at_home(test, **{"red box": heavy, "blue box": HOUSE["objects"]["blue box"]})


def test_a_question_to_the_user_ends_the_plan() -> None:
    async def test(house: House) -> None:
        asked = await ask_user.run(house.context, "Which cup?")
        assert asked == Result("ok", "needs_answer", "Which cup?")

    at_home(test)


@pytest.mark.parametrize("seed", range(6))
def test_an_errand_cut_off_at_any_moment_leaves_the_truth(seed: int) -> None:
    """Arm and gripper stay as they are, and the memory knows whether something is held."""

    async def test(house: House) -> None:
        moment = random.Random(seed).uniform(1.0, 45.0)
        doing = asyncio.ensure_future(clean_room.run(house.context, "den"))
        epoch = 1

        def cut() -> None:
            nonlocal epoch
            if epoch == 1 and house.robot.state().t >= moment and not doing.done():
                epoch = 2
                house.robot.stop(2)
                doing.cancel()

        house.robot.each_tick = cut
        await asyncio.wait([doing])
        assert doing.cancelled() or doing.result().ok
        for _ in range(100):
            await house.robot.tick()
        held = house.memory.held
        assert ([held.name] if held else []) == house.between_the_fingers()
        assert not house.robot.state().moving

    at_home(test)


def test_a_survey_never_asks_for_what_has_been_given_up() -> None:
    house = House()
    floor, robot = house.robot.floor_map, house.robot
    survey = Survey(floor.rooms[0], floor, robot.footprint, robot.state().pose)

    async def look() -> int:
        views, picture = 0, await robot.look()
        while survey.next_view(robot.state().pose) is not None:
            views += 1
            assert views < 8 * 200, "it would look for ever"
            survey.mark(picture)  # always the same one, whatever it asks for
        return views

    assert asyncio.run(look()) > 0


def test_small_things_on_the_floor_are_driven_around() -> None:
    """The lidar looks over them, so only the memory can keep the robot from running them over."""

    async def test(house: House) -> None:
        before = house.robot.where("blue box")
        result = await go_to(house.context, Pose(1.0, -0.5, 0.0), "the far end")
        assert result.ok, result
        assert math.dist(house.robot.where("blue box"), before) < 0.003

    at_home(test, **{"blue box": {"kind": "box", "at": [0.2, -0.55], "size": 0.04, "colour": "blue"}})


def test_what_is_not_where_something_like_it_was_seen_is_looked_for_again() -> None:
    async def test(house: House) -> None:
        ghost = Thing(77, "cup", "green", None, (0.3, 0.3, 0.04), 0.02, (0.06, 0.08), 0.0, None, 0.0, 1.5)
        house.memory.take(ghost)
        house.memory.put(ghost.position, 0.0)
        result = await pick_object.run(house.context, "green cup")
        assert result.ok, result
        assert house.memory.held is not None
        assert house.robot.where("green cup")[2] > 0.05

    at_home(test)


def test_what_a_close_look_shows_to_be_something_else_is_left_alone() -> None:
    async def test(house: House) -> None:
        before = house.robot.where("blue box")
        taken_for = Thing(77, "box", "red", None, (0.4, -0.5, 0.02), 0.01, (0.04, 0.04), 0.0, None, 0.0, 1.5)
        house.memory.take(taken_for)
        house.memory.put(taken_for.position, 0.0)
        result = await pick(house.context, house.memory.things[0])
        assert (result.outcome, result.error_code) == ("failed", "object_not_found")
        assert house.memory.held is None
        assert math.dist(house.robot.where("blue box"), before) < 0.003

    at_home(test)


def test_a_closed_door_is_named() -> None:
    async def test(house: House) -> None:
        result = await go_to(house.context, Pose(2.5, 0.0, 0.0), "the shed")
        assert (result.outcome, result.error_code) == ("failed", "door_closed")
        assert "the door between the den and the shed is closed" in result.message

    at_home(test, closed=True)


def test_a_drive_ends_on_the_way_where_that_is_enough() -> None:
    robot = HandRobot()
    goal = Pose(2.0, 0.0, 0.0)
    went = asyncio.run(
        go_to(context_of(robot, WorldMemory()), goal, "the dock", enough=lambda: robot.state().pose.x > 0.3)
    )
    assert went.ok
    state = robot.state()
    assert 0.3 < state.pose.x < 0.45
    assert abs(state.twist.vx) < 0.01
