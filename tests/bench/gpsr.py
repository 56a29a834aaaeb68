"""How many commands of the General Purpose Service Robot grammar the robot understands, does, and tells truly.

Commands are drawn from the grammar's own files (``--data``, or the folder that SAYSO_GPSR names; they are not part of
this repository), each category as often as the others. Each is performed by a whole engine in a simulated house of its
own with people in it, and judged from outside: by its plan, by physics, and by who heard what. What no body of this
kind can do is counted apart. ``--plans`` only plans them, in seconds. ``--task following`` and ``--task guiding`` are
apart from the grammar: three people walk about near each other, and the right one must be kept, or brought along.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, get_args

from rich.console import Console
from rich.table import Table

from tests.bench.report import machine
from tests.eval.gpsr.commands import commands
from tests.eval.gpsr.draw import generator
from tests.eval.gpsr.goal import Command
from tests.eval.gpsr.grammar import GrammarError
from tests.eval.gpsr.judge import Verdict
from tests.eval.gpsr.lexicon import Language
from tests.eval.gpsr.perform import perform
from tests.eval.gpsr.planned import misunderstood
from tests.eval.gpsr.three_people import Company, perform_among

VARIABLE: Final = "SAYSO_GPSR"


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="sayso bench gpsr", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--data", type=Path, metavar="FOLDER", default=os.environ.get(VARIABLE), help=f"or {VARIABLE}")
    parser.add_argument("--n", type=int, default=18, help="so many commands, or so many seeds of a task (18)")
    parser.add_argument("--seed", type=int, default=0, help="of the drawing (0)")
    parser.add_argument("--category", help="only commands of this one")
    parser.add_argument("--only", type=int, metavar="NUMBER", action="append", help="only commands of these numbers")
    parser.add_argument("--lang", choices=get_args(Language), default="en")
    parser.add_argument("--task", choices=get_args(Company), help="among three people, instead of the grammar")
    parser.add_argument("--plans", action="store_true", help="only plan them: understood or not, without physics")
    parser.add_argument("--draw", action="store_true", help="print the commands, and perform none")
    parser.add_argument("--speed", choices=["max", "real"], default="max", help="how fast simulated time passes")
    parser.add_argument("--limit", type=float, default=600, metavar="SECONDS", help="robot time for a command (600)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of the engine")
    parser.add_argument("--failures", type=Path, metavar="FILE", help="write there what was wrong with each command")
    args = parser.parse_args(argv)
    settings = dict(pair.split("=", 1) for pair in args.set)
    verdicts: list[Verdict] = []
    if args.task:
        for seed in range(args.seed, args.seed + args.n):
            verdicts.append(perform_among(args.task, seed, language=args.lang, speed=args.speed, settings=settings))
            _tell(verdicts[-1], len(verdicts), args.n)
    else:
        drawn = _drawn(parser, args)
        if args.plans:
            return _plan(drawn, settings, as_json=args.json)
        for command in drawn:
            if args.draw:
                sys.stdout.write(f"{command.number} {command.category}: {command.text}\n")
                continue
            verdicts.append(perform(command, speed=args.speed, limit_s=args.limit, settings=settings))
            _tell(verdicts[-1], len(verdicts), len(drawn))
    if args.draw:
        return 0
    result = summary(verdicts, seed=args.seed, language=args.lang)
    if args.failures:
        args.failures.write_text("\n".join(failure(one) for one in verdicts if not one.good), "utf-8")
    if args.json:
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
    else:
        _print(result)
    return 0


def _plan(drawn: Sequence[Command], settings: Mapping[str, str], *, as_json: bool) -> int:
    """Plan commands and perform none; tells what was not understood."""
    possible = [command for command in drawn if not command.goal.cannot]
    wrong = [(command, why) for command in possible if (why := misunderstood(command, settings))]
    if as_json:
        faults = [{"number": command.number, "text": command.text, "wrong": why} for command, why in wrong]
        result = {"bench": "gpsr", "n": len(possible), "understood": len(possible) - len(wrong), "faults": faults}
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
        return 0
    for command, why in wrong:
        sys.stdout.write(f"✗ {command.category} #{command.number}: {command.text}: {'; '.join(why)}\n")
    sys.stdout.write(f"understood {len(possible) - len(wrong)} of {len(possible)}\n")
    return 0


def _drawn(parser: argparse.ArgumentParser, args: argparse.Namespace) -> list[Command]:
    if args.data is None:
        parser.error(f"the grammar's files are not here; name their folder with --data or {VARIABLE}")
    try:
        made = generator(Path(args.data))
    except (OSError, GrammarError) as error:
        parser.error(str(error))
    if args.category and args.category not in made.categories:
        parser.error(f"there is no category {args.category!r}; there are: {', '.join(made.categories)}")
    found = commands(made, args.n, args.seed, language=args.lang, category=args.category)
    return [command for command in found if not args.only or command.number in args.only]


def summary(verdicts: Sequence[Verdict], *, seed: int, language: str) -> dict[str, Any]:
    """All figures as one JSON object. What cannot be done is in no figure but its own."""
    possible = [one for one in verdicts if not one.cannot]
    categories = sorted({one.category for one in possible})
    return {
        "bench": "gpsr",
        "n": len(verdicts),
        "seed": seed,
        "language": language,
        "machine": machine(),
        "all": figures(possible),
        "categories": {name: figures([one for one in possible if one.category == name]) for name in categories},
        "cannot": [
            {"text": one.text, "why": one.cannot, "result": one.result, "words": one.words, "made_up": one.made_up}
            for one in verdicts
            if one.cannot
        ],
        "verdicts": [as_json(one) for one in verdicts],
    }


def figures(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Of some verdicts: how many are good in which way."""
    asked = [one for one in verdicts if one.told is not None]
    return {
        "n": len(verdicts),
        "understood": sum(one.understood for one in verdicts),
        "done": sum(one.done for one in verdicts),
        "told": sum(bool(one.told) for one in asked),
        "asked": len(asked),
        "contacts": sum(len(one.contacts) for one in verdicts),
        "made_up": sum(bool(one.made_up) for one in verdicts),
        "robot_s": round(sum(one.robot_s for one in verdicts), 1),
        "wall_s": round(sum(one.wall_s for one in verdicts), 1),
    }


def as_json(verdict: Verdict) -> dict[str, Any]:
    """A verdict with its reasons."""
    fields = ("number", "category", "kind", "text", "plan", "result", "words", "asked", "people", "misunderstood",
              "undone", "untold", "made_up", "contacts", "cannot")  # fmt: skip
    marks = {"understood": verdict.understood, "done": verdict.done, "told": verdict.told}
    return {name: getattr(verdict, name) for name in fields} | marks | {"robot_s": round(verdict.robot_s, 1)}


def failure(verdict: Verdict) -> str:
    """What was wrong with a command, in lines for people."""
    lines = [f"#{verdict.number} {verdict.category}: {verdict.text}", f"  kind: {verdict.kind}"]
    lines.append(f"  plan: {'; '.join(verdict.plan) or 'none'}")
    lines.append(f"  result: {verdict.result}: {verdict.words}")
    lines += [f"  asked: {question}" for question in verdict.asked]
    lines += [f"  {did}" for did in verdict.people]
    for name, faults in (
        ("not understood", verdict.misunderstood),
        ("not done", verdict.undone),
        ("not told", verdict.untold or ()),
        ("made up", verdict.made_up),
        ("ran into", verdict.contacts),
    ):
        lines += [f"  {name}: {fault}" for fault in faults]
    return "\n".join(lines) + "\n"


def _tell(verdict: Verdict, number: int, of: int) -> None:
    marks = "".join(
        " –"[one is None] if one is None else "✗✓"[one] for one in (verdict.understood, verdict.done, verdict.told)
    )
    more = f" ran into {', '.join(verdict.contacts)}" if verdict.contacts else ""
    more += f" made up: {'; '.join(verdict.made_up)}" if verdict.made_up else ""
    time = f"{verdict.robot_s:.0f} s of robot time in {verdict.wall_s:.0f} s"
    sys.stderr.write(f"[{number}/{of}] {marks} {verdict.category} #{verdict.number}: {verdict.text} ({time}){more}\n")
    sys.stderr.flush()


def _print(result: dict[str, Any]) -> None:
    console = Console()
    table = Table(title=f"gpsr (n = {result['n']}, {result['language']})", caption=result["machine"]["cpu"])
    for column in ("category", "n", "understood", "done", "told", "contacts", "made up", "robot time"):
        table.add_column(column, justify="left" if column == "category" else "right")
    for name, row in [*result["categories"].items(), ("all", result["all"])]:
        counts = (row["n"], row["understood"], row["done"], f"{row['told']}/{row['asked']}", row["contacts"])
        table.add_row(name, *map(str, counts), str(row["made_up"]), f"{row['robot_s']:.0f} s")
    console.print(table)
    for one in result["cannot"]:
        line = f"  cannot: {one['text']}: {one['why']}. The robot: {one['result']}: {one['words']}"
        console.print(line, soft_wrap=True, highlight=False)


if __name__ == "__main__":
    sys.exit(main())
