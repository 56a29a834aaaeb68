"""People: upright figures that stand on the floor where the map has nothing.

Whatever rises from the floor away from mapped walls and furniture is taken apart by where it stands. A figure is as
wide as a person, reaches up to the hip at least, or out of the picture, and fills its outline from the feet upwards;
chairs that were moved are open between their legs, doors and boards are flat. Colours only tell how people are dressed.
"""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.perception.colours import colour_name, to_hsv
from engine.perception.sighting import PixelBox, Sighting
from engine.robot.camera import Picture, Points
from engine.robot.floor_map import FloorMap

FARTHEST: Final = 5.0
"""m from the base's centre."""
WIDTHS: Final = (0.16, 0.8)
"""m across, without and with moving arms."""
HIP: Final = 0.5
"""m that somebody is tall at least; less where the picture ends above."""
_CUT = 0.3  # m that must show of somebody whom the picture's upper edge cuts
_FROM_FLOOR = 0.35  # m: what begins higher hangs, unless the picture's lower edge cuts it
_FLOOR = 0.06  # m above which something stands out
_ROBOT = 0.32  # m from the base's centre that the robot itself takes
_FIXED = 0.15  # m around walls and furniture that may belong to them; odometry errs
_CELL, _HALF = 0.05, 128  # m, cells from the middle of the grid that things are told apart in
_THICKNESS = 0.1  # m from somebody's front to the middle
_LEGS, _FILLED = (0.1, 0.34), 0.42  # m above the floor, and how much of their width legs fill there
_FLAT = 0.012  # m that a board is uneven at most
_ENOUGH = 160  # pixels across a picture that are looked at
_FEWEST = 40  # of them


def find_people(picture: Picture, floor_map: FloorMap) -> tuple[Sighting, ...]:
    """Everybody in the picture, the nearest first."""
    height, width = picture.depth.shape
    step = max(1, round(width / _ENOUGH))
    sparse = np.zeros((height, width), dtype=np.bool_)
    sparse[::step, ::step] = np.isfinite(picture.depth[::step, ::step])
    pixels, points = np.flatnonzero(sparse), picture.points(sparse)
    away = np.hypot(points[:, 0], points[:, 1])
    loose = (points[:, 2] > _FLOOR) & (away < FARTHEST) & (away > _ROBOT)
    loose[loose] = ~_fixed(picture.on_map(points[loose]), floor_map)
    pixels, points = pixels[loose], points[loose]
    labels, count = _apart(points)
    found = []
    for label in range(1, count):
        mine = labels == label
        if np.count_nonzero(mine) < _FEWEST:
            continue
        rows, columns = np.divmod(pixels[mine], width)
        box = (int(columns.min()), int(rows.min()), int(columns.max()) + step, int(rows.max()) + step)
        if _is_figure(points[mine], rows // step, columns // step, box, height):
            found.append(_sighting(picture, points[mine], pixels[mine], box))
    return tuple(sorted(found, key=lambda person: person.range))


def _fixed(points: Points, floor_map: FloorMap) -> NDArray[np.bool_]:
    """Which points of the map frame may belong to what is mapped."""
    reach = math.ceil(_FIXED / floor_map.resolution)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    grown = cv2.dilate(floor_map.occupied.astype(np.uint8), disc) > 0
    cells = np.floor((points[:, :2] - floor_map.origin) / floor_map.resolution).astype(int)
    rows, columns = grown.shape
    outside = (cells < 0).any(axis=1) | (cells[:, 0] >= columns) | (cells[:, 1] >= rows)
    cells[outside] = 0
    found: NDArray[np.bool_] = grown[cells[:, 1], cells[:, 0]] | outside
    return found


def _apart(points: Points) -> tuple[NDArray[np.int32], int]:
    """A number for every point, equal for what stands together on the floor, and one more than the highest."""
    grid = np.zeros((2 * _HALF, 2 * _HALF), dtype=np.uint8)
    cells = np.clip(np.floor(points[:, :2] / _CELL).astype(int) + _HALF, 0, 2 * _HALF - 1)
    grid[cells[:, 1], cells[:, 0]] = 1
    # Legs are a hand's breadth apart.
    count, labels = cv2.connectedComponents(cv2.dilate(grid, np.ones((3, 3), dtype=np.uint8)), connectivity=8)
    return np.asarray(labels, dtype=np.int32)[cells[:, 1], cells[:, 0]], int(count)


def _is_figure(
    points: Points,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    box: PixelBox,
    height: int,
) -> bool:
    _, top, _, bottom = box
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    if low > _FROM_FLOOR and bottom < height:
        return False
    if high < HIP and not (top == 0 and high - low > _CUT):
        return False
    if not WIDTHS[0] < _across(points) < WIDTHS[1] or _unevenness(points) < _FLAT:
        return False
    return _filled(points, rows, columns) > _FILLED


def _across(points: Points) -> float:
    """Width as the robot sees it, m; a few stray points do not count."""
    x, y = points[:, :2].mean(axis=0)
    along = math.atan2(y, x)
    aside = points[:, 1] * math.cos(along) - points[:, 0] * math.sin(along)
    low, high = np.percentile(aside, (1, 99))
    return float(high - low)


def _unevenness(points: Points) -> float:
    """How far the points are from one upright plane, m."""
    off = points[:, :2] - points[:, :2].mean(axis=0)
    return float(np.linalg.svd(off, full_matrices=False)[1][-1] / math.sqrt(len(points)))


def _filled(points: Points, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> float:
    """How much of its width the figure fills, on the average over the lines of pixels below the knees; where these do
    not show, over its lowest part."""
    height = points[:, 2]
    low = max(_LEGS[0], float(height.min()))
    legs = (height > low) & (height < low + _LEGS[1] - _LEGS[0])
    if not legs.any():
        return 0.0
    lines = np.unique(rows[legs])
    widest = np.ptp(columns[legs]) + 1
    return float(np.count_nonzero(legs) / (len(lines) * widest))


def _sighting(picture: Picture, points: Points, pixels: NDArray[np.intp], box: PixelBox) -> Sighting:
    height, width = picture.depth.shape
    front = np.median(points[:, :2], axis=0)
    away = float(np.hypot(*front))
    middle = front * (1 + _THICKNESS / away)
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    [place] = picture.on_map(np.array([[middle[0], middle[1], (low + high) / 2]]))
    left, top, right, bottom = box
    upper = pixels[points[:, 2] >= np.percentile(points[:, 2], 50)]
    clothes = to_hsv(picture.rgb[top:bottom]).reshape(-1, 3)[upper - top * width]
    return Sighting(
        kind="person",
        colour=colour_name(clothes, np.zeros(len(clothes), dtype=np.bool_)),
        box=box,
        position=(float(place[0]), float(place[1]), float(place[2])),
        sigma=0.05 + 0.02 * away,
        size=(_across(points), high - min(low, _FLOOR)),
        range=float(np.linalg.norm(np.array([*middle, (low + high) / 2]) - picture.mount.position)),
        surface=0.0,
        complete=left > 0 and top > 0 and right < width and bottom < height,
    )
