"""The judge of the task suite: it finds what is wrong, and finds nothing where nothing is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest

from config import load
from engine.robot.arm import ARM_INITIAL
from engine.robot.geometry import Pose
from engine.robot.sim.body import initial_qpos
from engine.robot.sim.build import build
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from tests.bench.tasks import verdicts_of
from tests.eval.checker import CONDITIONS, Done, Evidence, Mistaken, Sample, faults
from tests.eval.runner import run
from tests.eval.tasks import tasks, trial

FLAT = load_scene(scene_path("flat"))
WORKSHOP = load_scene(scene_path("workshop"))
PLACES = load(environ={}).places
Where = tuple[float, ...]


class Story:
    """A made-up run: what is where at which time."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._model: Any = build(scene)
        self._data: Any = mujoco.MjData(self._model)
        initial_qpos(self._model, self._data, scene.start.pose)
        self._pose, self._t = scene.start.pose, 0.0
        self.samples: list[Sample] = []
        self.then(0.0)

    def then(self, seconds: float, robot: Pose | None = None, **things: Where) -> Story:
        """So much later the robot is there, and these things (``red_box``) too."""
        self._pose, self._t = robot or self._pose, self._t + seconds
        for axis, value in zip(("x", "y", "yaw"), (self._pose.x, self._pose.y, self._pose.yaw), strict=True):
            self._data.qpos[self._model.joint(f"base {axis}").qposadr[0]] = value
        for name, where in things.items():
            self._put(name.replace("_", " "), where)
        self.samples.append(Sample(self._t, self._pose, ARM_INITIAL, self._data.qpos.copy()))
        return self

    def _put(self, name: str, where: Where) -> None:
        if name in self._scene.people:
            for axis, value in zip("xy", where, strict=True):
                self._data.qpos[self._model.joint(f"{name} {axis}").qposadr[0]] = value
            return
        at = self._model.joint(name).qposadr[0]
        self._data.qpos[at : at + len(where)] = where

    def told(self, *actions: Done, result: str = "done", words: str = "") -> Evidence:
        places = self._scene.known_places() or PLACES
        return Evidence(self._scene, places, tuple(self.samples), actions, result, words)


def wrong(evidence: Evidence, condition: str, arguments: Any) -> str:
    found = faults([{condition: arguments}], evidence)
    return found[0] if found else ""


IN_BIN = (1.52, 1.3, 0.02)
ON_STOOL = (-0.85, 1.25, 0.141)
KITCHEN_FLOOR = (0.5, 2.5, 0.0)
LYING = (-0.85, 1.25, 0.161, math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)


@pytest.mark.parametrize(
    ("condition", "arguments", "good", "bad"),
    [
        ("in_bin", "red box", {"red_box": IN_BIN}, {"red_box": (1.52, 1.3, 0.25)}),
        ("all_in_bin", "red", {"red_box": IN_BIN}, {"blue_box": IN_BIN}),
        ("none_in_bin", "red", {"red_box": IN_BIN}, {"blue_box": IN_BIN}),
        ("lies_on", {"thing": "red box", "furniture": "stool"}, {"red_box": ON_STOOL}, {"red_box": KITCHEN_FLOOR}),
        ("lies_on", {"thing": "red box", "furniture": "stool"}, {"red_box": LYING}, {"red_box": (-0.85, 1.25, 0.2)}),
        ("on_floor", "red box", {"red_box": KITCHEN_FLOOR}, {"red_box": ON_STOOL}),
        ("in_room", {"thing": "red box", "room": "kitchen"}, {"red_box": KITCHEN_FLOOR}, {"red_box": (3, 2, 0)}),
        (
            "near",
            {"thing": "red box", "place": "kitchen", "within": 0.6},
            {"red_box": KITCHEN_FLOOR},
            {"red_box": (1.2, 2.5, 0)},
        ),
        ("untouched", {"but": ["red box"]}, {"red_box": KITCHEN_FLOOR}, {"blue_box": KITCHEN_FLOOR}),
    ],
)
def test_where_a_thing_lies_is_told_from_where_it_does_not(
    condition: str, arguments: Any, good: Mapping[str, Where], bad: Mapping[str, Where]
) -> None:
    assert wrong(Story(FLAT).then(5, None, **good).told(), condition, arguments) == ""
    assert wrong(Story(FLAT).then(5, None, **bad).told(), condition, arguments).startswith(f"{condition}: ")


def test_a_thing_between_the_fingertips_is_held_and_one_below_them_is_not() -> None:
    story = Story(FLAT).then(1)
    x, y, z = story.told().grip()
    assert wrong(story.then(1, red_box=(x, y, z - 0.02)).told(), "held", "red box") == ""
    assert "fingertips" in wrong(story.then(1, red_box=(x, y, 0.0)).told(), "held", "red box")


def test_a_stack_is_too_high_until_its_upper_block_is_off() -> None:
    low = {"furniture": "stack table", "than": 0.06, "kind": "tag_block"}
    assert "block 5 (9" in wrong(Story(WORKSHOP).then(1).told(), "no_higher", low)
    beside = Story(WORKSHOP).then(1, block_5=(1.58, 1.55, 0.101)).told()
    assert wrong(beside, "no_higher", low) == ""
    assert "orange box" in wrong(beside, "no_higher", {**low, "kind": "box"})
    on_floor = Story(WORKSHOP).then(1, block_5=(1.2, 1.2, 0.0)).told()
    assert wrong(on_floor, "no_higher", low) == ""


def test_where_the_robot_was_and_in_which_order() -> None:
    bedroom, study = Pose(0.5, -2.0, -math.pi / 2), Pose(3.0, 2.0, math.pi / 2)
    there = Story(FLAT).then(9, bedroom).then(9, study).then(9, FLAT.start.pose).told()
    assert wrong(there, "passed", {"places": ["bedroom", "study", "start"]}) == ""
    assert "was not at the bedroom" in wrong(there, "passed", {"places": ["study", "bedroom"]})
    assert wrong(there, "robot_at", {"place": "start"}) == ""
    assert "m from the study" in wrong(there, "robot_at", {"place": "study"})
    turned_round = Story(FLAT).then(9, Pose(0, 0, 3)).told()
    assert "turned by 172°" in wrong(turned_round, "robot_at", {"place": "start", "turned": 10})
    assert wrong(there, "robot_not_in", "kitchen") == ""
    assert wrong(there, "robot_not_in", "study") == "robot_not_in: was in the study"


def test_standing_near_counts_only_while_the_robot_stands() -> None:
    near = Pose(1.4, 1.9, 1.5)
    stood = Story(FLAT).then(1, near).then(4, near).told()
    arguments = {"thing": "green box", "within": 0.5, "seconds": 3}
    assert wrong(stood, "stood_near", arguments) == ""
    assert wrong(stood, "robot_near", {"thing": "green box", "within": 0.5}) == ""
    passing = Story(FLAT).then(1, near).then(4, Pose(1.5, 2.0, 1.5)).told()
    assert "for 0.0 s" in wrong(passing, "stood_near", arguments)


def test_following_needs_nearness_all_the_time_and_a_way() -> None:
    behind, arguments = Story(WORKSHOP), {"target": "worker", "within": 1.5, "part": 0.8, "way": 1.0}
    left_alone = Story(WORKSHOP)
    for step in range(20):
        x = 2.9 - 0.1 * step
        behind.then(1, Pose(x + 1.2, 0, 3.1), worker=(x, 0.0))
        left_alone.then(1, worker=(x, 0.0))
    behind.samples = behind.samples[1:]
    assert wrong(behind.told(), "followed", arguments) == ""
    assert "near the worker for" in wrong(left_alone.told(), "followed", arguments)
    assert "drove" in wrong(behind.told(), "followed", {**arguments, "way": 5.0})


def along(line: Sequence[tuple[float, float]], part: float) -> Story:
    story = Story(WORKSHOP)
    for x, y in line[: round(part * len(line))]:
        story.then(1, Pose(x, y, 0.0))
    return story


def test_a_line_is_followed_to_its_end_and_not_cut_short() -> None:
    points = WORKSHOP.lines["blue line"].points
    fine = [
        (a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])) for a, b in pairwise(points) for f in np.linspace(0, 1, 20)
    ]
    whole, half = along(fine, 1.0).told(), along(fine, 0.5).told()
    kept = {"line": "blue line", "within": 0.1, "part": 0.9}
    assert faults([{"kept_to": kept}, {"at_end_of": {"line": "blue line", "within": 0.3}}], whole) == ()
    assert "% of the blue line" in wrong(half, "kept_to", kept)
    assert "from the end" in wrong(half, "at_end_of", {"line": "blue line", "within": 0.3})


def test_what_lies_on_a_line_is_not_aside() -> None:
    arguments = {"things": ["red box"], "line": "blue line", "within": 0.1}
    assert "red box" in wrong(Story(WORKSHOP).then(1).told(), "aside", arguments)
    assert wrong(Story(WORKSHOP).then(1, red_box=(-1.3, -2.5, 0)).told(), "aside", arguments) == ""


def test_touching_with_the_hull_is_counted_once_for_as_long_as_it_lasts() -> None:
    wall = Pose(-4.82, -1.5, 0.0)  # the tail is 2 cm inside the wall
    bumped = Story(FLAT).then(5, wall).then(1, wall).then(1, Pose(-4.0, -1.5, 0)).then(1, wall).told()
    assert wrong(bumped, "collisions", 2) == ""
    assert wrong(bumped, "collisions", 1).startswith("collisions: 2: wall")
    assert wrong(Story(FLAT).then(5, Pose(-4.0, -1.5, 0)).told(), "collisions", 0) == ""


def test_gestures_and_turns_are_seen_in_the_joints_and_the_base() -> None:
    still = Story(FLAT).then(1)
    assert "no joint" in wrong(still.told(), "arm_moved", 0.2)
    assert "turned by 0°" in wrong(still.told(), "turned", 60)
    moved = Story(FLAT).then(1, Pose(0, 0, 0.8)).then(1, Pose(0, 0, 0))
    moved.samples[1] = Sample(1.0, Pose(0, 0, 0.8), (0.0, -0.6, 1.85, 1.05, 0.0), moved.samples[1].qpos)
    assert faults([{"arm_moved": 0.2}, {"turned": 60}], moved.told()) == ()


def test_reports_are_judged_by_their_codes_and_words() -> None:
    refused = Story(FLAT).told(
        Done("navigation", "failed", "door_closed"), result="failed", words="The bedroom door is closed."
    )
    assert faults([{"reported": "failed"}, {"failed_with": ["door_closed"]}, {"says": "closed"}], refused) == ()
    assert "door_closed" in wrong(refused, "failed_with", "path_blocked")
    assert wrong(refused, "reported", "done")
    assert wrong(refused, "says", "open")
    assert "no action failed" in wrong(Story(FLAT).told(Done("navigation", "ok", None)), "failed_with", "path_blocked")


def test_a_place_that_was_told_must_be_the_true_one() -> None:
    told = Story(FLAT).told(Done("locate", "ok", None, {"x": 1.45, "y": 2.3}))
    assert wrong(told, "located", {"thing": "green box", "within": 0.1}) == ""
    assert "told a place" in wrong(told, "located", {"thing": "red box", "within": 0.1})
    assert "no action told" in wrong(Story(FLAT).told(), "located", {"thing": "red box", "within": 0.1})


def test_a_condition_that_names_nothing_real_is_a_mistake_and_no_verdict() -> None:
    for entry in (
        {"in_bni": "red box"},
        {"in_bin": "red bxo"},
        {"lies_on": {"thing": "red box", "furniture": "stol"}},
        {"robot_at": {"place": "moon"}},
    ):
        with pytest.raises(Mistaken):
            faults([entry], Story(FLAT).told())


@pytest.mark.parametrize("kind", tasks())
def test_doing_nothing_does_no_task(kind: str) -> None:
    made = trial(kind, tasks()[kind], seed=0)
    assert "{" not in made.say
    assert {name for entry in made.success for name in entry} <= CONDITIONS.keys()
    places = made.scene.known_places() or PLACES
    still = Story(made.scene).samples
    evidence = Evidence(made.scene, places, [*still, *still], (), "no result", "")
    assert faults(made.success, evidence), "a robot that only stands there must not pass"


def test_a_seed_makes_the_same_trial_again_and_another_makes_another() -> None:
    for kind, task in tasks().items():
        assert trial(kind, task, 1) == trial(kind, task, 1)
        assert trial(kind, task, 1).scene != trial(kind, task, 2).scene, kind


def test_a_whole_run_is_judged_from_the_robots_own_process() -> None:
    blocked = trial("blocked way", tasks()["blocked way"], seed=3)
    verdict = run(blocked)
    assert verdict.ok, verdict.reason
    assert verdict.robot_s > 1
    wished = blocked.model_copy(update={"success": ({"robot_at": {"place": "study"}},)})
    assert "m from the study" in run(wished).reason


def test_two_runs_side_by_side_do_the_same() -> None:
    made = trial("closed door", tasks()["closed door"], seed=0)
    one, other = verdicts_of([made, made], "max", jobs=2)
    assert one.ok
    assert other.ok
    assert one.robot_s == pytest.approx(other.robot_s, abs=1e-6)
