"""From the word to the last process gone, for every shape of process tree that is hard to get rid of.

Who is alive is told by the kernel: every process of a shape holds the write end of one FIFO, so the end of file at
its read end is the moment when nobody is left. ``ratios`` are the survivors of all repetitions, which must be none.
Shapes with deaf members include the grace of 150 ms between SIGTERM and SIGKILL, storms as much of it as they are
given. "… killed" is from the SIGKILL of that process, without a word from us; "supervisors paused" from a word to
supervisors that were stopped. The budget is 350 ms.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
import tempfile
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from engine.process import ProcessTree
from tests.bench.load import busy_machine
from tests.bench.report import Figure, figures, print_report, report
from tests.rollcall import DEADLINE_S, RollCall, roll_call

Blow = Callable[[ProcessTree], Awaitable[object]]


@dataclass(frozen=True, slots=True)
class Trial:
    """A shape of ``tests.shapes`` and what is done to it; None: its host, a process that stands for the engine, is
    killed."""

    shape: str
    blow: Blow | None


async def word(tree: ProcessTree) -> None:
    await tree.kill()


async def warden_killed(tree: ProcessTree) -> None:
    os.kill(tree.supervisors[1], signal.SIGKILL)


async def guard_killed(tree: ProcessTree) -> None:
    os.kill(tree.supervisors[0], signal.SIGKILL)


async def both_killed(tree: ProcessTree) -> None:
    for number in (signal.SIGSTOP, signal.SIGKILL):
        for supervisor in tree.supervisors:
            os.kill(supervisor, number)
    await tree.kill()


async def supervisors_paused(tree: ProcessTree) -> None:
    for supervisor in tree.supervisors:
        os.kill(supervisor, signal.SIGSTOP)
    await tree.kill()


TRIALS = {
    "one process": Trial("single", word),
    "chain of five": Trial("chain", word),
    "children in their own sessions": Trial("sessions", word),
    "deaf to SIGTERM": Trial("ignoring", word),
    "paused children": Trial("paused", word),
    "orphans, deaf, without environment": Trial("orphans", word),
    "fork storm": Trial("storm", word),
    "orphans, warden killed": Trial("orphans", warden_killed),
    "orphans, guard killed": Trial("orphans", guard_killed),
    "sessions, both supervisors killed": Trial("sessions", both_killed),
    "orphans, supervisors paused": Trial("orphans", supervisors_paused),
    "orphans, engine killed": Trial("orphans", None),
    "fork storm, engine killed": Trial("storm", None),
}


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench kill", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=50, help="how often each tree is killed")
    parser.add_argument("--load", type=int, default=0, help="other processes that keep the processor busy")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    survivors: dict[str, float] = {}
    with busy_machine(args.load):
        for name, trial in TRIALS.items():
            outcomes = [asyncio.run(_once(trial)) for _ in range(args.n)]
            found[name] = figures((seconds * 1e3 for seconds, _ in outcomes), "ms")
            survivors[f"survivors, {name}"] = sum(left for _, left in outcomes)
    print_report(report("kill", args.n, found, survivors), args.json)


async def _once(trial: Trial) -> tuple[float, int]:
    """Seconds from the blow to nobody left, and how many were (the seconds are the deadline then)."""
    with tempfile.TemporaryDirectory() as folder:
        async with roll_call(Path(folder) / "roll") as roll:
            if trial.blow is None:
                return await _host_killed(trial.shape, roll)
            async with ProcessTree(roll.command(trial.shape)) as tree:
                await roll.complete(trial.shape)
                began = perf_counter()
                blow = asyncio.ensure_future(trial.blow(tree))
                outcome = await _wait(began, roll)
                await blow
                return outcome


async def _host_killed(shape: str, roll: RollCall) -> tuple[float, int]:
    command = [sys.executable, "-m", "tests.host", *roll.command(shape)]
    host = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.DEVNULL)
    await roll.complete(shape)
    began = perf_counter()
    host.kill()
    outcome = await _wait(began, roll)
    await host.wait()
    return outcome


async def _wait(began: float, roll: RollCall) -> tuple[float, int]:
    try:
        await roll.empty()
    except TimeoutError:
        return DEADLINE_S, len(roll.members())
    return perf_counter() - began, 0


if __name__ == "__main__":
    main()
