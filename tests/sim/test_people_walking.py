"""People who follow the robot, stray, lead it and step out of its way, in the family's flat and in a bare hall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.robot.floor_map import Wall
from engine.robot.follow import Follower
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.memory import STATE
from engine.robot.occupancy import Route, route
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map, wall_pieces
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.world import World
from tests.sim.rig import drive, settings, tick
from tests.sim.test_people_hearing import HALL, company_of, hall, said


def family(start: Pose, **people: dict[str, Any]) -> World:
    """The family's flat with these people instead."""
    scene = load_scene(scene_path("family"))
    begin = {"x": start.x, "y": start.y, "yaw": math.degrees(start.yaw)}
    return World(Scene.model_validate({**scene.model_dump(), "start": begin, "people": people}), settings())


def place(world: World, name: str) -> tuple[float, float]:
    at = world.model.joint(f"{name} x").qposadr[0]
    x, y = world.data.qpos[at : at + 2].tolist()
    return x, y


def apart(world: World, name: str) -> float:
    return math.dist(place(world, name), (world.true_pose.x, world.true_pose.y))


class Watched:
    """Looks at somebody in every tick: how near the robot, how fast, and whether in a wall."""

    def __init__(self, world: World, name: str, walls: tuple[Wall, ...]) -> None:
        self._world, self._name, self._walls = world, name, walls
        self._last = place(world, name)
        self.nearest, self.fastest = math.inf, 0.0

    def __call__(self) -> None:
        x, y = here = place(self._world, self._name)
        self.nearest = min(self.nearest, apart(self._world, self._name))
        self.fastest = max(self.fastest, math.dist(here, self._last) / 0.02)
        self._last = here
        for wall in self._walls:
            inside = wall.x_min < x < wall.x_max and wall.y_min < y < wall.y_max
            assert not inside, f"in a wall at {here}"


def go(world: World, scene: Scene, goal: Pose, each_tick: Watched) -> None:
    """Drive there, as the robot would."""
    way = route(floor_map(scene), world.true_pose, goal, FOOTPRINT)
    assert isinstance(way, Route), way.message
    follower = Follower(way.points, goal.yaw)
    until = world.t + 15 + 6 * way.length
    while not (guidance := follower.guide(world.true_pose)).arrived:
        assert world.t < until, f"no arrival: {world.true_pose}, blocked by {world.blocked}"
        world.drive(guidance.twist)
        tick(world)
        each_tick()
    drive(world, ZERO, 3.0, each_tick)


def test_who_follows_comes_after_the_robot_through_doors_and_never_through_walls() -> None:
    scene = load_scene(scene_path("family"))
    world = family(Pose(-2.0, 0.3, math.pi), William={"path": [[-3.0, 0.3]]})
    assert [n.does for n in said(world, "William, please follow me to the kitchen.")] == ["hears", "follows"]
    watched = Watched(world, "William", wall_pieces(scene))
    go(world, scene, Pose(0.4, 2.3, math.pi / 2), watched)
    assert apart(world, "William") == pytest.approx(1.0, abs=0.3)
    assert watched.nearest > 0.55
    assert 0.3 < watched.fastest <= 0.8 + 1e-6
    assert [n.does for n in said(world, "Here we are.")] == ["hears", "stays"]
    before = place(world, "William")
    go(world, scene, Pose(0.4, 0.0, 0.0), watched)
    assert place(world, "William") == pytest.approx(before, abs=0.01)


def test_who_walked_round_their_path_leaves_it_to_follow() -> None:
    world = hall(eve={"path": [[-1.2, -1], [-1.2, 1]], "speed": 0.3})
    said(world, "Please follow me.")
    drive(world, Twist(0.25), 8.0)
    assert apart(world, "eve") == pytest.approx(1.0, abs=0.35)


def test_who_strays_stops_once_until_they_are_called() -> None:
    world = hall(eve={"path": [[-1.2, 0]], "strays": 1.0})
    said(world, "Please follow me.")
    drive(world, Twist(0.2), 9.0)
    assert [(n.who, n.does) for n in company_of(world).news()] == [("eve", "stays")]
    stood = place(world, "eve")
    assert stood[0] == pytest.approx(-0.2, abs=0.05)
    assert said(world, "The kitchen is near.", 2.0)[-1].does == "hears"
    assert place(world, "eve") == pytest.approx(stood, abs=0.01)
    assert [n.does for n in said(world, "Please come along.")] == ["hears", "follows"]
    drive(world, Twist(0.2), 10.0)
    assert apart(world, "eve") == pytest.approx(1.0, abs=0.3), "not a second time"
    assert company_of(world).news() == ()


def test_who_has_strayed_comes_when_their_name_is_called() -> None:
    world = hall(eve={"path": [[-1.2, 0]], "strays": 0.5})
    said(world, "Please follow me.")
    drive(world, Twist(0.2), 6.0)
    assert said(world, "Eve!")[-1].does == "follows"


def test_who_sits_or_lies_goes_nowhere() -> None:
    for posture in ("sitting", "lying"):
        world = hall(eve={"path": [[-1, 0]], "posture": posture})
        assert [n.does for n in said(world, "Please follow me.")] == ["hears"]
        assert [n.does for n in said(world, "May I pass, please?")] == ["hears"]
        drive(world, Twist(0.3), 4.0)
        assert place(world, "eve") == pytest.approx((-1, 0), abs=0.01)


def test_who_leads_walks_their_way_waits_for_the_robot_and_stands_at_its_end() -> None:
    world = hall(ann={"path": [[1, 0]], "leads": [[4, 0], [4, 2]], "speed": 0.5})
    assert [n.does for n in said(world, "I follow you.")] == ["hears", "leads"]
    drive(world, ZERO, 6.0)
    assert apart(world, "ann") == pytest.approx(2.0, abs=0.1), "they wait"
    while world.true_pose.x < 3.6:
        drive(world, Twist(0.3), 0.1)
    drive(world, ZERO, 6.0)
    assert place(world, "ann") == pytest.approx((4, 2), abs=0.08)
    assert [n.does for n in company_of(world).news()] == ["stays"]


def test_nobody_leads_who_does_not_know_where_to() -> None:
    world = hall(ann={"path": [[1, 0]]})
    assert [n.does for n in said(world, "I follow you.")] == ["hears"]


@pytest.mark.parametrize(("y", "way"), [(0.1, 1), (-0.1, -1)])
def test_who_is_in_the_way_steps_to_the_side_they_are_on_already(y: float, way: int) -> None:
    world = hall(eve={"path": [[1, y]], "facing": 180})
    assert [n.does for n in said(world, "May I pass, please?", 3.0)] == ["hears", "steps aside"]
    x, stepped = place(world, "eve")
    assert math.dist((x, stepped), (1, y)) == pytest.approx(0.6, abs=0.03)
    assert math.copysign(1, stepped) == way
    drive(world, Twist(0.4), 6.0)
    assert world.true_pose.x > 1.9, f"blocked by {world.blocked}"


def test_nobody_steps_into_a_wall() -> None:
    world = family(Pose(1.0, -0.55, 0.0), eve={"path": [[2.0, -0.5]], "facing": 180})
    assert said(world, "Let me pass, please.", 3.0)[-1].does == "steps aside"
    assert place(world, "eve")[1] == pytest.approx(0.1, abs=0.05)


def test_who_walks_about_goes_on_once_the_robot_has_passed() -> None:
    world = hall(eve={"path": [[0.9, 0], [5, 0]], "speed": 0.2})
    said(world, "Let me pass, please.", 3.0)
    aside = place(world, "eve")
    assert abs(aside[1]) > 0.5
    drive(world, Twist(0.5), 7.0)
    drive(world, ZERO, 10.0)
    assert place(world, "eve") != pytest.approx(aside, abs=0.3)


def test_who_was_led_away_from_their_path_stays_there_after_the_host_was_replaced() -> None:
    eve = {"path": [[-1.2, -1], [-1.2, 1]], "speed": 0.3}
    world = hall(eve=eve)
    said(world, "Please follow me.")
    drive(world, Twist(0.3), 9.0)
    last = np.zeros((), STATE)
    world.fill(last)
    again = World(Scene.model_validate({**HALL, "people": {"eve": eve}}), settings(), last)
    stood = place(again, "eve")
    assert stood[0] > 0
    drive(again, ZERO, 3.0)
    assert place(again, "eve") == pytest.approx(stood, abs=0.01)


@pytest.mark.parametrize(
    ("words", "room", "robot"),
    [("I follow you to the kitchen.", "kitchen", Pose(0.9, 0.6, 0)), ("我跟着你去书房。", "study", Pose(2.4, -0.3, 0))],
)
def test_who_gives_the_tasks_leads_to_any_room(words: str, room: str, robot: Pose) -> None:
    world = family(robot, you={"path": [[1, 0]], "speed": 1.0, "gives_tasks": True})
    assert [n.does for n in said(world, words)] == ["hears", "leads"]
    drive(world, ZERO, 8.0)
    assert load_scene(scene_path("family")).rooms[room].contains(*place(world, "you"))


def test_who_gives_the_tasks_answers_as_a_person_at_the_keyboard_and_not_by_themselves() -> None:
    world = hall(you={"path": [[1, 0]], "gives_tasks": True}, eve={"path": [[-2, 0]]})
    assert [(n.who, n.does) for n in said(world, "What is your name?")] == [("eve", "hears"), ("eve", "says")]
