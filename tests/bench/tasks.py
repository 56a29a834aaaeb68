"""How many of the tasks of the suite the robot does, each in a world of its own, judged from physics.

Every kind runs with the seeds 0 … N − 1; every run is a whole engine, with processes of its own, in a simulation as
fast as the machine. As many run side by side as there are cores, because engine and physics take turns; what each does
is the same however many there are. What goes on is told on stderr.

*Times real time* of a kind is what one engine reached, beside the others, its start and the judging included. That of
all is the robot time of all runs over the wall time of the whole suite, with everything in it.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, get_args

from rich.console import Console
from rich.table import Table

from tests.bench.report import machine
from tests.eval.runner import Through, Verdict, run
from tests.eval.tasks import Trial, tasks, trial


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="sayso bench tasks", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each kind")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--only", metavar="WORDS", action="append", help="only kinds whose name has this in it")
    parser.add_argument("--speed", choices=["max", "real"], default="max", help="how fast simulated time passes")
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="runs side by side; default: one a core at full speed, one in real time"
    )
    parser.add_argument(
        "--through", choices=get_args(Through), default="host", help="what the robot is driven through (host)"
    )
    args = parser.parse_args(argv)
    jobs = args.jobs or (machine()["cores"] if args.speed == "max" else 1)
    if jobs < 1:
        parser.error("--jobs must be at least 1")
    known = tasks()
    chosen = [kind for kind in known if not args.only or any(words in kind for words in args.only)]
    if not chosen:
        parser.error(f"no kind of task is called that; there are: {', '.join(known)}")
    seeds = range(args.first, args.first + args.seeds)
    trials = [trial(kind, known[kind], seed) for kind in chosen for seed in seeds]
    began = time.monotonic()
    verdicts = []
    for verdict in verdicts_of(trials, args.speed, jobs, through=args.through):
        verdicts.append(verdict)
        _tell(verdict)
    verdicts.sort(key=lambda verdict: (chosen.index(verdict.kind), verdict.seed))
    result = summary(verdicts, jobs, time.monotonic() - began)
    if args.json:
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
    else:
        _print(result)
    return 0


def verdicts_of(trials: Sequence[Trial], speed: str, jobs: int, *, through: Through = "host") -> Iterator[Verdict]:
    """Perform all trials, so many side by side; the verdicts as they come."""
    if jobs == 1:
        yield from (run(trial, speed=speed, through=through) for trial in trials)
        return
    with ProcessPoolExecutor(min(jobs, len(trials)), multiprocessing.get_context("spawn")) as workers:
        runs = [workers.submit(run, trial, speed=speed, through=through) for trial in trials]
        try:
            yield from (done.result() for done in as_completed(runs))
        finally:
            workers.shutdown(wait=False, cancel_futures=True)


def summary(verdicts: Sequence[Verdict], jobs: int, wall_s: float) -> dict[str, Any]:
    """All figures as one JSON object; ``wall_s`` is what the whole suite took."""
    kinds: dict[str, Any] = {}
    for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
        mine = [verdict for verdict in verdicts if verdict.kind == kind]
        kinds[kind] = {**_figures(mine), "failures": {v.seed: v.reason for v in mine if not v.ok}}
    everything = {**_figures(verdicts), "times_real_time": round(sum(v.robot_s for v in verdicts) / wall_s, 1)}
    return {
        "bench": "tasks",
        "n": len(verdicts),
        "machine": machine(),
        "jobs": jobs,
        "suite_s": round(wall_s, 1),
        "all": everything,
        "kinds": kinds,
    }


def _figures(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    robot_s, wall_s = sum(v.robot_s for v in verdicts), sum(v.wall_s for v in verdicts)
    return {
        "runs": len(verdicts),
        "done": sum(v.ok for v in verdicts),
        "success": round(sum(v.ok for v in verdicts) / len(verdicts), 3),
        "robot_s": round(statistics.median(v.robot_s for v in verdicts), 1),
        "wall_s": round(statistics.median(v.wall_s for v in verdicts), 1),
        "times_real_time": round(robot_s / wall_s, 1),
    }


def _tell(verdict: Verdict) -> None:
    mark = "✓" if verdict.ok else "✗"
    line = f"{mark} {verdict.kind} #{verdict.seed}: {verdict.robot_s:.0f} s of robot time in {verdict.wall_s:.0f} s"
    sys.stderr.write(f"{line}{'' if verdict.ok else '. ' + verdict.reason}\n")
    sys.stderr.flush()


def _print(result: dict[str, Any]) -> None:
    console = Console()
    how = f"{result['jobs']} side by side, {result['suite_s']} s in all"
    caption = f"{result['machine']['cpu']}; times are medians; {how}"
    table = Table(title=f"tasks (n = {result['n']})", caption=caption)
    for column in ("kind", "done", "robot time", "wall time", "× real time"):
        table.add_column(column, justify="left" if column == "kind" else "right")
    for name, row in [*result["kinds"].items(), ("all", result["all"])]:
        done = f"{row['done']}/{row['runs']}"
        table.add_row(name, done, f"{row['robot_s']} s", f"{row['wall_s']} s", f"{row['times_real_time']}")
    console.print(table)
    for name, row in result["kinds"].items():
        for seed, reason in row["failures"].items():
            console.print(f"  {name} #{seed}: {reason}", soft_wrap=True, highlight=False)


if __name__ == "__main__":
    sys.exit(main())
