"""From ``robot.stop()`` to zero velocity commanded to the motors, on a busy machine.

The robot drives; at a random moment a thread of its own (as a key handler or the wake reader would be) calls
``stop()``. Both ends are stamped with the system's monotonic clock, the second by the robot process at the moment
the motors are told. Beside it run: matrix multiplication in other processes, and in threads of the same process the
recogniser, decoding all the time, the console, drawing a robot on its way, and the engine's loop with its heartbeat.
``rest`` is when the base has come to rest.
"""

from __future__ import annotations

import argparse
import asyncio
import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path

import numpy as np

from config import load
from engine.audio.wav import read_wav
from engine.loading import make_recogniser
from engine.robot.robot import Twist
from engine.robot.sim.memory import REST_TIME, SCHEDULING, STOP_TIME, STOPPED_EPOCH, ZERO_TIME
from engine.robot.sim.robot import SimRobot
from engine.robot.sim.scheduling import from_word
from tests.bench.load import busy_machine
from tests.bench.report import Figure, figures, print_report, report
from tests.sim.rig import running
from tests.tui.scripted import engine_for
from tui.app import SaysoApp

SPEED = 0.3
LONGEST_DRIVE = 0.12  # s before a stop comes


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench interrupt", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=1000, help="how many stops, with and without real-time scheduling")
    parser.add_argument("--load", type=int, default=2, help="other processes that keep the processor busy")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    with busy_machine(args.load), _busy_threads():
        for wanted in (True, False):
            name, zero, rest = asyncio.run(_interrupts(args.n, realtime=wanted))
            if f"zero ({name})" in found:
                continue  # real-time scheduling is not allowed here: both runs were the same
            found[f"zero ({name})"] = figures(zero * 1e3, "ms")
            found[f"rest ({name})"] = figures(rest * 1e3, "ms")
    print_report(report("interrupt", args.n, found), args.json)


async def _interrupts(n: int, *, realtime: bool) -> tuple[str, np.ndarray, np.ndarray]:
    """Scheduling, and seconds from each stop to zero commanded and to rest."""
    chance = random.Random(0)
    zero, rest = [], []
    async with running(speed="real", realtime_priority=realtime) as robot:
        memory = robot.memory
        beating = asyncio.create_task(_beat(robot))
        for epoch in range(2, n + 2):
            direction = 1 if epoch % 2 else -1  # to and fro, so that it never runs into anything
            stopper = threading.Timer(chance.uniform(0.04, LONGEST_DRIVE), robot.stop, (epoch,))
            stopper.start()
            while memory.ints[STOPPED_EPOCH] != epoch:
                robot.drive(Twist(direction * SPEED), epoch - 1)
                await robot.tick()
            while memory.times[REST_TIME] < memory.times[ZERO_TIME]:
                await robot.tick()
            stopper.join()
            zero.append(memory.times[ZERO_TIME] - memory.times[STOP_TIME])
            rest.append(memory.times[REST_TIME] - memory.times[STOP_TIME])
        beating.cancel()
        return from_word(memory.ints[SCHEDULING]), np.array(zero), np.array(rest)


async def _beat(robot: SimRobot) -> None:
    while True:
        robot.heartbeat()
        await asyncio.sleep(0.05)


@contextmanager
def _busy_threads() -> Iterator[None]:
    """A recogniser that never stops decoding and a console that never stops drawing, in threads of this process."""
    recogniser = make_recogniser(load())
    recogniser.load()
    speech = read_wav(Path(str(files("assets") / "speech" / "go_to_the_bedroom_then_turn_around.wav")))
    samples = (speech / 32768).astype(np.float32)
    done = threading.Event()

    def recognise() -> None:
        while not done.is_set():
            recogniser.transcribe(samples)

    console = SaysoApp(lambda: engine_for(["--act"]))
    threads = [
        threading.Thread(target=recognise),
        threading.Thread(target=console.run, kwargs={"headless": True, "size": (120, 40)}),
    ]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        done.set()
        console.call_from_thread(console.exit)
        for thread in threads:
            thread.join()


if __name__ == "__main__":
    main()
