"""From an interruption to zero velocity commanded to the motors, and to the base at rest.

The robot drives, at a random moment somebody interrupts, and the robot process notes when the motors are told zero and
when the base has come to rest. Whoever interrupts is, one after the other: *stop()*, a thread that calls the robot
itself; and, in a whole sayso on a pseudo-terminal (``tests.bench.rig``), the *key*, from the byte written to the
terminal; a *wake*, from the byte written to its pipe, and on to the engine listening; a *command*, from the JSON line
written to its pipe; and *speech*, a "stop" at the simulated microphone, from the end of the word: where the voice of
the recording has fallen 35 dB below its loudest 20 ms. Voice activity, recogniser and session come after that.

All but "idle" have matrix multiplication in other processes beside them, and all but *speech* one more recogniser that
decodes all the time: like a sayso's own, in a process that belongs to the one that is interrupted. Ratios are figures
over their budgets, so that 1 or less is inside, and the shares of what did not come about: stops that were not heard,
wakes after which nobody listened, and drives that the robot broke off by itself because the machine was too busy for a
heartbeat.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from engine.robot.geometry import Twist
from engine.robot.host.memory import REST_TIME, SCHEDULING, STOPPED_EPOCH, ZERO_TIME, Memory
from engine.robot.sim.robot import SimRobot
from engine.scheduling import Scheduling, from_word, raise_priority
from tests.bench.load import busy_machine, busy_recogniser
from tests.bench.report import Figure, figures, print_report, report
from tests.bench.rig import PATIENCE_S, Rig, rig
from tests.sim.rig import running
from tests.tui.scripted import engine_for
from tui.app import SaysoApp

SPEED = 0.3
LONGEST_DRIVE = 0.12  # s before an interruption comes
LISTENING_LIMIT = 2.0
"""s after a wake from which it counts as lost."""
HEARING_LIMIT = 2.0
"""s after the end of the word from which a spoken stop counts as not heard."""

BUDGETS: dict[tuple[str, Scheduling], dict[str, float]] = {
    ("zero", "realtime"): {"p99": 5, "max": 20},
    ("zero", "nice"): {"p99": 20},
    ("zero", "normal"): {"p99": 20},
    ("spoken", "realtime"): {"p95": 600},
    ("spoken", "nice"): {"p95": 600},
    ("spoken", "normal"): {"p95": 600},
}
"""ms, by what is measured and the scheduling of the robot process."""


class Findings:
    """Figures, and how they compare to their budgets."""

    def __init__(self) -> None:
        self.figures: dict[str, Figure] = {}
        self.ratios: dict[str, float] = {}

    def add(self, what: str, of: str, scheduling: Scheduling, seconds: list[float]) -> None:
        name = f"{what}, {of} ({scheduling})"
        if not seconds:
            return  # nothing was heard: the share of misses says so
        figure = self.figures[name] = figures((s * 1e3 for s in seconds), "ms")
        for statistic, limit in BUDGETS.get((what, scheduling), {}).items():
            value: float = figure[statistic]  # type: ignore[literal-required]
            self.ratios[f"{name}: {statistic} / budget of {limit:g} ms"] = value / limit


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench interrupt", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=1000, help="how many stop(); a fifth as many of each of the others")
    parser.add_argument("--load", type=int, default=2, help="other processes that keep the processor busy")
    parser.add_argument("--camera", action="store_true", help="the screen shows what the camera sees as well")
    args = parser.parse_args(argv)
    found, few = Findings(), max(1, args.n // 5)
    with busy_machine(args.load):
        measured: set[Scheduling] = set()
        for wanted in (True, False):
            with busy_recogniser(prompt=wanted), _busy_console():
                scheduling = asyncio.run(_direct(args.n, found, realtime=wanted, known=measured))
            if scheduling in measured:
                break  # real-time scheduling is not allowed here: both runs would be the same
            measured.add(scheduling)
            scheduled = f"robot.realtime_priority={str(wanted).lower()}"
            with rig(decoding=True, camera=args.camera, settings=(scheduled,)) as sayso, _punctual():
                _interrupted(sayso, few, found)
    with rig(decoding=False, camera=args.camera) as sayso, _punctual():  # its own recogniser is the one that hears
        with busy_machine(args.load):
            _spoken(sayso, few, found, "busy")
        _spoken(sayso, few, found, "idle")
    print_report(report("interrupt", args.n, found.figures, found.ratios), args.json)
    if not args.json:
        outside = [name for name, ratio in found.ratios.items() if "budget" in name and ratio > 1]
        print("Outside of the budget: " + "; ".join(outside) if outside else "All inside of the budgets.")


# stop() itself


async def _direct(n: int, found: Findings, *, realtime: bool, known: set[Scheduling]) -> Scheduling:
    """A robot without an engine; returns how its process is scheduled."""
    chance = random.Random(0)
    zero, rest = [], []
    async with running(speed="real", realtime_priority=realtime) as robot:
        memory = robot.memory
        scheduling = from_word(memory.ints[SCHEDULING])
        if scheduling in known:
            return scheduling
        beating = asyncio.create_task(_beat(robot))
        for epoch in range(2, n + 2):
            direction = 1 if epoch % 2 else -1  # to and fro, so that it never runs into anything
            said: list[float] = []
            stopper = threading.Timer(chance.uniform(0.04, LONGEST_DRIVE), _stop, (robot, epoch, said, realtime))
            stopper.start()
            while memory.ints[STOPPED_EPOCH] != epoch:
                robot.drive(Twist(direction * SPEED), epoch - 1)
                await robot.tick()
            while memory.times[REST_TIME] < memory.times[ZERO_TIME]:
                await robot.tick()
            stopper.join()
            zero.append(memory.times[ZERO_TIME] - said[0])
            rest.append(memory.times[REST_TIME] - said[0])
        beating.cancel()
    found.add("zero", "stop()", scheduling, zero)
    found.add("rest", "stop()", scheduling, rest)
    return scheduling


def _stop(robot: SimRobot, epoch: int, said: list[float], realtime: bool) -> None:
    """Stop it as the engine's threads do: with the best scheduling there is, where that is asked for."""
    if realtime:
        raise_priority()
    said.append(time.monotonic())
    robot.stop(epoch)


async def _beat(robot: SimRobot) -> None:
    while True:
        robot.heartbeat()
        await asyncio.sleep(0.05)


@contextmanager
def _busy_console() -> Iterator[None]:
    """A console that never stops drawing, in a thread of this process."""
    console = SaysoApp(lambda: engine_for(["--act"]))
    thread = threading.Thread(target=console.run, kwargs={"headless": True, "size": (120, 40)})
    thread.start()
    try:
        yield
    finally:
        console.call_from_thread(console.exit)
        thread.join()


# A whole sayso


@contextmanager
def _punctual() -> Iterator[None]:
    """Whoever looks at the clock and then interrupts must not be kept waiting in between: that would be measured."""
    raise_priority()
    try:
        yield
    finally:
        if hasattr(os, "sched_setscheduler"):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _interrupted(sayso: Rig, n: int, found: Findings) -> None:
    """By key, wake and command in turn."""
    scheduling = from_word(sayso.memory.ints[SCHEDULING])
    acts: dict[str, Callable[[], None]] = {
        "key": sayso.press_escape,
        "wake": sayso.wake,
        "command": lambda: sayso.command("interrupt"),
    }
    zero: dict[str, list[float]] = {name: [] for name in acts}
    rest: dict[str, list[float]] = {name: [] for name in acts}
    listening: list[float] = []
    chance = random.Random(0)
    for _ in range(n):
        for name, act in acts.items():
            sayso.drive()
            time.sleep(chance.uniform(0, LONGEST_DRIVE))
            began = time.monotonic()
            act()
            told, stood = _stop_since(sayso, began)
            zero[name].append(told - began)
            rest[name].append(stood - began)
            if name == "wake" and (at := sayso.when("listen.started", began, LISTENING_LIMIT)) is not None:
                listening.append(at - began)
    for name in acts:
        found.add("zero", name, scheduling, zero[name])
        found.add("rest", name, scheduling, rest[name])
    found.add("listening", "wake", scheduling, listening)
    found.ratios[f"wakes without listening ({scheduling})"] = 1 - len(listening) / n
    found.ratios[f"drives lost to a halt ({scheduling})"] = sayso.lost / (3 * n)


def _stop_since(sayso: Rig, began: float) -> tuple[float, float]:
    """When the motors were told zero, and when the base had come to rest."""
    memory = sayso.memory
    if not sayso.came_true(lambda: memory.times[REST_TIME] >= memory.times[ZERO_TIME] >= began, PATIENCE_S):
        raise SystemExit(f"{PATIENCE_S:g} s after an interruption the robot has not come to rest.")
    return memory.times[ZERO_TIME], memory.times[REST_TIME]


def _spoken(sayso: Rig, n: int, found: Findings, machine: str) -> None:
    memory: Memory = sayso.memory
    zero, rest, missed = [], [], 0
    for _ in range(n):
        sayso.drive()
        began = time.monotonic()
        end = sayso.say_stop()
        if sayso.came_true(lambda: memory.times[ZERO_TIME] >= began, end + HEARING_LIMIT - time.monotonic()):  # noqa: B023
            told, stood = _stop_since(sayso, began)
            zero.append(told - end)
            rest.append(stood - end)
        else:
            missed += 1
            sayso.command("interrupt")
            _stop_since(sayso, began)
    scheduling = from_word(memory.ints[SCHEDULING])
    found.add("spoken", machine, scheduling, zero)
    found.add("rest, spoken", machine, scheduling, rest)
    found.ratios[f"spoken stops not heard, {machine}"] = missed / n


if __name__ == "__main__":
    main()
