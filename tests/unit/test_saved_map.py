"""A map that Nav2 saved is the house of a real robot."""

from __future__ import annotations

import contextlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import SceneError
from engine.robot.home import home
from engine.robot.saved_map import read_map
from tests.sim.rig import settings

YAML = """\
image: map.pgm
resolution: 0.05
origin: [-1.0, -2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.25
"""


def saved(folder: Path, text: str = YAML) -> Path:
    """3 m × 4 m of free floor with a wall around, an unknown corner at the upper right, and a box at the lower left."""
    grey = np.full((80, 60), 254, dtype=np.uint8)
    grey[[0, -1], :] = grey[:, [0, -1]] = 0
    grey[1:10, 50:-1] = 205
    grey[-15:-10, 5:10] = 0
    cv2.imwrite(str(folder / "map.pgm"), grey)
    file = folder / "map.yaml"
    file.write_text(text)
    return file


def test_dark_is_occupied_light_is_free_and_unknown_is_not_driven_into(tmp_path: Path) -> None:
    floor = read_map(saved(tmp_path))
    assert (floor.resolution, floor.origin, floor.occupied.shape) == (0.05, (-1.0, -2.0), (80, 60))
    assert floor.occupied[12, 7], "the box, counted from below"
    assert floor.occupied[75, 55], "the unknown corner"
    assert not floor.occupied[40, 30]
    assert floor.holds(1.9, 1.9)
    assert not floor.holds(2.1, 0)


def test_it_is_the_house_of_a_real_robot(tmp_path: Path) -> None:
    lived_in = home(settings(kind="rosmaster", port="/dev/ttyTest", map=str(saved(tmp_path))))
    assert lived_in.name == "map"
    assert lived_in.places == {}
    edges = lived_in.edges(blind=True)
    assert np.hypot(*(edges - (-0.625, -1.475)).T).min() < 0.05, "a robot that sees nothing stops short of the box"


def test_a_map_is_for_real_robots(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="for real robots"):
        settings(map=str(saved(tmp_path)))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (YAML.replace("0.05", "-1"), "resolution"),
        (YAML.replace("-2.0, 0.0", "-2.0, 0.3"), "turned by 17.2°"),
        (YAML.replace("map.pgm", "none.pgm"), "none.pgm, cannot be read: there is none"),
        (YAML.replace("map.pgm", "map.yaml"), "none that can be read"),
        (YAML + "mode: raw\n", "saved raw"),
        ("[", "not YAML"),
        ("- 1", "is wrong"),
        (YAML.replace("-1.0", ".nan"), "origin"),
    ],
)
def test_what_is_wrong_with_a_map_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        read_map(saved(tmp_path, text))


def test_a_map_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"nowhere\.yaml cannot be read: there is none"):
        home(settings(kind="rosmaster", port="/dev/ttyTest", map=str(tmp_path / "nowhere.yaml")))


@given(st.binary(max_size=300))
def test_no_picture_makes_it_raise_anything_else(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    folder = tmp_path_factory.mktemp("map")
    (folder / "map.yaml").write_text(YAML)
    (folder / "map.pgm").write_bytes(data)
    with contextlib.suppress(SceneError):
        read_map(folder / "map.yaml")
