"""Grasping by perception alone: seeded placements of boxes, cups and bottles on the floor and on low tables.

In every trial one thing stands somewhere, turned at random, and the robot before it; the robot looks, picks up what it
sees, and a look at the physics tells whether it really has it. Tables are 14 cm high; things stand 4.5 to 14 cm from
an edge. Then things are picked up and carried from room to room. Figures: how long it takes (robot time) and how many
times real time it ran; ratios: how often it succeeded by kind and surface, and how often each failure occurred.
``lies`` counts results and memories that the physics contradicts.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import random
import sys
from collections import Counter
from dataclasses import dataclass
from time import perf_counter
from typing import Final

from engine.perception.looking import LOOK_POSES
from engine.perception.memory import WorldMemory
from engine.perception.naming import wanted
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Pose
from engine.robot.occupancy import Route, route
from engine.skills.grasp import pick
from engine.skills.hand import look, move_to, still_held
from engine.skills.travel import go_to
from tests.bench.report import figures, print_report, report
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import places

KINDS: Final = {
    "box": ("red box", "blue box", "green box", "yellow box"),
    "cup": ("white cup", "blue cup"),
    "bottle": ("bottle",),
}
FLOORS: Final = ((-0.8, 1.2, 1.9, 2.9), (2.8, 4.3, 1.2, 2.4), (-0.9, 1.5, -2.9, -1.4), (-4.2, -2.0, -1.0, 1.0))
SIDES: Final = {"coffee table": (1, 0), "workbench": (1, 0), "stool": (0, 1), "bedside table": (0, 1)}
"""The side of each table from which one can reach it."""
TOP: Final = 0.141
AWAY: Final = (4.2, -1.3)
"""Where what is not needed stands."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One thing somewhere, and the robot before it."""

    kind: str
    name: str
    surface: str
    at: tuple[float, float, float]
    yaw: float
    stand: Pose


def draw(robot: HandRobot, number: int, seed: int) -> Trial:
    """The trial of this number: kinds and surfaces take turns."""
    rng = random.Random(1000 * seed + number)
    kind = tuple(KINDS)[number % 3]
    name, yaw = rng.choice(KINDS[kind]), rng.uniform(0, math.pi / 2)
    while True:
        if (number // 3) % 2:
            surface = rng.choice(tuple(SIDES))
            x, y, facing = _on_table(rng, _piece(robot, surface), SIDES[surface])
            at = (x, y, TOP)
        else:
            surface = "floor"
            x0, x1, y0, y1 = rng.choice(FLOORS)
            x, y, facing = rng.uniform(x0, x1), rng.uniform(y0, y1), rng.uniform(-math.pi, math.pi)
            at = (x, y, 0.001)
        away = rng.uniform(0.5, 0.9)
        stand = Pose(x - away * math.cos(facing), y - away * math.sin(facing), facing + rng.uniform(-0.15, 0.15))
        if isinstance(route(robot.floor_map, Pose(0, 0, 0), stand, robot.footprint), Route):
            return Trial(kind, name, surface, at, yaw, stand)


def _piece(robot: HandRobot, name: str) -> Furniture:
    return next(piece for piece in robot.floor_map.furniture if piece.name == name)


def _on_table(rng: random.Random, piece: Furniture, side: tuple[int, int]) -> tuple[float, float, float]:
    """A place on it, and the direction in which one looks at it from its side."""
    inwards, margin = rng.uniform(0.045, 0.14), 0.08
    if side[0]:
        return piece.x_max - inwards, rng.uniform(piece.y_min + margin, piece.y_max - margin), math.pi
    return rng.uniform(piece.x_min + margin, piece.x_max - margin), piece.y_max - inwards, -math.pi / 2


async def prepare(robot: HandRobot, trial: Trial) -> None:
    """Put everything in its place, and let it come to rest."""
    for index, name in enumerate(robot.scene.objects):
        robot.put(name, AWAY[0] + 0.15 * (index % 5), AWAY[1] - 0.15 * (index // 5), 0.001)
    robot.put(trial.name, *trial.at, trial.yaw)
    robot.stand_at(trial.stand)
    for _ in range(15):
        await robot.tick()


async def grasp(robot: HandRobot, trial: Trial, memory: WorldMemory) -> str:
    """Look and pick: ``ok``, or what went wrong."""
    context = context_of(robot, memory)
    kind = robot.scene.objects[trial.name]
    for pose in (LOOK_POSES["AHEAD"], LOOK_POSES["FAR"]):  # a bottle on a table is cut off in the first
        await move_to(context, pose.joints)
        await look(context)
        if seen := memory.find(wanted(f"{kind.colour} {kind.kind}"), near=(trial.stand.x, trial.stand.y)):
            result = await pick(context, seen[0])
            return "ok" if result.ok else str(result.error_code)
    return "not seen"


def lifted(robot: HandRobot, trial: Trial) -> bool:
    """Whether the thing is in the robot's hand, in truth."""
    x, y, z = robot.where(trial.name)
    pose = robot.world.true_pose
    return z > 0.18 and math.hypot(x - pose.x, y - pose.y) < 0.3


async def run(
    n: int, carries: int, seed: int, noise: float
) -> tuple[Counter[tuple[str, str, str]], Counter[str], dict[str, list[float]]]:
    """Outcomes by kind and surface, counts, and times."""
    robot = HandRobot(odometry_noise=noise, seed=seed)
    outcomes: Counter[tuple[str, str, str]] = Counter()
    counts: Counter[str] = Counter()
    times: dict[str, list[float]] = {"grasp": [], "× real time": [], "carry": []}
    goals, rng = list(places().values()), random.Random(seed)
    for number in range(n):
        trial, memory = draw(robot, number, seed), WorldMemory()
        await prepare(robot, trial)
        began, wall = robot.world.t, perf_counter()
        outcome = await grasp(robot, trial, memory)
        took = robot.world.t - began
        times["× real time"].append(took / (perf_counter() - wall))
        counts["lies"] += ((outcome == "ok") != lifted(robot, trial)) + (
            (memory.held is not None) != lifted(robot, trial)
        )
        if outcome == "ok" and not lifted(robot, trial):
            outcome = "only said"
        outcomes[trial.kind, "floor" if trial.surface == "floor" else "table", outcome] += 1
        if outcome != "ok":
            print(f"trial {number}: {trial}: {outcome}", file=sys.stderr)
            continue
        times["grasp"].append(took)
        if counts["drives"] < carries:
            began = robot.world.t
            context = context_of(robot, memory)
            result = await go_to(context, rng.choice(goals), "a place")
            counts["drives"] += 1
            counts["carried"] += lifted(robot, trial) and still_held(context)
            counts["arrived"] += result.ok
            times["carry"].append(robot.world.t - began)
    return outcomes, counts, times


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench grasp", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=100, help="how many placements")
    parser.add_argument("--carry", type=int, default=40, help="how many drives with what was picked up")
    parser.add_argument("--noise", type=float, default=0.0, help="relative error of odometry")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(argv)
    outcomes, counts, times = asyncio.run(run(args.n, args.carry, args.seed, args.noise))
    ratios: dict[str, float] = {"grasped": sum(c for (_, _, o), c in outcomes.items() if o == "ok") / args.n}
    for kind in KINDS:
        for surface in ("floor", "table"):
            these = {o: c for (k, s, o), c in outcomes.items() if (k, s) == (kind, surface)}
            if these:
                ratios[f"{kind}, {surface} (n {sum(these.values())})"] = these.get("ok", 0) / sum(these.values())
            ratios |= {f"{kind}, {surface}: {o}": c for o, c in these.items() if o != "ok"}
    if counts["drives"]:
        ratios[f"carried without dropping (n {counts['drives']})"] = counts["carried"] / counts["drives"]
        ratios["arrived"] = counts["arrived"] / counts["drives"]
    ratios["lies"] = counts["lies"]
    units = {"grasp": "s", "× real time": "×", "carry": "s"}
    found = {name: figures(values, units[name]) for name, values in times.items() if values}
    print_report(report("grasp", args.n, found, ratios), args.json)


if __name__ == "__main__":
    main()
