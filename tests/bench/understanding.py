"""How well readers understand sentences whose meaning somebody wrote down, and how sure they are when they are wrong.

Each line of the sets has a meaning and a sentence (``engine/understanding/notation.py``). A reading is right where
its acts, structure and the words of its roles are those of the line; articles and prepositions around a role don't
count. For every kind of sentence it is counted how many are right, and for those that are no order how many were read
as one."""

from __future__ import annotations

import argparse
import json
import random
import re
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from config import load, paths
from engine.errors import ExitCode
from engine.han import is_chinese
from engine.planner.build import learned_reader
from engine.understanding.meaning import Meaning, meaning_of
from engine.understanding.notation import Example
from engine.understanding.training import gpsr, huric
from engine.understanding.training.coverage import kind_of
from engine.understanding.training.examples import written
from tests.bench.report import figures, machine

SENTENCES: Final = Path(__file__).parents[2] / "assets" / "understanding" / "sentences"
HELD_OUT: Final = (SENTENCES / "from_meanings" / "09.txt", SENTENCES / "own" / "79.txt")
"""Written by two whose sentences the reader has not learnt from."""
BUCKETS: Final = (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.01)
_AROUND: Final = re.compile(
    r"^(?:(?:to|in|into|on|onto|at|from|for|of|with|by|the|a|an|my|your|our|this|that|those|these|some|is|are|if|whether)\s+)+"
    r"|^(?:在|到|去|从|把|给|那个?|这个?|我的)+(?=.)|\s+(?:please|there|here)$|[上里]$"
)


@dataclass(frozen=True, slots=True)
class Reading:
    """What became of one sentence."""

    kind: str
    language: str
    wanted: Meaning
    found: Meaning | None
    seconds: float

    @property
    def right(self) -> bool:
        return self.found is not None and self.found_plain == _plain(self.wanted)

    @property
    def found_plain(self) -> list[Any]:
        return _plain(self.found) if self.found is not None else []

    @property
    def acts_right(self) -> bool:
        """Whether acts and structure are right, whatever the words of the roles."""
        return self.found is not None and [one[0] for one in self.found_plain] == [
            one[0] for one in _plain(self.wanted)
        ]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="sayso bench understanding", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--set", type=Path, nargs="+", default=list(HELD_OUT), metavar="FILE")
    parser.add_argument("--public", type=Path, metavar="DIR", help="the thirds of HuRIC and GPSR that are left out")
    parser.add_argument("--wrong", action="store_true", help="tell on stderr what was read wrongly")
    args = parser.parse_args(argv)
    reader = learned_reader(load().models.folder or paths().models)
    if reader is None:
        parser.error("the learned reader has no base; run `sayso models pull multilingual-e5-small`")
    reader.read("go")
    readings = []
    for kind, example in _examples(args.set) if args.public is None else _public(args.public):
        began = time.perf_counter()
        found = reader.read(example.text)
        seconds = time.perf_counter() - began
        wanted = meaning_of(example.text, example.steps)
        language = "zh" if is_chinese(example.text) else "en"
        readings.append(Reading(kind, language, wanted, found, seconds))
        if args.wrong and not readings[-1].right:
            sure = f"{found.confidence:.2f}" if found is not None else "-"
            sys.stderr.write(f"✗ {sure} {example.text}\n    {readings[-1].found_plain}\n    {_plain(wanted)}\n")
    names = [path.name for path in args.set] if args.public is None else ["HuRIC", "GPSR"]
    result = summary(names, readings)
    if args.json:
        sys.stdout.write(json.dumps(result, ensure_ascii=False) + "\n")
    else:
        _print(result)
    return int(ExitCode.DONE)


def _examples(files: Iterable[Path]) -> list[tuple[str, Example]]:
    return [(kind_of(example.steps), example) for example in written(files)]


def _public(folder: Path) -> list[tuple[str, Example]]:
    people = huric.examples(folder / "huric_en_part.jsonl")[1]
    grammar = gpsr.examples(folder / "gpsr", 5 * len(people), random.Random(1))[1][: len(people)]
    return [("HuRIC", example) for example in people] + [("GPSR", example) for example in grammar]


def summary(names: Sequence[str], readings: Sequence[Reading]) -> dict[str, Any]:
    """All figures as one JSON object."""
    kinds = dict.fromkeys(reading.kind for reading in readings)
    return {
        "bench": "understanding",
        "sets": list(names),
        "n": len(readings),
        "machine": machine(),
        "all": _figures(readings),
        "languages": {lang: _figures([r for r in readings if r.language == lang]) for lang in ("en", "zh")},
        "kinds": {kind: _figures([r for r in readings if r.kind == kind]) for kind in kinds},
        "calibration": [_bucket(readings, low, high) for low, high in pairwise(BUCKETS)],
        "latency": figures((reading.seconds for reading in readings), "s"),
    }


def _figures(readings: Sequence[Reading]) -> dict[str, Any]:
    count = max(1, len(readings))
    no_orders = [reading for reading in readings if not reading.wanted.wanted()]
    return {
        "n": len(readings),
        "right": round(sum(reading.right for reading in readings) / count, 3),
        "acts_right": round(sum(reading.acts_right for reading in readings) / count, 3),
        "no_orders": len(no_orders),
        "read_as_orders": sum(reading.found is not None and bool(reading.found.wanted()) for reading in no_orders),
    }


def _bucket(readings: Sequence[Reading], low: float, high: float) -> dict[str, Any]:
    inside = [r for r in readings if r.found is not None and low <= r.found.confidence < high]
    right = sum(reading.right for reading in inside) / len(inside) if inside else None
    return {"from": low, "n": len(inside), "right": None if right is None else round(right, 3)}


def _plain(meaning: Meaning) -> list[Any]:
    """Symbols with the bare words of their roles."""
    flat: list[Any] = []

    def walk(described: Any) -> None:
        for key, value in described.items():
            if key == "roles" or key == "instead":
                flat.append((key, sorted((role["role"], bare(role["words"])) for role in value)))
            elif isinstance(value, list):
                flat.append((key,))
                for inner in value:
                    walk(inner)
            elif isinstance(value, dict):
                flat.append((key,))
                walk(value)
            else:
                flat.append((key if key != "do" else f"do {value}", bare(str(value))))

    for node in meaning.describe()["nodes"]:
        walk(node)
    return flat


def bare(words: str) -> str:
    """Without what does not matter around a role."""
    plain = words.casefold().strip(" ,.!?;:，。！？")
    while (shorter := _AROUND.sub("", plain)) != plain and shorter:
        plain = shorter
    return plain


def _print(result: dict[str, Any]) -> None:
    out = sys.stdout.write
    rows = {"all": result["all"], **result["languages"], **result["kinds"]}
    out(f"{'':14}{'n':>6}{'right':>8}{'acts':>8}{'no orders read as orders':>28}\n")
    for name, row in rows.items():
        read_as = f"{row['read_as_orders']} of {row['no_orders']}" if row["no_orders"] else ""
        out(f"{name:14}{row['n']:>6}{row['right']:>8.1%}{row['acts_right']:>8.1%}{read_as:>28}\n")
    out(
        "confidence: "
        + ", ".join(f"≥ {b['from']:g}: {b['right'] or 0:.0%} of {b['n']}" for b in result["calibration"])
        + "\n"
    )
    out(f"latency: {result['latency']}\n")


if __name__ == "__main__":
    sys.exit(main())
