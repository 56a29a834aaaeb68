"""The robot in its own process: stops, epochs, heartbeat, loss, and nothing left behind."""

from __future__ import annotations

import asyncio
import gc
import math
import os
import signal
import subprocess
import sys
import textwrap

import numpy as np
import psutil
import pytest

from engine.errors import RobotError, SceneError
from engine.robot.robot import ZERO, RobotState, Twist
from engine.robot.sim.memory import LOOP_SAMPLES, STEPS
from engine.robot.sim.robot import SimRobot
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


def test_a_stop_from_another_thread_needs_no_loop() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            await keep_driving(robot, FORWARD, 1, 25)
            await asyncio.to_thread(robot.stop, 2)
            state = await ticks_until(robot, lambda state: state.epoch == 2)
            assert state.command == ZERO

    run(main)


def test_the_robot_halts_when_the_heartbeat_is_lost_and_waits_for_a_new_command() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            assert (await keep_driving(robot, FORWARD, 1, 25)).halted is None
            robot.heartbeat()
            robot.drive(FORWARD, 1)
            halted = await keep_driving(robot, FORWARD, 1, 1, beating=False)
            while halted.halted is None:
                halted = await keep_driving(robot, FORWARD, 1, 1, beating=False)
            assert halted.halted == "heartbeat lost"
            assert halted.command == ZERO
            rest = await ticks_until(robot, lambda state: not state.moving, beating=False)
            again = await ticks_until(robot, lambda state: state.halted is None)
            assert again.command == ZERO, "what was commanded before the silence is void"
            assert again.pose.distance_to(rest.pose) < 0.01
            assert (await keep_driving(robot, FORWARD, 1, 10)).moving

    run(main)


def test_a_command_without_a_successor_dies() -> None:
    async def main() -> None:
        async with running() as robot:
            await keep_driving(robot, FORWARD, 1, 30)
            state = await ticks_until(robot, lambda state: not state.moving)
            assert state.epoch == 1
            assert state.halted is None

    run(main)


@pytest.mark.parametrize("speed", ["max", "real"])
def test_a_killed_robot_process_is_an_error_for_all_who_wait(speed: str) -> None:
    async def main() -> None:
        async with running(speed=speed) as robot:
            await robot.tick()
            assert robot.pid is not None
            waiting = [asyncio.create_task(_tick_for_ever(robot)) for _ in range(3)]
            await asyncio.sleep(0)
            os.kill(robot.pid, signal.SIGKILL)
            for outcome in await asyncio.gather(*waiting, return_exceptions=True):
                assert isinstance(outcome, RobotError)
                assert "SIGKILL" in str(outcome)
            for access in (robot.state, robot.scan, lambda: robot.drive(FORWARD, 1)):
                with pytest.raises(RobotError):
                    access()
            robot.stop(2)  # never raises: whoever stops must not have to ask whether there is a robot

    run(main)


async def _tick_for_ever(robot: SimRobot) -> None:
    while True:
        await robot.tick()


def test_a_frozen_robot_process_at_full_speed_is_not_waited_for_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.robot.sim.robot.ANSWER_LIMIT", 0.2)

    async def main() -> None:
        async with running() as robot:
            assert robot.pid is not None
            os.kill(robot.pid, signal.SIGSTOP)
            with pytest.raises(RobotError, match="not answered"):
                await robot.tick()

    run(main)


def test_all_who_wait_get_the_same_tick() -> None:
    async def main() -> None:
        async with running() as robot:
            for _ in range(20):
                states = await asyncio.gather(*(robot.tick() for _ in range(5)))
                assert len({state.t for state in states}) == 1

    run(main)


def test_one_who_stops_waiting_does_not_disturb_the_others() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            tired, patient = asyncio.create_task(robot.tick()), asyncio.create_task(robot.tick())
            await asyncio.sleep(0)
            tired.cancel()
            assert isinstance(await patient, RobotState)
            assert tired.cancelled()
            first, second = await robot.tick(), await robot.tick()
            assert second.t > first.t

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
            robot.set_light((255, 128, 0))
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
    me = psutil.Process()

    async def main() -> tuple[set[int], int, int]:
        robot = SimRobot(settings())
        pids = set()
        await robot.start()  # the loop's thread pool and self-pipe exist after the first time
        await robot.close()
        gc.collect()  # what earlier tests left to the collector must not be closed in between
        before = me.num_fds()
        for _ in range(3):
            await robot.start()
            assert robot.pid is not None
            pids.add(robot.pid)
            await robot.tick()
            await robot.close()
            await robot.close()
            with pytest.raises(RobotError):
                robot.state()
        return pids, before, me.num_fds()

    pids, before, after = run(main)
    assert after == before
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_the_robot_process_ends_when_the_engine_is_killed() -> None:
    program = textwrap.dedent(
        """
        import asyncio, sys
        from tests.sim.rig import running

        async def main():
            async with running(speed=sys.argv[1]) as robot:
                print(robot.pid, flush=True)
                while True:
                    robot.heartbeat()
                    await robot.tick()

        asyncio.run(main())
        """
    )
    for speed in ("real", "max"):
        with subprocess.Popen([sys.executable, "-c", program, speed], stdout=subprocess.PIPE, text=True) as engine:
            assert engine.stdout is not None
            body = psutil.Process(int(engine.stdout.readline()))
            engine.kill()
            body.wait(timeout=10)


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


def test_the_control_loop_keeps_its_own_timing() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            memory = robot.memory
            for _ in range(10):
                await robot.tick()
            steps = memory.ints[STEPS]
            assert 0 < steps < LOOP_SAMPLES
            assert np.all(memory.loop["busy"][1:steps] > 0)

    run(main)
