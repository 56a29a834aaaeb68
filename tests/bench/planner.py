"""How many commands of a set the planner understands, how fast, and where its plans come from.

Each command goes through the planner that ``sayso plan`` uses; nothing moves. Acceptable plans, questions, refusals,
reasons and small talk are counted by category; where a plan looks first, both outcomes are played to it. The answers
that were wrong are told on stderr, unless --figures keeps them out of sight (for sets that nobody is to learn from).
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from config import load
from config.schema import Profile, Settings
from engine.errors import ExitCode
from engine.parts.loading import at_home, make_models
from engine.planner.build import build_planner
from engine.planner.worlds.world_file import load_world
from tests.bench.report import Figure, figures, machine
from tests.eval.commands import Entry, load_commands, world_file
from tests.eval.house_words import SceneWords, WorldWords
from tests.eval.judge import KnownWords, Plans, Verdict, judge
from tests.eval.neutral import Compared, compare, load_neutral

HERE = Path(__file__).resolve().parents[1] / "eval"
PHRASES = "phrases"
"""The profile without any model."""
COLUMNS = {
    "n": "n", "acceptable": "right", "slots": "slots", "clarify_precision": "asks: prec.", "clarify_recall": "recall",
    "refused": "refused", "ungrounded": "ungr.", "forbidden": "forb.",
}  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="sayso bench planner", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--set", type=Path, default=HERE / "dev.yaml", metavar="FILE", help="default: the dev split")
    parser.add_argument("--profile", help=f"of profiles.yaml, or {PHRASES} for no model; default: that of the settings")
    parser.add_argument("--only", metavar="WORD", action="append", help="only categories or ids that have this in them")
    parser.add_argument("--limit", type=int, metavar="N", help="the first N commands")
    parser.add_argument("--figures", action="store_true", help="no commands and answers, only figures")
    parser.add_argument("--config", type=Path, action="append", default=[], help="read settings from FILE too")
    parser.add_argument(
        "--commands", type=Path, metavar="FILE", help="commands in neutral skill names (JSON), instead of a set"
    )
    args = parser.parse_args(argv)
    settings = _settings(args.profile, args.config)
    if args.commands is not None:
        return _neutral(settings, args)
    entries = [e for e in load_commands(args.set) if not args.only or any(w in (e.category, e.id) for w in args.only)]
    if not entries:
        parser.error("no command is left; leave out --only, or name a category of the set")
    verdicts = asyncio.run(_judged(settings, entries[: args.limit], quiet=args.figures))
    result = summary(args.set.name, args.profile or settings.planner.profile, verdicts, wordings=not args.figures)
    if args.json:
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
    else:
        _print(result)
    return int(ExitCode.DONE)


def _settings(profile: str | None, files: Sequence[Path]) -> Settings:
    if profile != PHRASES:
        return load(files=files, overrides=[] if profile is None else [f"planner.profile={profile}"])
    settings = load(files=files)
    planner = settings.planner.model_copy(update={"profile": PHRASES})
    return settings.model_copy(update={"planner": planner, "profiles": {**settings.profiles, PHRASES: Profile()}})


async def _judged(settings: Settings, entries: Sequence[Entry], *, quiet: bool) -> list[Verdict]:
    models = make_models(settings, _say)
    houses: dict[str | None, tuple[Plans, KnownWords]] = {}
    verdicts = []
    try:
        for entry in entries:
            if entry.world not in houses:
                world = None if entry.world is None else load_world(world_file(entry.world), _say)
                known = at_home(settings) if world is None else settings
                words: KnownWords = SceneWords(known) if world is None else WorldWords(world)
                houses[entry.world] = build_planner(known, models=models, world=world), words
            planner, called = houses[entry.world]
            verdict = await judge(entry, planner, called)
            verdicts.append(verdict)
            if not quiet and not verdict.ok:
                _say(f"✗ {entry.id} {entry.say!r}: {verdict.answers[-1].shown}")
    finally:
        if models is not None:
            await models.close()
    return verdicts


def summary(name: str, profile: str, verdicts: Sequence[Verdict], *, wordings: bool = True) -> dict[str, Any]:
    """All figures as one JSON object."""
    categories = dict.fromkeys(verdict.entry.category for verdict in verdicts)
    result: dict[str, Any] = {
        "bench": "planner",
        "set": name,
        "profile": profile,
        "n": len(verdicts),
        "machine": machine(),
        "all": _figures(verdicts),
        "categories": {c: _figures([v for v in verdicts if v.entry.category == c]) for c in categories},
        "latency": latencies(verdicts),
        "sources": dict(Counter(verdict.first.source or "none" for verdict in verdicts)),
        "outcomes": dict(Counter(f"{_wanted(v)} → {v.first.outcome}" for v in verdicts if not v.ok)),
    }
    if wordings:
        result["failures"] = [_failure(verdict) for verdict in verdicts if not verdict.ok]
    return result


def _figures(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    slots = [verdict.slots for verdict in verdicts if verdict.slots is not None]
    asked = [verdict for verdict in verdicts if verdict.first.outcome == "clarify"]
    ambiguous = [verdict for verdict in verdicts if set(verdict.entry.ok) == {"clarify"}]
    harmful = [v for v in verdicts if "refuse" in v.entry.ok]
    return {
        "n": len(verdicts),
        "acceptable": _share(verdict.ok for verdict in verdicts),
        "slots": _share(slots),
        "clarify_precision": _share("clarify" in verdict.entry.ok for verdict in asked),
        "clarify_recall": _share(verdict.ok for verdict in ambiguous),
        "refused": _share(verdict.ok for verdict in harmful),
        "ungrounded": sum(bool(verdict.ungrounded) for verdict in verdicts),
        "forbidden": sum(verdict.forbidden for verdict in verdicts),
    }


def _share(good: Iterable[bool]) -> float | None:
    judged = list(good)
    return round(sum(judged) / len(judged), 3) if judged else None


def latencies(verdicts: Sequence[Verdict]) -> dict[str, Figure]:
    """How long the answers took, s: all of them, and those by source. Without a source, there is no plan."""
    answers = [answer for verdict in verdicts for answer in verdict.answers]
    sources = sorted({answer.source for answer in answers})
    found = {"all": figures((answer.seconds for answer in answers), "s")}
    for source in sources:
        found[source or "no plan"] = figures((a.seconds for a in answers if a.source == source), "s")
    return found


def _wanted(verdict: Verdict) -> str:
    return "plan" if verdict.entry.plans else "/".join(verdict.entry.ok)


def _failure(verdict: Verdict) -> dict[str, Any]:
    entry = verdict.entry
    wanted = entry.ok if len(verdict.answers) == 1 else entry.then[len(verdict.answers) - 2].ok
    return {
        "id": entry.id,
        "say": entry.say,
        "wanted": list(wanted),
        "came": [answer.shown for answer in verdict.answers],
        "source": verdict.answers[-1].source,
        "ungrounded": list(verdict.ungrounded),
    }


def _print(result: dict[str, Any]) -> None:
    console = Console()
    title = f"planner: {result['set']}, profile {result['profile']} (n = {result['n']})"
    table = Table(title=title, caption=f"{result['machine']['cpu']}, load {result['machine']['load']}")
    table.add_column("category")
    for header in COLUMNS.values():
        table.add_column(header, justify="right")
    for name, row in [*result["categories"].items(), ("all", result["all"])]:
        table.add_row(name, *(_shown(column, row[column]) for column in COLUMNS))
    console.print(table)
    for name, figure in result["latency"].items():
        values = ", ".join(f"{key} {figure[key]:.3g}" for key in ("min", "median", "p95", "p99", "max"))
        console.print(f"  {name}: {values} {figure['unit']}", highlight=False)
    console.print(f"  sources: {result['sources']}", highlight=False)
    console.print(f"  wrong: {result['outcomes']}", highlight=False)


def _shown(column: str, value: float | None) -> str:
    if value is None:
        return ""
    return str(value) if column in ("n", "ungrounded", "forbidden") else f"{100 * value:.0f} %"


def _say(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


# Commands of others, in neutral names


def _neutral(settings: Settings, args: argparse.Namespace) -> int:
    if not args.commands.exists():
        _say(f"{args.commands} is not there, so nothing is compared.")
        return int(ExitCode.DONE)
    found = asyncio.run(_compared(settings, args.commands, args.limit, quiet=args.figures))
    counts: dict[str, Any] = {}
    for name in (*dict.fromkeys(one.category for one in found), "all"):
        mine = [one for one in found if name in (one.category, "all")]
        counts[name] = {"n": len(mine), "acceptable": _share(one.ok for one in mine)}
    result = {"bench": "planner", "set": args.commands.name, "n": len(found), "categories": counts}
    sys.stdout.write(json.dumps(result, ensure_ascii=False, indent=None if args.json else 1) + "\n")
    return int(ExitCode.DONE)


async def _compared(settings: Settings, path: Path, limit: int | None, *, quiet: bool) -> list[Compared]:
    models = make_models(settings, _say)
    try:
        found = []
        async for one in compare(
            load_neutral(path), lambda world: build_planner(settings, models=models, world=world), limit
        ):
            found.append(one)
            if not quiet and not one.ok:
                _say(f"✗ {one.command!r}: {one.came}")
        return found
    finally:
        if models is not None:
            await models.close()


if __name__ == "__main__":
    sys.exit(main())
