"""Driving from every place of the map to every other, in one tour through the real physics.

Figures: how exactly the robot arrives, how fast it travels, how long planning takes. Ratios: how often it touched
something fixed or was held back by the safety envelope, which should both be never.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from time import perf_counter

from engine.robot.occupancy import route
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map
from tests.bench.report import figures, print_report, report
from tests.sim.rig import drive_to, flat, in_the_flat, places


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench driving", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=0, help="only the first so many drives; 0 for all")
    args = parser.parse_args(argv)
    known, world, floor = places(), in_the_flat(), floor_map(flat())
    tour = list(every_ordered_pair(sorted(known), "E"))
    tour = tour[: args.n] if args.n else tour
    off, turned, pace, planning = [], [], [], []
    touched = held = 0
    for symbol in tour:
        goal, began, fixed, blocked = known[symbol], world.t, set[str](), set[str]()

        def look(fixed: set[str] = fixed, blocked: set[str] = blocked) -> None:
            fixed.update(set(world.touching()) - set(flat().objects))
            blocked.update([world.blocked] if world.blocked else [])

        start = perf_counter()
        route(floor, world.true_pose, goal, FOOTPRINT)
        planning.append((perf_counter() - start) * 1e3)
        way = drive_to(world, goal, look)
        pose = world.true_pose
        off.append(pose.distance_to(goal) * 1e3)
        turned.append(abs(math.degrees(math.remainder(pose.yaw - goal.yaw, 2 * math.pi))))
        if way.length > 1:
            pace.append(way.length / (world.t - began))
        touched, held = touched + bool(fixed), held + bool(blocked)
    found = {
        "off the goal": figures(off, "mm"),
        "off its direction": figures(turned, "°"),
        "mean speed, ways over 1 m": figures(pace, "m/s"),
        "planning": figures(planning, "ms"),
    }
    print_report(report("driving", len(tour), found, {"touched": touched, "held back": held}), args.json)


def every_ordered_pair(names: list[str], start: str) -> Iterator[str]:
    """The stops of a tour that begins at ``start`` and goes from each name to each other exactly once (a circuit of
    the complete graph, by Hierholzer's algorithm)."""
    left = {name: [other for other in names if other != name] for name in names}
    stack, circuit = [start], []
    while stack:
        if ahead := left[stack[-1]]:
            stack.append(ahead.pop())
        else:
            circuit.append(stack.pop())
    circuit.reverse()
    yield from circuit[1:]


if __name__ == "__main__":
    main()
