"""How long the phrase planner takes, and how much of the development commands it plans.

``sentence`` is one plain command whose clause was matched before, with other numbers (what happens all day);
``first`` is one whose clause was not; ``no match`` is the price that a language model's requests pay on their way.
With the shared data, coverage is counted too: of the commands that need no more than the skills, things and places
there are, how many get an acceptable plan, and how many of the others get one, which would be wrong.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter

from config import load
from engine.errors import PlanError
from engine.plan import ActionCall, Quantity
from engine.planner.phrases.phrases import Matched, PhrasePlanner, is_stop
from engine.planner.worlds.house import build_vocabulary
from tests.bench.report import Figure, figures, print_report, report

ROOT = Path(__file__).parents[2]
COMMANDS = ROOT.parent / "shared" / "data" / "commands_dev.json"
LOAD = """
from time import perf_counter
import config.schema, engine.plan
begin = perf_counter()
from engine.planner.phrases.phrases import PhrasePlanner
PhrasePlanner({})
print(perf_counter() - begin)
"""

PLAIN = (
    "go forward {} metres", "move {} cm to the left", "back up {} meters", "turn left {} degrees",
    "rotate {} degrees clockwise", "go to the kitchen", "drive to the lounge please", "raise your arm",
    "wait {} seconds", "set the light to blue", "go forward {} metres and turn right {} degrees",
    "pick up block {}", "bring the red box from the table to the kitchen", "where is the blue cup", "clean the room",
    "put it in the bin", "follow the line and clear the obstacles", "remove blocks higher than {} cm",
    "pick up the red box and put it on the table",
)  # fmt: skip
BEYOND = (
    "pick up everything except the red box", "if there is a bottle on the sofa throw it in the bin",
    "what is the capital of France", "bring me the remote from the living room, then go to the charger",
    "go to the bedroom, find the sock and bring it to me", "tell me a joke",
)  # fmt: skip
NEEDS_ONLY_PHRASES = ("motion", "single", "object", "multi")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench phrases", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--rounds", type=int, default=200, help="how often each sentence is planned")
    args = parser.parse_args(argv)
    found, n = _times(args.rounds)
    ratios = {"sentences within 1 ms": _share_within(1.0)}
    if COMMANDS.exists():
        ratios |= _coverage(_planner())
    print_report(report("phrases", n, found, ratios), args.json)


def _planner() -> PhrasePlanner:
    """For the house that comes with sayso."""
    settings = load(environ={})
    return PhrasePlanner(settings.places, vocabulary=build_vocabulary(settings))


def _times(rounds: int) -> tuple[dict[str, Figure], int]:
    planner = _planner()
    first = [_ms(planner.plan, sentence.format(1, 90)) for sentence in PLAIN]
    plain = [_ms(planner.plan, sentence.format(i, i + 1)) for i in range(rounds) for sentence in PLAIN]
    fresh = [_planner() for _ in range(max(rounds // 40, 1))]
    beyond = [_ms(each.plan, sentence) for each in fresh for sentence in BEYOND]
    stops = [_ms(is_stop, "Stop right now!") for _ in range(rounds)]
    loads = [1000 * float(_python(LOAD)) for _ in range(5)]
    samples = {"sentence": plain, "first": first, "no match": beyond, "is_stop": stops, "load": loads}
    return {name: figures(times, "ms") for name, times in samples.items()}, len(plain)


def _share_within(limit_ms: float) -> float:
    """Of the plain commands that a fresh planner has never met."""
    planner = _planner()
    times = [_ms(planner.plan, sentence.format(3, 45)) for sentence in PLAIN]
    return sum(time <= limit_ms for time in times) / len(times)


def _ms(action: Callable[[str], object], text: str) -> float:
    begin = perf_counter()
    action(text)
    return 1000 * (perf_counter() - begin)


def _python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout


# Coverage: the development commands use neutral names for skills, things and places


def _coverage(planner: PhrasePlanner) -> dict[str, float]:
    words = _Ours()
    within, planned, wrong = 0, 0, 0
    for command in json.loads(COMMANDS.read_text("utf-8")):
        goals = [goal for plan in command["gold"] for goal in words.plans(plan)]
        possible = command["category"] in NEEDS_ONLY_PHRASES and bool(goals)
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


class _Ours:
    """Plans in neutral names, told in ours."""

    def __init__(self) -> None:
        settings = load(environ={})
        self._vocabulary = build_vocabulary(settings)
        self._symbols = {
            name.replace(" ", "_"): symbol
            for symbol, place in settings.places.items()
            for name in (place.name, *place.aliases)
        } | {"user": "zero", "trash_bin": "trash"}

    def plans(self, plan: list[str]) -> list[list[str]]:
        """Every way to write a plan with our skills; none where one of its skills, things or places is not ours."""
        steps = [(name, rest.removesuffix(")")) for name, _, rest in (action.partition("(") for action in plan)]
        try:
            return [list(written) for written in self._rest(steps)]
        except (PlanError, KeyError):
            return []

    def _rest(self, steps: list[tuple[str, str]]) -> Iterator[tuple[str, ...]]:
        match steps:
            case []:
                yield ()
                return
            case [("locate", a), ("grasp", b), ("navigate", to), ("place", on), *rest] if a == b and to == on:
                thing = self._thing(a)
                for end in self._rest(rest):
                    if to != "user":
                        yield (f"pick_object({thing})", self._put(to), *end)
                    if to != "trash_bin":
                        yield (f"carry({thing},{self._symbols[to]})", *end)
                    if to == "user":
                        yield (f"locate({thing})", f"carry({thing},zero)", *end)
            case [("locate", a), ("grasp", b), *rest] if a == b:
                yield from ((f"pick_object({self._thing(a)})", *end) for end in self._rest(rest))
            case [("navigate", to), ("place", on), *rest] if to == on:
                yield from ((self._put(to), *end) for end in self._rest(rest))
            case [(name, argument), *rest]:
                yield from ((self._action(name, argument), *end) for end in self._rest(rest))

    def _thing(self, name: str) -> str:
        return self._vocabulary.object(name.replace("_", " "))

    def _put(self, name: str) -> str:
        surface = self._vocabulary.surface(name.replace("trash_bin", "bin").replace("_", " "))
        return "place_in_bin()" if surface == "bin" else f"place_object({surface})"

    def _action(self, name: str, argument: str) -> str:
        match name:
            case "navigate" if argument != "user":
                return f"navigation({self._symbols[argument]})"
            case "turn":
                angle = float(argument)
                return f"move_{'left' if angle > 0 else 'right'}({abs(angle):g})"
            case "get_pose":
                return "report_pose()"
            case "look":
                return "seewhat()"
            case "locate":
                return f"locate({self._thing(argument)})"
            case "follow_line":
                return f"follow_line({argument})"
            case "follow_tag":
                return f"apriltag_follow({argument})"
            case "move_forward" | "set_cmdvel" | "wait":
                return f"{name}({','.join(f'{float(number):g}' for number in argument.split(','))})"
            case "arm_up" | "arm_down" | "beep" | "stop" | "say":
                return f"{name}({argument})"
        raise KeyError(name)


def _written(call: ActionCall) -> str:
    arguments = (f"{a.value:g}" if isinstance(a, Quantity) else a for a in call.positional)
    return f"{call.name}({','.join(arguments)})"


if __name__ == "__main__":
    main()
