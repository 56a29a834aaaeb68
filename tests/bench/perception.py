"""How well and how fast loose things are seen: seeded random placements on every floor and on the low tables.

Every trial puts a few things of random kind, colour, size and turn before the robot, looks with the arm pose that suits
their distance, and compares what perception says with where they truly are. A thing counts as visible where the
picture shows it with at least ``VISIBLE`` pixels and does not cut it off. ``false things`` are sightings with nothing
there, in those pictures and in the empty rooms.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from engine.perception.looking import LOOK_POSES, look_at
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from tests.bench.report import Figure, figures, print_report, report
from tests.sim.arranged import COLOURS, SIZES, Arranged, Put, loose

VISIBLE = 6
"""Pixels from which on a thing counts."""
BANDS = ((0.2, 0.5), (0.5, 1.0), (1.0, 1.5), (1.5, 2.2))
"""Distances from the camera, m."""
SPOTS = (
    (0.0, 0.0), (3.0, 0.0), (-2.3, -0.4), (-3.3, -0.8), (0.3, 2.2), (1.0, 2.3), (3.2, 1.8), (4.0, 2.6), (0.2, -2.2),
    (2.0, -1.7), (-3.9, 1.0),
)  # fmt: skip
"""Where the robot stands in the rooms."""
TABLES = (
    (-2.35, 1.9, math.pi), (2.9, 1.7, math.pi), (-0.3, 1.3, math.pi), (2.2, -2.95, -math.pi / 2),
    (-3.1, 0.9, math.pi / 2),
)  # fmt: skip
"""Where it stands before a low table."""
TABLE_TOP = 0.141


@dataclass(slots=True)
class Tally:
    """What the trials found."""

    seconds: list[float] = field(default_factory=list)
    seen: Counter[tuple[str, int]] = field(default_factory=Counter)
    missed: Counter[tuple[str, int]] = field(default_factory=Counter)
    errors: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    sigmas: list[float] = field(default_factory=list)  # error over sigma
    kinds: Counter[tuple[str, str]] = field(default_factory=Counter)
    colours: Counter[tuple[str, str]] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)
    pictures: int = 0


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench perception", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("-n", type=int, default=300, help="pictures with things in them")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--verbose", action="store_true", help="name everything that went wrong")
    args = parser.parse_args(argv)
    rng = np.random.default_rng(args.seed)
    tally = Tally()
    for _ in range(max(1, args.n // 30)):
        _trials(tally, rng, min(30, args.n), args.verbose)
    empty = Tally()
    _empty_rooms(empty, rng, args.verbose)
    found: dict[str, Figure] = {
        "perceive, 160×120": figures([s * 1e3 for s in tally.seconds], "ms"),
        "perceive, 320×240": figures(_large(rng), "ms"),
        "error over sigma": figures(tally.sigmas, ""),
    }
    for band, (low, high) in enumerate(BANDS):
        if tally.errors[band]:
            found[f"position error, {low}–{high} m"] = figures([e * 1e3 for e in tally.errors[band]], "mm")
    print_report(report("perception", tally.pictures, found, _ratios(tally, empty)), args.json)


def _ratios(tally: Tally, empty: Tally) -> dict[str, float]:
    ratios: dict[str, float] = {}
    for kind in SIZES:
        for band, (low, high) in enumerate(BANDS):
            seen, missed = tally.seen[kind, band], tally.missed[kind, band]
            if seen + missed:
                ratios[f"recall {kind} {low}–{high} m"] = seen / (seen + missed)
    for what, pairs in (("kind", tally.kinds), ("colour", tally.colours)):
        right = sum(count for (true, told), count in pairs.items() if true == told)
        ratios[f"{what} right"] = right / max(sum(pairs.values()), 1)
        for (true, told), count in pairs.most_common():
            if true != told:
                ratios[f"{what}: {true} taken for {told}"] = count / sum(n for (t, _), n in pairs.items() if t == true)
    ratios["beyond three sigma"] = float(np.mean(np.array(tally.sigmas) > 3))
    ratios["false things per picture"] = len(tally.false) / tally.pictures
    ratios["false things per picture, empty rooms"] = len(empty.false) / empty.pictures
    return ratios


def _trials(tally: Tally, rng: np.random.Generator, count: int, verbose: bool) -> None:
    objects = {}
    for kind in SIZES:
        for index in range(6):
            scale = float(rng.uniform(0.75, 1.4))
            tag = index + 1 if kind == "tag_block" else None
            objects[f"{kind} {index}"] = loose(kind, str(rng.choice(COLOURS)), scale=scale, tag=tag)
    stage = Arranged(objects)
    for _ in range(count):
        pose, things, away = _placed(stage, rng)
        picture = stage.look(things, pose, look_at(away).joints)
        _judge(tally, stage, things, picture, verbose)


def _placed(stage: Arranged, rng: np.random.Generator) -> tuple[Pose, list[Put], float]:
    """Where the robot stands and what stands before it, far enough apart not to overlap."""
    on_table = rng.random() < 0.35
    if on_table:
        x, y, yaw = TABLES[rng.integers(len(TABLES))]
        away = 0.55
    else:
        x, y = SPOTS[rng.integers(len(SPOTS))]
        yaw, away = rng.uniform(-math.pi, math.pi), float(rng.uniform(0.28, 2.1))
    pose = Pose(x + rng.uniform(-0.05, 0.05), y + rng.uniform(-0.05, 0.05), yaw + rng.uniform(-0.1, 0.1))
    names = rng.permutation(list(stage.objects))[:3]
    things: list[Put] = []
    for name, side in zip(names, rng.permutation([-0.3, 0.0, 0.3]), strict=True):
        bearing, distance = pose.yaw + side + rng.uniform(-0.08, 0.08), away * rng.uniform(0.9, 1.15)
        at = (pose.x + distance * math.cos(bearing), pose.y + distance * math.sin(bearing))
        z = 0.0
        if on_table:
            tables = [f for f in stage.map.furniture if f.kind == "low_table" and f.holds(*at, margin=0.05)]
            z = TABLE_TOP if tables else math.nan
        elif not _free(stage.map, *at):
            z = math.nan
        if not math.isnan(z):
            things.append(Put(str(name), *at, z, float(rng.uniform(-math.pi, math.pi))))
    return pose, things, away


def _free(floor_map: FloorMap, x: float, y: float, margin: float = 0.08) -> bool:
    west, south = floor_map.origin
    cells = [
        (int((y + dy - south) / floor_map.resolution), int((x + dx - west) / floor_map.resolution))
        for dx in (-margin, 0, margin)
        for dy in (-margin, 0, margin)
    ]
    rows, columns = floor_map.occupied.shape
    return all(0 <= r < rows and 0 <= c < columns and not floor_map.occupied[r, c] for r, c in cells)


def _judge(tally: Tally, stage: Arranged, things: Sequence[Put], picture: Picture, verbose: bool) -> None:
    sight = _timed(tally, picture, stage.map)
    claimed = set()
    for thing in things:
        shown = stage.shown(picture, thing.name)
        seen = stage.found(sight, thing)
        if seen is not None:
            claimed.add(id(seen))
        if shown < VISIBLE or stage.cut(picture, thing.name):
            continue
        truth = stage.objects[thing.name]
        middle = np.array(stage.middle(thing))
        camera = picture.on_map(picture.mount.position[None])[0]
        away = float(np.linalg.norm(middle - camera))
        band = next((i for i, (low, high) in enumerate(BANDS) if low <= away < high), None)
        if band is None:
            continue
        if seen is None:
            tally.missed[truth.kind, band] += 1
            if verbose:
                print(f"missed {truth.colour} {truth.kind} {truth.size} at {away:.2f} m, {shown} pixels, on {thing.z}")
            continue
        tally.seen[truth.kind, band] += 1
        error = float(np.hypot(*(np.array(seen.position) - middle)[:2]))
        tally.errors[band].append(error)
        tally.sigmas.append(error / seen.sigma)
        kind = "block" if truth.kind == "tag_block" else truth.kind
        tally.kinds[kind, seen.kind] += 1
        colour = seen.colour if kind == "block" else truth.colour
        if kind != "block":
            tally.colours[truth.colour, seen.colour] += 1
        if verbose and (error > 3 * seen.sigma or (kind, colour) != (seen.kind, seen.colour)):
            print(
                f"{truth.colour} {truth.kind} {truth.size} at {away:.2f} m, {shown} px seen as {seen.name}"
                f" {seen.size[0]:.3f}×{seen.size[1]:.3f}, error {error:.3f}, sigma {seen.sigma:.3f}, {seen.box}"
            )
    for seen in sight.objects:
        if id(seen) not in claimed and seen.kind != "person":
            tally.false.append(seen.name)
            if verbose:
                print(f"false {seen.name} {seen.position} {seen.size} {seen.box} range {seen.range:.2f}")


def _timed(tally: Tally, picture: Picture, floor_map: FloorMap) -> Sight:
    began = perf_counter()
    sight = perceive(picture, floor_map)
    tally.seconds.append(perf_counter() - began)
    tally.pictures += 1
    return sight


def _empty_rooms(tally: Tally, rng: np.random.Generator, verbose: bool) -> None:
    stage = Arranged({})
    for x, y in SPOTS:
        for heading in range(12):
            look = list(LOOK_POSES.values())[(heading + int(rng.integers(3))) % 3]
            pose = Pose(x, y, math.radians(30 * heading))
            _judge(tally, stage, (), stage.look((), pose, look.joints), verbose)


def _large(rng: np.random.Generator) -> list[float]:
    """Milliseconds of pictures of 320×240."""
    tally = Tally()
    stage = Arranged(
        {f"{kind} 1": loose(kind, "red", tag=1 if kind == "tag_block" else None) for kind in SIZES},
        width=320,
        height=240,
    )
    for _ in range(20):
        pose, things, away = _placed(stage, rng)
        _timed(tally, stage.look(things, pose, look_at(away).joints), stage.map)
    return [seconds * 1e3 for seconds in tally.seconds]


if __name__ == "__main__":
    main()
