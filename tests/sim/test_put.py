"""Putting down by real contact: things stand where the robot says, and what it remembers is true."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable

import pytest

from engine.perception.naming import wanted
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Pose
from engine.skills.hand import from_map, still_held
from engine.skills.outcome import Result
from engine.skills.put import put_in, put_on, put_on_floor
from tests.sim.test_grasp import COFFEE_TABLE, KITCHEN, STOOL, Bench


class Hands(Bench):
    """A bench on which things are put down."""

    def piece(self, name: str) -> Furniture:
        return next(piece for piece in self.robot.floor_map.furniture if piece.name == name)

    async def settle(self) -> None:
        for _ in range(25):
            await self.robot.tick()

    def upright(self, name: str) -> bool:
        _, x, y, _ = self.robot.world.data.body(name).xquat.tolist()
        return 1 - 2 * (x * x + y * y) > 0.98


def with_hands(stand: Pose, test: Callable[[Hands], Awaitable[None]]) -> None:
    async def run() -> None:
        await test(Hands(stand))

    asyncio.run(run())


async def remembered_where_it_is(hands: Hands, thing: str, words: str) -> None:
    """As seen from the robot, which may be wrong about where on the map it stands."""
    await hands.settle()
    (known,) = hands.memory.find(wanted(words))
    believed = from_map(hands.context.pose, known.position)
    true = from_map(hands.robot.world.true_pose, hands.robot.where(thing))
    assert math.dist(believed[:2], true[:2]) < 0.03
    assert hands.memory.held is None


@pytest.mark.parametrize(("thing", "stand"), [("red box", COFFEE_TABLE), ("bottle", STOOL)])
def test_what_is_held_is_put_on_the_floor_upright(thing: str, stand: Pose) -> None:
    async def test(hands: Hands) -> None:
        words = "green bottle" if thing == "bottle" else thing
        assert (await hands.pick(words)).ok
        result = await put_on_floor(hands.context)
        assert result.ok, result
        await remembered_where_it_is(hands, thing, words)
        assert hands.robot.where(thing)[2] < 0.01
        assert hands.upright(thing)

    with_hands(stand, test)


@pytest.mark.parametrize(("thing", "stand", "table"), [("green box", KITCHEN, "stool"), ("bottle", STOOL, "stool")])
def test_what_is_held_is_put_on_a_table_beside_what_stands_there(thing: str, stand: Pose, table: str) -> None:
    async def test(hands: Hands) -> None:
        words = "green bottle" if thing == "bottle" else thing
        cup = hands.robot.where("white cup")
        assert (await hands.pick(words)).ok
        piece = hands.piece(table)
        result = await put_on(hands.context, piece)
        assert result.ok, result
        await remembered_where_it_is(hands, thing, words)
        x, y, z = hands.robot.where(thing)
        assert piece.holds(x, y, margin=0.01)
        assert z == pytest.approx(piece.height, abs=0.01)
        assert hands.upright(thing)
        assert math.dist(hands.robot.where("white cup"), cup) < 0.01

    with_hands(stand, test)


@pytest.mark.parametrize(("thing", "stand"), [("green box", KITCHEN), ("white cup", STOOL)])
def test_what_is_held_is_dropped_into_the_bin(thing: str, stand: Pose) -> None:
    async def test(hands: Hands) -> None:
        assert (await hands.pick(thing)).ok
        piece = hands.piece("bin")
        result = await put_in(hands.context, piece)
        assert result.ok, result
        await hands.settle()
        x, y, z = hands.robot.where(thing)
        assert piece.holds(x, y, margin=0.01)
        assert z < piece.height
        assert hands.memory.held is None

    with_hands(stand, test)


def test_an_empty_hand_has_nothing_to_put_down() -> None:
    async def test(hands: Hands) -> None:
        results = [await put_on_floor(hands.context), await put_on(hands.context, hands.piece("stool"))]
        results.append(await put_in(hands.context, hands.piece("bin")))
        assert [result.error_code for result in results] == ["nothing_held"] * 3

    with_hands(KITCHEN, test)


def test_a_table_that_is_full_has_no_room() -> None:
    async def test(hands: Hands) -> None:
        assert (await hands.pick("green box")).ok
        piece, loose = hands.piece("bedside table"), [n for n in hands.robot.scene.objects if n != "green box"]
        for index, name in enumerate(loose[:9]):
            x = piece.x_min + 0.075 + 0.15 * (index % 3)
            hands.robot.put(name, x, piece.y_min + 0.075 + 0.15 * (index // 3), 0.141)
        result: Result = await put_on(hands.context, piece)
        assert (result.outcome, result.error_code) == ("failed", "no_room")
        assert hands.has("green box")
        assert still_held(hands.context)

    with_hands(KITCHEN, test)


def test_a_high_table_is_out_of_reach_and_the_thing_stays_held() -> None:
    async def test(hands: Hands) -> None:
        assert (await hands.pick("green box")).ok
        result = await put_on(hands.context, hands.piece("dining table"))
        assert (result.outcome, result.error_code) == ("failed", "out_of_reach")
        assert hands.has("green box")

    with_hands(KITCHEN, test)


def test_what_is_taken_out_of_the_hand_on_the_way_is_reported_as_dropped() -> None:
    async def test(hands: Hands) -> None:
        assert (await hands.pick("green box")).ok
        hands.robot.put("green box", 1.0, 3.0, 0.001)
        await hands.settle()
        assert not still_held(hands.context)
        result = await put_on(hands.context, hands.piece("stool"))
        assert (result.outcome, result.error_code) == ("failed", "dropped")
        assert hands.memory.held is None

    with_hands(KITCHEN, test)


@pytest.mark.parametrize("phase", ["lowering", "opening"])
def test_an_interruption_leaves_the_truth_about_what_was_let_go(phase: str) -> None:
    async def test(hands: Hands) -> None:
        robot = hands.robot
        assert (await hands.pick("green box")).ok
        putting = asyncio.create_task(put_on_floor(hands.context))

        def interrupt() -> None:
            """In the very tick in which the phase has come."""
            low = robot.where("green box")[2]
            told = robot.world.arm.grip_target
            reached = {"lowering": low < 0.05 and told < 0.01, "opening": robot.state().gripper > 0.7}
            if reached[phase] and robot.state().epoch == 1:
                robot.stop(2)
                putting.cancel()

        robot.each_tick = interrupt
        with pytest.raises(asyncio.CancelledError):
            await putting
        await hands.settle()
        assert (hands.memory.held is not None) == (phase == "lowering") == still_held(hands.context)
        if phase == "opening":
            await remembered_where_it_is(hands, "green box", "green box")

    with_hands(KITCHEN, test)
