"""The skills on the real physics, at full speed: what they report is where the robot is."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable

import pytest

from config import load
from engine.epoch import Epoch
from engine.perception.eyes import Eyes
from engine.perception.memory import WorldMemory
from engine.plan import parse_call
from engine.planner.build import build_registry
from engine.robot.arm import ARM_INITIAL
from engine.robot.geometry import Pose
from engine.robot.sim.robot import SimRobot
from engine.skills.context import SkillContext
from engine.skills.outcome import Result
from engine.skills.places import Places

PLACES = load(environ={}).places


class Rig:
    """A running robot and a way to call skills on it."""

    def __init__(self, robot: SimRobot) -> None:
        self.robot = robot
        self.epoch = Epoch(robot.stop)
        self.places = Places(PLACES)
        self.registry = build_registry(load(environ={}), self.places)
        self.world = WorldMemory()
        self.progress: list[float | None] = []
        self.said: list[str] = []

    async def do(self, call: str) -> Result:
        action = self.registry.resolve(parse_call(call))
        context = SkillContext(
            robot=self.robot,
            epoch=self.epoch.current,
            places=self.places,
            say=self._say,
            progress=self._progress,
            describe_skills=lambda: "I can drive.",
            see=Eyes(self.robot, self.world).see,
            world=self.world,
        )
        return await self.registry[action.name].run(context, **action.args)

    @property
    def pose(self) -> Pose:
        return self.robot.state().pose

    async def _say(self, text: str) -> None:
        self.said.append(text)

    def _progress(
        self, fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None:
        del message, path
        self.progress.append(fraction)


def on_the_robot(test: Callable[[Rig], Awaitable[None]]) -> None:
    """Run ``test`` with a robot that stands in the hall."""

    async def run() -> None:
        robot = SimRobot(load(environ={}, overrides=["robot.speed=max"]).robot)
        await robot.start()
        beating = asyncio.create_task(_beat(robot))
        try:
            await robot.tick()
            await test(Rig(robot))
        finally:
            beating.cancel()
            await robot.close()

    asyncio.run(run())


async def _beat(robot: SimRobot) -> None:
    while True:
        robot.heartbeat()
        await asyncio.sleep(0.05)


@pytest.mark.parametrize(
    ("call", "x", "y", "yaw"),
    [
        ("move_forward(1)", 1.0, 0.0, 0.0),
        ("move_forward(-50 cm)", -0.5, 0.0, 0.0),
        ("move_sideways(0.3)", 0.0, 0.3, 0.0),
        ("move_sideways(-30 cm)", 0.0, -0.3, 0.0),
        ("move_left(90)", 0.0, 0.0, 90.0),
        ("move_right(30)", 0.0, 0.0, -30.0),
        ("move_left(450, 3)", 0.0, 0.0, 90.0),
        ("set_cmdvel(0.3, 0, 0, 2)", 0.6, 0.0, 0.0),
        ("set_cmdvel(0, 0, 0.5, 2)", 0.0, 0.0, 57.3),
    ],
)
def test_motion_ends_where_it_was_told_to(call: str, x: float, y: float, yaw: float) -> None:
    async def test(rig: Rig) -> None:
        result = await rig.do(call)
        assert result.ok, result
        assert rig.pose.x == pytest.approx(x, abs=0.06 if "cmdvel" in call else 0.015)
        assert rig.pose.y == pytest.approx(y, abs=0.015)
        assert math.degrees(math.remainder(rig.pose.yaw - math.radians(yaw), 2 * math.pi)) == pytest.approx(
            0, abs=6 if "cmdvel" in call else 1.5
        )
        assert not rig.robot.state().moving
        told = [value for value in rig.progress if value is not None]
        assert told == sorted(told)

    on_the_robot(test)


def test_the_course_sentence_of_the_older_system_ends_where_it_should() -> None:
    async def test(rig: Rig) -> None:
        for call in (
            "set_cmdvel(0.5, 0, 0, 2)",
            "set_cmdvel(-0.1, 0, 0, 5)",
            "move_left(30, 1.5)",
            "move_right(90, 1.5)",
            "set_cmdvel(0, 0.5, 0, 1)",
            "set_cmdvel(0, -0.1, 0, 1)",
            "finishtask()",
        ):
            assert (await rig.do(call)).ok, call
        assert math.degrees(rig.pose.yaw) == pytest.approx(-60, abs=3)
        sideways = 0.5 - 0.1
        assert rig.pose.x == pytest.approx(0.5 + sideways * math.sin(math.radians(60)), abs=0.12)
        assert rig.pose.y == pytest.approx(sideways * math.cos(math.radians(60)), abs=0.12)

    on_the_robot(test)


def test_a_wall_ends_a_drive_before_it_is_touched_and_the_report_is_true() -> None:
    async def test(rig: Rig) -> None:
        result = await rig.do("move_forward(10, 0.7)")
        assert (result.outcome, result.error_code) == ("failed", "path_blocked")
        assert result.data["moved"] == pytest.approx(rig.pose.x, abs=0.02)
        assert "obstacle" in result.message

    on_the_robot(test)


def test_every_place_is_reached() -> None:
    """One after another; ways between all of them are in ``test_route``, other orders too."""

    async def test(rig: Rig) -> None:
        for place in PLACES:
            result = await rig.do(f"navigation({place})")
            assert result.ok, (place, result)
            goal = rig.places.pose(place)
            assert goal is not None
            assert goal.distance_to(rig.pose) < 0.03, place
            assert abs(math.remainder(goal.yaw - rig.pose.yaw, 2 * math.pi)) < math.radians(2), place

    on_the_robot(test)


def test_the_remembered_place_is_found_again() -> None:
    async def test(rig: Rig) -> None:
        await rig.do("move_forward(0.8)")
        remembered = await rig.do("get_current_pose()")
        assert remembered.data["x"] == pytest.approx(0.8, abs=0.02)
        await rig.do("navigation(kitchen)")
        assert (await rig.do("navigation(zero)")).ok
        assert rig.pose.x == pytest.approx(0.8, abs=0.04)
        assert rig.pose.y == pytest.approx(0.0, abs=0.03)

    on_the_robot(test)


@pytest.mark.parametrize(("called", "name"), [("the nook", "nook"), ("A corner", "corner"), ("theatre", "theatre")])
def test_the_name_of_a_place_has_no_article(called: str, name: str) -> None:
    async def test(rig: Rig) -> None:
        done = await rig.do(f"remember_place({called})")
        assert done.message.startswith(f"I will remember this as the {name}.")
        assert rig.places.symbol(name)
        assert (await rig.do(f"navigation({name})")).ok

    on_the_robot(test)


def test_nothing_remembered_is_a_typed_failure() -> None:
    async def test(rig: Rig) -> None:
        result = await rig.do("navigation(zero)")
        assert (result.outcome, result.error_code) == ("failed", "unknown_place")

    on_the_robot(test)


@pytest.mark.parametrize("gesture", ["arm_up", "arm_nod", "arm_shake", "arm_applaud", "dance", "drift"])
def test_gestures_are_performed_and_end_at_rest(gesture: str) -> None:
    async def test(rig: Rig) -> None:
        result = await rig.do(f"{gesture}()")
        assert result.ok, result
        await rig.do("arm_down()")
        state = rig.robot.state()
        assert not state.moving
        assert all(abs(a - b) < 0.1 for a, b in zip(state.joints, ARM_INITIAL, strict=True))

    on_the_robot(test)


def test_light_say_and_wait_do_what_they_say() -> None:
    async def test(rig: Rig) -> None:
        before = rig.robot.state().t
        await rig.do("wait(1.5)")
        assert rig.robot.state().t - before == pytest.approx(1.5, abs=0.05)
        await rig.do("light(red)")
        assert rig.robot.state().light == (255, 0, 0), "what may be undone is asked as soon as it is over"
        await rig.do('say("dinner is ready")')
        assert rig.said == ["dinner is ready"]
        where = await rig.do("report_pose()")
        assert where.data["room"] == "hall"

    on_the_robot(test)


def test_a_stop_in_mid_drive_leaves_the_skill_unable_to_move_the_robot() -> None:
    async def test(rig: Rig) -> None:
        driving = asyncio.create_task(rig.do("move_forward(4)"))
        while rig.pose.x < 0.3:
            await rig.robot.tick()
        rig.epoch.advance()
        state = await rig.robot.tick()
        assert state.command.is_zero
        result = await driving  # it still commands every tick, in an epoch that is over
        assert not result.ok
        assert rig.pose.x < 0.4

    on_the_robot(test)
