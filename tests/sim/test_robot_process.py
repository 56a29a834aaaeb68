"""The robot in its own process, in simulated time: stops, epochs, ticks, and nothing left behind."""

from __future__ import annotations

import asyncio
import gc
import math
import os
import resource
import signal

import psutil
import pytest

from engine.errors import ExitCode, RobotError, SceneError
from engine.robot.geometry import ZERO, Twist
from engine.robot.host.memory import Memory
from engine.robot.host.process import HostProcess
from engine.robot.robot import RobotState
from engine.robot.sim.robot import SimRobot
from tests.open_files import open_files
from tests.sim.rig import keep_driving, run, running, settings, ticks_until

FORWARD = Twist(vx=0.3)


def test_after_a_stop_the_very_next_tick_commands_zero() -> None:
    async def main() -> None:
        async with running() as robot:
            assert (await keep_driving(robot, FORWARD, 1, 50)).twist.vx == pytest.approx(0.3, abs=0.01)
            robot.stop(2)
            state = await robot.tick()
            assert state.command == ZERO
            assert state.epoch == 2
            assert state.joint_targets == pytest.approx(state.joints, abs=0.02)

    run(main)


def test_at_full_speed_a_robot_that_is_stopped_comes_to_rest_though_nobody_waits_for_it() -> None:
    async def main() -> None:
        async with running() as robot:
            assert (await keep_driving(robot, FORWARD, 1, 50)).moving
            robot.stop(2)
            for _ in range(200):
                await asyncio.sleep(0)
            rest = robot.state()
            assert not rest.moving
            assert rest.epoch == 2
            robot.stop(3)
            for _ in range(200):
                await asyncio.sleep(0)
            assert robot.state().t == rest.t, "time stands still again"

    run(main)


def test_commands_of_an_epoch_that_is_over_never_move_the_robot() -> None:
    async def main() -> None:
        async with running() as robot:
            await keep_driving(robot, FORWARD, 1, 30)
            robot.stop(2)
            rest = await ticks_until(robot, lambda state: not state.moving)
            late = await keep_driving(robot, FORWARD, 1, 50)
            robot.move_arm((0.5, 0, 0, 0, 0), 1)
            robot.set_gripper(1.0, 1)
            for _ in range(50):
                late = await robot.tick()
            assert late.pose.distance_to(rest.pose) < 1e-3
            assert late.joint_targets == rest.joint_targets
            assert late.gripper == pytest.approx(rest.gripper, abs=0.01)
            assert (await keep_driving(robot, FORWARD, 2, 30)).moving

    run(main)


def test_a_command_given_right_after_a_stop_is_carried_out() -> None:
    async def main() -> None:
        async with running() as robot:
            for epoch in range(2, 30):
                robot.stop(epoch)
                robot.set_gripper(float(epoch % 2), epoch)
                for _ in range(60):
                    state = await robot.tick()
                assert state.gripper == pytest.approx(epoch % 2, abs=0.05)

    run(main)


def test_not_even_a_light_comes_from_an_epoch_that_is_over() -> None:
    async def main() -> None:
        async with running() as robot:
            robot.stop(2)
            robot.set_light((255, 0, 0), 1)
            for _ in range(5):
                assert (await robot.tick()).light == (0, 0, 0)
            robot.set_light((0, 255, 0), 2)
            await ticks_until(robot, lambda state: state.light == (0, 255, 0))

    run(main)


@pytest.mark.parametrize("light_first", [False, True])
def test_a_light_and_a_beep_at_once_are_both_done(light_first: bool) -> None:
    async def main() -> None:
        async with running() as robot:
            at = (await robot.tick()).t
            signals = [lambda: robot.beep(2.0, 1), lambda: robot.set_light((255, 0, 0), 1)]
            for signal_now in reversed(signals) if light_first else signals:
                signal_now()
            await ticks_until(robot, lambda state: state.light == (255, 0, 0))
            assert float(robot.memory.state.get()["buzzer_until"]) > at + 1.9

    run(main)


def test_without_the_memory_for_it_the_robot_says_what_is_missing() -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))  # not one more
    try:
        with pytest.raises(RobotError, match="cannot be had: Too many open files") as caught:
            Memory.create()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert caught.value.exit_code is ExitCode.MISSING
    assert "ulimit" in caught.value.hint


def test_a_command_without_a_successor_dies() -> None:
    async def main() -> None:
        async with running() as robot:
            await keep_driving(robot, FORWARD, 1, 30)
            state = await ticks_until(robot, lambda state: not state.moving)
            assert state.epoch == 1
            assert state.halted is None

    run(main)


def test_a_robot_that_cannot_be_had_again_can_be_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def main() -> None:
        async with running() as robot:
            at = (await keep_driving(robot, FORWARD, 1, 50)).pose
            assert robot.pid is not None
            os.kill(robot.pid, signal.SIGKILL)
            with pytest.raises(RobotError):
                await robot.tick()
            with monkeypatch.context() as broken:
                broken.setattr("engine.child.sys.executable", "/nonexistent/python")
                with pytest.raises(RobotError, match="cannot be started"):
                    await robot.start()
            with pytest.raises(RobotError, match="SIGKILL"):
                robot.state()
            await robot.start()
            assert robot.state().pose.distance_to(at) < 0.05

    run(main)


def test_all_who_wait_get_the_same_tick() -> None:
    async def main() -> None:
        async with running() as robot:
            for _ in range(20):
                states = await asyncio.gather(*(robot.tick() for _ in range(5)))
                assert len({state.t for state in states}) == 1

    run(main)


def test_at_full_speed_time_passes_only_while_somebody_waits() -> None:
    async def main() -> None:
        async with running() as robot:
            first = await robot.tick()
            for _ in range(100):
                await asyncio.sleep(0)
            assert robot.state().t == first.t
            assert (await robot.tick()).t == pytest.approx(first.t + 0.02)

    run(main)


def test_the_same_commands_give_the_same_trajectory() -> None:
    async def trajectory() -> list[RobotState]:
        async with running(odometry_noise=0.05, seed=7) as robot:
            states = []
            for i in range(150):
                robot.drive(Twist(0.4, 0.1 * math.sin(i / 10), 0.8), 1)
                if i == 40:
                    robot.move_arm((0.4, 0.1, 1.0, 0.5, 0.0), 1)
                states.append(await robot.tick())
            return states

    assert run(trajectory) == run(trajectory)


def test_arm_gripper_and_light_do_as_told() -> None:
    async def main() -> None:
        async with running() as robot:
            goal = (0.5, 0.2, 1.0, 0.8, -0.3)
            robot.move_arm(goal, 1)
            robot.set_gripper(1.0, 1)
            robot.set_light((255, 128, 0), 1)
            before = await robot.tick()
            for _ in range(150):
                state = await robot.tick()
                moved = [abs(a - b) for a, b in zip(state.joint_targets, before.joint_targets, strict=True)]
                assert max(moved) <= 1.0 * 0.02 + 1e-6, "faster than the speed asked for"
                before = state
            assert state.joints == pytest.approx(goal, abs=0.02)
            assert state.gripper == pytest.approx(1.0, abs=0.02)
            assert state.light == (255, 128, 0)

    run(main)


def test_a_stop_holds_the_arm_where_it_is() -> None:
    async def main() -> None:
        async with running() as robot:
            robot.move_arm((2.0, 0.0, 0.0, 0.0, 0.0), 1)
            for _ in range(40):
                await robot.tick()
            robot.stop(2)
            for _ in range(10):
                held = await robot.tick()
            for _ in range(50):
                state = await robot.tick()
            assert state.joints == pytest.approx(held.joints, abs=0.01)
            assert abs(state.joints[0] - 2.0) > 0.5

    run(main)


def test_values_that_are_not_finite_are_refused() -> None:
    async def main() -> None:
        async with running() as robot:
            for bad in (math.nan, math.inf, -math.inf):
                with pytest.raises(ValueError, match="finite"):
                    robot.drive(Twist(bad, 0, 0), 1)
                with pytest.raises(ValueError, match="finite"):
                    robot.move_arm((0, 0, bad, 0, 0), 1)
            assert not (await robot.tick()).moving

    run(main)


def test_it_can_be_started_and_closed_again_and_again_without_leaving_anything() -> None:

    async def main() -> tuple[set[int], list[str], list[str]]:
        robot = SimRobot(settings())
        pids = set()
        await robot.start()  # the loop's thread pool and self-pipe exist after the first time
        await robot.close()
        gc.collect()  # what earlier tests left to the collector must not be closed in between
        before = open_files()
        for _ in range(3):
            await robot.start()
            assert robot.pid is not None
            pids.add(robot.pid)
            await robot.tick()
            await robot.close()
            await robot.close()
            with pytest.raises(RobotError):
                robot.state()
        return pids, before, open_files()

    pids, before, after = run(main)
    assert after == before
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_whoever_still_knows_a_process_that_was_released_holds_no_file_open() -> None:
    before = open_files()
    memory = Memory.create()
    process = HostProcess(settings(), memory, {})
    assert open_files() != before
    process.kill()
    process.release()
    os.close(memory.fd)
    del memory
    assert open_files() == before
    assert process.epitaph() is not None


def test_cancelling_the_start_leaves_no_process() -> None:
    async def main() -> None:
        robot = SimRobot(settings())
        starting = asyncio.create_task(robot.start())
        await asyncio.sleep(0)
        pid = robot.pid
        assert pid is not None
        starting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await starting
        assert not psutil.pid_exists(pid)

    run(main)


def test_a_scene_that_does_not_exist_is_named_with_the_nearest_that_does() -> None:
    with pytest.raises(SceneError, match="Did you mean flat"):
        SimRobot(settings(scene="flatt"))
