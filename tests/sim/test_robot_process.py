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
from pathlib import Path

import numpy as np
import psutil
import pytest

from engine.errors import RobotError, SceneError
from engine.robot.robot import ZERO, Pose, RobotState, Twist
from engine.robot.sim.memory import LOOP_SAMPLES, REST_TIME, STEPS, ZERO_TIME, Memory
from engine.robot.sim.robot import SimRobot
from tests.sim.rig import beating, keep_driving, run, running, settings, ticks_until

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


async def silence(robot: SimRobot, epoch: int) -> RobotState:
    """Let an engine that drives on fall silent until the robot has halted and stands."""
    assert (await keep_driving(robot, FORWARD, epoch, 25)).halted is None
    halted = await keep_driving(robot, FORWARD, epoch, 1, beating=False)
    while halted.halted is None:
        halted = await keep_driving(robot, FORWARD, epoch, 1, beating=False)
    assert halted.halted == "heartbeat lost"
    assert halted.command == ZERO
    return await ticks_until(robot, lambda state: not state.moving, beating=False)


def test_a_robot_that_halted_stays_halted_for_all_that_belongs_to_the_epoch_before() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            rest = await silence(robot, 1)
            robot.move_arm((0.5, 0, 0, 0, 0), 1)
            after = await keep_driving(robot, FORWARD, 1, 25)
            assert after.halted == "heartbeat lost"
            assert after.command == ZERO
            assert after.pose.distance_to(rest.pose) < 0.01
            assert after.joint_targets == rest.joint_targets

    run(main)


def test_a_new_epoch_releases_a_robot_that_halted_once_the_engine_beats_again() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            await silence(robot, 1)
            robot.stop(2)
            silent = await keep_driving(robot, FORWARD, 2, 10, beating=False)
            assert silent.epoch == 2
            assert silent.halted == "heartbeat lost"
            assert not silent.moving
            assert (await keep_driving(robot, FORWARD, 2, 10)).moving

    run(main)


def test_a_command_given_with_the_epoch_that_releases_the_robot_is_carried_out() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            await silence(robot, 1)
            robot.heartbeat()
            robot.stop(2)
            robot.set_gripper(1.0, 2)
            await ticks_until(robot, lambda state: state.gripper > 0.95)

    run(main)


def test_a_robot_that_halted_still_shows_its_light() -> None:
    async def main() -> None:
        async with running(speed="real") as robot:
            await silence(robot, 1)
            robot.set_light((255, 0, 0), 1)
            state = await ticks_until(robot, lambda state: state.light == (255, 0, 0))
            assert state.halted

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


@pytest.mark.parametrize("speed", ["max", "real"])
def test_a_frozen_robot_process_is_not_waited_for_for_ever(monkeypatch: pytest.MonkeyPatch, speed: str) -> None:
    monkeypatch.setattr("engine.robot.sim.robot.ANSWER_LIMIT", 0.3)

    async def main() -> None:
        async with running(speed=speed) as robot, beating(robot):
            assert robot.pid is not None
            os.kill(robot.pid, signal.SIGSTOP)
            with pytest.raises(RobotError, match=r"not answered|silent"):
                await _tick_for_ever(robot)

    run(main)


@pytest.mark.parametrize("speed", ["max", "real"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM])
def test_a_lost_robot_starts_again_where_it_was(
    monkeypatch: pytest.MonkeyPatch, speed: str, number: signal.Signals
) -> None:
    monkeypatch.setattr("engine.robot.sim.robot.ANSWER_LIMIT", 0.5)

    async def main() -> None:
        async with running(speed=speed) as robot, beating(robot):
            robot.set_light((0, 0, 255), 1)
            robot.move_arm((0.5, 0.2, 1.0, 0.8, -0.3), 1)
            robot.set_gripper(1.0, 1)
            await keep_driving(robot, Twist(vx=0.5, wz=0.5), 1, 60)
            lost = robot.pid
            assert lost is not None
            os.kill(lost, number)
            with pytest.raises(RobotError):
                await _tick_for_ever(robot)
            before = robot._memory.state.get()  # type: ignore[union-attr]
            robot.stop(2)
            await robot.start()
            assert not psutil.pid_exists(lost)
            first = await robot.tick()
            assert first.epoch == 2, "the stop that came while there was no robot counts"
            assert first.command == ZERO
            assert not first.moving
            assert first.halted is None
            assert first.t >= before["t"]
            x, y, yaw = before["true_pose"].tolist()
            assert first.pose.distance_to(Pose(x, y, yaw)) < 0.001
            assert first.joints == pytest.approx(before["joints"].tolist(), abs=0.03)
            assert first.gripper == pytest.approx(float(before["gripper"]), abs=0.1)
            assert first.light == (0, 0, 255)
            objects = robot.memory.state.get()["qpos"] - before["qpos"]
            assert np.abs(objects).max() < 0.05, "nothing in the flat jumps"
            assert not (await keep_driving(robot, FORWARD, 1, 20)).moving, "what is over stays over"
            assert (await keep_driving(robot, FORWARD, 2, 20)).moving

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


ENGINE = textwrap.dedent(
    """
    import asyncio, sys
    from engine.robot.robot import Twist
    from tests.sim.rig import running

    async def main():
        async with running(speed=sys.argv[1]) as robot:
            said = False
            while True:
                robot.heartbeat()
                robot.drive(Twist(vx=0.5), 1)
                state = await robot.tick()
                if state.twist.vx > 0.45 and not said:
                    said = True
                    print(robot.pid, robot.memory.fd, flush=True)

    asyncio.run(main())
    """
)


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="reads another process's memory through /proc")
@pytest.mark.parametrize("speed", ["real", "max"])
@pytest.mark.parametrize("end", ["engine is killed", "robot process is told to end"])
def test_the_robot_comes_to_rest_before_its_process_ends(speed: str, end: str) -> None:
    with subprocess.Popen([sys.executable, "-c", ENGINE, speed], stdout=subprocess.PIPE, text=True) as engine:
        assert engine.stdout is not None
        pid, number = map(int, engine.stdout.readline().split())
        body = psutil.Process(pid)
        fd = os.open(f"/proc/{pid}/fd/{number}", os.O_RDWR)
        memory = Memory(fd)
        os.close(fd)
        if end == "engine is killed":
            engine.kill()
        else:
            body.terminate()
        body.wait(timeout=10)
        engine.kill()
    last = memory.state.get()
    assert last["halted"].item().decode() == ("engine gone" if end == "engine is killed" else "switched off")
    assert not last["command"].any()
    assert np.abs(last["twist"]).max() < 0.01
    assert memory.times[REST_TIME] >= memory.times[ZERO_TIME] > 0


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
