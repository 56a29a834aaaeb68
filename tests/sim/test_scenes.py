"""The scenes that come with sayso: what their files say is what the robot meets, and what its map knows."""

from __future__ import annotations

import math
from typing import Any

import cv2
import mujoco
import numpy as np
import pytest

from config import load
from engine.errors import SceneError
from engine.parts.loading import at_home
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from engine.robot.occupancy import Route, route
from engine.robot.sim.build import build
from engine.robot.sim.clutter import WALL_DISTANCE, clutter
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map, wall_pieces
from engine.robot.sim.furniture import FLAT
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.sketch import sketch
from engine.robot.sim.world import World
from tests.sim.eye import Eye
from tests.sim.rig import flat, settings
from tests.sim.test_scene import small

SEEDS = range(25)


def workshop() -> Scene:
    return load_scene(scene_path("workshop"))


def changed(scene: Scene, **changes: Any) -> Scene:
    return Scene.model_validate({**scene.model_dump(), **changes})


def occupied(floor: FloorMap, x: float, y: float) -> bool:
    row, column = (math.floor((v - o) / floor.resolution) for v, o in zip((y, x), floor.origin[::-1], strict=True))
    return bool(floor.occupied[row, column])


def test_the_map_knows_landmarks_doors_and_how_high_furniture_is() -> None:
    known = floor_map(flat())
    east = next(tag for tag in known.tags if tag.id == 100)
    assert (east.x, east.y, east.yaw, east.size) == pytest.approx((4.945, 0.15, math.pi, 0.24))
    kitchen_door = next(door for door in known.doors if set(door.between) == {"hall", "kitchen"})
    assert (kitchen_door.x, kitchen_door.y, kitchen_door.width) == (0.2, 0.9, 1.0)
    table = next(thing for thing in known.furniture if thing.name == "coffee table")
    assert (table.height, table.kind) == (0.14, "low_table")


@pytest.mark.parametrize("name", ["flat", "workshop", "clutter-3"])
def test_landmarks_hang_free_on_walls_and_fronts(name: str) -> None:
    scene = load_scene(scene_path(name))
    known = floor_map(scene)
    assert known.tags
    for tag in known.tags:
        behind = (tag.x - 0.08 * math.cos(tag.yaw), tag.y - 0.08 * math.sin(tag.yaw))
        assert occupied(known, *behind), f"landmark {tag.id} hangs on nothing"
        for metres in (0.1, 0.2, 0.3):
            before = (tag.x + metres * math.cos(tag.yaw), tag.y + metres * math.sin(tag.yaw))
            for piece in scene.furniture.values():
                x0, y0, x1, y1 = piece.area
                hidden = x0 < before[0] < x1 and y0 < before[1] < y1 and piece.size[2] > tag.z - tag.size / 2
                assert not hidden or piece.kind in FLAT, f"landmark {tag.id} is hidden"


def test_a_landmark_is_read_by_the_robots_camera_from_before_it() -> None:
    eye = Eye("flat", width=320, height=240)
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11))
    for tag in floor_map(flat()).tags:
        x, y = tag.x + 1.0 * math.cos(tag.yaw), tag.y + 1.0 * math.sin(tag.yaw)
        picture = eye.look(Pose(x, y, tag.yaw + math.pi))
        _, found, _ = detector.detectMarkers(cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY))
        assert found is not None, tag
        assert tag.id in found.ravel().tolist()


def test_a_poster_is_read_as_its_text() -> None:
    poster = workshop().posters[0]
    eye = Eye("workshop", width=320, height=240)
    picture = eye.look(Pose(poster.at[0] - 0.9, poster.at[1], 0.0))
    text, _, _ = cv2.QRCodeDetector().detectAndDecode(picture.rgb[:, :, ::-1].copy())
    assert text == poster.text


def test_the_map_keeps_moved_furniture_where_it_was_and_the_lidar_sees_where_it_is() -> None:
    desk = {"kind": "carton", "at": [1.5, 0.5], "moved": [0.9, 1.0], "size": [0.2, 0.2, 0.3]}
    scene = small(furniture={"carton": desk}, objects={})
    known = floor_map(scene)
    assert occupied(known, 1.5, 0.5)
    assert not occupied(known, 0.9, 1.0)
    world = World(scene, settings())
    assert world.ranges[0] == pytest.approx(0.9 - 0.1 - scene.start.x, abs=0.01)


def test_what_is_not_mapped_is_met_but_not_known() -> None:
    carton = {"kind": "carton", "at": [1.5, 1.0], "mapped": False, "size": [0.2, 0.2, 0.3]}
    scene = small(furniture={"carton": carton}, objects={})
    assert not occupied(floor_map(scene), 1.5, 1.0)
    assert floor_map(scene).furniture == ()
    assert World(scene, settings()).ranges[0] == pytest.approx(0.9, abs=0.01)


def test_a_closed_door_stops_the_lidar_but_not_the_map() -> None:
    door = {"between": ["left", "right"], "at": 1, "width": 0.8}
    ways = {}
    for closed in (False, True):
        scene = small(doors=[{**door, "closed": closed}], furniture={}, objects={})
        ways[closed] = float(World(scene, settings()).ranges[0])
        assert not occupied(floor_map(scene), 2.0, 1.0)
    assert ways[False] == pytest.approx(3.45, abs=0.02)
    assert ways[True] == pytest.approx(1.475, abs=0.02)


def test_a_person_walks_round_the_path_and_is_where_the_coordinates_say() -> None:
    path = [[1.0, 0.6], [1.7, 0.6], [1.7, 1.4], [1.0, 1.4]]
    world = World(small(furniture={}, objects={}, doors=[], people={"eve": {"path": path, "speed": 0.5}}), settings())
    eve = world.model.joint("eve x").qposadr[0]
    corners, longest = set(), 0.0
    last = world.data.qpos[eve : eve + 2].copy()
    for _ in range(6000):
        world.step()
        here = world.data.qpos[eve : eve + 2]
        longest, last = max(longest, math.dist(here, last)), here.copy()
        corners |= {i for i, corner in enumerate(path) if math.dist(corner, here) < 0.06}
        assert world.data.body("eve").xpos[:2] == pytest.approx(last, abs=0.005)
    assert corners == {0, 1, 2, 3}
    assert longest <= 0.5 * 0.002 + 1e-6, "nobody jumps"


def test_a_person_waits_for_a_robot_in_the_way_and_does_not_push_it() -> None:
    people = {"eve": {"path": [[1.8, 1.0], [0.2, 1.0]], "speed": 0.6}}
    world = World(small(furniture={}, objects={}, doors=[], people=people), settings())
    for _ in range(3000):
        world.step()
    assert world.true_pose.distance_to(Pose(0.5, 1.0, 0.0)) < 0.002
    eve = world.model.joint("eve x").qposadr[0]
    assert 0.9 < world.data.qpos[eve] < 1.1
    ahead = np.concatenate((world.ranges[:20], world.ranges[-20:]))
    assert ahead.min() == pytest.approx(0.45, abs=0.1), "the lidar sees the legs"


def test_things_may_stand_on_one_another() -> None:
    scene = workshop()
    model = build(scene)
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    for name, loose in scene.objects.items():
        assert data.body(name).xpos[2] == pytest.approx(scene.standing_height(loose), abs=0.004), name
    assert data.body("block 5").xpos[2] > data.body("block 4").xpos[2] + 0.04
    with pytest.raises(SceneError, match="would stand on itself"):
        floor_map(_loop())


def _loop() -> Scene:
    box = {"kind": "box", "at": [1, 1], "size": 0.04}
    try:
        return small(objects={"a": {**box, "stands_on": "b"}, "b": {**box, "stands_on": "a"}})
    except ValueError as error:
        raise SceneError(str(error)) from error


def test_clutter_is_the_same_for_the_same_seed_and_another_for_another() -> None:
    assert load_scene(scene_path("clutter-7")) == clutter(7)
    assert clutter(7) != clutter(8).model_copy(update={"name": "clutter-7"})
    with pytest.raises(SceneError, match="no scene called 'clutter-x'"):
        scene_path("clutter-x")


@pytest.mark.parametrize("seed", SEEDS)
def test_everything_in_clutter_can_be_reached(seed: int) -> None:
    scene = clutter(seed)
    known = floor_map(scene)
    start = scene.start.pose
    walls = [(w.x_min, w.y_min, w.x_max, w.y_max) for w in wall_pieces(scene)]
    assert len(scene.objects) >= 4
    assert {"bin"} < set(scene.furniture)
    for place in scene.known_places().values():
        goal = Pose(place.position.x, place.position.y, place.orientation.yaw)
        assert isinstance(route(known, start, goal, FOOTPRINT), Route), place.name
    for name, loose in scene.objects.items():
        if loose.stands_on is None:
            around = [away(loose.at, area) for area in [*walls, *(piece.area for piece in scene.furniture.values())]]
            assert min(around) > WALL_DISTANCE - 0.06, name
        else:
            x0, y0, x1, y1 = scene.furniture[loose.stands_on].area
            assert min(loose.at[0] - x0, x1 - loose.at[0], loose.at[1] - y0, y1 - loose.at[1]) < 0.09, name
        others = [other.at for n, other in scene.objects.items() if n != name]
        assert min(math.dist(loose.at, other) for other in others) > 0.14, name


def away(point: tuple[float, float], area: tuple[float, float, float, float]) -> float:
    dx = max(area[0] - point[0], 0.0, point[0] - area[2])
    dy = max(area[1] - point[1], 0.0, point[1] - area[3])
    return math.hypot(dx, dy)


def test_a_scene_with_places_brings_them_and_the_flat_has_those_of_the_configuration() -> None:
    configured = load(environ={})
    assert at_home(configured).places == configured.places
    there = at_home(load(overrides=["robot.scene=workshop"], environ={})).places
    assert [place.name for place in there.values()][:2] == ["workshop", "line"]
    assert next(iter(there)) == "A"


def test_the_drawing_shows_things_in_their_colours_where_they_are() -> None:
    drawn = sketch(flat(), words=False)
    for name, (red, green, blue) in {"red box": (211, 58, 51), "green box": (60, 156, 78)}.items():
        column, row = drawn.pixel(*flat().objects[name].at)
        assert np.abs(drawn.picture[int(row), int(column)].astype(int) - (red, green, blue)).max() < 30, name
    column, row = drawn.pixel(-1.5, 3.5)
    assert drawn.picture[int(row), int(column)].max() < 120, "a wall is dark"
