"""Ways over the floor, and driving them in the real physics."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest

from engine.robot.floor_map import FloorMap, Furniture
from engine.robot.follow import Follower
from engine.robot.geometry import Pose, Twist
from engine.robot.occupancy import Route, Unreachable, distances, inflate, route
from engine.robot.robot import Footprint
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map
from tests.sim.rig import drive_to, flat, in_the_flat, places

FLAT_MAP = floor_map(flat())
PLACES = places()
HALL = PLACES["E"]


def room(rows: int = 60, columns: int = 80) -> FloorMap:
    """4 m × 3 m with walls around and a crate in the middle."""
    occupied = np.zeros((rows, columns), dtype=np.bool_)
    occupied[[0, -1], :] = occupied[:, [0, -1]] = True
    occupied[20:40, 36:44] = True
    return FloorMap(0.05, (0.0, 0.0), occupied, furniture=(Furniture("crate", 1.8, 1.0, 2.2, 2.0),))


def smallest_gap(floor: FloorMap, points: tuple[tuple[float, float], ...]) -> float:
    """Between the path and the nearest occupied cell, m."""
    rows, columns = np.nonzero(floor.occupied)
    centres = np.column_stack((columns, rows)) * floor.resolution + floor.origin + floor.resolution / 2
    along = np.concatenate([np.linspace(a, b, 60) for a, b in itertools.pairwise(points)])
    away = np.abs(along[:, None, :] - centres[None, :, :]) - floor.resolution / 2
    return float(np.hypot(*np.maximum(away, 0).transpose(2, 0, 1)).min())


def test_distances_are_those_of_brute_force() -> None:
    occupied = np.random.default_rng(1).random((30, 40)) < 0.02
    rows, columns = np.nonzero(occupied)
    grid = np.stack(np.meshgrid(np.arange(30), np.arange(40), indexing="ij"), axis=-1)
    exact = np.hypot(grid[..., 0, None] - rows, grid[..., 1, None] - columns).min(axis=-1)
    found = distances(occupied, 0.05, limit=0.5)
    near = exact * 0.05 < 0.5
    assert found[near] == pytest.approx(np.maximum(exact - 0.5, 0)[near] * 0.05)
    assert (found[~near] > 0.45).all()


def test_inflation_takes_the_radius_on_every_side() -> None:
    floor = room()
    inflated = inflate(floor, 0.3)
    assert inflated[30, 44 + 5]
    assert not inflated[30, 44 + 7]
    assert inflated[6, 6] == (0.05 * (5.5) < 0.3)
    assert (inflated | ~floor.occupied).all()


def test_a_way_goes_around_the_crate_with_clearance() -> None:
    way = route(room(), Pose(0.6, 1.5, 0), Pose(3.4, 1.5, 0), FOOTPRINT)
    assert isinstance(way, Route)
    assert way.points[0] == (0.6, 1.5)
    assert way.points[-1] == (3.4, 1.5)
    assert 2.8 < way.length < 4.2
    assert smallest_gap(room(), way.points) >= FOOTPRINT.radius + 0.03


def test_a_free_way_is_one_straight_line() -> None:
    way = route(room(), Pose(0.6, 0.5, 0), Pose(3.4, 0.5, 1), FOOTPRINT)
    assert isinstance(way, Route)
    assert len(way.points) == 2


@pytest.mark.parametrize(
    ("goal", "reason", "said"),
    [
        (Pose(2.0, 1.5, 0), "goal_blocked", "the crate"),
        (Pose(0.1, 1.5, 0), "goal_blocked", "a wall"),
        (Pose(7.0, 1.5, 0), "outside_map", "outside the map"),
    ],
)
def test_an_impossible_goal_is_a_reason(goal: Pose, reason: str, said: str) -> None:
    way = route(room(), Pose(0.6, 1.5, 0), goal, FOOTPRINT)
    assert isinstance(way, Unreachable)
    assert way.reason == reason
    assert said in way.message


def test_a_gap_that_is_too_narrow_is_no_way() -> None:
    floor = room()
    occupied = floor.occupied.copy()
    occupied[:, 39:41] = True
    occupied[8:14, 39:41] = False  # 0.3 m
    divided = FloorMap(floor.resolution, floor.origin, occupied)
    way = route(divided, Pose(0.6, 1.5, 0), Pose(3.4, 1.5, 0), FOOTPRINT)
    assert isinstance(way, Unreachable)
    assert way.reason == "no_way"


def test_a_robot_walled_in_is_told_so() -> None:
    floor = room()
    occupied = floor.occupied.copy()
    occupied[24:36, 6], occupied[24:36, 17], occupied[24, 6:18], occupied[36, 6:18] = True, True, True, True
    way = route(FloorMap(0.05, (0, 0), occupied), Pose(0.6, 1.5, 0), Pose(3.4, 1.5, 0), FOOTPRINT)
    assert isinstance(way, Unreachable)
    assert way.reason == "start_blocked"


def test_what_the_lidar_sees_is_driven_around() -> None:
    start, goal = Pose(0.6, 0.5, 0), Pose(3.4, 0.5, 0)
    carton = np.array([(x, y) for x in np.arange(1.9, 2.1, 0.02) for y in np.arange(0.05, 0.9, 0.02)])
    way = route(room(), start, goal, FOOTPRINT, extra=carton)
    assert isinstance(way, Route)
    assert max(y for _, y in way.points) > 2.0, "over the far side of the crate"


def test_it_may_start_and_end_nearer_to_things_than_it_travels() -> None:
    beside = 1.8 - FOOTPRINT.length / 2 - 0.05
    way = route(room(), Pose(beside, 1.5, 0), Pose(2.2 + FOOTPRINT.length / 2 + 0.05, 1.5, math.pi), FOOTPRINT)
    assert isinstance(way, Route)
    crosswise = Footprint(0.30, 0.50)
    refused = route(room(), Pose(0.6, 1.5, 0), Pose(beside, 1.5, math.pi / 2), crosswise)
    assert isinstance(refused, Unreachable)


def test_every_place_of_the_flat_is_reachable_from_every_other() -> None:
    free = distances(FLAT_MAP.occupied, FLAT_MAP.resolution, 0.5)
    for (a, start), (b, goal) in itertools.permutations(PLACES.items(), 2):
        way = route(FLAT_MAP, start, goal, FOOTPRINT)
        assert isinstance(way, Route), f"{a} to {b}: {way}"
        along = np.concatenate([np.linspace(p, q, 200) for p, q in itertools.pairwise(way.points)])
        columns, rows = ((along - FLAT_MAP.origin) / FLAT_MAP.resolution).astype(int).T
        assert free[rows, columns].min() > FOOTPRINT.radius, f"{a} to {b}"


def test_a_goal_in_the_furniture_of_the_flat_names_it() -> None:
    for thing in FLAT_MAP.furniture:
        middle = Pose((thing.x_min + thing.x_max) / 2, (thing.y_min + thing.y_max) / 2, 0)
        way = route(FLAT_MAP, HALL, middle, FOOTPRINT)
        assert isinstance(way, Unreachable)
        assert way.reason == "goal_blocked"
        assert f"the {thing.name} is there" in way.message or "chair" in way.message


def test_places_are_driven_to_without_touching_anything_fixed() -> None:
    """A tour through all places in random order; the whole of all ordered pairs is ``tests/bench/driving.py``."""
    symbols = sorted(PLACES)
    random.Random(0).shuffle(symbols)
    world = in_the_flat()
    fixed: set[str] = set()
    held: set[str] = set()

    def look() -> None:
        fixed.update(set(world.touching()) - set(flat().objects))
        held.update([world.blocked] if world.blocked else [])

    for symbol in symbols:
        goal = PLACES[symbol]
        drive_to(world, goal, look)
        assert not fixed, f"on the way to {symbol}"
        assert not held, f"on the way to {symbol}"
        assert world.at_rest
        assert world.true_pose.distance_to(goal) <= 0.03
        assert abs(math.remainder(world.true_pose.yaw - goal.yaw, 2 * math.pi)) <= math.radians(2)


def test_a_robot_facing_away_turns_before_it_goes() -> None:
    follower = Follower([(0, 0), (2, 0)], 0.0)
    first = follower.guide(Pose(0, 0, math.pi * 0.9))
    assert (first.twist.vx, first.twist.vy) == (0, 0)
    assert abs(first.twist.wz) > 1


def test_a_short_way_is_driven_without_turning_along_it() -> None:
    follower = Follower([(0, 0), (0, 0.3)], 0.0)
    guidance = follower.guide(Pose(0, 0, 0))
    assert guidance.twist.vy > 0.1
    assert guidance.twist.vx == pytest.approx(0, abs=1e-9)
    assert guidance.twist.wz == 0


def test_it_comes_back_to_the_path_it_was_pushed_off() -> None:
    follower, pose = Follower([(0, 0), (3, 0)], 0.0), Pose(0, 0, 0)
    furthest = 0.0
    for i in range(1500):
        guidance = follower.guide(pose)
        if guidance.arrived:
            break
        pose = _moved(pose, guidance.twist)
        if i == 100:
            pose = Pose(pose.x, 0.4, pose.yaw)
        elif i > 250:
            furthest = max(furthest, abs(pose.y))
    assert guidance.arrived
    assert furthest < 0.03
    assert follower.progress == 1.0


def test_progress_does_not_jump_to_a_later_stretch_of_the_path() -> None:
    there_and_back = Follower([(0, 0), (2, 0), (2, 0.3), (0, 0.3)], 0.0)
    there_and_back.guide(Pose(0.5, 0.2, 0))
    assert there_and_back.progress < 0.2


def _moved(pose: Pose, twist: Twist, dt: float = 0.02) -> Pose:
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = pose.x + (c * twist.vx - s * twist.vy) * dt, pose.y + (s * twist.vx + c * twist.vy) * dt
    return Pose(x, y, pose.yaw + twist.wz * dt)
