"""Scene files, the map made of them, and the model built from them."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from engine.errors import SceneError
from engine.robot.floor_map import FloorMap
from engine.robot.sim.build import build
from engine.robot.sim.floor import floor_map, wall_pieces
from engine.robot.sim.furniture import FLAT, solids
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.textures import TAG_CELLS, tag_cells
from tests.sim.rig import flat

SMALL = {
    "name": "small",
    "bounds": {"x": [0, 4], "y": [0, 2]},
    "start": {"x": 0.5, "y": 1},
    "rooms": {"left": {"x": [0, 2], "y": [0, 2]}, "right": {"x": [2, 4], "y": [0, 2]}},
    "doors": [{"between": ["left", "right"], "at": 1, "width": 0.8}],
    "furniture": {"desk": {"kind": "desk", "at": [3.4, 1], "size": [1, 0.6, 0.7], "turn": 270}},
    "objects": {"red box": {"kind": "box", "at": [3.4, 1], "stands_on": "desk", "size": 0.04, "colour": "red"}},
}


def small(**changes: object) -> Scene:
    return Scene.model_validate({**SMALL, **changes})


def written(tmp_path: Path, **changes: object) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(yaml.safe_dump({**SMALL, **changes}), "utf-8")
    return path


def occupied(floor: FloorMap, x: float, y: float) -> bool:
    row, column = (math.floor((v - o) / floor.resolution) for v, o in zip((y, x), floor.origin[::-1], strict=True))
    return bool(floor.occupied[row, column])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"furnitur": {}}, "furnitur: this key means nothing"),
        ({"doors": [{"between": ["left", "rihgt"], "at": 1, "width": 1}]}, "did you mean right"),
        ({"start": {"x": 9, "y": 0}}, "start: .* outside the bounds"),
        ({"start": {"x": "here", "y": 0}}, "start.x: .*number"),
        ({"keep_out": [{"name": "stairs", "x": [0, 1], "y": [0, 2]}]}, "inside the keep-out zone stairs"),
        ({"objects": {"cup": {"kind": "cup", "at": [1, 1], "stands_on": "dsek", "size": 0.1}}}, "did you mean desk"),
        ({"objects": {"cup": {"kind": "cup", "at": [1, 1], "stands_on": "desk", "size": 0.1}}}, "not on the desk"),
        ({"objects": {"b": {"kind": "tag_block", "at": [1, 1], "size": 0.1}}}, "objects.b: a tag_block has a tag"),
        ({"walls": {"colour": "rde"}}, "walls.colour: 'rde' is no colour"),
    ],
)
def test_a_mistake_in_a_scene_names_the_file_and_the_key(tmp_path: Path, changes: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=rf"small\.yaml is wrong: .*{said}"):
        load_scene(written(tmp_path, **changes))


def test_a_scene_that_is_no_yaml_or_no_file_says_so(tmp_path: Path) -> None:
    broken = tmp_path / "broken.yaml"
    broken.write_text("rooms: [", "utf-8")
    with pytest.raises(SceneError, match="is not YAML"):
        load_scene(broken)
    with pytest.raises(SceneError, match="no scene file"):
        scene_path(str(tmp_path / "missing.yaml"))


def test_walls_stand_on_the_edges_of_rooms_with_gaps_for_doors() -> None:
    floor = floor_map(small())
    for x, y in ((0.0, 1.0), (4.0, 1.0), (1.0, 0.0), (3.0, 2.0), (2.0, 0.3), (2.0, 1.7)):
        assert occupied(floor, x, y), (x, y)
    for x, y in ((1.0, 1.0), (2.0, 1.0), (2.0, 0.7), (2.0, 1.35)):
        assert not occupied(floor, x, y), (x, y)
    assert len(wall_pieces(small())) == 6, "four around, two beside the door: a shared wall stands once"


def test_a_door_that_no_wall_has_is_refused() -> None:
    with pytest.raises(SceneError, match="not in a wall that they share"):
        wall_pieces(small(doors=[{"between": ["left", "right"], "at": 1.8, "width": 0.8}]))


def test_turned_furniture_takes_its_turned_place() -> None:
    floor = floor_map(small())
    desk = floor.furniture[0]
    assert (desk.x_min, desk.y_min, desk.x_max, desk.y_max) == pytest.approx((3.1, 0.5, 3.7, 1.5))
    assert occupied(floor, 3.15, 0.6)
    assert not occupied(floor, 3.0, 1.0)


def test_rugs_are_no_obstacle() -> None:
    floor = floor_map(flat())
    rug = flat().furniture["bedroom rug"]
    assert not occupied(floor, *rug.at)
    assert "bedroom rug" not in {thing.name for thing in floor.furniture}


def test_every_piece_of_the_flat_fills_its_place_and_no_more() -> None:
    for name, piece in flat().furniture.items():
        length, depth, height = piece.size
        for part in solids(piece):
            for centre, half, most in zip(part.centre, part.half, (length / 2, depth / 2), strict=False):
                assert abs(centre) + half <= most * 1.05 + 0.06, name
            assert part.centre[2] + part.half[2] <= height + 0.5, name
            assert min(part.half) > 0, name


def test_what_stands_on_the_floor_shows_in_the_plane_of_the_lidar() -> None:
    for name, piece in flat().furniture.items():
        if piece.kind not in FLAT:
            crossing = [s for s in solids(piece) if s.centre[2] - s.half[2] <= 0.1 <= s.centre[2] + s.half[2]]
            assert crossing, name
            assert all(max(s.half[:2]) >= 0.02 for s in crossing), name


def test_the_flat_settles_with_everything_where_it_was_put() -> None:
    scene = flat()
    model = build(scene)
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    for name, loose in scene.objects.items():
        x, y, z = data.body(name).xpos
        assert math.dist((x, y), loose.at) < 0.005, name
        ground = 0.0 if loose.stands_on is None else scene.furniture[loose.stands_on].size[2]
        assert z == pytest.approx(ground, abs=0.004), name


@pytest.mark.parametrize("name", ["flat", "workshop"])
def test_without_pictures_a_scene_is_the_same_to_everything_but_the_eye(name: str) -> None:
    scene = load_scene(scene_path(name))
    painted, plain = build(scene), build(scene, pictures=False)
    assert painted.ntex > 10
    assert plain.ntex == 1  # the sky
    assert [painted.geom(i).name for i in range(painted.ngeom)] == [plain.geom(i).name for i in range(plain.ngeom)]
    ends = []
    for model in (painted, plain):
        data = mujoco.MjData(model)
        data.qvel[:] = 0.3  # everything flies apart, and meets something
        for _ in range(300):
            mujoco.mj_step(model, data)
        ends.append(data.qpos.copy())
    assert (ends[0] == ends[1]).all()


def test_no_two_things_of_the_flat_stand_in_one_another() -> None:
    pieces = [(n, p.area) for n, p in flat().furniture.items() if p.kind not in FLAT]
    walls = [("a wall", (w.x_min, w.y_min, w.x_max, w.y_max)) for w in wall_pieces(flat())]
    for i, (name, a) in enumerate(pieces):
        for other, b in [*pieces[i + 1 :], *walls]:
            apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            tucked_in = {"chair", "table", "desk"} >= {flat().furniture[n].kind for n in (name, other) if n != "a wall"}
            assert apart or (tucked_in and other != "a wall"), f"{name} and {other}"


def test_a_tag_on_a_block_is_read_as_its_own_number() -> None:
    import cv2

    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11))
    for tag in (0, 1, 2, 3, 586):
        cells = tag_cells(tag)
        assert cells.shape == (TAG_CELLS, TAG_CELLS)
        picture = np.kron(cells, np.ones((12, 12))).astype(np.uint8) * 255
        _, found, _ = detector.detectMarkers(np.pad(picture, 20, constant_values=255))
        assert found is not None
        assert found.ravel().tolist() == [tag]
