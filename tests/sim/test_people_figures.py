"""How the people of a scene stand, sit, lie and gesture: what the camera and the lidar meet of them."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.robot.geometry import Pose
from engine.robot.sim.figure import WAVE_SWING, waving_joint
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.world import World
from tests.sim.eye import Eye
from tests.sim.rig import settings
from tests.sim.test_scene import small

UP = (0.0, -1.1, 1.6, 0.85, 0.0)
"""The arm as it rests, with the camera looking up at people."""


def scene_with(facing: float = 180.0, **person: Any) -> Scene:
    """The robot looks east, at somebody 2.3 m before it who looks back."""
    return Scene.model_validate(
        {
            "name": "room",
            "bounds": {"x": [-3, 3], "y": [-3, 3]},
            "start": {"x": -2.3, "y": 0},
            "rooms": {"room": {"x": [-3, 3], "y": [-3, 3]}},
            "people": {"eve": {"path": [[0, 0]], "facing": facing, "height": 1.65, **person}},
        }
    )


def seen(scene: Scene) -> NDArray[np.float64]:
    """Where what the camera sees of eve is, map frame, m, shape (n, 3)."""
    eye = Eye(scene)
    picture = eye.look(joints=UP)
    assert picture.labels is not None
    roots = eye.model.body_rootid[eye.model.geom_bodyid]
    mine = (picture.labels >= 0) & (roots[picture.labels] == eye.model.body("eve").id)
    return picture.on_map(picture.points(mine))


@pytest.mark.parametrize(
    ("gesture", "left", "above"),
    [
        ("raising the left arm", -0.235, 0.15),
        ("raising the right arm", 0.235, 0.15),
        ("waving", 0.235, 0.15),
        ("pointing to the left", -0.85, None),
        ("pointing to the right", 0.85, None),
    ],
)
def test_a_gesture_shows_beside_or_above_the_head_on_their_own_side(
    gesture: str, left: float, above: float | None
) -> None:
    points = seen(scene_with(gesture=gesture))
    if above is not None:
        raised = points[points[:, 2] > 1.65 + above]
        assert len(raised) > 20
        assert raised[:, 1].mean() == pytest.approx(left, abs=0.05)
    else:
        out = points[np.abs(points[:, 1]) > 0.5]
        assert len(out) > 30
        assert np.sign(out[:, 1]).mean() == np.sign(left)
        assert np.abs(out[:, 1]).max() > abs(left)
        assert out[:, 2].std() < 0.05, "level"


def test_a_waving_arm_swings_for_who_copies_the_coordinates() -> None:
    world = World(scene_with(gesture="waving"), settings())
    joint = world.model.joint(waving_joint("eve")).qposadr[0]
    angles = []
    for _ in range(1000):
        world.step()
        angles.append(float(world.data.qpos[joint]))
    assert max(angles) == pytest.approx(WAVE_SWING, abs=0.01)
    assert min(angles) == pytest.approx(-WAVE_SWING, abs=0.01)
    upwards = sum(1 for before, after in itertools.pairwise(angles) if before < 0 <= after)
    assert upwards == 2, "1.2 times a second"
    assert world.data.body("eve").xpos[:2] == pytest.approx((0, 0), abs=1e-4), "the arm pulls nobody about"


def test_who_sits_has_their_thighs_level_and_their_shins_before_the_lidar() -> None:
    sofa = {"kind": "sofa", "at": [0.12, 0.0], "size": [2.1, 0.9, 0.78], "turn": 270}
    scene = scene_with(posture="sitting", seat=0.38)
    scene = Scene.model_validate({**scene.model_dump(), "furniture": {"sofa": sofa}})
    points = seen(scene)
    assert points[:, 2].max() == pytest.approx(0.38 + 0.08 + 0.52 * 1.65, abs=0.03)
    world = World(scene, settings())
    before = world.ranges[np.r_[:8, -8:0]].min()
    assert before == pytest.approx(2.3 - 0.245 * 1.65 - 0.055, abs=0.03)
    for _ in range(500):
        world.step()
    assert world.data.body("eve").xpos == pytest.approx((0, 0, 0), abs=1e-4), "the sofa does not push"


def test_who_lies_is_level_with_the_head_where_they_face() -> None:
    bed = {"kind": "bed", "at": [0.0, 0.0], "size": [1.6, 1.9, 0.6], "turn": 0}
    scene = scene_with(posture="lying", seat=0.45, facing=90.0, shirt="red")
    scene = Scene.model_validate({**scene.model_dump(), "furniture": {"bed": bed}})
    eye = Eye(scene)
    eye.look(joints=UP)
    eve = eye.model.body("eve").id
    middles = eye.data.geom_xpos[eye.model.geom_bodyid == eve]
    assert middles[:, 2].min() > 0.45
    assert middles[:, 2].max() < 0.75
    assert middles[:, 1].max() == pytest.approx(0.75, abs=0.05)
    assert middles[:, 1].min() == pytest.approx(-0.75, abs=0.05)


def test_who_lies_on_the_floor_is_met_by_the_lidar() -> None:
    world = World(scene_with(posture="lying", seat=0.0, facing=90.0), settings())
    assert world.ranges[0] == pytest.approx(2.3 - 0.28, abs=0.03), "a hand beside the hip"


@pytest.mark.parametrize("facing", [0.0, 90.0, 135.0, 180.0, 225.0])
def test_an_arm_stretched_out_is_seen_whole_whatever_way_somebody_looks(facing: float) -> None:
    """MuJoCo's own bounds on rays take a turned body as if it were not turned."""
    eye = Eye(scene_with(gesture="pointing to the left", facing=facing))
    labels = eye.look(Pose(-2.6, 0.0, 0.0), UP).labels
    assert labels is not None
    hand = np.array([0.0, 0.235 + 0.4 * 1.65, 0.82 * 1.65 - 0.03])
    c, s = math.cos(math.radians(facing)), math.sin(math.radians(facing))
    hand[:2] = (-s * hand[1], c * hand[1])
    spheres = [g for g in range(eye.model.ngeom) if math.dist(eye.data.geom_xpos[g], hand) < 0.02]
    assert spheres
    assert any((labels == g).any() for g in spheres)


def test_the_family_is_at_home_and_everybody_known_wears_a_colour_of_their_own() -> None:
    scene = load_scene(scene_path("family"))
    assert {"you", "William", "Anna", "Elizabeth", "James", "visitor"} == set(scene.people)
    shirts = [person.shirt for person in scene.people.values()]
    assert len(set(shirts)) == len(shirts)
    assert [name for name, person in scene.people.items() if not person.known] == ["you", "visitor"]


def test_who_holds_something_that_does_not_exist_is_told() -> None:
    with pytest.raises(ValueError, match=r"people\.eve\.holds: no object is called 'cup'"):
        small(people={"eve": {"path": [[1, 1]], "holds": "cup"}})
