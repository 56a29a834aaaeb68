"""Picking things up by real contact and real pictures: what is reported and remembered is what the physics says."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from dataclasses import replace

import numpy as np
import pytest

from engine.perception.looking import LOOK_POSES
from engine.perception.memory import Thing, WorldMemory
from engine.perception.naming import wanted
from engine.perception.sighting import Colour, Kind
from engine.robot.arm import ARM_INITIAL
from engine.robot.geometry import Pose
from engine.skills.aim import grip_height
from engine.skills.context import SkillContext
from engine.skills.grasp import pick
from engine.skills.hand import gap, look, move_to, still_held
from engine.skills.outcome import Result
from tests.sim.inhand import HandRobot, context_of

COFFEE_TABLE = Pose(-2.3, 1.9, math.pi)
STOOL = Pose(-0.9, 2.0, -math.pi / 2)
WORKBENCH = Pose(2.95, 1.7, math.pi)
KITCHEN = Pose(0.8, 2.3, 0.0)


class Bench:
    """A robot in hand, its memory, and its view of the world."""

    def __init__(self, stand: Pose) -> None:
        self.robot = HandRobot()
        self.memory = WorldMemory()
        self.context: SkillContext = context_of(self.robot, self.memory)
        self.robot.stand_at(stand)

    async def see(self, name: str) -> Thing:
        """Look around for a thing; what is not seen is a failure of the test."""
        for _ in range(10):
            await self.robot.tick()
        for pose in (LOOK_POSES["AHEAD"], LOOK_POSES["FAR"]):
            await move_to(self.context, pose.joints)
            await look(self.context)
            now = self.context.pose
            if found := self.memory.find(wanted(name), near=(now.x, now.y)):
                return found[0]
        raise AssertionError(f"no {name} in {self.memory.things}")

    async def pick(self, name: str) -> Result:
        return await pick(self.context, await self.see(name))

    def remember(self, thing: Thing) -> None:
        """As if it had been seen."""
        self.memory.take(thing)
        self.memory.put(thing.position, thing.seen_at)

    def has(self, name: str) -> bool:
        """Whether the thing of the scene is in the hand, in truth."""
        x, y, z = self.robot.where(name)
        pose = self.robot.world.true_pose
        return z > 0.18 and math.hypot(x - pose.x, y - pose.y) < 0.3


def on_a_bench(stand: Pose, test: Callable[[Bench], Awaitable[None]]) -> None:
    async def run() -> None:
        await test(Bench(stand))

    asyncio.run(run())


@pytest.mark.parametrize(
    ("thing", "stand"),
    [
        ("green box", KITCHEN),
        ("red box", COFFEE_TABLE),
        ("yellow box", WORKBENCH),  # turned by 20°
        ("blue cup", Pose(2.2, -2.9, -math.pi / 2)),
        ("bottle", STOOL),
        ("ball", Pose(-3.6, -0.6, math.pi)),
    ],
)
def test_a_thing_is_picked_up_and_known_to_be_held(thing: str, stand: Pose) -> None:
    async def test(bench: Bench) -> None:
        name = {"bottle": "green bottle", "ball": "orange ball"}.get(thing, thing)
        result = await bench.pick(name)
        assert result.ok, result
        assert bench.has(thing)
        assert bench.memory.held is not None
        assert bench.memory.held.name == name
        assert still_held(bench.context)
        assert bench.memory.find(wanted(name)) == ()

    on_a_bench(stand, test)


def test_a_box_between_two_others_is_taken_without_moving_them() -> None:
    async def test(bench: Bench) -> None:
        robot = bench.robot
        robot.put("green box", 1.4, 2.3, 0.001)
        robot.put("red box", 1.4, 2.37, 0.001)
        robot.put("blue box", 1.4, 2.23, 0.001)
        result = await bench.pick("green box")
        assert result.ok, result
        assert bench.has("green box")
        assert math.dist(robot.where("red box"), (1.4, 2.37, 0.0)) < 0.01
        assert math.dist(robot.where("blue box"), (1.4, 2.23, 0.0)) < 0.01

    on_a_bench(KITCHEN, test)


def test_what_was_taken_for_neighbours_does_not_keep_the_fingers_off() -> None:
    """Glances from afar left things all round the box that no close look shows."""

    async def test(bench: Bench) -> None:
        seen = await bench.see("green box")
        x, y, z = seen.position
        for number, angle in enumerate(np.arange(0, 2 * math.pi, math.pi / 4), 900):
            beside = (x + 0.07 * math.cos(angle), y + 0.07 * math.sin(angle), z)
            bench.remember(replace(seen, number=number, colour="grey", position=beside, size=(0.08, 0.04)))
        result = await pick(bench.context, seen)
        assert result.ok, result
        assert bench.has("green box")

    on_a_bench(KITCHEN, test)


@pytest.mark.parametrize(
    ("kind", "colour", "size"),
    [
        ("cup", "green", (0.06, 0.08)),
        ("cup", "white", (0.06, 0.06)),
        ("cup", "red", (0.06, 0.14)),
        ("box", "green", (0.05, 0.03)),
    ],
)
def test_a_bottle_is_not_taken_for_what_a_part_of_it_looked_like(
    kind: Kind, colour: Colour, size: tuple[float, float]
) -> None:
    async def test(bench: Bench) -> None:
        before = bench.robot.where("bottle")
        bottle = await bench.see("green bottle")
        bench.memory.forget(bottle)
        x, y, z = bottle.position
        label = replace(bottle, kind=kind, colour=colour, size=size, position=(x, y, z), named_from=1.2, whole=False)
        bench.remember(label)
        result = await pick(bench.context, label)
        assert (result.outcome, result.error_code) == ("failed", "object_not_found")
        assert result.message == f"What I took for the {colour} {kind} is the green bottle."
        assert bench.memory.held is None
        assert math.dist(bench.robot.where("bottle"), before) < 0.003
        assert [thing.name for thing in bench.memory.things if thing.distance_to(x, y) < 0.05] == ["green bottle"]

    on_a_bench(STOOL, test)


def test_a_ball_is_not_taken_for_the_box_that_it_looked_like_from_afar() -> None:
    async def test(bench: Bench) -> None:
        ball = await bench.see("orange ball")
        bench.memory.forget(ball)
        box = replace(ball, kind="box", named_from=1.9)
        bench.remember(box)
        result = await pick(bench.context, box)
        assert result.message == "What I took for the orange box is the orange ball."
        assert bench.memory.held is None

    on_a_bench(Pose(-3.6, -0.6, math.pi), test)


def test_a_hand_that_is_full_takes_nothing_else() -> None:
    async def test(bench: Bench) -> None:
        assert (await bench.pick("red box")).ok
        result = await bench.pick("blue box")
        assert (result.outcome, result.error_code) == ("failed", "hand_full")
        assert "red box" in result.message
        assert bench.has("red box")

    on_a_bench(COFFEE_TABLE, test)


def test_what_has_gone_meanwhile_is_not_found_and_forgotten() -> None:
    async def test(bench: Bench) -> None:
        seen = await bench.see("green box")
        bench.robot.put("green box", 4.2, -1.3, 0.001)
        result = await pick(bench.context, seen)
        assert (result.outcome, result.error_code) == ("failed", "object_not_found")
        assert bench.memory.held is None
        assert bench.memory.find(wanted("green box")) == ()

    on_a_bench(KITCHEN, test)


def test_what_was_pushed_a_little_meanwhile_is_found_again_and_taken() -> None:
    async def test(bench: Bench) -> None:
        seen = await bench.see("green box")
        bench.robot.put("green box", 1.33, 2.36, 0.001, 0.5)
        result = await pick(bench.context, seen)
        assert result.ok, result
        assert bench.has("green box")

    on_a_bench(KITCHEN, test)


def test_the_middle_of_a_large_table_is_out_of_reach() -> None:
    async def test(bench: Bench) -> None:
        bench.robot.put("red box", -3.1, 1.9, 0.141)
        bench.robot.put("blue box", 4.2, -1.3, 0.001)
        seen = await bench.see("red box")
        result = await pick(bench.context, seen)
        assert (result.outcome, result.error_code) == ("failed", "out_of_reach")
        assert math.dist(bench.robot.where("red box"), (-3.1, 1.9, 0.14)) < 0.01

    on_a_bench(COFFEE_TABLE, test)


def test_what_is_snatched_from_the_fingers_is_missed_and_taken_at_the_second_try() -> None:
    async def test(bench: Bench) -> None:
        robot, snatched = bench.robot, []

        def snatch() -> None:
            """Once, as soon as the fingers close, somebody pulls the box 8 cm away."""
            down = robot.arm.grip(robot.state().joints).point[2] < 0.05
            if not snatched and down and robot.world.arm.grip_target < 0.9:
                x, y, _ = robot.where("green box")
                robot.put("green box", x + 0.02, y + 0.08, 0.001)
                snatched.append(robot.world.t)

        seen = await bench.see("green box")
        robot.each_tick = snatch
        result = await pick(bench.context, seen)
        assert snatched
        assert result.ok, result
        assert bench.has("green box")
        assert bench.memory.held is not None

    on_a_bench(KITCHEN, test)


@pytest.mark.parametrize("phase", ["descent", "closing", "lift", "folding"])
def test_an_interruption_leaves_the_truth_about_what_is_held(phase: str) -> None:
    async def test(bench: Bench) -> None:
        robot = bench.robot
        picking = asyncio.create_task(pick(bench.context, await bench.see("green box")))

        def interrupt() -> None:
            """In the very tick in which the phase has come."""
            state = robot.state()
            low = robot.arm.grip(state.joints).point[2]
            told = robot.world.arm.grip_target
            reached = {
                "descent": low < 0.06 and told > 0.9,
                "closing": told < 0.8 and low < 0.04,
                "lift": told < 0.05 and low > 0.06,
                "folding": told < 0.05 and low > 0.2,
            }
            if reached[phase] and state.epoch == 1:
                robot.stop(2)
                picking.cancel()

        robot.each_tick = interrupt
        with pytest.raises(asyncio.CancelledError):
            await picking
        for _ in range(5):
            state = await robot.tick()
        assert (bench.memory.held is not None) == (phase in ("lift", "folding"))
        # The arm goes home as after a wake; what it holds comes along, and what it does not hold stays.
        robot.move_arm(ARM_INITIAL, 2, speed=1.0)
        while math.dist(state.joints, ARM_INITIAL) > 0.05:
            state = await robot.tick()
        assert bench.has("green box") == (bench.memory.held is not None) == still_held(bench.context)
        if phase == "descent":
            assert gap(bench.context) == pytest.approx(robot.arm.jaw, abs=0.003)

    on_a_bench(KITCHEN, test)


def test_the_fingers_take_low_things_just_above_the_floor_and_tall_ones_below_the_palm() -> None:
    assert grip_height((0.04, 0.04)) == pytest.approx(0.026, abs=0.002)
    assert grip_height((0.06, 0.08)) == pytest.approx(0.04)
    assert grip_height((0.06, 0.15)) == pytest.approx(0.09)
