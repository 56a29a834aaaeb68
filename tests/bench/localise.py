"""Driving between the places of several scenes with the odometry of a usual base, looking out and blind.

For some minutes of robot time the robot goes from place to place as it believes; in every control tick its belief is
compared with where it is. Figures: how far off position and heading are, on the way and on arrival, with and without
looking out for landmarks and walls, and on the way for each journey alone. Ratios: drives that failed, pictures a
minute, and how many times real time it ran.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import math
import random
from dataclasses import dataclass, field
from time import perf_counter

from engine.perception.memory import WorldMemory
from engine.robot.geometry import Pose, wrap
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.skills.travel import go_to
from tests.bench.report import Figure, figures, print_report, report
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import places


@dataclass(slots=True)
class Errors:
    """Between belief and truth."""

    position: list[float] = field(default_factory=list)  # cm
    heading: list[float] = field(default_factory=list)  # degrees

    def add(self, robot: HandRobot) -> None:
        """Of now."""
        believed, true = robot.state().pose, robot.world.true_pose
        self.position.append(100 * believed.distance_to(true))
        self.heading.append(abs(math.degrees(wrap(believed.yaw - true.yaw))))

    def figures(self, name: str) -> dict[str, Figure]:
        """Both of them, under this name."""
        return {f"position, {name}": figures(self.position, "cm"), f"heading, {name}": figures(self.heading, "°")}


@dataclass(slots=True)
class Journey:
    """What became of some minutes of driving, or of several such journeys."""

    on_the_way: Errors = field(default_factory=Errors)
    on_arrival: Errors = field(default_factory=Errors)
    drives: int = 0
    failed: int = 0
    pictures: int = 0
    seconds: float = 0.0  # of robot time

    def add(self, other: Journey) -> None:
        """That one as well."""
        for mine, its in ((self.on_the_way, other.on_the_way), (self.on_arrival, other.on_arrival)):
            mine.position += its.position
            mine.heading += its.heading
        self.drives += other.drives
        self.failed += other.failed
        self.pictures += other.pictures
        self.seconds += other.seconds


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench localise", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--minutes", type=float, default=5.0, help="of robot time, for each scene and seed")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--scenes", nargs="+", default=["flat", "workshop", "clutter-7"], metavar="SCENE")
    parser.add_argument("--noise", type=float, default=0.02, help="relative error of odometry")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    ratios: dict[str, float] = {}
    count = 0
    for name, looking in (("looking", True), ("blind", False)):
        journey, began = Journey(), perf_counter()
        for scene, seed in itertools.product(args.scenes, range(args.seeds)):
            one = asyncio.run(drive(scene, args.minutes * 60, seed, args.noise, looking=looking))
            journey.add(one)
            if looking:
                found |= one.on_the_way.figures(f"{scene}, seed {seed}")
        found |= journey.on_the_way.figures(f"{name}, on the way") | journey.on_arrival.figures(f"{name}, on arrival")
        ratios |= {
            f"{name}: drives that failed": journey.failed / journey.drives,
            f"{name}: pictures a minute": journey.pictures / journey.seconds * 60,
            f"{name}: times real time": journey.seconds / (perf_counter() - began),
        }
        count += journey.drives
    print_report(report("localise", count, found, ratios), args.json)


async def drive(name: str, seconds: float, seed: int, noise: float, *, looking: bool) -> Journey:
    """Go to places of a scene drawn from ``seed`` until so much robot time has passed, or until the robot has got
    lost."""
    scene = load_scene(scene_path(name))
    robot, rng, journey = HandRobot(scene, odometry_noise=noise, seed=seed), random.Random(seed), Journey()
    own = {symbol: Pose(p.position.x, p.position.y, p.orientation.yaw) for symbol, p in scene.known_places().items()}
    goals = own or places()
    robot.capabilities -= set() if looking else {"camera"}
    context = context_of(robot, WorldMemory())
    robot.each_tick = lambda: journey.on_the_way.add(robot)
    lost = 0
    while robot.world.t < seconds and lost < 5:
        symbol = rng.choice(sorted(goals))
        result = await go_to(context, goals[symbol], symbol)
        lost = 0 if result.ok else lost + 1
        journey.drives += 1
        journey.failed += not result.ok
        if result.ok:
            journey.on_arrival.add(robot)
    journey.pictures += robot.pictures
    journey.seconds += robot.world.t
    return journey


if __name__ == "__main__":
    main()
