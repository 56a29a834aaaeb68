"""How long the phrase planner takes, and how much of the development commands it plans.

``sentence`` is one plain command whose clause was matched before, with other numbers (what happens all day);
``first`` is one whose clause was not; ``no match`` is the price that a language model's requests pay on their way.
With the shared data, coverage is counted too: of the commands that need no more than the skills and places there are,
how many get an acceptable plan, and how many of the others get one, which would be wrong.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import yaml

from config.schema import Place
from engine.plan import ActionCall, Quantity
from engine.planner.phrases import Matched, PhrasePlanner, is_stop
from tests.bench.report import Figure, figures, print_report, report

ROOT = Path(__file__).parents[2]
COMMANDS = ROOT.parent / "shared" / "data" / "commands_dev.json"
LOAD = """
from time import perf_counter
import config.schema, engine.plan
begin = perf_counter()
from engine.planner.phrases import PhrasePlanner
PhrasePlanner({})
print(perf_counter() - begin)
"""

PLAIN = (
    "go forward {} metres", "move {} cm to the left", "back up {} meters", "turn left {} degrees",
    "rotate {} degrees clockwise", "go to the kitchen", "drive to the lounge please", "raise your arm",
    "wait {} seconds", "set the light to blue", "go forward {} metres and turn right {} degrees",
)  # fmt: skip
BEYOND = (
    "pick up the red box and put it on the table", "if there is a bottle on the sofa throw it in the bin",
    "what is the capital of France", "bring me the remote from the living room, then go to the charger",
    "go to the bedroom, find the cup and bring it to me", "tell me a joke",
)  # fmt: skip
NEEDS_ONLY_PHRASES = ("motion", "single", "multi")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench phrases", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--rounds", type=int, default=200, help="how often each sentence is planned")
    args = parser.parse_args(argv)
    places = {symbol: Place(**place) for symbol, place in _map().items()}
    found, n = _times(places, args.rounds)
    ratios = {"sentences within 1 ms": _share_within(places, 1.0)}
    if COMMANDS.exists():
        ratios |= _coverage(PhrasePlanner(places))
    print_report(report("phrases", n, found, ratios), args.json)


def _map() -> dict[str, Any]:
    places: dict[str, Any] = yaml.safe_load((ROOT / "config" / "map.yaml").read_text("utf-8"))["places"]
    return places


def _times(places: dict[str, Place], rounds: int) -> tuple[dict[str, Figure], int]:
    planner = PhrasePlanner(places)
    first = [_ms(planner.plan, sentence.format(1, 90)) for sentence in PLAIN]
    plain = [_ms(planner.plan, sentence.format(i, i + 1)) for i in range(rounds) for sentence in PLAIN]
    fresh = [PhrasePlanner(places) for _ in range(max(rounds // 40, 1))]
    beyond = [_ms(each.plan, sentence) for each in fresh for sentence in BEYOND]
    stops = [_ms(is_stop, "Stop right now!") for _ in range(rounds)]
    loads = [1000 * float(_python(LOAD)) for _ in range(5)]
    samples = {"sentence": plain, "first": first, "no match": beyond, "is_stop": stops, "load": loads}
    return {name: figures(times, "ms") for name, times in samples.items()}, len(plain)


def _share_within(places: dict[str, Place], limit_ms: float) -> float:
    """Of the plain commands that a fresh planner has never met."""
    planner = PhrasePlanner(places)
    times = [_ms(planner.plan, sentence.format(3, 45)) for sentence in PLAIN]
    return sum(time <= limit_ms for time in times) / len(times)


def _ms(action: Callable[[str], object], text: str) -> float:
    begin = perf_counter()
    action(text)
    return 1000 * (perf_counter() - begin)


def _python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout


# Coverage: the development commands use neutral names for skills and places


def _coverage(planner: PhrasePlanner) -> dict[str, float]:
    symbols = {name.replace(" ", "_"): symbol for symbol, name in _names()}
    within, planned, wrong = 0, 0, 0
    for command in json.loads(COMMANDS.read_text("utf-8")):
        goals = [[_ours(action, symbols) for action in plan] for plan in command["gold"]]
        possible = command["category"] in NEEDS_ONLY_PHRASES and any(None not in goal for goal in goals)
        found = planner.plan(command["command"])
        calls = [_written(call) for call in found.calls] if isinstance(found, Matched) else None
        within += possible
        if calls is not None and possible and calls in goals:
            planned += 1
        elif calls is not None:
            wrong += 1
            sys.stderr.write(f"wrong plan for {command['command']!r}: {calls}\n")
        elif possible:
            sys.stderr.write(f"no plan for {command['command']!r}\n")
    return {"commands that phrases could plan": within, "of them planned": planned, "wrong plans": wrong}


def _names() -> list[tuple[str, str]]:
    return [(symbol, name) for symbol, place in _map().items() for name in (place["name"], *place.get("aliases", ()))]


def _ours(action: str, symbols: dict[str, str]) -> str | None:
    """An action in our names; None when there is no such skill or place yet."""
    name, _, rest = action.partition("(")
    argument = rest.removesuffix(")")
    match name:
        case "navigate":
            return f"navigation({symbols[argument]})" if argument in symbols else None
        case "turn":
            angle = float(argument)
            return f"move_{'left' if angle > 0 else 'right'}({abs(angle):g})"
        case "get_pose":
            return "report_pose()"
        case "move_forward" | "set_cmdvel" | "wait":
            return f"{name}({','.join(f'{float(number):g}' for number in argument.split(','))})"
        case "arm_up" | "arm_down" | "beep" | "stop" | "say":
            return action
    return None


def _written(call: ActionCall) -> str:
    arguments = (f"{a.value:g}" if isinstance(a, Quantity) else a for a in call.positional)
    return f"{call.name}({','.join(arguments)})"


if __name__ == "__main__":
    main()
