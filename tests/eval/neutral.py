"""Commands of others, with acceptable plans in neutral skill names, put to the planner in a world made from them.

The format is a list of ``{id, category, command, type, gold}``: ``type`` is plan, clarify, refuse or chat, ``gold``
holds acceptable plans as lists of ``navigate(place)``, ``locate(thing)``, ``grasp(thing)``, ``place(place)``,
``turn(±deg)``, ``look()``, ``if_seen(thing)`` and skills that are called like ours. The places and things that the
plans name are the world. What comes after ``if_seen`` is left to feedback.
"""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from engine.planner.request import PlanRequest
from engine.planner.worlds.world import World
from engine.planner.worlds.world_file import read_world
from tests.eval.effects import Step, effects
from tests.eval.equivalence import is_the_same, only_looks
from tests.eval.house_words import WorldWords
from tests.eval.judge import Answer, Plans, acceptable, as_answer

OURS: Final = {
    "navigate": "navigation", "grasp": "pick_object", "place": "put", "turn": "move_left", "get_pose": "report_pose",
    "look": "seewhat", "arm_dance": "dance", "follow_tag": "apriltag_follow",
}  # fmt: skip
OF_PLACES: Final = ("navigate", "place")
OF_THINGS: Final = ("locate", "grasp", "if_seen")
CALLED: Final = {
    "living_room": ["lounge"], "charger": ["charging station", "dock"], "trash_bin": ["trash", "bin"],
    "sofa": ["couch"], "user": ["me"],
}  # fmt: skip
"""What else people call the places, where a set has them."""
LOOKED_FOR: Final = ("person", "human")


@dataclass(frozen=True, slots=True)
class Compared:
    """How one command went."""

    category: str
    command: str
    ok: bool
    came: str


Command = dict[str, Any]


def load_neutral(path: Path) -> list[Command]:
    """The commands of a file."""
    commands: list[Command] = json.loads(path.read_text("utf-8"))
    return commands


async def compare(
    commands: Sequence[Command], plans: Callable[[World], Plans], limit: int | None = None
) -> AsyncIterator[Compared]:
    """Put every command to the planner for the world of the set."""
    world = world_of(commands)
    words = WorldWords(world)
    planner = plans(world)
    for command in commands[:limit]:
        answer = as_answer(await planner.plan(PlanRequest(command["command"], cycle=f"neutral {command['id']}")), 0.0)
        yield Compared(command["category"], command["command"], is_right(command, answer, words), answer.shown)


def world_of(commands: Sequence[Command]) -> World:
    """The places and things that the acceptable plans name."""
    steps = [step for command in commands for plan in command["gold"] for step in map(_read, plan)]
    places = dict.fromkeys(arg for name, args in steps if name in OF_PLACES for arg in args)
    things = dict.fromkeys(arg for name, args in steps if name in OF_THINGS for arg in args)
    return read_world(
        {
            "places": [{"name": name, "aliases": CALLED.get(name, [])} for name in places if name != "floor"],
            "objects": [{"name": name} for name in things if name not in LOOKED_FOR],
        },
        "the commands",
    )


def is_right(command: Command, answer: Answer, words: WorldWords) -> bool:
    """Whether an answer is one of those that the set accepts."""
    kind = command["type"]
    if kind != "plan":
        wanted = ("refuse", "impossible") if kind == "refuse" else (kind,)
        return acceptable(wanted, answer, words, must_go_on=False)
    return answer.outcome == "plan" and any(_fits(plan, answer, words) for plan in command["gold"])


def _fits(plan: Sequence[str], answer: Answer, words: WorldWords) -> bool:
    steps = [_read(step) for step in plan]
    condition = next((index for index, (name, _) in enumerate(steps) if name == "if_seen"), None)
    if condition is not None:
        about = (arg for _, args in steps[: condition + 1] for arg in args)
        return not answer.finished and only_looks(answer.steps, about, words)
    done = effects(answer.steps, words)
    return any(is_the_same(effects(way, words), done, words) for way in _ways(steps))


def _ways(steps: Sequence[tuple[str, tuple[str, ...]]]) -> Iterator[tuple[Step, ...]]:
    """The plan in our names; what is brought to the user need not be put down there."""
    ours = tuple(Step(OURS.get(name, name), tuple(map(_value, args))) for name, args in steps)
    yield ours
    if ours and ours[-1] == Step("put", ("user",)):
        yield ours[:-1]


def _read(step: str) -> tuple[str, tuple[str, ...]]:
    name, _, rest = step.partition("(")
    inside = rest.removesuffix(")")
    return name, tuple(inside.split(",")) if inside else ()


def _value(arg: str) -> str | float:
    try:
        return float(arg)
    except ValueError:
        return arg.strip()
