"""The skills that handle things, as a plan calls them: by name, by the box in the picture, and servo by servo."""

from __future__ import annotations

import math

import pytest

from engine.perception.looking import LOOK_POSES
from engine.robot.geometry import Pose
from engine.robot.sim.build import build
from engine.skills.hand import gap, look, move_to
from engine.skills.library.manipulation import (
    close_gripper,
    grasp_obj,
    open_gripper,
    place_object,
    putdown,
    servo1_move,
)
from tests.sim.test_grasp import COFFEE_TABLE, KITCHEN, Bench, on_a_bench
from tests.sim.test_skills import Rig, on_the_robot


def test_the_box_in_the_picture_says_which_of_two_things_is_taken() -> None:
    async def test(bench: Bench) -> None:
        await move_to(bench.context, LOOK_POSES["AHEAD"].joints)
        sight = await look(bench.context)
        box = next(thing.box for thing in sight.objects if thing.name == "blue box")
        result = await grasp_obj.run(bench.context, *(float(edge) for edge in box))
        assert result.ok, result
        assert bench.has("blue box")
        assert not bench.has("red box")
        assert (await putdown.run(bench.context)).ok
        assert bench.robot.where("blue box")[2] < 0.01

    on_a_bench(COFFEE_TABLE, test)


def test_a_box_around_nothing_names_what_is_in_the_picture() -> None:
    async def test(bench: Bench) -> None:
        await move_to(bench.context, LOOK_POSES["AHEAD"].joints)
        result = await grasp_obj.run(bench.context, 0.0, 0.0, 12.0, 9.0)
        assert (result.outcome, result.error_code) == ("failed", "object_not_found")
        assert "green box" in result.message

    on_a_bench(KITCHEN, test)


def test_what_is_held_is_put_where_the_words_say() -> None:
    async def test(bench: Bench) -> None:
        assert (await bench.pick("green box")).ok
        result = await place_object.run(bench.context, "stool")
        assert result.ok, result
        x, y, z = bench.robot.where("green box")
        assert (-1.15 < x < -0.65, 1.05 < y < 1.45, z == pytest.approx(0.14, abs=0.01)) == (True, True, True)
        nowhere = await place_object.run(bench.context, "stool")
        assert nowhere.error_code == "nothing_held"

    on_a_bench(KITCHEN, test)


def test_opening_the_gripper_lets_go_and_closing_it_tells_what_is_in_it() -> None:
    async def test(bench: Bench) -> None:
        assert (await bench.pick("green box")).ok
        closed = await close_gripper.run(bench.context)
        assert "4.0 cm" in closed.message or "3.9 cm" in closed.message
        opened = await open_gripper.run(bench.context)
        assert "green box" in opened.message
        assert bench.memory.held is None
        assert gap(bench.context) == pytest.approx(bench.robot.arm.jaw, abs=0.003)
        for _ in range(50):
            await bench.robot.tick()
        assert bench.robot.where("green box")[2] < 0.2  # on the hull or the floor
        assert "nothing between" in (await close_gripper.run(bench.context)).message

    on_a_bench(KITCHEN, test)


@pytest.mark.parametrize(("angle", "yaw"), [(90.0, 0.0), (180.0, 90.0), (30.0, -60.0)])
def test_servo_1_turns_the_arm_about_its_vertical_axis(angle: float, yaw: float) -> None:
    async def test(bench: Bench) -> None:
        result = await servo1_move.run(bench.context, angle)
        assert result.ok, result
        assert math.degrees(bench.robot.state().joints[0]) == pytest.approx(yaw, abs=1.5)

    on_a_bench(Pose(0, 0, 0), test)


def test_a_box_goes_from_the_kitchen_floor_into_the_bin_on_the_robot_in_its_process() -> None:
    async def test(rig: Rig) -> None:
        model = build(rig.robot.scene)
        at = model.joint("green box").qposadr[0]
        bin_ = next(piece for piece in rig.robot.floor_map.furniture if piece.kind == "bin")
        assert (await rig.do("navigation(kitchen)")).ok
        picked = await rig.do('pick_object("the green box")')
        assert picked.ok, picked
        assert rig.world.held is not None
        thrown = await rig.do("place_in_bin()")
        assert thrown.ok, thrown
        x, y, z = rig.robot.memory.state.get()["qpos"][at : at + 3].tolist()
        assert bin_.holds(x, y, margin=0.01)
        assert z < bin_.height
        assert rig.world.held is None

    on_the_robot(test)
