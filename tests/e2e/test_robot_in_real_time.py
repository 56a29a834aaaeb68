"""The robot in its own process, against the clock: heartbeat, pauses, loss, and how it ends."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import pytest

from engine.errors import RobotError
from engine.perception.memory import WorldMemory
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.memory import LOOP_SAMPLES, REST_TIME, STEPS, ZERO_TIME, Memory
from engine.robot.robot import UNDECIDED, RobotState
from engine.robot.sim.robot import SimRobot
from engine.skills.library.motion import set_cmdvel
from tests.sim.inhand import context_of
from tests.sim.rig import beating, keep_driving, run, running, ticks_until

FORWARD = Twist(vx=0.3)


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


async def seen(robot: SimRobot, met: Callable[[RobotState], bool]) -> None:
    """Look at the robot, without waiting for its ticks, until its state meets the condition."""
    async with asyncio.timeout(20):
        while not met(robot.state()):  # noqa: ASYNC110 - a paused robot gives no ticks
            await asyncio.sleep(0)


@pytest.mark.parametrize("speed", ["max", "real"])
def test_nobody_gets_a_tick_of_a_paused_robot(speed: str) -> None:
    async def main() -> None:
        async with running(speed=speed) as robot, beating(robot):
            before = await keep_driving(robot, FORWARD, 1, 25)
            token = robot.pause(1)
            waiting = asyncio.create_task(robot.tick())
            await seen(robot, lambda state: state.paused and not state.moving)
            assert not waiting.done()
            robot.resume(token)
            async with asyncio.timeout(5):
                after = await waiting
            assert not after.paused
            assert after.paused_s > 0.0
            assert after.work_t - before.work_t == pytest.approx(after.t - before.t - after.paused_s)
            assert after.pose.distance_to(before.pose) < 0.05
            assert (await keep_driving(robot, FORWARD, 1, 25)).moving

    run(main)


@pytest.mark.parametrize("speed", ["max", "real"])
def test_a_stop_frees_whoever_waits_for_a_tick_of_a_paused_robot(speed: str) -> None:
    async def main() -> None:
        async with running(speed=speed) as robot, beating(robot):
            await keep_driving(robot, FORWARD, 1, 25)
            robot.pause(1)
            waiting = asyncio.create_task(robot.tick())
            await seen(robot, lambda state: state.paused)
            await asyncio.to_thread(robot.stop, 2)
            async with asyncio.timeout(5):
                state = await waiting
            assert state.epoch == 2
            assert state.command == ZERO

    run(main)


def test_a_skill_that_drives_for_a_time_drives_as_far_with_a_pause_in_it() -> None:
    async def drive(pause: bool) -> float:
        async with running(speed="max") as robot:
            skill = asyncio.create_task(set_cmdvel.run(context_of(robot, WorldMemory()), 0.3, 0.0, 0.0, 3.0))
            if pause:
                await seen(robot, lambda state: state.t > 1.0)
                token = robot.pause(1)
                await seen(robot, lambda state: state.paused_s > 1.0)
                robot.resume(token)
            result = await skill
            assert result.ok, result.message
            return float(result.data["moved"])

    async def main() -> None:
        assert await drive(pause=True) == pytest.approx(await drive(pause=False), abs=0.05)

    run(main)


def test_a_pause_that_nobody_ends_halts_the_robot() -> None:
    async def main() -> None:
        async with running(speed="real") as robot, beating(robot):
            await keep_driving(robot, FORWARD, 1, 25)
            robot.pause(1)
            async with asyncio.timeout(10):
                state = await robot.tick()
            assert state.halted == UNDECIDED
            assert state.halted_in == 1
            assert not state.moving

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
    monkeypatch.setattr("engine.robot.host.hosted.ANSWER_LIMIT", 0.3)

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
    monkeypatch.setattr("engine.robot.host.hosted.ANSWER_LIMIT", 0.5)

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


ENGINE = textwrap.dedent(
    """
    import asyncio, sys
    from engine.robot.geometry import Twist
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
