"""How much faster than real time the robot process is, and how evenly its 2 ms loop runs.

``step`` is one physics step of the whole flat with the safety envelope and the lidar in it, measured in this
process; ``lateness`` and ``busy`` come from the robot process itself, which keeps the timing of every step: how late
it woke up, and how long the step took. Each with and without real-time scheduling, the robot driving in circles
while ``--load`` threads keep the processor busy.
"""

from __future__ import annotations

import argparse
import asyncio
from time import perf_counter

import numpy as np

from engine.robot.geometry import Twist
from engine.robot.host.memory import LOOP_SAMPLES, OVERRUNS, SCHEDULING, STEPS
from engine.robot.sim.build import TIMESTEP
from engine.scheduling import from_word
from tests.bench.load import busy_machine
from tests.bench.report import Figure, figures, print_report, report
from tests.sim.rig import in_the_flat, running

CIRCLE = Twist(0.3, 0.0, 0.8)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench physics", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--seconds", type=float, default=8.0, help="robot time of each run")
    parser.add_argument("--load", type=int, default=2, help="processes that keep the processor busy; 0 for none")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    ratios: dict[str, float] = {}
    steps = _steps(args.seconds)
    found["step"] = figures(steps * 1e6, "µs")
    ratios["times real time, in hand"] = TIMESTEP / float(np.mean(steps))
    ratios["times real time, at full speed"] = asyncio.run(_full_speed(args.seconds))
    with busy_machine(args.load):
        for wanted in (True, False):
            name, loop, overruns = asyncio.run(_real_time(min(args.seconds, 15.0), realtime=wanted))
            found[f"lateness ({name})"] = figures(loop["late"] * 1e6, "µs")
            found[f"busy ({name})"] = figures(loop["busy"] * 1e6, "µs")
            ratios[f"overruns ({name})"] = overruns
    print_report(report("physics", len(steps), found, ratios), args.json)


def _steps(seconds: float) -> np.ndarray:
    """Seconds that each physics step takes while driving."""
    world, taken = in_the_flat(), []
    for i in range(round(seconds / TIMESTEP)):
        if i % 10 == 0:
            world.drive(CIRCLE)
        began = perf_counter()
        world.step()
        taken.append(perf_counter() - began)
    return np.array(taken)


async def _full_speed(seconds: float) -> float:
    """Robot time per wall time through the process, one command and one tick at a time."""
    async with running(speed="max") as robot:
        began = perf_counter()
        for _ in range(round(seconds / 0.02)):
            robot.drive(CIRCLE, 1)
            await robot.tick()
        return seconds / (perf_counter() - began)


async def _real_time(seconds: float, *, realtime: bool) -> tuple[str, np.ndarray, int]:
    """The name of the scheduling, the loop's own timing, and how often it fell behind for good."""
    async with running(speed="real", realtime_priority=realtime) as robot:
        memory = robot.memory
        for _ in range(round(seconds / 0.02)):
            robot.heartbeat()
            robot.drive(CIRCLE, 1)
            await robot.tick()
        steps = min(memory.ints[STEPS], LOOP_SAMPLES - 1)
        return from_word(memory.ints[SCHEDULING]), memory.loop[1:steps].copy(), memory.ints[OVERRUNS]


if __name__ == "__main__":
    main()
