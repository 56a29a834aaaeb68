"""How many of the tasks of the suite the robot does, each in a world of its own, judged from physics.

Every kind runs with the seeds 0 … N − 1; every run is a whole engine in a simulation as fast as the machine. What goes
on is told on stderr. The times of real time have the start of the engine and the judging in them.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from tests.bench.report import machine
from tests.eval.runner import Verdict, run
from tests.eval.tasks import tasks, trial


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="sayso bench tasks", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each kind")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--only", metavar="WORDS", action="append", help="only kinds whose name has this in it")
    parser.add_argument("--speed", choices=["max", "real"], default="max", help="how fast simulated time passes")
    args = parser.parse_args(argv)
    known = tasks()
    chosen = [kind for kind in known if not args.only or any(words in kind for words in args.only)]
    if not chosen:
        parser.error(f"no kind of task is called that; there are: {', '.join(known)}")
    verdicts = []
    for kind in chosen:
        for seed in range(args.first, args.first + args.seeds):
            verdict = run(trial(kind, known[kind], seed), speed=args.speed)
            verdicts.append(verdict)
            _tell(verdict)
    result = summary(verdicts)
    if args.json:
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
    else:
        _print(result)
    return 0


def summary(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """All figures as one JSON object."""
    kinds: dict[str, Any] = {}
    for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
        mine = [verdict for verdict in verdicts if verdict.kind == kind]
        kinds[kind] = {**_figures(mine), "failures": {v.seed: v.reason for v in mine if not v.ok}}
    return {"bench": "tasks", "n": len(verdicts), "machine": machine(), "all": _figures(verdicts), "kinds": kinds}


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
    table = Table(title=f"tasks (n = {result['n']})", caption=f"{result['machine']['cpu']}; times are medians")
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
